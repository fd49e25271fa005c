"""Meshes to OBJ and surfaces from GLB, as the command takes and gives them, and what rides on them."""

import json
import struct

import numpy as np

INFINITE_SHARPNESS = 10


def read_all(items, name, width, kind):
    """One property of all items of a collection: (items, width), or (items,) where `width` is 0."""
    values = np.empty(len(items) * max(width, 1), kind)
    items.foreach_get(name, values)
    return values.reshape(-1, width) if width else values


def vertex_positions(mesh):
    return read_all(mesh.vertices, "co", 3, np.float32)


def corner_vertices(mesh):
    return read_all(mesh.loops, "vertex_index", 0, np.int32)


def vertex_colors(mesh, layer):
    """Red, green, blue of each vertex by a layer of colours, linear; the mean of its corners' own."""
    values = read_all(layer.data, "color", 4, np.float32)[:, :3]
    if layer.domain == "POINT":
        return values
    vertices = corner_vertices(mesh)
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


class Riders:
    """What of a mesh rides on its surface: OBJ holds one set of texture coordinates and three numbers a
    vertex, so that what is more comes in further files of the same mesh."""

    def __init__(self, mesh, group_names):
        active = mesh.uv_layers.active
        layers = sorted(mesh.uv_layers, key=lambda layer: layer != active)
        self.uvs = [(layer.name, read_all(layer.data, "uv", 2, np.float32))  # u and v of each corner
                    for layer in layers]
        active = mesh.color_attributes.active_color
        layers = sorted(mesh.color_attributes, key=lambda layer: layer != active)
        self.colors = [(layer.name, vertex_colors(mesh, layer)) for layer in layers]
        weights = group_weights(mesh, len(group_names))
        used = np.flatnonzero(weights.any(axis=0))  # a rig has many more bones than one mesh has groups
        self.groups, self.triples = [], [values for _, values in self.colors]
        for first in range(0, len(used), 3):
            part = used[first : first + 3]
            self.groups.append([group_names[group] for group in part])
            triple = np.zeros((len(weights), 3))
            triple[:, : len(part)] = weights[:, part]
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


class Given:
    """Faces and sharp edges of a Blender mesh, as OBJ has them."""

    def __init__(self, mesh):
        self.corners = corner_vertices(mesh)
        self.sizes = read_all(mesh.polygons, "loop_total", 0, np.int32)
        self.slots = read_all(mesh.polygons, "material_index", 0, np.int32)
        self.tags = []
        sharpness = sharpness_of(read_all(mesh.edges, "crease", 0, np.float32).astype(float))
        sharpness[read_all(mesh.edges, "use_edge_sharp", 0, bool)] = INFINITE_SHARPNESS
        ends = read_all(mesh.edges, "vertices", 2, np.int32)
        for edge in np.flatnonzero(sharpness):
            self.tags.append("t crease 2/1/0 %d %d %.9g\n" % (*ends[edge], sharpness[edge]))
        for layer in mesh.vertex_creases:
            sharpness = sharpness_of(read_all(layer.data, "value", 0, np.float32).astype(float))
            for vertex in np.flatnonzero(sharpness):
                self.tags.append("t corner 1/1/0 %d %.9g\n" % (vertex, sharpness[vertex]))

    def bytes(self):
        return b"".join([self.corners, self.sizes, self.slots, "".join(self.tags).encode()])

    def obj_text(self, positions, uvs=None, triples=None):
        """As OBJ with OpenSubdiv's tags. Materials are called after their slots. positions: (n, 3);
        uvs: of each corner, (corners, 2); triples: linear numbers of 0 to 1, (n, 3)."""
        rows = positions if triples is None else np.hstack([positions, srgb(triples)])
        text = rows_text("v" + " %.9g" * rows.shape[1] + "\n", rows)
        numbers, corner = self.corners[:, None] + 1, " %d"
        if uvs is not None:
            # Corners that share a vertex and a coordinate share its number, or seams would be everywhere.
            firsts, places = unique_rows(uvs)
            text += rows_text("vt %.9g %.9g\n", uvs[firsts])
            numbers, corner = np.hstack([numbers, places[:, None] + 1]), " %d/%d"
        forms = {size: "f" + corner * size + "\n" for size in np.unique(self.sizes).tolist()}
        lines = [forms[size] for size in self.sizes.tolist()]
        for face in np.flatnonzero(np.diff(self.slots, prepend=-1)):
            lines[face] = f"usemtl slot{self.slots[face]}\n" + lines[face]
        return text + "".join(lines) % tuple(numbers.ravel().tolist()) + "".join(self.tags)


def rows_text(form, rows):
    return (form * len(rows)) % tuple(rows.ravel().tolist())


def unique_rows(rows):
    """The first of each of the different rows, and which of these each row is."""
    order = np.lexsort(rows.T)
    is_new = np.ones(len(rows), bool)
    is_new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    numbers = np.empty(len(rows), np.int64)
    numbers[order] = np.cumsum(is_new) - 1
    return order[is_new], numbers


COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def read_glb(data):
    """Positions, normals, texture coordinates and colours or None, triangles and their materials' slots."""
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
        slot = int(name[4:]) if name.startswith("slot") else 0
        colors = values(attributes["COLOR_0"]) if "COLOR_0" in attributes else None
        parts.append((positions, values(attributes["NORMAL"]), uvs, triangles,
                      np.full(len(triangles), slot, np.int32), colors))
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
        "slots": np.concatenate([part[4] for part in parts]),
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
        self.slots = given["slots"][::step]
        self.triangles = given["triangles"]
        self.uvs, self.colors, self.groups, self.keys = [], [], [], []

    def corners_of(self, given):
        """The rows of another of its files at this one's corners; None where faces differ."""
        if np.array_equal(given["triangles"], self.triangles):
            return self.faces.ravel()
        if given["triangles"].shape != self.triangles.shape:
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

    def merge(self):
        """Finds the vertices of a mesh: the first corner at each, `firsts`, and that of each corner, `vertices`.
        Those on seams and creases come once for each side; in Blender corners hold what differs."""
        corners = self.faces.ravel()
        rows = np.empty((len(self.positions), 3 + 3 * len(self.keys)), np.float32)
        rows[:, :3] = self.positions
        for number, (_, places) in enumerate(self.keys):
            rows[corners, 3 + 3 * number : 6 + 3 * number] = places
        used = np.unique(corners)
        numbers = np.empty(len(rows), np.int64)
        _, numbers[used] = unique_rows(rows[used])
        self.vertices = numbers[corners]
        self.firsts = np.empty(self.vertices.max() + 1, np.int64)
        self.firsts[self.vertices[::-1]] = np.arange(len(corners))[::-1]


def mark_sharp_edges(mesh, surface):
    """Marks edges beside which the surface's normals differ, as a crease has it."""
    corners, vertices = surface.faces.ravel(), surface.vertices
    sides = np.hstack([surface.normals[corners], vertices[:, None]])
    if np.array_equal(sides[:, :3], sides[surface.firsts][vertices, :3]):
        return
    _, sides = unique_rows(sides)
    after = np.roll(np.arange(len(corners)).reshape(surface.faces.shape), -1, axis=1).ravel()
    is_up = vertices < vertices[after]
    ends = np.stack([np.where(is_up, sides, sides[after]), np.where(is_up, sides[after], sides)], axis=1)
    edges = read_all(mesh.loops, "edge_index", 0, np.int32)
    known = np.empty((len(mesh.edges), 2), np.int64)
    known[edges] = ends  # of one of its two faces
    is_sharp = np.zeros(len(mesh.edges), bool)
    is_sharp[edges[(known[edges] != ends).any(axis=1)]] = True
    mesh.edges.foreach_set("use_edge_sharp", is_sharp)
    mesh.use_auto_smooth, mesh.auto_smooth_angle = True, np.pi  # or Blender leaves the marks out


def fill_mesh(mesh, surface, has_normals):
    """Makes an empty Blender mesh a Surface: with its exact normals, or with Blender's own, which
    takes a fifth of the time."""
    firsts, vertices = surface.firsts, surface.vertices
    count, size = surface.faces.shape
    corners = surface.faces.ravel()
    mesh.vertices.add(len(firsts))
    mesh.loops.add(len(vertices))
    mesh.polygons.add(count)
    mesh.vertices.foreach_set("co", surface.positions[corners[firsts]].astype(np.float32).ravel())
    mesh.loops.foreach_set("vertex_index", vertices.astype(np.int32))
    mesh.polygons.foreach_set("loop_start", np.arange(0, count * size, size, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(count, size, np.int32))
    mesh.polygons.foreach_set("material_index", np.ascontiguousarray(surface.slots))
    mesh.polygons.foreach_set("use_smooth", np.ones(count, bool))
    mesh.update(calc_edges=True)
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
    if not has_normals:
        return mark_sharp_edges(mesh, surface)
    mesh.use_auto_smooth = True  # or Blender leaves custom normals out
    mesh.normals_split_custom_set(surface.normals[corners].tolist())
