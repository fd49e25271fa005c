"""Meshes to OBJ and surfaces from GLB, as the command takes and gives them, and what rides on them."""

import json
import struct

import bpy
import numpy as np

INFINITE_SHARPNESS = 10


def vertex_colors(mesh, layer):
    """Red, green, blue of each vertex by a layer of colours, linear; the mean of its corners' own."""
    values = np.empty(4 * len(layer.data), np.float32)
    layer.data.foreach_get("color", values)
    values = values.reshape(-1, 4)[:, :3]
    if layer.domain == "POINT":
        return values
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    sums = np.zeros((len(mesh.vertices), 3))
    np.add.at(sums, vertices, values)
    return sums / np.maximum(1, np.bincount(vertices, minlength=len(sums)))[:, None]


def group_weights(mesh, count):
    """The weights of each vertex in groups 0 to `count`: (vertices, count)."""
    weights = np.zeros((len(mesh.vertices), count))
    if count:
        for vertex in mesh.vertices:
            for element in vertex.groups:
                if element.group < count:
                    weights[vertex.index, element.group] = element.weight
    return weights


def srgb(linear):
    """What OBJ has, of what Blender and glTF have."""
    above = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, above)


def vertex_positions(mesh):
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)


class Riders:
    """What of a mesh rides on its surface: OBJ holds one set of texture coordinates and three numbers a
    vertex, so that what is more comes in further files of the same mesh."""

    def __init__(self, mesh, group_names):
        active = mesh.uv_layers.active
        layers = sorted(mesh.uv_layers, key=lambda layer: layer != active)
        self.uvs = []  # (name, u and v of each corner)
        for layer in layers:
            values = np.empty(2 * len(mesh.loops), np.float32)
            layer.data.foreach_get("uv", values)
            self.uvs.append((layer.name, values.reshape(-1, 2)))
        active = mesh.color_attributes.active_color
        layers = sorted(mesh.color_attributes, key=lambda layer: layer != active)
        self.colors = [(layer.name, vertex_colors(mesh, layer)) for layer in layers]
        weights = group_weights(mesh, len(group_names))
        self.groups = [group_names[i : i + 3] for i in range(0, len(group_names), 3)]
        self.triples = [values for _, values in self.colors]
        for first in range(0, len(group_names), 3):
            triple = np.zeros((len(weights), 3))
            part = weights[:, first : first + 3]
            triple[:, : part.shape[1]] = part
            self.triples.append(triple)

    @property
    def file_count(self):
        return max(len(self.uvs), len(self.triples), 1)

    def of_file(self, number):
        """Texture coordinates of corners and numbers of vertices of one of the files, or None."""
        return (self.uvs[number][1] if number < len(self.uvs) else None,
                self.triples[number] if number < len(self.triples) else None)


def sharpness_of(crease):
    """OpenSubdiv's, as Blender's own surfaces have it of an edge's or vertex' crease of 0 to 1."""
    return INFINITE_SHARPNESS * crease * crease


def tags(mesh):
    """Lines of OBJ, by OpenSubdiv's convention."""
    lines = []
    for edge in mesh.edges:
        sharpness = INFINITE_SHARPNESS if edge.use_edge_sharp else sharpness_of(edge.crease)
        if sharpness > 0:
            v0, v1 = edge.vertices
            lines.append(f"t crease 2/1/0 {v0} {v1} {sharpness:.9g}")
    for layer in mesh.vertex_creases:
        for vertex, element in enumerate(layer.data):
            if element.value > 0:
                lines.append(f"t corner 1/1/0 {vertex} {sharpness_of(element.value):.9g}")
    return lines


def obj_text(mesh, positions, uvs=None, triples=None):
    """A Blender mesh as OBJ with OpenSubdiv's tags. Materials are called after their slots.
    positions: (n, 3); uvs: of each corner, (corners, 2); triples: linear numbers of 0 to 1, (n, 3)."""
    rows = positions if triples is None else np.hstack([positions, srgb(triples)])
    form = "v" + " %.9g" * rows.shape[1]
    lines = [form % tuple(row) for row in rows]
    if uvs is not None:
        # Corners that share a vertex and a coordinate share its number, or seams would be everywhere.
        unique, numbers = np.unique(uvs, axis=0, return_inverse=True)
        lines += ["vt %.9g %.9g" % tuple(uv) for uv in unique]
        numbers = numbers.ravel()
    slot = None
    for polygon in mesh.polygons:
        if polygon.material_index != slot:
            slot = polygon.material_index
            lines.append(f"usemtl slot{slot}")
        corners = []
        for loop in polygon.loop_indices:
            vertex = mesh.loops[loop].vertex_index + 1
            corners.append(str(vertex) if uvs is None else f"{vertex}/{numbers[loop] + 1}")
        lines.append("f " + " ".join(corners))
    return "\n".join(lines + tags(mesh)) + "\n"


COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def read_glb(data):
    """Positions, normals, texture coordinates and colours or None, triangles and their materials' names."""
    if data[:4] != b"glTF":
        raise RuntimeError("the command gave no GLB")
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + length])
    binary = memoryview(data)[28 + length :]

    def values(index):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        width = WIDTHS[accessor["type"]]
        return np.frombuffer(binary, COMPONENTS[accessor["componentType"]],
                             accessor["count"] * width,
                             view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
                             ).reshape(-1, width)

    parts, first = [], 0
    names = [material.get("name", "") for material in document.get("materials", [])]
    for primitive in document["meshes"][0]["primitives"]:
        attributes = primitive["attributes"]
        positions = values(attributes["POSITION"])
        triangles = values(primitive["indices"]).reshape(-1, 3).astype(np.int64) + first
        uvs = values(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else None
        name = names[primitive["material"]] if "material" in primitive else ""
        colors = values(attributes["COLOR_0"]) if "COLOR_0" in attributes else None
        parts.append((positions, values(attributes["NORMAL"]), uvs, triangles,
                      [name] * len(triangles), colors))
        first += len(positions)
    offset = document["nodes"][0].get("translation", (0, 0, 0))
    all_uvs = None
    if all(part[2] is not None for part in parts):
        all_uvs = np.concatenate([part[2] for part in parts]) * (1, -1) + (0, 1)
    return {
        "positions": np.concatenate([part[0] for part in parts]) + np.array(offset),
        "normals": np.concatenate([part[1] for part in parts]),
        "uvs": all_uvs,
        "colors": np.concatenate([part[5][:, :3] for part in parts])
                  if all(part[5] is not None for part in parts) else None,
        "triangles": np.concatenate([part[3] for part in parts]),
        "materials": sum((part[4] for part in parts), []),
        "extras": document["asset"].get("extras", {}),
    }


def joined_quads(triangles):
    """Quads of the pairs of triangles that the writer cut them into: rows (n, 4), or None."""
    if len(triangles) % 2:
        return None
    first, second = triangles[0::2], triangles[1::2]
    is_shared = (first[:, :, None] == second[:, None, :]).any(axis=2)
    is_new = ~(second[:, :, None] == first[:, None, :]).any(axis=2)
    if not ((is_shared.sum(axis=1) == 2) & (is_new.sum(axis=1) == 1)).all():
        return None
    rows = np.arange(len(first))
    lone = (~is_shared).argmax(axis=1)  # the corner that the second triangle lacks
    corner = [first[rows, (lone + i) % 3] for i in range(3)]
    quads = np.stack([corner[0], corner[1], second[rows, is_new.argmax(axis=1)], corner[2]], axis=1)
    # From the same corner on, whichever diagonal they are cut along.
    start = (quads == first[:, :1]).argmax(axis=1)
    return np.take_along_axis(quads, (start[:, None] + np.arange(4)) % 4, axis=1)


class Surface:
    """A surface with what further files of the same mesh bring along, corner by corner."""

    def __init__(self, given):
        """`given`: what read_glb() returned."""
        self.extras = given["extras"]
        self.normals = given["normals"]
        self.positions = given["positions"]
        faces, step = joined_quads(given["triangles"]), 2
        if faces is None:
            faces, step = given["triangles"], 1
        self.faces = faces
        self.slots = [int(text[4:]) if text.startswith("slot") else 0
                      for text in given["materials"][::step]]
        self.uvs, self.colors, self.groups, self.keys = [], [], [], []

    def corners_of(self, given):
        """The rows of another of its files at this one's corners; None where faces differ."""
        if given["triangles"].shape != (len(self.faces) * (self.faces.shape[1] - 2), 3):
            return None
        faces = joined_quads(given["triangles"]) if self.faces.shape[1] == 4 else given["triangles"]
        return None if faces is None or faces.shape != self.faces.shape else faces.ravel()

    def take(self, given, riders, number):
        """What file `number` brings; raises RuntimeError where it is of another surface."""
        corners = self.corners_of(given)
        if corners is None or not np.array_equal(given["positions"][corners],
                                                 self.positions[self.faces.ravel()]):
            raise RuntimeError("what rides on the mesh came with another surface, and is left out")
        if number < len(riders.uvs):
            self.uvs.append((riders.uvs[number][0], given["uvs"][corners]))
        if number >= len(riders.triples):
            return
        rows = given["colors"][corners]
        if number < len(riders.colors):
            self.colors.append((riders.colors[number][0], rows))
            return
        for axis, name in enumerate(riders.groups[number - len(riders.colors)]):
            self.groups.append((name, rows[:, axis]))

    def take_key(self, given, name):
        """A shape key; raises RuntimeError where its faces are others."""
        corners = self.corners_of(given)
        if corners is None:
            raise RuntimeError(f"the surface of shape key {name} has other faces; it is left out")
        self.keys.append((name, given["positions"][corners]))


def build_mesh(name, surface):
    """A Blender mesh of a Surface, with its exact normals; and the first corner at each vertex."""
    # Vertices on seams and creases come once for each side; in Blender corners hold what differs.
    corners = surface.faces.ravel()
    places = np.hstack([surface.positions[corners]] + [places for _, places in surface.keys])
    _, firsts, numbers = np.unique(places, axis=0, return_index=True, return_inverse=True)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(places[firsts, :3].tolist(), [], numbers.reshape(surface.faces.shape).tolist())
    mesh.polygons.foreach_set("material_index", surface.slots)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(surface.faces), bool))
    for layer_name, values in surface.uvs:
        layer = mesh.uv_layers.new(name=layer_name)
        layer.data.foreach_set("uv", values.astype(np.float32).ravel())
    for layer_name, values in surface.colors:
        rows = np.ones((len(firsts), 4), np.float32)
        rows[:, :3] = values[firsts]
        layer = mesh.color_attributes.new(layer_name, "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", rows.ravel())
    if surface.uvs:
        mesh.uv_layers.active_index = 0
    if surface.colors:
        mesh.color_attributes.active_color_index = 0
    mesh.update()
    mesh.use_auto_smooth = True  # or Blender leaves custom normals out
    mesh.normals_split_custom_set(surface.normals[corners].tolist())
    return mesh, firsts


def add_groups(thing, surface, firsts):
    """Vertex groups of an object with what build_mesh() returned."""
    for name, weights in surface.groups:
        group = thing.vertex_groups.new(name=name)
        for vertex, weight in enumerate(weights[firsts].tolist()):
            if weight > 1e-6:
                group.add([vertex], min(weight, 1.0), "REPLACE")


def add_keys(thing, surface, firsts, source_keys):
    """Shape keys of an object, with the values and limits of those that they come from."""
    if not surface.keys:
        return
    thing.shape_key_add(name=source_keys.reference_key.name, from_mix=False)
    for name, places in surface.keys:
        key = thing.shape_key_add(name=name, from_mix=False)
        key.data.foreach_set("co", places[firsts].astype(np.float32).ravel())
        given = source_keys.key_blocks[name]
        key.slider_min, key.slider_max = given.slider_min, given.slider_max
        key.value, key.mute = given.value, given.mute
