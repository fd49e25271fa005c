"""Meshes to OBJ and surfaces from GLB, as the command takes and gives them."""

import json
import struct

import bpy
import numpy as np

INFINITE_SHARPNESS = 10


def vertex_colors(mesh):
    """Red, green, blue of each vertex by the active colours, linear; the mean of its corners' own. None: no colours."""
    layer = mesh.color_attributes.active_color
    if layer is None:
        return None
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


def srgb(linear):
    """What OBJ has, of what Blender and glTF have."""
    above = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, above)


def obj_text(mesh):
    """A Blender mesh as OBJ with OpenSubdiv's tags. Materials are called after their slots."""
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    rows, colors = positions.reshape(-1, 3), vertex_colors(mesh)
    if colors is not None:
        rows = np.hstack([rows, srgb(colors)])
    form = "v" + " %.9g" * rows.shape[1]
    lines = [form % tuple(row) for row in rows]
    layer = mesh.uv_layers.active
    if layer:
        uvs = np.empty(2 * len(mesh.loops), np.float32)
        layer.data.foreach_get("uv", uvs)
        # Corners that share a vertex and a coordinate share its number, or seams would be everywhere.
        unique, numbers = np.unique(uvs.reshape(-1, 2), axis=0, return_inverse=True)
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
            corners.append(f"{vertex}/{numbers[loop] + 1}" if layer else str(vertex))
        lines.append("f " + " ".join(corners))
    for edge in mesh.edges:
        if edge.use_edge_sharp or edge.crease >= 1:
            v0, v1 = edge.vertices
            lines.append(f"t crease 2/1/0 {v0} {v1} {INFINITE_SHARPNESS}")
    return "\n".join(lines) + "\n"


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
    return np.stack([corner[0], corner[1], second[rows, is_new.argmax(axis=1)], corner[2]], axis=1)


def build_mesh(name, surface):
    """A Blender mesh of what read_glb() returned, with its exact normals."""
    # Vertices on seams and creases come once for each side; in Blender corners hold what differs.
    _, firsts, numbers = np.unique(surface["positions"], axis=0, return_index=True,
                                   return_inverse=True)
    numbers = numbers.ravel()
    faces, step = joined_quads(surface["triangles"]), 2
    if faces is None:
        faces, step = surface["triangles"], 1
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(surface["positions"][firsts].tolist(), [], numbers[faces].tolist())
    corners = faces.ravel()
    slots = [int(text[4:]) if text.startswith("slot") else 0
             for text in surface["materials"][::step]]
    mesh.polygons.foreach_set("material_index", slots)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    if surface["uvs"] is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", surface["uvs"][corners].astype(np.float32).ravel())
    if surface["colors"] is not None:
        rows = np.ones((len(firsts), 4), np.float32)
        rows[:, :3] = surface["colors"][firsts]
        mesh.color_attributes.new("Color", "FLOAT_COLOR", "POINT").data.foreach_set("color", rows.ravel())
    mesh.update()
    mesh.use_auto_smooth = True  # or Blender leaves custom normals out
    mesh.normals_split_custom_set(surface["normals"][corners].tolist())
    return mesh
