"""Meshes of all formats but glTF; points are in point_cases.py."""

import math
import random
import struct

import shapes
from case import Case, all_of, bounded, counts, near, passes, warns, warns_nothing
from shapes import CUBE_FACES, CUBE_POINTS, corners_of, lines, merged, moved, obj, obj_faces, torus

POINTS, FACES = torus()
IS_TORUS = all_of(counts(vertices=96, genus=1, components=1, boundary_loops=0), passes(POINTS))
IS_CUBE = counts(vertices=8, faces=6, genus=0, components=1, boundary_loops=0)
SRGB_128 = ((128 / 255 + 0.055) / 1.055) ** 2.4  # linear


def good(name, data, check=IS_TORUS, **more):
    files = data if isinstance(data, dict) else {"a." + name.split("_")[0]: data}
    files = {path: text if isinstance(text, bytes) else text.encode() for path, text in files.items()}
    return Case(name, files, next(iter(files)), check=check, **more)


def bad(name, data, *says, exit=3, **more):
    return good(name, data, check=None, exit=exit, says=says, **more)


def colored(expected, within=2e-3):
    """The surface's first vertex has this colour, linear."""

    def check(result):
        found = result.output().attribute("COLOR_0")
        if not found:
            return "no colours"
        return None if near(found[0][:3], expected, within) else f"colour {found[0]}, not {expected}"

    return check


def has_uvs(result):
    return None if result.output().attribute("TEXCOORD_0") else "no texture coordinates"


def obj_cases():
    three = "".join(
        lines("v %g %g %g", moved(CUBE_POINTS, (3 * k, 0, 0)))
        + "".join("f " + " ".join(str(i - 8) for i in f) + "\n" for f in CUBE_FACES)
        for k in range(3)
    )
    plain, vertices, faces = obj(POINTS, FACES), obj(POINTS, []), obj_faces(FACES)
    yield good("obj_plain", plain, all_of(IS_TORUS, warns_nothing))
    yield good("obj_negative_blocks", three, counts(vertices=24, faces=18, components=3))
    continued = "".join("v %.9g %.9g \\\n %.9g\n" % p for p in POINTS) + "usemtl A\\B_\\C\n"
    continued += "".join("f %d %d \\\n%d \\\n %d\n" % tuple(i + 1 for i in f) for f in FACES)
    yield good("obj_continued_lines", continued)
    yield good("obj_usemtl_swallows_face", vertices + "usemtl tex\\\n" + faces,
               counts(vertices=96, faces=95), says=("a.obj:97", "`usemtl`", "goes on with the next line"))
    tabs = lines("v\t%.9g\t%.9g  %.9g \t", POINTS)
    tabs += "".join("f\t%d\v%d\f%d\t%d \n" % tuple(i + 1 for i in f) for f in FACES)
    yield good("obj_tabs", tabs)
    text = "mtllib my mat.mtl\nusemtl Rot\n" + plain
    mtl = "newmtl Rot\nKd 1 0 0\nmap_Kd -bm 0.3 -s 2 2 2 my tex.png\nnewmtl W\nmap_Kd C:\\tex\\a.png\n"
    yield good("obj_utf16", {"a.obj": b"\xfe\xff" + text.encode("utf-16-be"), "my mat.mtl": mtl},
               all_of(IS_TORUS, warns("utf-16")))
    yield good("obj_bom", {"a.obj": b"\xef\xbb\xbf" + text.encode(), "my mat.mtl": mtl})
    yield bad("obj_index_zero", plain.replace("f 1 9 ", "f 0 9 "), "a.obj:97", "counts from 1")
    mixed = lines("v %.9g %.9g %.9g 1.0", POINTS[:48]) + lines("v %.9g %.9g %.9g 0.2 0.4 0.6", POINTS[48:])
    yield good("obj_w_and_colour", mixed + faces)
    double = [tuple(2 * c for c in p) for p in POINTS]
    yield good("obj_w_is_no_divisor", lines("v %.9g %.9g %.9g 2.0", double) + faces, passes(double))
    last = FACES[-1]
    yield good("obj_corner_twice", obj(POINTS, FACES[:-1] + [(last[0], last[1], last[1], last[3])]),
               counts(vertices=96, faces=96))
    yield good("obj_lines_and_points", plain + "l 1 2 3 4\np 1\nf 1 2\nf 3\nl 1/ 2/\n",
               says=("faces of one or two corners, dropped: 2",))
    far = torus(scale=5, at=(548213.25, 5804512.75, 120.5))[0]
    yield good("obj_utm", obj(far, FACES, "%.4f"), passes(far, 3e-6))
    small = torus(scale=0.01, at=(548213.25, 5804512.75, 120.5))[0]
    yield good("obj_utm_small_part", obj(small, FACES, "%.9f"), passes(small, 1e-5))
    split = [CUBE_POINTS[i] for f in CUBE_FACES for i in f]
    quads = [tuple(range(k, k + 4)) for k in range(0, 24, 4)]
    yield good("obj_split_cube", obj(split, quads), counts(vertices=24, components=6),
               says=("--weld 0 makes them one",))
    yield good("obj_split_cube_welded", obj(split, quads), IS_CUBE, args=("--weld", "0"))
    yield good("obj_double_shell", obj(POINTS, FACES + [tuple(reversed(f)) for f in FACES]))
    yield good("obj_repeated_faces", obj(POINTS, FACES + FACES[:10]))
    yield good("obj_touching_corner", obj(*merged(CUBE_POINTS + moved(CUBE_POINTS, (1, 1, 1)), CUBE_FACES
               + [tuple(i + 8 for i in f) for f in CUBE_FACES])), counts(components=2, boundary_loops=0))
    two = CUBE_FACES + [tuple(i + 8 for i in f) for f in CUBE_FACES]
    yield good("obj_touching_edge", obj(*merged(CUBE_POINTS + moved(CUBE_POINTS, (1, 1, 0)), two)),
               counts(components=2, boundary_loops=0))
    yield good("obj_inner_wall", obj(*merged(CUBE_POINTS + moved(CUBE_POINTS, (1, 0, 0)), two)),
               counts(components=3), says=("repeat another one",))
    yield good("obj_inside_out", obj(POINTS, [tuple(reversed(f)) for f in FACES]))
    turned = [tuple(reversed(f)) if k % 3 == 0 else f for k, f in enumerate(FACES)]
    yield good("obj_some_turned", obj(POINTS, turned))
    ring = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0), (1, 1, 0), (1, 3, 0), (3, 3, 0), (3, 1, 0)]
    yield good("obj_keyhole", obj(ring, [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)]), passes(ring))
    ell = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))]
    walls = [(i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6) for i in range(6)]
    yield good("obj_concave", obj(ell, [(5, 4, 3, 2, 1, 0), tuple(range(6, 12))] + walls),
               all_of(counts(vertices=12, genus=0, boundary_loops=0), passes(ell)))
    strip = []
    for i in range(24):
        a = math.pi * i / 12
        strip += [((1 + t * math.cos(a / 2)) * math.cos(a), (1 + t * math.cos(a / 2)) * math.sin(a),
                   t * math.sin(a / 2)) for t in (-0.3, 0, 0.3)]
    twisted = [(i * 3 + j, i * 3 + j + 3, i * 3 + j + 4, i * 3 + j + 1) for i in range(23) for j in (0, 1)]
    twisted += [(69 + j, 2 - j, 1 - j, 70 + j) for j in (0, 1)]
    yield good("obj_moebius", obj(strip, twisted), passes(strip))
    tee = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (4, 0, 0), (4, 1, 0), (4, 2, 0), (2, 1, 0)]
    yield good("obj_t_junction", obj(tee, [(0, 1, 2, 3), (1, 4, 5, 7), (7, 5, 6, 2)]), passes(tee))
    rim = [(math.cos(math.pi * i / 300), math.sin(math.pi * i / 300), z) for z in (0, 0.5) for i in range(600)]
    around = [(i, (i + 1) % 600, 600 + (i + 1) % 600, 600 + i) for i in range(600)]
    caps = [tuple(reversed(range(600))), tuple(range(600, 1200))]
    yield good("obj_600_corners", obj(rim, caps + around), all_of(counts(vertices=1200, genus=0), passes(rim)))
    fan = rim[:600] + [(0, 0, 1)]
    yield good("obj_fan_of_600", obj(fan, [(i, (i + 1) % 600, 600) for i in range(600)]), passes(fan))
    free = "cstype rat bspline\ndeg 2 2\nsurf 0 1 0 1 1 2 3 4 5 6 7 8 9\nparm u 0 0 0 1 1 1\nparm v 0 0 0 1 1 1\nend\n"
    yield good("obj_free_form_besides", "vp 0 0\nvp 1 0\n" + plain + free)
    commented = "".join("v %.9g %.9g %.9g # vertex %d\n" % (*p, k) for k, p in enumerate(POINTS))
    yield good("obj_comments_behind", commented + faces.replace("\n", " # face\n"))
    yield good("obj_cr_only", plain.replace("\n", "\r"))
    yield good("obj_crlf_no_end", plain.replace("\n", "\r\n").rstrip())
    yield bad("obj_decimal_comma", plain.replace(".", ","), "a.obj:1", "if that is meant")
    yield good("obj_unused_nan", plain + "v nan nan nan\n",
               all_of(counts(file_vertices=97, components=1, genus=1), passes(POINTS)),
               says=("a.obj:193", "no face names such vertices"))
    yield bad("obj_used_ind", plain.replace("v 1.4 0 0", "v -1.#IND 0 1.#QNAN", 1), "a.obj:1", "no finite number")
    fortran = "".join("v %s\n" % " ".join(("%.6E" % c).replace("E", "D") for c in p) for p in POINTS)
    yield bad("obj_fortran_exponents", fortran + faces, "a.obj:1", "no finite number")
    normals = "".join("f " + " ".join("%d//%d" % (i + 1, i + 1) for i in f) + "\n" for f in FACES)
    yield good("obj_nan_normals", vertices + "vn nan nan nan\n" * 96 + normals)
    groups = "mtllib nowhere.mtl\no\ng\no A\ng a b c\no A\nusemtl\nusemtl none here\ns off\ns 1\n"
    yield good("obj_empty_groups", groups + plain + "g end\no last\n", says=("nowhere.mtl",))
    forms = ("%d/1/1", "%d//1", "%d", "%d/1")
    refs = "".join("f " + " ".join(forms[k % 4] % (i + 1) for i in f) + "\n" for k, f in enumerate(FACES))
    yield good("obj_mixed_references", vertices + "vt 0 0\nvn 0 0 1\n" + refs)
    seam = POINTS + [(p[0] + 1.2e-7, p[1], p[2]) for p in POINTS[:8]]
    parted = [tuple(i + 96 if i < 8 and k >= 88 else i for i in f) for k, f in enumerate(FACES)]
    yield good("obj_seam_by_rounding", obj(seam, parted), counts(vertices=104, boundary_loops=2),
               says=("--weld 1e-05 makes them one",))
    for name, scale in (("1e-6", 1e-6), ("1e12", 1e12), ("1e-40", 1e-40), ("1e38", 1e38)):
        scaled = torus(scale=scale)[0]
        inside = passes(scaled) if 1e-30 < scale < 1e30 else counts(vertices=96, genus=1)
        yield good(f"obj_size_{name}", obj(scaled, FACES), inside)
    yield bad("obj_size_1e200", obj(torus(scale=1e200)[0], FACES), "1e", exit=4)
    yield good("obj_plus_signs", lines("v %+.9e %+.9E %+.9g", POINTS) + faces.replace(" ", " +"))
    yield good("obj_faces_first", faces + vertices)
    bow = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
    yield good("obj_bow_tie", obj(bow, [(0, 2, 1, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]), passes(bow))
    star = [(0, 0, 0), (0, 0, 1)]
    star += [(math.cos(math.pi * i / 20), math.sin(math.pi * i / 20), z) for i in range(40) for z in (0, 1)]
    yield good("obj_40_faces_on_an_edge", obj(star, [(0, 2 + 2 * i, 3 + 2 * i, 1) for i in range(40)]), passes(star))
    tent = [(x, y, 2.0 if (x, y) == (1, 1) else 0.0) for y in range(4) for x in range(4)]
    grid = [(y * 4 + x, y * 4 + x + 1, y * 4 + x + 5, y * 4 + x + 4) for y in range(3) for x in range(3)]
    yield good("obj_corner_tag", obj(tent, grid) + "t corner 1/1/0 5 10.0\n", passes(tent))
    yield bad("obj_index_above_32_bits", obj(POINTS, FACES[:-1]) + "f 4294967297 2 3 4\n", "4294967297")
    yield bad("obj_index_of_20_digits", obj(POINTS, FACES[:-1]) + "f 99999999999999999999 2 3 4\n", "a.obj:192")
    yield bad("obj_empty", "", "a.obj", exit=4)
    sheet = [(x, y, 0.3 * math.sin(x)) for y in range(5) for x in range(7)]
    flat = [(y * 7 + x, y * 7 + x + 1, y * 7 + x + 8, y * 7 + x + 7) for y in range(4) for x in range(6)]
    fin = [(3, y, 0.3 * math.sin(3) + 1) for y in range(5)]
    blade = [(y * 7 + 3, (y + 1) * 7 + 3, 36 + y, 35 + y) for y in range(4)]
    for name, order in (("obj_fin_on_sheet", flat + blade), ("obj_fin_first", blade + flat)):
        yield good(name, obj(sheet + fin, order), passes(sheet + fin))
    yield good("obj_unread_maps", {"a.obj": "mtllib m.mtl\nusemtl A\n" + plain,
               "m.mtl": "newmtl A\nKd 1 1 1\nmap_d a.png\nmap_Ks b.png\nmap_Pr c.png\nmap_Pm d.png\n"},
               says=("map_d, map_ks, map_pm, map_pr",))


def ply_cases():
    head = shapes.ply_head
    plain = shapes.ply(POINTS, FACES)
    yield good("ply_plain", plain, all_of(IS_TORUS, warns_nothing))
    first = struct.unpack("<f", b"\x0a\x33\xb3\x3f")[0]  # its first byte ends lines
    late = [(first, *POINTS[0][1:])] + POINTS[1:]
    for name, end in (("lf", "\n"), ("crlf", "\r\n"), ("cr", "\r")):
        yield good(f"ply_binary_{name}", shapes.ply_binary(POINTS, FACES, end=end))
        yield good(f"ply_binary_{name}_then_10", shapes.ply_binary(late, FACES, end=end),
                   all_of(counts(vertices=96, genus=1), passes(late)))
    strip = []
    for i in range(12):
        for j in range(9):
            strip += [i * 8 + j % 8, (i + 1) % 12 * 8 + j % 8]
        strip.append(-1)
    strips = head("binary_little_endian", 96, None).replace(
        "end_header", "element tristrips 1\nproperty list int int vertex_indices\nend_header").encode()
    strips += shapes.packed("<3f", POINTS) + struct.pack(f"<i{len(strip)}i", len(strip), *strip)
    is_stripped = all_of(counts(vertices=96, file_faces=192, genus=1, components=1), passes(POINTS))
    yield good("ply_strips_binary", strips, is_stripped, silent=("turned",))
    text = head("ascii", 96, None).replace(
        "end_header", "element tristrips 1\nproperty list int int vertex_indices\nend_header")
    text += lines("%.9g %.9g %.9g", POINTS) + f"{len(strip)} " + " ".join(map(str, strip)) + "\n"
    yield good("ply_strips_text", text, is_stripped, silent=("turned",))
    yield bad("ply_strips_index", text[:-2].rsplit(" ", 1)[0] + " -2\n", "vertex -2 of 96")
    yield good("ply_uint", shapes.ply_binary(POINTS, FACES, count="uint", index="uint"))
    yield good("ply_ushort_big_endian", shapes.ply_binary(POINTS, FACES, ">", "ushort", "ushort", name="vertex_index"))
    yield good("ply_uchar_double", shapes.ply_binary(POINTS, FACES, index="uchar", kind="double"))
    around = "property uchar material_index\nproperty list uchar int vertex_indices\nproperty float quality"
    between = head("ascii", 96, 96, face=around) + lines("%.9g %.9g %.9g", POINTS)
    yield good("ply_face_properties", between + lines("7 4 %d %d %d %d 0.5", FACES),
               all_of(IS_TORUS, warns("ignored-face-properties")), says=("material_index, quality",))
    big = "\n".join(["ply", "format binary_big_endian 1.0", "comment TextureFile a b.png", "element camera 1",
                     "property float view_px", "property list uchar int junk", "element face 96",
                     "property list uchar int vertex_indices", "property list uchar float texcoord",
                     "property int texnumber", "element vertex 96", *(f"property double {c}" for c in "xyz"),
                     *(f"property uchar {c}" for c in ("red", "green", "blue")),
                     "property list uchar float bones", "element edge 1", "property int vertex1",
                     "property int vertex2", "end_header", ""]).encode()
    big += struct.pack(">fB2i", 1, 2, 5, 6)
    for f in FACES:
        big += struct.pack(">B4iB8fi", 4, *f, 8, 0, 0, 1, 0, 1, 1, 0, 1, 0)
    for p in POINTS:
        big += struct.pack(">3d3BB2f", *p, 200, 100, 0, 2, 1, 1)
    yield good("ply_faces_first", big + struct.pack(">2i", 0, 1), all_of(IS_TORUS, has_uvs),
               says=("texnumber", "a b.png"))
    rgb = ("red", "green", "blue")
    for name, kind, values, linear in (
            ("uchar", "uchar", "255 128 64", (1, SRGB_128)), ("ushort", "ushort", "65535 32896 16384", (1, SRGB_128)),
            ("float", "float", "1 0.50196 0.25", (1, SRGB_128)), ("float_255", "float", "255 128 64", (1, SRGB_128)),
            ("double_255", "double", "254.5 128 64", (0.9957, SRGB_128))):
        further = [f"{kind} {c}" for c in rgb]
        told = warns("color-range") if name.endswith("255") else warns_nothing
        yield good(f"ply_colour_{name}", shapes.ply(POINTS, FACES, further=further, values=" " + values),
                   all_of(IS_TORUS, told, lambda r, l=linear: None if near(
                       r.output().attribute("COLOR_0")[0][:2], l, 4e-3) else f"{r.output().attribute('COLOR_0')[0]}"))
    diffuse = [f"uchar diffuse_{c}" for c in rgb]
    yield good("ply_colour_diffuse", shapes.ply(POINTS, FACES, further=diffuse, values=" 255 128 64"),
               all_of(IS_TORUS, colored((1, SRGB_128, 0.0513), 5e-3)))
    faced = head("ascii", 96, 96, face="property list uchar int vertex_indices\n" + "\n".join(f"property uchar {c}" for c in rgb))
    faced += lines("%.9g %.9g %.9g", POINTS) + lines("4 %d %d %d %d 255 0 0", FACES)
    yield good("ply_colour_of_faces", faced, says=("red, green, blue",))
    padded = plain.replace("ply\n", "ply \n").replace("ascii 1.0", "ascii 1.0  ").replace("element vertex 96", "element vertex   96 ")
    padded = padded.replace("property float x", "property  float x ").replace("element face", "\nelement face").replace("end_header\n", "end_header \n\n")
    yield good("ply_blanks", padded)
    wrapped = head("ascii", 96, 96) + " ".join("%.9g %.9g %.9g" % p for p in POINTS) + "\n"
    yield good("ply_wrapped", wrapped + " ".join("4 %d %d %d %d" % f for f in FACES) + "\n",
               all_of(IS_TORUS, warns("wrapped-lines")))
    tall = head("ascii", 96, 96) + lines("%.9g\n%.9g\n%.9g", POINTS) + lines("4\n%d %d\n%d %d", FACES)
    yield good("ply_wrapped_tall", tall, all_of(IS_TORUS, warns("wrapped-lines")))
    yield bad("ply_wrapped_one_missing", tall.rsplit(" ", 1)[0], "a.ply:")
    yield good("ply_int", shapes.ply(CUBE_POINTS, CUBE_FACES, kind="int"), IS_CUBE)
    below = moved(CUBE_POINTS, (-1, -1, -1))
    yield good("ply_int_negative", shapes.ply(below, CUBE_FACES, kind="int"), passes(below))
    yield good("ply_int_negative_binary", shapes.ply_binary(below, CUBE_FACES, kind="int"), passes(below))
    yield good("ply_two_corners", shapes.ply(POINTS, FACES + [(0, 1), (0,)]), says=("faces of one or two corners, dropped: 2",))
    yield bad("ply_index_minus_1", shapes.ply(POINTS, FACES[:-1]) .replace("face 95", "face 96") + "4 -1 0 1 2\n", "vertex -1 of 96")
    yield bad("ply_promises_too_many", shapes.ply_binary(POINTS, FACES).replace(b"vertex 96", b"vertex 4000000000"), "4000000000")
    yield bad("ply_version_1_1", plain.replace("ascii 1.0", "ascii 1.1"), "a.ply:2", "1.1")
    yield bad("ply_capital_axes", plain.replace("float x", "float X"), "no property `x`")
    yield bad("ply_index_ffffffff", shapes.ply_binary(POINTS, FACES[:-1] + [(0xFFFFFFFF, 1, 2, 3)], index="uint"), "4294967295")
    yield bad("ply_magic_only", "ply\n", "inside the header")


def stl_cases():
    corners = corners_of(POINTS, FACES)
    binary, text = shapes.stl_binary, shapes.stl_text(corners)
    yield good("stl_binary", binary(corners), all_of(IS_TORUS, warns_nothing))
    yield good("stl_text", text, all_of(IS_TORUS, warns_nothing))
    yield good("stl_binary_solid", binary(corners, b"solid base exported by a program"))
    yield good("stl_binary_solid_facet", binary(corners, b"solid base\nfacet normal 0 0 0\nouter loop\n"))
    yield good("stl_leading_blanks", "  " + text)
    yield good("stl_long_name", shapes.stl_text(corners, "x" * 700 + " facet outer", "nan -nan(ind) 1.#IND", "\r\n"))
    yield good("stl_capitals", text.upper())
    second = shapes.stl_text(corners_of(moved(POINTS, (5, 0, 0)), FACES), "b")
    yield good("stl_two_solids", shapes.stl_text(corners, "") + second, counts(vertices=192, components=2))
    yield bad("stl_count_0", binary(corners, count=0), "promises 0 triangles in 84 bytes, but the file has 9684, which 192")
    yield bad("stl_count_ffffffff", binary(corners, count=0xFFFFFFFF), "has 9684, which 192")
    yield good("stl_zeros_behind", binary(corners, b"part", tail=bytes(37)), says=("37 zero bytes", "byte 9684"))
    yield good("stl_zero_behind", binary(corners, b"part", tail=b"\0"), says=("1 zero byte behind the triangles",))
    yield bad("stl_more_behind", binary(corners, b"part", tail=b"\1" * 37), "9684 bytes, but the file has 9721")
    yield bad("stl_cut_short", binary(corners)[:-25], "9684 bytes, but the file has 9659")
    yield good("stl_colours_viscam", binary(corners, behind=0xFC00), says=("colours of triangles are left out",))
    yield good("stl_colours_magics", binary(corners, b"COLOR=\x80\x80\x80\xff"), says=("colours of triangles are left out",))
    random.seed(7)
    shaken = [tuple(tuple(c + random.uniform(-6e-8, 6e-8) for c in p) for p in t) for t in corners]
    yield good("stl_rounded_corners", binary(shaken), all_of(IS_TORUS, warns("joined-corners")))
    yield good("stl_rounded_corners_text", shapes.stl_text(shaken), all_of(IS_TORUS, warns("joined-corners")))
    apart = [tuple(tuple(c + random.uniform(-3e-6, 3e-6) for c in p) for p in t) for t in corners]
    yield good("stl_corners_apart", binary(apart), counts(components=192), says=("--weld 1e-05",))
    tiny = [tuple(tuple(c * 1e-7 for c in p) for p in t) for t in corners_of(*torus())]
    tiny += [tuple((p[0] + 1, p[1], p[2]) for p in t) for t in corners]
    yield good("stl_detail_as_small_as_rounding", binary(tiny), counts(vertices=192, components=2))
    yield good("stl_latin_1", shapes.stl_text(corners, "St\xfcck").encode("latin-1"))
    yield bad("stl_no_triangle_text", "solid nothing\nendsolid nothing\n", "a.stl", exit=4)
    yield bad("stl_no_triangle_binary", binary([]), "a.stl", exit=4)
    yield bad("stl_solid_only", "solid\n", "a.stl", exit=4)
    flat = corners + [(POINTS[0], POINTS[0], POINTS[1]), (POINTS[5],) * 3]
    yield good("stl_flat_triangles", binary(flat), all_of(IS_TORUS, warns("degenerate-triangles")))


def off_cases():
    off = shapes.off
    yield good("off_plain", off(POINTS, FACES), all_of(IS_TORUS, warns_nothing))
    yield good("off_glued_counts", off(POINTS, FACES, "OFF96 96 0\n"))
    yield good("off_counts_in_line_1", off(POINTS, FACES, "OFF 96 96 0\n"))
    yield good("off_two_counts", off(POINTS, FACES, "OFF\n96 96\n"))
    commented = "# made\n\nOFF\n# counts\n\n96 96 192 # tail\n\n" + lines("%.9g %.9g %.9g # v\n", POINTS)
    yield good("off_comments", commented + lines("4 %d %d %d %d  # f", FACES))
    for name, values in (("int", "255 128 0 255"), ("float", "1.0 0.50196 0.0 1.0"), ("rgb", "255 128 0")):
        text = "COFF\n96 96 0\n" + lines("%.9g %.9g %.9g " + values, POINTS) + shapes.counted_faces(FACES)
        yield good(f"off_colours_{name}", text, all_of(IS_TORUS, warns_nothing, colored((1, SRGB_128, 0), 4e-3)))
    faced = "OFF\n96 96 0\n" + lines("%.9g %.9g %.9g", POINTS) + lines("4 %d %d %d %d 255 0 0", FACES)
    yield good("off_colours_of_faces", faced, says=("colours of faces are left out",))
    normals = "NOFF\n96 96 0\n" + lines("%.9g %.9g %.9g 0 0 1", POINTS) + shapes.counted_faces(FACES)
    yield good("off_normals", normals)
    placed = "STOFF\n96 96 0\n" + lines("%.9g %.9g %.9g 0.25 0.5", POINTS) + shapes.counted_faces(FACES)
    yield good("off_coordinates", placed, all_of(IS_TORUS, has_uvs))
    more = "OFF\n96 96 0\n" + lines("%.9g %.9g %.9g 1 0 0", POINTS) + shapes.counted_faces(FACES)
    yield good("off_values_not_promised", more, all_of(IS_TORUS, warns("excess-values")))
    yield bad("off_no_header", off(POINTS, FACES, "96 96 0\n"), "in the place of OFF")
    yield bad("off_4_dimensions", "4OFF\n96 96 0\n" + lines("%.9g %.9g %.9g 1", POINTS) + shapes.counted_faces(FACES), "4OFF")
    for order, name in ((">", "big"), ("<", "little")):
        for colours in (True, False):
            data = b"OFF BINARY\n" + struct.pack(order + "3i", 96, 96, 0) + shapes.packed(order + "3f", POINTS)
            data += b"".join(struct.pack(order + "5i", 4, *f) + (bytes(4) if colours else b"") for f in FACES)
            kind = f"off_binary_{name}" + ("" if colours else "_bare")
            if colours == (order == ">"):
                yield good(kind, data, all_of(IS_TORUS, warns_nothing if colours else warns("binary-layout")))
                yield bad(f"{kind}_short", data[:-3], "a.off")
            else:
                yield bad(kind, data, "a.off")
    yield bad("off_binary_counts", b"OFF BINARY\n" + struct.pack("<3i", 1 << 29, 1, 0) + bytes(50), "does not fit 62 bytes")
    wrapped = off(POINTS, []) + "".join("4\n%d\n%d\n%d\n%d\n" % f for f in FACES)
    yield good("off_wrapped", wrapped, all_of(IS_TORUS, warns("wrapped-lines")))
    yield bad("off_wrapped_one_missing", wrapped.rsplit("\n", 2)[0], "a.off:")
    one = "OFF 96 96 0 " + " ".join("%.9g %.9g %.9g" % p for p in POINTS) + " " + " ".join("4 %d %d %d %d" % f for f in FACES)
    yield bad("off_one_line", one, "a.off:1")
    five = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 0.5, 0), (0, 2, 0)]
    yield good("off_concave", off(five, [(0, 1, 2, 3, 4)], "OFF\n5 1 0\n"), passes(five))
    yield bad("off_header_only", "OFF\n", "before its counts")


def cases() -> list[Case]:
    return [*obj_cases(), *ply_cases(), *stl_cases(), *off_cases()]
