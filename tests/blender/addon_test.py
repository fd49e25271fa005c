"""The Blender add-on, in Blender without a window: the panel's settings, and meshes both ways.

blender --background --factory-startup --python-exit-code 1 --python addon_test.py -- ADDON PLANISH
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

import bmesh
import bpy
import numpy as np

ADDON, PROGRAM = sys.argv[sys.argv.index("--") + 1 :]


def load():
    sys.path.insert(0, str(pathlib.Path(ADDON).resolve().parents[1]))
    import planish_blender

    return planish_blender


def coordinates(mesh):
    values = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", values)
    return values.reshape(-1, 3)


def select_only(thing):
    bpy.ops.object.select_all(action="DESELECT")
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing


def distance_to(points, mesh):
    vertices = coordinates(mesh)
    return max(np.linalg.norm(vertices - point, axis=1).min() for point in points)


def test_cube():
    bpy.ops.mesh.primitive_cube_add(location=(3, 2, 1))
    cube = bpy.context.object
    given = coordinates(cube.data).copy()
    assert bpy.ops.mesh.planish_fit() == {"FINISHED"}
    result = bpy.context.object
    assert result.name == f"{cube.name}.planish" and result.matrix_world == cube.matrix_world
    assert len(result.data.polygons) == 6 * 16
    assert {len(polygon.vertices) for polygon in result.data.polygons} == {4}
    assert distance_to(given, result.data) < 1e-5
    assert len(result.data.uv_layers) == 1
    # A closed surface of one sheet, seams and all.
    assert len(result.data.vertices) - len(result.data.edges) + len(result.data.polygons) == 2
    # The surface's own normals: exact at the corner of a cube, by symmetry.
    result.data.calc_normals_split()
    corners = [i for i, v in enumerate(coordinates(result.data))
               if np.abs(np.abs(v) - 1).max() < 1e-5]
    assert len(corners) == 8
    for loop in result.data.loops:
        if loop.vertex_index in corners:
            expected = np.sign(coordinates(result.data)[loop.vertex_index]) / np.sqrt(3)
            assert np.abs(np.array(loop.normal) - expected).max() < 1e-3, loop.normal[:]
    # Texture coordinates at the given corners are the given ones.
    assert uv_at_corners(cube.data, given) == uv_at_corners(result.data, given)


def uv_at_corners(mesh, points):
    layer, found = mesh.uv_layers.active.data, set()
    vertices = coordinates(mesh)
    for loop in mesh.loops:
        for number, point in enumerate(points):
            if np.abs(vertices[loop.vertex_index] - point).max() < 1e-5:
                found.add((number, *np.round(layer[loop.index].uv, 4).tolist()))
    return found


def test_sharp_edges_and_materials():
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    for name in ("first", "second"):
        cube.data.materials.append(bpy.data.materials.new(name))
    for index, polygon in enumerate(cube.data.polygons):
        polygon.material_index = index % 2
    smooth = fit_of(cube)
    for index, edge in enumerate(cube.data.edges):  # marked in both ways
        edge.use_edge_sharp = index % 2 == 0
        edge.crease = index % 2
    sharp = fit_of(cube)
    assert np.abs(coordinates(smooth.data)).max() > 1.01  # it bulges
    assert np.abs(coordinates(sharp.data)).max() < 1 + 1e-5  # all edges sharp: the cube itself
    assert [slot.material.name for slot in sharp.material_slots] == ["first", "second"]
    counts = np.bincount([polygon.material_index for polygon in sharp.data.polygons])
    assert counts.tolist() == [48, 48]


def fit_of(thing):
    select_only(thing)
    assert bpy.ops.mesh.planish_fit() == {"FINISHED"}
    return bpy.context.object


def test_all_selected():
    """Each selected mesh gets its surface; what is no mesh is left alone, and one error stops no other."""
    bpy.ops.object.select_all(action="DESELECT")
    sources = []
    for place in range(3):
        bpy.ops.mesh.primitive_cube_add(location=(4 * place, 9, 0))
        sources.append(bpy.context.object)
    bpy.ops.object.light_add()
    for thing in sources:
        thing.select_set(True)
    bpy.context.view_layer.objects.active = sources[1]
    before = set(bpy.data.objects)
    assert bpy.ops.mesh.planish_fit() == {"FINISHED"}
    made = set(bpy.data.objects) - before
    assert len(made) == 3 and set(bpy.context.selected_objects) == made, made
    for source in sources:
        (result,) = [thing for thing in made if thing.matrix_world == source.matrix_world]
        assert result.name == f"{source.name}.planish"
        assert (bpy.context.object == result) == (source == sources[1])
    sources[0].data.clear_geometry()
    select_only(sources[2])
    sources[0].select_set(True)
    count = len(bpy.data.objects)
    expect_error(f"{sources[0].name} has no faces")
    assert len(bpy.data.objects) == count + 1


def test_colors():
    """Given colours at given vertices, between them what lies between; of corners' colours the mean."""
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    given = coordinates(cube.data).copy()
    wanted = 0.25 + 0.5 * (given + 1) / 2
    for domain, kind in (("POINT", "FLOAT_COLOR"), ("CORNER", "FLOAT_COLOR")):
        layer = cube.data.color_attributes.new("tint", kind, domain)
        places = range(8) if domain == "POINT" else [loop.vertex_index for loop in cube.data.loops]
        for place, vertex in zip(layer.data, places):
            place.color = (*wanted[vertex], 1)
        cube.data.color_attributes.active_color = layer
        result = fit_of(cube)
        made = np.empty(4 * len(result.data.vertices), np.float32)
        result.data.color_attributes.active_color.data.foreach_get("color", made)
        made, vertices = made.reshape(-1, 4), coordinates(result.data)
        for point, color in zip(given, wanted):
            nearest = np.linalg.norm(vertices - point, axis=1).argmin()
            assert np.abs(made[nearest, :3] - color).max() < 1e-5, (domain, made[nearest], color)
        assert made[:, :3].min() > 0.2499 and made[:, :3].max() < 0.7501 and (made[:, 3] == 1).all()
        cube.data.color_attributes.remove(layer)


def riding_cube():
    """A cube with two sets of texture coordinates, two layers of colours, four groups and two shape keys."""
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    mesh = cube.data
    given = coordinates(mesh).copy()
    second = mesh.uv_layers.new(name="second")
    for loop in mesh.loops:
        x, y, z = given[loop.vertex_index]
        second.data[loop.index].uv = (0.5 + 0.25 * x, 0.5 + 0.125 * (y + z))
    mesh.uv_layers.active = mesh.uv_layers[0]
    for number, name in enumerate(("tint", "shade")):
        layer = mesh.color_attributes.new(name, "FLOAT_COLOR", "POINT")
        for vertex, item in enumerate(layer.data):
            item.color = (*(0.5 + (0.25 - 0.5 * number) * given[vertex]), 1)
    mesh.color_attributes.active_color = mesh.color_attributes["shade"]
    for number in range(4):
        group = cube.vertex_groups.new(name=f"group{number}")
        for vertex in range(8):
            group.add([vertex], 0.25 * number * (given[vertex][number % 3] + 1) / 2, "REPLACE")
    cube.shape_key_add(name="rest")
    for name, factor in (("tall", (1, 1, 2)), ("wide", (3, 1, 1))):
        key = cube.shape_key_add(name=name, from_mix=False)
        for vertex, item in enumerate(key.data):
            item.co = given[vertex] * factor
    cube.data.shape_keys.key_blocks["wide"].value = 0.25
    cube.data.shape_keys.key_blocks["tall"].slider_max = 0.5
    return cube, given


def at_vertices(result, given):
    """The numbers of a surface's vertices that are given ones."""
    vertices = coordinates(result.data)
    places = [np.linalg.norm(vertices - point, axis=1).argmin() for point in given]
    assert np.abs(vertices[places] - given).max() < 1e-5
    return places


def weights_of(thing, vertices):
    return np.array([[sum(element.weight for element in thing.data.vertices[int(vertex)].groups
                          if element.group == group.index) for group in thing.vertex_groups]
                     for vertex in vertices])


def test_all_that_rides():
    cube, given = riding_cube()
    settings = bpy.context.scene.planish
    settings.interpolation, settings.creases = "fair", "use"
    result = fit_of(cube)
    places = at_vertices(result, given)
    assert [layer.name for layer in result.data.uv_layers] == ["UVMap", "second"]
    layer = result.data.uv_layers["second"].data
    for loop in result.data.loops:
        if loop.vertex_index in places:
            x, y, z = given[places.index(loop.vertex_index)]
            assert np.abs(np.array(layer[loop.index].uv) - (0.5 + 0.25 * x, 0.5 + 0.125 * (y + z))).max() < 1e-5
    assert [layer.name for layer in result.data.color_attributes] == ["shade", "tint"]
    assert result.data.color_attributes.active_color.name == "shade"
    for number, name in enumerate(("tint", "shade")):
        data = result.data.color_attributes[name].data
        made = np.array([data[int(place)].color[:3] for place in places])
        assert np.abs(made - (0.5 + (0.25 - 0.5 * number) * given)).max() < 1e-5, name
    assert [group.name for group in result.vertex_groups] == [f"group{number}" for number in range(4)]
    made = weights_of(result, places)
    for number in range(4):
        assert np.abs(made[:, number] - 0.25 * number * (given[:, number % 3] + 1) / 2).max() < 1e-5
    # Linear between them.
    made = weights_of(result, range(len(result.data.vertices)))
    assert made.min() >= 0 and made[:, 3].max() < 0.75 + 1e-5
    # Shape keys: the surfaces through the moved vertices, and the mix that the source shows.
    keys = result.data.shape_keys.key_blocks
    assert [key.name for key in keys] == ["rest", "tall", "wide"]
    assert keys["wide"].value == 0.25 and keys["tall"].slider_max == 0.5
    for name, factor in (("tall", (1, 1, 2)), ("wide", (3, 1, 1))):
        moved = np.empty(3 * len(result.data.vertices), np.float32)
        keys[name].data.foreach_get("co", moved)
        moved = moved.reshape(-1, 3)
        assert np.abs(moved[places] - given * factor).max() < 1e-5, name
        # It is the surface of the mesh that has the key's shape.
        bpy.ops.mesh.primitive_cube_add()
        alone = bpy.context.object
        for vertex, item in enumerate(alone.data.vertices):
            item.co = given[vertex] * factor
        assert distance_to(moved, fit_of(alone).data) < 1e-5, name
    # The source is as it was.
    assert cube.show_only_shape_key is False and cube.data.shape_keys.key_blocks["wide"].value == 0.25
    # Keys whose vertices modifiers make more of still come along; what has none has no error.
    cube.modifiers.new("finer", "SUBSURF").subdivision_type = "SIMPLE"
    finer = fit_of(cube)
    assert len(finer.data.polygons) == 4 * len(result.data.polygons)
    assert len(finer.data.shape_keys.key_blocks) == 3
    settings.interpolation, settings.creases = "auto", "choose"


def test_semi_sharp_creases():
    """A crease of 0.4 bends the ridge of a roof more than none, and less than a sharp one."""
    settings = bpy.context.scene.planish
    settings.scheme, settings.interpolation, settings.creases = "catmull-clark", "progressive", "use"
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4)
    plate = bpy.context.object
    for vertex in plate.data.vertices:
        vertex.co.z = abs(vertex.co.x)
    heights = []
    for crease in (0, 0.4, 1):
        for edge in plate.data.edges:
            edge.crease = crease if all(abs(plate.data.vertices[v].co.x) < 1e-6 for v in edge.vertices) else 0
        made = fit_of(plate)
        # How sharply the ridge bends: the most that two faces beside it turn.
        normals = np.array([polygon.normal for polygon in made.data.polygons])
        centers = np.array([polygon.center for polygon in made.data.polygons])
        left = normals[(centers[:, 0] < 0) & (centers[:, 0] > -0.1)][:, 0].mean()
        right = normals[(centers[:, 0] > 0) & (centers[:, 0] < 0.1)][:, 0].mean()
        heights.append(left - right)
    assert heights[0] + 0.05 < heights[1] < heights[2] - 0.05, heights
    settings.scheme, settings.interpolation, settings.creases = "doo-sabin", "auto", "choose"


def test_names_do_not_grow():
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    cube.name = "Block"
    again = fit_of(fit_of(cube))
    assert again.name.startswith("Block.planish.0") and again.name.count("planish") == 1, again.name
    assert fit_of(again).name.count("planish") == 1


def test_settings():
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    sphere = bpy.context.object
    settings = bpy.context.scene.planish
    settings.level, settings.interpolation = 1, "fair"
    faces = len(sphere.data.polygons)
    assert len(fit_of(sphere).data.polygons) == 3 * faces  # a quad for each corner
    settings.quads = "on"
    assert len(fit_of(sphere).data.polygons) < 3 * faces
    settings.level, settings.interpolation, settings.quads = 2, "auto", "auto"


def test_edit_mode():
    """The meshes that are edited, as they are at the moment; what is selected of one is no matter."""
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(cube.data)
    edited.verts.ensure_lookup_table()
    edited.verts[0].co = (-2, -2, -2)
    bpy.ops.mesh.select_all(action="DESELECT")
    bmesh.update_edit_mesh(cube.data)
    before = set(bpy.data.objects)
    assert bpy.ops.mesh.planish_fit() == {"FINISHED"}
    assert bpy.context.mode == "EDIT_MESH" and bpy.context.object == cube
    bpy.ops.object.mode_set(mode="OBJECT")
    (result,) = set(bpy.data.objects) - before
    at_vertices(result, coordinates(cube.data))
    # The key that is edited is what is seen.
    cube, given = riding_cube()
    cube.active_shape_key_index = 1
    bpy.ops.object.mode_set(mode="EDIT")
    before = set(bpy.data.objects)
    assert bpy.ops.mesh.planish_fit() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    (result,) = set(bpy.data.objects) - before
    assert result.data.shape_keys is None and cube.active_shape_key_index == 1
    at_vertices(result, given * (1, 1, 2))


def rig(bones=2):
    """An armature of bones of length 1 one above the other."""
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.collection.objects.link(armature)
    select_only(armature)
    bpy.ops.object.mode_set(mode="EDIT")
    for number in range(bones):
        bone = armature.data.edit_bones.new(f"bone{number}")
        bone.head, bone.tail = (0, 0, number), (0, 0, number + 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def rigged_column(armature, bind):
    """A column of 2 along two bones, with a shape key and a group that no bone has."""
    mesh = bpy.data.meshes.new("Column")
    ring = [(0.4 * np.cos(angle), 0.4 * np.sin(angle)) for angle in np.arange(8) * np.pi / 4]
    mesh.from_pydata([(x, y, z) for z in np.linspace(0, 2, 7) for x, y in ring], [],
                     [(8 * row + i, 8 * row + (i + 1) % 8, 8 * row + 8 + (i + 1) % 8, 8 * row + 8 + i)
                      for row in range(6) for i in range(8)])
    column = bpy.data.objects.new("Column", mesh)
    bpy.context.collection.objects.link(column)
    for number in range(2):
        group = column.vertex_groups.new(name=f"bone{number}")
        for vertex in mesh.vertices:
            up = min(max(vertex.co.z - 0.5, 0), 1)
            group.add([vertex.index], up if number else 1 - up, "REPLACE")
    column.vertex_groups.new(name="none")
    column.shape_key_add(name="rest")
    key = column.shape_key_add(name="thick", from_mix=False)
    for vertex, item in enumerate(key.data):
        item.co = mesh.vertices[vertex].co * 1.25
    bind(column, armature)
    return column


def by_modifier(column, armature):
    column.parent = armature
    modifier = column.modifiers.new("Skeleton", "ARMATURE")
    modifier.object, modifier.use_deform_preserve_volume = armature, True


def by_parent(column, armature):
    column.parent, column.parent_type = armature, "ARMATURE"


def shown(thing):
    """Where the vertices are that the view shows."""
    bpy.context.view_layer.update()
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return coordinates(evaluated.data) @ np.array(thing.matrix_world.to_3x3()).T + thing.matrix_world.translation


def test_armatures():
    """A posed mesh is fitted at rest, and its surface follows the bones as it does."""
    for bind in (by_modifier, by_parent):
        armature = rig()
        armature.location = (1, 2, 3)
        column = rigged_column(armature, bind)
        rest = coordinates(column.data).copy()
        smooth = column.modifiers.new("finer", "SUBSURF")
        smooth.subdivision_type, smooth.show_viewport = "SIMPLE", False
        bone = armature.pose.bones["bone1"]
        bone.rotation_mode, bone.rotation_euler = "XYZ", (0.9, 0, 0)
        posed = shown(column)
        assert np.abs(posed - rest - np.array((1, 2, 3))).max() > 0.5
        result = fit_of(column)
        places = at_vertices(result, rest)
        assert result.parent == armature
        (modifier,) = result.modifiers
        assert modifier.type == "ARMATURE" and modifier.object == armature
        assert modifier.use_deform_preserve_volume == (bind is by_modifier)
        assert [group.name for group in result.vertex_groups] == ["bone0", "bone1", "none"]
        for angle in (0.9, -0.4):
            bone.rotation_euler[0] = angle
            assert np.abs(shown(result)[places] - shown(column)).max() < 1e-4, (bind, angle)
        result.data.shape_keys.key_blocks["thick"].value = 1
        column.data.shape_keys.key_blocks["thick"].value = 1
        assert np.abs(shown(result)[places] - shown(column)).max() < 1e-4
        # The source is as it was, and other modifiers are applied.
        assert column.parent_type == ("OBJECT" if bind is by_modifier else "ARMATURE")
        assert all(modifier.show_viewport for modifier in column.modifiers if modifier.type == "ARMATURE")
        smooth.show_viewport = True
        assert len(fit_of(column).data.polygons) == 4 * len(result.data.polygons)


def test_what_moves_shape_keys():
    cube, _ = riding_cube()
    keys = cube.data.shape_keys
    for frame, value in ((1, 0), (11, 1)):
        keys.key_blocks["wide"].value = value
        keys.key_blocks["wide"].keyframe_insert("value", frame=frame)
    driver = keys.key_blocks["tall"].driver_add("value").driver
    driver.type, driver.expression = "SCRIPTED", "frame / 22"
    result = fit_of(cube)
    # Whatever was chosen, the further files are of the same surface.
    assert len(result.data.uv_layers) == len(result.data.color_attributes) == 2
    assert weights_of(result, range(8)).max(axis=0).min() >= 0 and len(result.data.shape_keys.key_blocks) == 3
    for frame in (6, 11):
        bpy.context.scene.frame_set(frame)
        made = result.data.shape_keys.key_blocks
        assert abs(made["wide"].value - keys.key_blocks["wide"].value) < 1e-6
        assert abs(made["tall"].value - frame / 22) < 1e-6, (frame, made["tall"].value)
    bpy.context.scene.frame_set(1)


def test_own_settings():
    """An object's own settings begin as the scene's, and hold for it alone."""
    scene = bpy.context.scene.planish
    scene.level = 1
    cubes = []
    for place in range(2):
        bpy.ops.mesh.primitive_cube_add(location=(4 * place, -9, 0))
        cubes.append(bpy.context.object)
    cubes[0].planish.own = True
    assert cubes[0].planish.level == 1
    scene.level, cubes[0].planish.level = 2, 3
    for cube in cubes:
        cube.select_set(True)
    assert bpy.ops.mesh.planish_fit() == {"FINISHED"}
    for cube, level in zip(cubes, (3, 2)):
        (made,) = [thing for thing in bpy.context.selected_objects if thing.matrix_world == cube.matrix_world]
        assert len(made.data.polygons) == 6 * 4**level
    cubes[0].planish.own = False
    assert len(fit_of(cubes[0]).data.polygons) == 6 * 16


def test_try():
    """The surfaces of the choice stand side by side; the one that is kept takes the place of a fit."""
    bpy.ops.mesh.primitive_torus_add(major_segments=12, minor_segments=6, location=(1, 2, 3))
    torus = bpy.context.object
    torus.data.materials.append(bpy.data.materials.new("skin"))
    torus.vertex_groups.new(name="all").add(range(len(torus.data.vertices)), 1, "REPLACE")
    taken = fit_of(torus)
    select_only(torus)
    assert bpy.ops.mesh.planish_try() == {"FINISHED"}
    tried = sorted((thing for thing in bpy.data.objects if thing.planish.tried == torus),
                   key=lambda thing: thing.planish.order)
    assert len(tried) >= 2 and [thing.planish.taken for thing in tried] == [True] + [False] * (len(tried) - 1)
    assert np.array_equal(coordinates(tried[0].data), coordinates(taken.data))
    assert len({thing.planish.choice for thing in tried}) == len(tried)
    places = [thing.matrix_world.translation.x for thing in tried]
    assert all(second - first > torus.dimensions.x for first, second in zip([1, *places], places))
    for thing in tried:
        assert thing.planish.title in thing.name and "cost" in thing.planish.figures
        assert [slot.name for slot in thing.material_slots] == ["skin"]
        at_vertices(thing, coordinates(torus.data))
    # Once more, of one of them, is the same, not twice as many.
    select_only(tried[1])
    assert bpy.ops.mesh.planish_try() == {"FINISHED"}
    tried = sorted((thing for thing in bpy.data.objects if thing.planish.tried == torus),
                   key=lambda thing: thing.planish.order)
    (kept,) = [thing for thing in tried if json.loads(thing.planish.choice) == json.loads(tried[-1].planish.choice)]
    others, choice = [thing.name for thing in tried if thing != kept], json.loads(kept.planish.choice)
    wanted = coordinates(kept.data).copy()
    select_only(torus)
    assert bpy.ops.mesh.planish_keep(name=kept.name) == {"FINISHED"}
    assert not any(name in bpy.data.objects for name in others)
    assert kept.name.startswith(f"{torus.name}.planish") and kept.matrix_world == torus.matrix_world
    assert not kept.show_name and kept.planish.tried is None and bpy.context.object == kept
    # Its settings are the mesh's own, and make it again.
    assert choice and torus.planish.own and not bpy.context.scene.planish.is_property_set("refine")
    for name, value in choice.items():
        assert getattr(torus.planish, name) == value
    assert np.array_equal(coordinates(fit_of(torus).data), wanted)
    # Nothing is left to try where all is named, and none may be kept.
    for name, value in (("interpolation", "fair"), ("creases", "use"), ("quads", "off"), ("refine", "off")):
        setattr(torus.planish, name, value)
    select_only(torus)
    assert not bpy.ops.mesh.planish_try.poll()
    torus.planish.interpolation = "auto"
    assert bpy.ops.mesh.planish_try() == {"FINISHED"}
    assert bpy.ops.mesh.planish_drop_tried() == {"FINISHED"}
    assert not any(thing.planish.tried for thing in bpy.data.objects) and torus.name in bpy.data.objects
    assert not bpy.ops.mesh.planish_keep.poll()


def test_sheet():
    """A page of the selected meshes, each with its settings, the worst first; one error stops no other."""
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_cube_add()
    first = bpy.context.object
    first.name = "A/b"
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    second = bpy.context.object
    second.name = "A_b"
    second.planish.own = True
    second.planish.interpolation = "progressive"
    bpy.ops.mesh.primitive_cube_add()
    third = bpy.context.object
    third.name = "flat"
    third.data.clear_geometry()
    with tempfile.TemporaryDirectory() as folder:
        scene.planish.sheet = folder
        for thing in (first, second, third):
            thing.select_set(True)
        assert bpy.ops.mesh.planish_sheet() == {"FINISHED"}
        rows = {row.name: row.figures for row in bpy.context.window_manager.planish_sheet}
        assert list(rows)[0] == "flat" and rows["flat"] == "has no faces"
        assert set(rows) == {"A/b", "A_b", "flat"}
        assert rows["A_b"].startswith("progressive") and rows["A/b"].startswith("fair"), rows
        page = pathlib.Path(folder, "index.html").read_text(encoding="utf-8")
        # The panel has the page's order; both are of one name on some systems.
        names = {"A/b": "A_b", "A_b": "A_b_2"}
        on_page = [page.index(f">{names[name]}<") for name in list(rows)[1:]]
        assert on_page == sorted(on_page)
        assert len(list(pathlib.Path(folder).glob("*.html"))) == 3
    scene.planish.sheet = ""
    assert bpy.ops.object.planish_show(name="A_b") == {"FINISHED"} and bpy.context.object == second
    assert bpy.ops.mesh.planish_sheet() == {"FINISHED"}
    assert pathlib.Path(bpy.app.tempdir, "planish_sheet", "index.html").exists()


def test_creases_are_as_sharp_as_blenders(addon):
    """The command's Catmull-Clark surface of creases is Blender's own of the same control points."""
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    for crease, edge in zip((0.2, 0.4, 0.5, 0.7, 0.9), cube.data.edges):
        edge.crease = crease
    creases = [edge.crease for edge in cube.data.edges]
    taken = addon.source.take_source(bpy.context, cube)
    with tempfile.TemporaryDirectory() as folder:
        given, cage, surface = (pathlib.Path(folder, name) for name in ("given.obj", "cage.obj", "surface.glb"))
        given.write_text(taken.text(0))
        subprocess.run([PROGRAM, "fit", given, "-o", surface, "--cage", cage, "--scheme", "catmull-clark",
                        "--creases", "use", "--levels", "3", "-q"], check=True)
        control = [tuple(map(float, line.split()[1:4])) for line in cage.read_text().splitlines()
                   if line.startswith("v ")]
        made = addon.exchange.read_glb(surface.read_bytes())["positions"]
    for vertex, place in zip(cube.data.vertices, control):
        vertex.co = place
    own = cube.modifiers.new("own", "SUBSURF")
    own.levels, own.quality, own.use_limit_surface = 3, 10, True  # below, it stops before sharp creases do

    def far():
        bpy.context.view_layer.update()
        places = coordinates(cube.evaluated_get(bpy.context.evaluated_depsgraph_get()).data)
        return max(np.linalg.norm(places - place, axis=1).min() for place in made)

    assert far() < 1e-5, far()
    for edge, crease in zip(cube.data.edges, creases):
        edge.crease = np.sqrt(crease)  # as if sharpness were 10 times the crease
    assert far() > 1e-2, far()


def follow(addon, seconds=60):
    """Lets the timer run until live surfaces are up to date."""
    bpy.context.view_layer.update()
    end = time.monotonic() + seconds
    while addon.live.tick() is not None:
        assert time.monotonic() < end
        time.sleep(0.01)
    bpy.context.view_layer.update()


def test_live(addon):
    """A live surface follows its mesh, in place; what it does itself does not start it again."""
    live, scene = addon.live, bpy.context.scene
    scene.planish.creases = "use"
    bpy.ops.mesh.primitive_cube_add(location=(1, 2, 3))
    cube = bpy.context.object
    cube.data.materials.append(bpy.data.materials.new("skin"))
    cube.planish.live = True
    assert bpy.app.timers.is_registered(live.tick)
    follow(addon)
    result = cube.planish.result
    assert result.name == f"{cube.name}.planish" and result.hide_select
    assert cube.display_type == "WIRE"
    assert result.matrix_world == cube.matrix_world
    at_vertices(result, coordinates(cube.data))
    assert not live.changed, "its own change starts it again"
    starts = []
    start_job = live.start_job
    live.start_job = lambda *given, **more: starts.append(0) or start_job(*given, **more)

    def expect_follows(count=1):
        starts.clear()
        follow(addon)
        assert len(starts) == count, starts
        assert cube.planish.result == result
        at_vertices(result, coordinates(cube.data))

    # A vertex, in object and edit mode.
    result.data.materials.append(bpy.data.materials.new("of its own"))
    result.modifiers.new("its own", "DECIMATE")
    cube.data.vertices[0].co = (-2, -2, -2)
    cube.data.update()
    expect_follows()
    assert result.material_slots.keys() == [cube.data.materials[0].name, "of its own"]
    assert "its own" in result.modifiers
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(cube.data)
    edited.verts.ensure_lookup_table()
    edited.verts[1].co = (-1.5, -1, 1)
    bmesh.update_edit_mesh(cube.data)
    starts.clear()
    follow(addon)
    assert len(starts) == 1 and bpy.context.mode == "EDIT_MESH"
    bpy.ops.object.mode_set(mode="OBJECT")
    expect_follows(0)
    # Moves of the object need no fit.
    cube.location.x = 7
    expect_follows(0)
    assert result.matrix_world == cube.matrix_world
    # Settings: the scene's, then its own.
    scene.planish.level = 1
    expect_follows()
    assert len(result.data.polygons) == 6 * 4
    cube.planish.own = True
    expect_follows(0)
    cube.planish.level = 2
    expect_follows()
    assert len(result.data.polygons) == 6 * 16
    scene.planish.level = 2
    expect_follows(0)
    # Changes while the command is at work: it is finished, and begins again once.
    starts.clear()
    for step in range(3):
        cube.data.vertices[2].co.x = -1.1 - 0.1 * step
        cube.data.update()
        bpy.context.view_layer.update()
        live.tick()
    follow(addon)
    assert 2 <= len(starts) <= 3
    at_vertices(result, coordinates(cube.data))
    # A crease is drawn as one.
    for edge in cube.data.edges[:4]:
        edge.use_edge_sharp = True
    cube.data.update()
    expect_follows()
    assert sum(edge.use_edge_sharp for edge in result.data.edges) == 4 * 4
    # Undo makes other objects of all, with an older surface.
    live.everything_changed(scene)
    expect_follows()
    # What is wrong is said, and mended by the next change.
    scene.planish.program = "/nowhere/planish"
    cube.data.vertices[0].co.x = -3
    cube.data.update()
    follow(addon)
    assert "is not at /nowhere/planish" in live.messages[cube.name]
    scene.planish.program = PROGRAM
    cube.data.vertices[0].co.x = -2.5
    cube.data.update()
    expect_follows()
    assert cube.name not in live.messages
    # A duplicate has a surface of its own.
    select_only(cube)
    bpy.ops.object.duplicate()
    other = bpy.context.object
    assert other.planish.live and other.planish.result == result
    live.request(other)
    follow(addon)
    assert other.planish.result not in (None, result) and cube.planish.result == result
    # Without its mesh, a surface is an object as any other; without its surface a mesh is not live.
    left = other.planish.result
    bpy.ops.object.delete()
    follow(addon)
    assert not left.hide_select and left.planish.source is None and left.name in scene.objects
    # Turned off, it stays as it is, and nothing follows.
    cube.planish.live = False
    assert cube.display_type == "TEXTURED" and cube.planish.result is None
    assert not result.hide_select and result.parent is None and result.matrix_world == cube.matrix_world
    cube.data.vertices[0].co.x = -4
    cube.data.update()
    starts.clear()
    follow(addon)
    assert not starts
    cube.planish.live = True
    follow(addon)
    result = cube.planish.result
    result.hide_select = False
    select_only(result)
    bpy.ops.object.delete()
    follow(addon)
    assert not cube.planish.live and cube.planish.result is None
    live.start_job = start_job
    scene.planish.creases = "choose"


def test_live_with_armature(addon):
    """A live surface follows a pose without a fit."""
    armature = rig()
    column = rigged_column(armature, by_modifier)
    column.planish.live = True
    follow(addon)
    result = column.planish.result
    places = at_vertices(result, coordinates(column.data))
    start_job, starts = addon.live.start_job, []
    addon.live.start_job = lambda *given, **more: starts.append(0) or start_job(*given, **more)
    bone = armature.pose.bones["bone1"]
    bone.rotation_mode, bone.rotation_euler = "XYZ", (0.7, 0, 0)
    armature.location.x = 5
    follow(addon)
    assert not starts
    assert np.abs(shown(result)[places] - shown(column)).max() < 1e-4
    addon.live.start_job = start_job
    column.planish.live = False
    assert np.abs(shown(result)[places] - shown(column)).max() < 1e-4


def test_files(addon):
    """A file keeps own settings, and live surfaces follow in it."""
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    cube.name = "kept"
    cube.planish.live = cube.planish.own = True
    cube.planish.level = 1
    follow(addon)
    with tempfile.TemporaryDirectory() as folder:
        name = str(pathlib.Path(folder, "scene.blend"))
        bpy.ops.wm.save_as_mainfile(filepath=name)
        bpy.ops.wm.read_homefile(use_empty=True)
        assert not addon.live.live_objects()
        bpy.ops.wm.open_mainfile(filepath=name)
    cube = bpy.data.objects["kept"]
    assert cube.planish.own and cube.planish.level == 1 and addon.live.changed
    follow(addon)
    assert len(cube.planish.result.data.polygons) == 6 * 4
    cube.data.vertices[0].co = (-2, -2, -2)
    cube.data.update()
    follow(addon)
    at_vertices(cube.planish.result, coordinates(cube.data))
    cube.planish.live = False


def test_errors(addon):
    settings = bpy.context.scene.planish
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    settings.program = "/nowhere/planish"
    expect_error("is not at /nowhere/planish")
    settings.program = PROGRAM
    cube.data.clear_geometry()
    expect_error("has no faces")


def expect_error(words):
    try:
        bpy.ops.mesh.planish_fit()
    except RuntimeError as error:
        assert words in str(error), error
    else:
        raise AssertionError(f"no error: {words}")


def test_progress_and_cancel(addon):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=300, ring_count=200)
    settings = bpy.context.scene.planish
    settings.level = 3
    job = addon.start_job(bpy.context, bpy.context.object)
    shares = []
    while job.poll():
        shares.append(job.share)
        time.sleep(0.005)
    job.surface()
    assert shares == sorted(shares) and shares[-1] > 0.5, shares
    job = addon.start_job(bpy.context, bpy.context.object)
    time.sleep(0.05)
    job.cancel()
    while job.poll():
        time.sleep(0.005)
    try:
        job.surface()
    except RuntimeError:
        pass
    else:
        raise AssertionError("it was cancelled, and gave a surface")
    settings.level = 2


def main():
    addon = load()
    addon.register()
    assert bpy.types.VIEW3D_PT_planish
    bpy.context.scene.planish.program = PROGRAM
    # By measurement cubes stay boxes.
    bpy.context.scene.planish.creases = "use"
    test_cube()
    test_sharp_edges_and_materials()
    bpy.context.scene.planish.creases = "choose"
    test_all_selected()
    test_colors()
    test_all_that_rides()
    test_semi_sharp_creases()
    test_names_do_not_grow()
    test_settings()
    test_edit_mode()
    test_armatures()
    test_what_moves_shape_keys()
    test_own_settings()
    test_try()
    test_sheet()
    test_creases_are_as_sharp_as_blenders(addon)
    test_live(addon)
    test_live_with_armature(addon)
    test_errors(addon)
    test_progress_and_cancel(addon)
    test_files(addon)
    addon.unregister()
    print("the add-on works in Blender", bpy.app.version_string)


main()
