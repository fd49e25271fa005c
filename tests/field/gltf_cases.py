"""glTF as exporters write it, valid and not."""

import base64
import copy
import json
import math
import struct

from case import (Case, Result, all_of, bounded, counts, passes, warns, warns_nothing)
from shapes import sphere, torus, triangles

POINTS, QUADS = torus()
FACES = triangles(QUADS)
LOW, HIGH = (-1.4, -1.4, -0.4), (1.4, 1.4, 0.4)
BYTE, UBYTE, SHORT, USHORT, UINT, FLOAT = 5120, 5121, 5122, 5123, 5125, 5126
KINDS = {BYTE: "b", UBYTE: "B", SHORT: "h", USHORT: "H", UINT: "I", FLOAT: "f"}


class File:
    """A glTF that grows: a document and one buffer."""

    def __init__(self, points=POINTS, faces=FACES):
        self.binary = b""
        self.json = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "scene": 0,
                     "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "meshes": [{"primitives": [{"attributes": {}}]}]}
        self.primitive = self.json["meshes"][0]["primitives"][0]
        if points:
            self.primitive["attributes"]["POSITION"] = self.positions(points)
        if faces:
            self.primitive["indices"] = self.add([(k,) for f in faces for k in f], USHORT)

    def view(self, data: bytes, **more) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **more})
        self.binary += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, **entry) -> int:
        self.json["accessors"].append(entry)
        return len(self.json["accessors"]) - 1

    def add(self, rows, kind=FLOAT, stride=0, **more) -> int:
        width = len(rows[0])
        packed = [struct.pack(f"<{width}{KINDS[kind]}", *row) for row in rows]
        more_view = {"byteStride": stride} if stride else {}
        view = self.view(b"".join(row.ljust(stride, b"\x55") for row in packed), **more_view)
        kinds = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
        return self.accessor(bufferView=view, componentType=kind, count=len(rows),
                             type=kinds[width], **more)

    def positions(self, points, kind=FLOAT, **more) -> int:
        bounds = {name: [f(p[k] for p in points) for k in range(3)]
                  for name, f in (("min", min), ("max", max))}
        if kind == FLOAT:  # as they are stored
            bounds = {name: [struct.unpack("<f", struct.pack("<f", v))[0] for v in row]
                      for name, row in bounds.items()}
        return self.add(points, kind, **bounds, **more)

    def sparse(self, rows, places, type, width_count) -> dict:
        """What an accessor of `width_count` elements has besides, without a buffer view."""
        at = self.view(b"".join(struct.pack("<H", k) for k in places))
        values = self.view(b"".join(struct.pack(f"<{len(row)}f", *row) for row in rows))
        return {"componentType": FLOAT, "count": width_count, "type": type,
                "sparse": {"count": len(places),
                           "indices": {"bufferView": at, "componentType": USHORT},
                           "values": {"bufferView": values}}}

    def uses(self, *names, required=False):
        self.json.setdefault("extensionsUsed", []).extend(names)
        if required:
            self.json.setdefault("extensionsRequired", []).extend(names)
        return self

    def glb(self, text: bytes | None = None, pads=True, total=None, further=b"") -> bytes:
        document = dict(self.json, buffers=[{"byteLength": len(self.binary)}])
        document = {key: value for key, value in document.items() if value != []}
        text = json.dumps(document).encode() if text is None else text
        binary = self.binary
        if pads:
            text += b" " * (-len(text) % 4)
            binary += b"\0" * (-len(binary) % 4)
        body = struct.pack("<I4s", len(text), b"JSON") + text
        body += struct.pack("<I4s", len(binary), b"BIN\0") + binary + further
        return struct.pack("<4sII", b"glTF", 2, total or 12 + len(body)) + body

    def gltf(self, uri: str, **more) -> bytes:
        return json.dumps(dict(self.json, **more,
                               buffers=[{"byteLength": len(self.binary), "uri": uri}])).encode()


def node(file: File, **entry) -> File:
    file.json["nodes"] = [{"mesh": 0, **entry}]
    return file


def changed(change) -> bytes:
    """A torus with one change of its document."""
    file = File()
    change(file.json)
    return file.glb()


def text_of(file: File) -> str:
    return json.dumps(dict(file.json, buffers=[{"byteLength": len(file.binary)}]))


IS_TORUS = all_of(counts(vertices=96, genus=1, components=1), passes(POINTS, 3e-6))


def moved(points, by):
    return [tuple(p[k] + by[k] for k in range(3)) for p in points]


# ---------------------------------------------------------------- checks

def document_is(*checks):
    """Whether functions of the written document, or of its GLB, hold: pairs of words and them."""

    def check(result: Result) -> str | None:
        glb = result.output()
        for words, holds in checks:
            if not holds(glb):
                return words
        return None

    return check


def first_primitive(glb) -> dict:
    return glb.document["meshes"][0]["primitives"][0]


def polygons(glb) -> list[list[int]]:
    """What FB_ngon_encoding says the triangles are: fans of one first vertex."""
    indices = [row[0] for row in glb.accessor(first_primitive(glb)["indices"])]
    found: list[list[int]] = []
    for k in range(0, len(indices), 3):
        if found and found[-1][0] == indices[k] and found[-1][-1] == indices[k + 1]:
            found[-1].append(indices[k + 2])
        elif found and found[-1][0] == indices[k]:
            return []
        else:
            found.append(indices[k : k + 3])
    return found


def has_no_extension(name):
    def check(result: Result) -> str | None:
        text = json.dumps(result.output().document)
        return f"{name} is still in the document" if name in text else None

    return check


def says_bounds(low, high):
    """Of an inspection."""

    def check(result: Result) -> str | None:
        said = result.report["bounds"]
        wrong = max(abs(a - b) for row, given in zip(said, (low, high)) for a, b in zip(row, given))
        return None if wrong < 1e-5 else f"bounds {said}, not {[low, high]}"

    return check


# ---------------------------------------------------------------- cases

def addresses() -> list[Case]:
    file = File()
    text = base64.b64encode(file.binary).decode()

    def beside(name, uri, file_name=None, **more):
        files = {"a.gltf": file.gltf(uri)}
        if file_name:
            files[file_name] = file.binary
        return Case("gltf_" + name, files, "a.gltf", **more)

    data = "data:application/octet-stream"
    octets = "".join("%%%02x" % c for c in file.binary)
    right = {"check": IS_TORUS}
    return [
        beside("uri_encoded", "a%20b%C3%BCffer%20%231.bin", "a büffer #1.bin", **right),
        beside("uri_raw_percent", "scan 10%.bin", "scan 10%.bin", **right),
        beside("uri_raw_blank", "a b.bin", "a b.bin", **right),
        beside("uri_backslash", "parts\\a.bin", "parts/a.bin", **right),
        beside("uri_folder", "parts/a.bin", "parts/a.bin", **right),
        beside("uri_missing", "gone.bin", exit=3, says=("gone.bin", "copy it along")),
        beside("uri_up", "../a.bin", exit=3, says=("leads away from the folder",)),
        beside("uri_up_backslash", "..\\a.bin", exit=3, says=("leads away from the folder",)),
        beside("uri_web", "https://example.com/a.bin", exit=3,
               says=("is the address of something elsewhere",)),
        beside("data_gltf_buffer", f"data:application/gltf-buffer;base64,{text}", **right),
        beside("data_no_type", f"data:;base64,{text}", **right),
        beside("data_charset", f"{data};charset=utf-8;base64,{text}", **right),
        beside("data_percent", f"{data},{octets}", **right),
        beside("data_no_padding", f"{data};base64,{text.rstrip('=')}", **right),
        beside("data_encoded_base64", f"{data};base64,{text.replace('+', '%2B')}", **right),
        beside("data_line_breaks", f"{data};base64," + text[:76] + "\n" + text[76:], exit=3,
               says=("no data URI",)),
        beside("data_nothing", data, exit=3, says=("no data URI",)),
    ]


def stored() -> list[Case]:
    """Ways in which accessors and primitives hold the same torus."""
    found = []

    def torus_case(name, file, **more):
        found.append(Case("gltf_" + name, {"a.glb": file.glb()}, "a.glb",
                          **{"check": IS_TORUS, **more}))

    file = File(points=None)
    bounds = {"min": list(LOW), "max": list(HIGH)}
    file.primitive["attributes"]["POSITION"] = file.accessor(
        **file.sparse(POINTS, range(96), "VEC3", 96), **bounds)
    torus_case("sparse_positions", file)
    file = File(points=None, faces=None)
    file.primitive["attributes"]["POSITION"] = file.positions(POINTS, stride=20)
    file.primitive["indices"] = file.add([(k,) for f in FACES for k in f], UBYTE)
    torus_case("bytes_and_stride", file)
    torus_case("no_indices", File([POINTS[k] for f in FACES for k in f], None))
    file = File(faces=None)
    strip: list[int] = []
    for i in range(12):
        row = [k for j in range(9) for k in (i * 8 + j % 8, (i + 1) % 12 * 8 + j % 8)]
        strip += ([strip[-1], row[0]] if strip else []) + row
    file.primitive.update(mode=5, indices=file.add([(k,) for k in strip], USHORT))
    torus_case("strip", file)
    file = File(faces=None)
    file.primitive.update(mode=5, indices=file.add([(k,) for k in strip[:18] + [65535]], USHORT))
    torus_case("strip_restart", file, exit=3, says=("names vertex 65535 of 96",), check=None)
    whole = [tuple(round(c / 1.4 * 32767) for c in p) for p in POINTS]
    file = node(File(points=None), scale=[1.4] * 3).uses("KHR_mesh_quantization", required=True)
    file.primitive["attributes"]["POSITION"] = file.positions(whole, SHORT, stride=8,
                                                              normalized=True)
    torus_case("quantized_shorts", file,
               check=all_of(counts(vertices=96, genus=1), passes(POINTS, 2e-5)))
    whole = [tuple(round((c + 1.4) / 2.8 * 255) for c in p) for p in POINTS]
    file = node(File(points=None), scale=[2.8 / 255] * 3, translation=[-1.4] * 3)
    file.uses("KHR_mesh_quantization", required=True)
    file.primitive["attributes"]["POSITION"] = file.positions(whole, UBYTE, stride=4)
    torus_case("quantized_bytes", file,
               check=all_of(counts(vertices=96, genus=1), passes(POINTS, 4e-3)))
    # Indices without numbers name the first vertex alone.
    file = File(faces=None)
    file.primitive["indices"] = file.accessor(componentType=USHORT, count=12, type="SCALAR")
    torus_case("indices_without_view", file, exit=3, says=("which makes no triangle",), check=None)
    file = File()
    file.json["accessors"][1]["count"] += 1
    file.binary += b"\0\0\0\0"
    file.json["bufferViews"][1]["byteLength"] += 2
    torus_case("indices_not_by_three", file, exit=3, says=("make no whole triangles",), check=None)
    file = File()
    at = file.json["bufferViews"][1]["byteOffset"]
    file.binary = file.binary[:at] + struct.pack("<H", 9999) + file.binary[at + 2 :]
    torus_case("index_too_large", file, exit=3, says=("names vertex 9999 of 96",), check=None)
    file = File()
    file.binary = struct.pack("<f", math.nan) + file.binary[4:]
    torus_case("nan", file, exit=3, says=("vertex 0 is at",), check=None)
    file = File()
    file.json["meshes"][0]["primitives"].append(
        {"attributes": {"POSITION": file.accessor(componentType=FLOAT, count=1, type="VEC3",
                                                  min=[0, 0, 0], max=[0, 0, 0])}})
    torus_case("primitive_of_one_vertex", file)
    file = File()
    file.json["meshes"].append({"primitives": [{"attributes": {"NORMAL": 0}}]})
    file.json["nodes"] = [{"children": [1, 2]}, {"mesh": 0}, {"mesh": 1}]
    torus_case("primitive_without_positions", file)
    file = File()
    file.json["meshes"][0]["primitives"] += [{"attributes": {"POSITION": 0}, "mode": mode}
                                             for mode in (0, 1)]
    torus_case("points_and_lines", file, check=all_of(IS_TORUS, document_is(
        ("points and lines stay", lambda glb: [p.get("mode", 4) for p in glb.document["meshes"][0]
                                               ["primitives"]] == [4, 0, 1]))))
    return found


def containers() -> list[Case]:
    file = File()
    text = text_of(file).encode()

    def case(name, data, **more):
        return Case("gltf_" + name, {"a.glb": data}, "a.glb", **more)

    def cut(json):
        json["accessors"][0].pop("min")
        json["accessors"][0].pop("max")

    empty = changed(lambda j: j["scenes"][0].update(nodes=[]))

    def says_nothing_is_wrong(result: Result) -> str | None:
        said = result.report
        if said["problems"] or said["faces"] != 0 or said["asset"]["counts"]["meshes"] != 1:
            return f"faces {said['faces']}, problems {said['problems']}, asset {said['asset']}"
        return None if "the scene shows nothing" in said["warnings"][0] else f"{said['warnings']}"

    shorter = text_of(file).replace(f'"byteLength": {len(file.binary)}}}]',
                                    f'"byteLength": {len(file.binary) - 2}}}]').encode()
    return [
        case("bytes_behind", file.glb(further=b"\0" * 13), check=IS_TORUS),
        case("unknown_chunk", file.glb(further=struct.pack("<I4s", 8, b"XTRA") + b"12345678"),
             check=IS_TORUS),
        case("wrong_length", file.glb(total=12345678), exit=3, says=("header promises 12345678",)),
        case("no_padding", file.glb(pads=False), check=IS_TORUS),
        case("byte_order_mark", file.glb(b"\xef\xbb\xbf" + text), check=IS_TORUS),
        case("padded_with_zeros", file.glb(text + b"\0" * 4), check=IS_TORUS),
        case("buffer_too_short", file.glb(shorter), exit=3, says=("of a buffer of",)),
        case("no_bounds", changed(cut), check=IS_TORUS),
        case("wrong_bounds", changed(lambda j: j["accessors"][0].update(max=[9, 9, 9])),
             check=IS_TORUS),
        case("no_scene", changed(lambda j: (j.pop("scene"), j.pop("scenes"))), check=IS_TORUS),
        case("empty_scene", empty, says=("the scene shows nothing",),
             check=all_of(warns("empty-scene"), document_is(
                 ("its mesh is fitted", lambda glb: len(glb.accessor(
                     first_primitive(glb)["attributes"]["POSITION"])) > 1000),
                 ("its scene stays empty", lambda glb: not glb.positions())))),
        case("empty_scene_merged", empty, args=("--asset", "merge"), exit=4,
             says=("the scene shows nothing",)),
        Case("gltf_empty_scene_inspected", {"a.glb": empty}, "a.glb", inspects=True,
             check=says_nothing_is_wrong),
        case("cycle", changed(lambda j: j.update(nodes=[{"children": [1]},
                                                        {"children": [0], "mesh": 0}])),
             exit=3, says=("nodes must form trees",)),
        case("child_twice", changed(lambda j: j.update(nodes=[{"children": [1, 1]}, {"mesh": 0}])),
             exit=3, says=("nodes must form trees",)),
        case("version_1", changed(lambda j: j["asset"].update(version="1.0")), exit=3,
             says=("`1.0` is not 2.x",)),
        case("later_version", changed(lambda j: j["asset"].update(version="2.1")), check=IS_TORUS),
        case("later_version_needed",
             changed(lambda j: j.update(asset={"version": "2.1", "minVersion": "2.1"})), exit=3,
             says=("asset.minVersion: the file needs a reader of glTF 2.1",)),
        case("version_needed", changed(lambda j: j["asset"].update(minVersion="2.0")),
             check=IS_TORUS),
        case("latin_1", file.glb(text.replace(b'"mesh": 0', b'"mesh": 0, "name": "St\xfcck"')),
             exit=3, says=("UTF-8",)),
        case("trailing_comma", file.glb(text[:-1] + b",}"), exit=3, says=("parse error",)),
        case("numbers_with_points", file.glb(text.replace(b'"mesh": 0', b'"mesh": 0.0')
                                             .replace(b'"componentType": 5123',
                                                      b'"componentType": 5123.0')),
             check=counts(vertices=96, genus=1)),
        case("wrong_magic", b"XXXX" + file.glb()[4:], exit=3),
    ]


def scenes() -> list[Case]:
    found = []

    def case(name, file, **more):
        found.append(Case("gltf_" + name, {"a.glb": file.glb()}, "a.glb", **more))

    def seen(name, file, low, high, **more):
        found.append(Case(f"gltf_{name}_inspected", {"a.glb": file.glb()}, "a.glb", inspects=True,
                          check=says_bounds(low, high), **more))

    mirrored = node(File(), scale=[-1, 1, 1], translation=[3, 0, 0])
    case("mirrored", mirrored, check=passes([(3 - x, y, z) for x, y, z in POINTS]))
    both = File()
    both.json["nodes"] = [{"children": [1, 2]}, {"mesh": 0},
                          {"mesh": 0, "scale": [-1, 1, 1], "translation": [4, 0, 0]}]
    case("mirrored_too", both, check=bounded(LOW, (5.4, 1.4, 0.4)))
    case("flattened", node(File(), scale=[0, 1, 1]), check=bounded((0, -1.4, -0.4), (0, 1.4, 0.4)))
    instanced = node(File()).uses("EXT_mesh_gpu_instancing", required=True)
    places = instanced.add([(0, 0, 0), (4, 0, 0), (8, 0, 0)])
    instanced.json["nodes"][0]["extensions"] = {
        "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}
    case("instanced", instanced, check=IS_TORUS)
    seen("instanced", instanced, LOW, (9.4, 1.4, 0.4))
    far = (5804512.75, 120.5, -548213.25)
    case("far_node", node(File(), translation=far), check=passes(moved(POINTS, far), 3e-6))
    earth = File().uses("CESIUM_RTC", required=True)
    case("rtc", earth, exit=3, says=("`CESIUM_RTC` cannot be read",))
    two = File()
    two.json.update(nodes=[{"mesh": 0}, {"mesh": 0, "translation": [9, 0, 0]}],
                    scenes=[{"nodes": [0]}, {"nodes": [1]}], scene=1)
    case("second_scene", two, check=bounded((7.6, -1.4, -0.4), (10.4, 1.4, 0.4)))
    case("shear", node(File(), matrix=[1, 0, 0, 0, .5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
         check=passes([(x + y / 2, y, z) for x, y, z in POINTS]))
    case("matrix_and_translation", node(File(), matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0,
                                                        5, 0, 0, 1], translation=[1, 0, 0]))
    case("long_quaternion", node(File(), rotation=[0, 0, .7, .7]),
         check=passes([(-y, x, z) for x, y, z in POINTS]))
    hidden = File().uses("KHR_node_visibility")
    hidden.json["nodes"] = [{"children": [1, 2]}, {"mesh": 0},
                            {"mesh": 0, "translation": [4, 0, 0],
                             "extensions": {"KHR_node_visibility": {"visible": False}}}]
    case("hidden_node", hidden, check=IS_TORUS)
    needed = copy.deepcopy(hidden)
    needed.json["extensionsRequired"] = ["KHR_node_visibility"]
    case("hidden_node_required", needed, check=IS_TORUS)
    seen("hidden_node", needed, LOW, HIGH)
    # The place of a node with a skin means nothing; joints move the vertices.
    for name, bind in (("skin", None), ("skin_bound", [(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0,
                                                        0, 0, -5, 1)])):
        file = File()
        file.primitive["attributes"].update(JOINTS_0=file.add([(0, 0, 0, 0)] * 96, UBYTE),
                                            WEIGHTS_0=file.add([(1, 0, 0, 0)] * 96))
        file.json.update(nodes=[{"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
                                {"translation": [0, 0, 5]}],
                         scenes=[{"nodes": [0, 1]}], skins=[{"joints": [1]}])
        if bind:
            file.json["skins"][0]["inverseBindMatrices"] = file.add(bind)
        by = 0 if bind else 5
        case(name, file, check=document_is(
            ("joints and weights are carried",
             lambda glb: {"JOINTS_0", "WEIGHTS_0"} <= set(first_primitive(glb)["attributes"]))))
        seen(name, file, (-1.4, -1.4, by - 0.4), (1.4, 1.4, by + 0.4))
        case(name + "_merged", file, args=("--asset", "merge"),
             check=bounded((-1.4, -1.4, by - 0.4), (1.4, 1.4, by + 0.4)))
    file = File()
    file.primitive["attributes"].update(JOINTS_0=file.add([(0, 1, 0, 0)] * 96, UBYTE),
                                        WEIGHTS_0=file.add([(.3, .3, 0, 0)] * 96))
    file.json.update(nodes=[{"mesh": 0, "skin": 0}, {}, {}], scenes=[{"nodes": [0, 1, 2]}],
                     skins=[{"joints": [1, 2]}])
    case("weights_of_less_than_one", file, check=document_is(
        ("weights sum to 1", lambda glb: all(abs(sum(row) - 1) < 1e-6 for row in glb.accessor(
            first_primitive(glb)["attributes"]["WEIGHTS_0"])))))
    return found


def carried() -> list[Case]:
    """What rides on the vertices."""
    found = []

    def case(name, file, **more):
        found.append(Case("gltf_" + name, {"a.glb": file.glb()}, "a.glb", **more))

    def is_all(name, row, within=1e-6):
        return document_is((f"{name} is {row} everywhere", lambda glb: all(
            max(abs(a - b) for a, b in zip(given, row, strict=True)) <= within
            for given in glb.accessor(first_primitive(glb)["attributes"][name]))))

    def zeros(type, **more):
        return {"componentType": FLOAT, "count": 96, "type": type, **more}

    # Without a buffer view all is zero (glTF 2.0, section 3.6.2.1): Blender and Godot write so.
    file = File()
    file.primitive["attributes"]["TEXCOORD_0"] = file.accessor(**zeros("VEC2"))
    case("uvs_without_view", file, check=all_of(IS_TORUS, is_all("TEXCOORD_0", (0, 0))))
    file = File()
    file.primitive["attributes"]["COLOR_0"] = file.accessor(**zeros("VEC4"))
    case("colours_without_view", file, check=all_of(IS_TORUS, is_all("COLOR_0", (0, 0, 0, 0))))
    file = File()
    file.primitive["targets"] = [{"POSITION": file.accessor(
        **zeros("VEC3", min=[0, 0, 0], max=[0, 0, 0]))}]
    case("target_without_view", file, check=all_of(IS_TORUS, document_is(
        ("the target moves nothing", lambda glb: not any(
            any(row) for row in glb.accessor(first_primitive(glb)["targets"][0]["POSITION"]))))))
    file = File()
    file.primitive["attributes"].update(
        JOINTS_0=file.accessor(componentType=UBYTE, count=96, type="VEC4"),
        WEIGHTS_0=file.add([(1, 0, 0, 0)] * 96))
    file.json.update(nodes=[{"mesh": 0, "skin": 0}, {}], scenes=[{"nodes": [0, 1]}],
                     skins=[{"joints": [1]}])
    case("joints_without_view", file, check=is_all("JOINTS_0", (0, 0, 0, 0)))
    file = File()
    file.primitive["targets"] = [{"POSITION": file.accessor(
        **file.sparse([(0, 0, .3)] * 8, range(8), "VEC3", 96), min=[0, 0, 0], max=[0, 0, .3])}]
    case("sparse_target", file, check=all_of(IS_TORUS, document_is(
        ("the first ring moves by 0.3", lambda glb: abs(max(
            row[2] for row in glb.accessor(first_primitive(glb)["targets"][0]["POSITION"])) - .3)
            < 1e-5))))
    file = File()
    file.primitive["attributes"]["COLOR_0"] = file.add([(65535, 32768, 16384)] * 96, USHORT, 8,
                                                       normalized=True)
    case("colours_of_shorts", file,
         check=is_all("COLOR_0", (1, 32768 / 65535, 16384 / 65535, 1), 1e-5))
    # Targets of colours and texture coordinates.
    file = File()
    file.primitive["attributes"].update(COLOR_0=file.add([(0.5, 0.5, 0.5)] * 96),
                                        TEXCOORD_0=file.add([(p[0] / 4, p[1] / 4) for p in POINTS]))
    file.primitive["targets"] = [
        {"COLOR_0": file.add([(0.25, -0.25, 0)] * 96), "TEXCOORD_0": file.add([(0.5, -0.125)] * 96)}]

    def target_is(name, row):
        return lambda glb: all(
            max(abs(a - b) for a, b in zip(given, row, strict=True)) < 1e-6
            for given in glb.accessor(first_primitive(glb)["targets"][0][name]))

    case("target_of_colours", file, check=document_is(
        ("colours move", target_is("COLOR_0", (0.25, -0.25, 0, 0))),
        ("texture coordinates move", target_is("TEXCOORD_0", (0.5, -0.125)))))
    file = File()
    file.primitive["attributes"]["TANGENT"] = file.add([(1, 0, 0, 1)] * 96)
    file.primitive["targets"] = [{"POSITION": file.positions([(0, 0, .1)] * 96),
                                  "TANGENT": file.add([(0, 0, 0)] * 96)}]
    case("target_of_tangents", file, check=warns("left-out-targets"))
    # A colour for each triangle, on vertices of its own.
    file = File([POINTS[k] for f in FACES for k in f], None)
    file.primitive["attributes"]["COLOR_0"] = file.add(
        [(i % 2, 0, 0) for i in range(len(FACES)) for _ in range(3)])
    case("colours_of_faces", file, check=all_of(warns_nothing, document_is(
        ("colours are those of faces",
         lambda glb: {row[0] for row in glb.attribute("COLOR_0")} == {0, 1}))))
    points = sphere(1500)
    file = File(points, None)
    file.primitive["mode"] = 0
    file.primitive["material"] = 0
    file.json["materials"] = [{"name": "stars"}]
    file.primitive["attributes"]["TEXCOORD_0"] = file.add([(0, 0)] * 1500)
    case("points", file, says=("left out of the points: TEXCOORD_0, material",))
    splats = File(points, None)
    splats.primitive["mode"] = 0
    splats.primitive["attributes"]["KHR_gaussian_splatting:OPACITY"] = splats.add([(1,)] * 1500)
    splats.primitive["extensions"] = {"KHR_gaussian_splatting": {"kernel": "ellipse"}}
    case("splats", splats.uses("KHR_gaussian_splatting"),
         says=("left out of the points: KHR_gaussian_splatting:OPACITY",))
    return found


def extensions() -> list[Case]:
    found = []

    def case(name, file, **more):
        found.append(Case("gltf_" + name, {"a.glb": file.glb()}, "a.glb", **more))

    def with_extension(name, of, **extension) -> File:
        file = File().uses(name)
        holder = file.primitive if of == "primitive" else file.json["meshes"][0]
        holder["extensions"] = {name: extension}
        return file

    case("unknown_required", File().uses("ACME_x", required=True), exit=3,
         says=("`ACME_x` cannot be read",))
    case("khr_meshopt", File().uses("KHR_meshopt_compression", required=True), exit=3,
         says=("`KHR_meshopt_compression` cannot be read",))
    variants = with_extension("KHR_materials_variants", "primitive",
                              mappings=[{"material": 1, "variants": [1]}])
    variants.json.update(materials=[{"name": "a"}, {"name": "b"}], extensions={
        "KHR_materials_variants": {"variants": [{"name": "x"}, {"name": "y"}]}})
    variants.primitive["material"] = 0
    case("variants", variants, check=all_of(warns_nothing, document_is(
        ("variants stay", lambda glb: "KHR_materials_variants" in
         first_primitive(glb)["extensions"]))))
    # Extensions that describe the old triangles.
    outline = with_extension("CESIUM_primitive_outline", "primitive")
    outline.primitive["extensions"]["CESIUM_primitive_outline"]["indices"] = outline.add(
        [(0,), (8,), (8,), (16,)], USHORT)
    case("outline", outline, says=("CESIUM_primitive_outline",),
         check=all_of(warns("left-out-extensions"), has_no_extension("CESIUM_primitive_outline")))
    manifold = with_extension("EXT_mesh_manifold", "mesh",
                              manifoldPrimitive={"indices": 1, "attributes": {"POSITION": 0}})
    case("manifold", manifold, says=("EXT_mesh_manifold",), check=all_of(
        warns("left-out-extensions"), has_no_extension("EXT_mesh_manifold"),
        document_is(("no old accessor stays", lambda glb: len(glb.document["accessors"]) == 3))))
    unknown = with_extension("ACME_wires", "primitive", wires=[{"indices": 1}])
    case("unknown_of_triangles", unknown, says=("ACME_wires",),
         check=all_of(warns("left-out-extensions"), has_no_extension("ACME_wires")))
    case("unknown_of_nothing", with_extension("ACME_price", "primitive", price=12), check=all_of(
        warns_nothing, document_is(("it stays", lambda glb: first_primitive(glb)["extensions"] ==
                                    {"ACME_price": {"price": 12}}))))
    counted = File().uses("FB_geometry_metadata")
    counted.json["scenes"][0]["extensions"] = {"FB_geometry_metadata": {"vertexCount": 96}}
    case("scene_counts", counted,
         check=all_of(warns("left-out-extensions"), has_no_extension("FB_geometry_metadata")))
    # Triangles encode the quads of the surface.
    for args in ((), ("--levels", "0"), ("--levels", "1", "--quads", "off")):
        found.append(Case("gltf_ngons" + "".join(args), {
            "a.glb": with_extension("FB_ngon_encoding", "primitive").glb()}, "a.glb", args=args,
            check=document_is(
                ("the extension stays", lambda glb: "extensions" in first_primitive(glb)),
                ("all polygons are quads", lambda glb: {len(p) for p in polygons(glb)} == {4}))))
    found.append(Case("gltf_ngons_quantized", {
        "a.glb": with_extension("FB_ngon_encoding", "primitive").glb()}, "a.glb",
        args=("--compress", "quantize"), check=document_is(
            ("all polygons are quads", lambda glb: {len(p) for p in polygons(glb)} == {4}))))
    found.append(Case("gltf_ngons_packed", {
        "a.glb": with_extension("FB_ngon_encoding", "primitive").glb()}, "a.glb",
        args=("--compress", "meshopt"), says=("FB_ngon_encoding",),
        check=warns("left-out-extensions")))
    needed = with_extension("FB_ngon_encoding", "primitive")
    needed.json["extensionsRequired"] = ["FB_ngon_encoding"]
    found.append(Case("gltf_ngons_needed", {"a.glb": needed.glb()}, "a.glb",
                      args=("--compress", "meshopt"), exit=3,
                      says=("`FB_ngon_encoding` describes triangles that give way",)))
    # And those of the file are its polygons.
    def encoded(points, fans, **more) -> File:
        return File(points, [(f[0], f[k], f[k + 1]) for f in fans for k in range(1, len(f) - 1)],
                    **more).uses("FB_ngon_encoding")

    around = [(math.cos(math.pi * k / 3), math.sin(math.pi * k / 3)) for k in range(6)]
    prism = [(x, y, z) for z in (0, 1) for x, y in around]
    walls = [(k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k) for k in range(6)]
    fans = [(5, 4, 3, 2, 1, 0), *walls, (6, 7, 8, 9, 10, 11)]
    quad = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 1, 0), (-1, 0, 0)]
    apex = [(0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    for name, points, given, faces in (
            ("read", prism, fans, 8), ("apart", quad, [(0, 1, 2), (0, 3, 4)], 2),
            ("closed_fan", apex, [(0, 1, 2, 3, 4, 1)], 2),
            ("split_first", quad + quad[:1], [(0, 1, 2, 3), (6, 3, 4, 5)], 2),
            ("split_last", quad + quad[2:3], [(0, 1, 2), (0, 2, 6), (0, 6, 3)], 1)):
        file = encoded(points, given)
        file.primitive["extensions"] = {"FB_ngon_encoding": {}}
        case(f"ngons_{name}", file, args=("--quads", "off"), check=all_of(
            counts(file_faces=faces, file_vertices=len({points[k] for f in given for k in f})),
            passes([points[k] for f in given for k in f])))
    turned = node(encoded(prism, fans), scale=[-1, 1, 1])
    turned.primitive["extensions"] = {"FB_ngon_encoding": {}}
    case("ngons_mirrored", turned, args=("--asset", "merge"), silent=("inside",),
         check=counts(file_faces=8, components=1, genus=0))
    # Ids are those of the nearest vertex, never between two.
    for name, kind in (("floats", FLOAT), ("bytes", UBYTE)):
        features = with_extension("EXT_mesh_features", "primitive",
                                  featureIds=[{"featureCount": 2, "attribute": 0}])
        features.primitive["attributes"]["_FEATURE_ID_0"] = features.add(
            [(3 * (i // 48),) for i in range(96)], kind, 4)
        case("features_of_" + name, features, check=all_of(warns_nothing, document_is(
            ("ids are whole", lambda glb: {row[0] for row in glb.attribute("_FEATURE_ID_0")} ==
             {0, 3}),
            ("the extension stays", lambda glb: "extensions" in first_primitive(glb)))))
        for more, args in (("adaptive", ("--chord-error", "1e-3")),
                           ("packed", ("--compress", "quantize")),
                           ("catmull_clark", ("--scheme", "catmull-clark"))):
            found.append(Case(f"gltf_features_of_{name}_{more}", {"a.glb": features.glb()},
                              "a.glb", args=args, check=document_is(
                ("ids are whole", lambda glb: {row[0] for row in glb.attribute("_FEATURE_ID_0")}
                 == {0, 3}))))
    features = with_extension("EXT_mesh_features", "primitive",
                              featureIds=[{"featureCount": 192, "attribute": 0}])
    features.json["accessors"], features.json["bufferViews"], features.binary = [], [], b""
    del features.primitive["indices"]
    features.primitive["attributes"] = {
        "POSITION": features.positions([POINTS[k] for f in FACES for k in f]),
        "_FEATURE_ID_0": features.add([(i,) for i in range(192) for _ in range(3)])}
    case("features_of_faces", features, check=all_of(warns_nothing, document_is(
        ("ids are those of faces", lambda glb: {row[0] for row in glb.attribute("_FEATURE_ID_0")} ==
         set(range(192))),
        ("the extension stays", lambda glb: "extensions" in first_primitive(glb)))))
    implicit = with_extension("EXT_mesh_features", "primitive", featureIds=[{"featureCount": 96}])
    case("features_of_vertices", implicit,
         check=all_of(warns("left-out-extensions"), has_no_extension("EXT_mesh_features")))
    # Textures that are not there.
    textured = File()
    textured.primitive["material"] = 0
    textured.json.update(images=[{"uri": "gone%20away.png"}], textures=[{"source": 0}],
                         materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])
    image = base64.b64encode(b"\x89PNG\r\n\x1a\n").decode()

    def picture(glb):
        entry = glb.document["images"][0]
        view = glb.document["bufferViews"][entry["bufferView"]]
        return glb.binary[view["byteOffset"] :][: view["byteLength"]], entry

    case("texture_missing", textured, says=("gone away.png", "materials are as without it"),
         check=all_of(warns("missing-images"), document_is(
             ("a pixel stands for it", lambda glb: picture(glb)[0].startswith(b"\x89PNG")),
             ("nothing names the file as an address", lambda glb: "uri" not in picture(glb)[1]))))
    inside = copy.deepcopy(textured)
    inside.json["images"] = [{"uri": f"data:image/png;base64,{image}"}]
    case("texture_in_data", inside, check=all_of(warns_nothing, document_is(
        ("it stands in the buffer", lambda glb: picture(glb)[0] == b"\x89PNG\r\n\x1a\n"),
        ("its type is said", lambda glb: picture(glb)[1] == {
            "bufferView": picture(glb)[1]["bufferView"], "mimeType": "image/png"}))))
    return found


def cases() -> list[Case]:
    return addresses() + stored() + containers() + scenes() + carried() + extensions()
