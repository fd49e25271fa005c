"""Points of all formats, and files whose names say something else than their content."""

import gzip
import struct

import shapes
from case import Case, all_of, bounded, passes, warns
from shapes import CUBE_POINTS, lines, moved, obj, sphere, torus

SPHERE = sphere(1500)
ROUND = ((-1, -1, -1), (1, 1, 1))
PLAIN = lines("%.7g %.7g %.7g", SPHERE)


def is_round(centre=(0, 0, 0), radius=1.0, points=1500, within=0.02):
    """One closed piece with the sphere's bounds, of so many points."""
    low, high = ([c + s * radius for c in centre] for s in (-1, 1))
    inside = bounded(low, high, within * radius)

    def check(result):
        said, made = result.report["input"], result.report["reconstruction"]
        if said["components"] != 1 or said["genus"] != 0 or said["boundary_loops"] != 0:
            return f"no sphere: {said['components']} pieces, genus {said['genus']}, {said['boundary_loops']} loops"
        if points is not None and made["points"] != points:
            return f"{made['points']} points, not {points}"
        return inside(result)

    return check


def good(name, data, check=None, **more):
    data = data if isinstance(data, bytes) else data.encode()
    path = more.pop("path", "a." + name.split("_")[0])
    return Case(name, {path: data}, path, check=check or is_round(), **more)


def bad(name, data, *says, exit=3, **more):
    data = data if isinstance(data, bytes) else data.encode()
    path = more.pop("path", "a." + name.split("_")[0])
    return Case(name, {path: data}, path, exit=exit, says=says, **more)


def xyz_cases():
    yield good("xyz_plain", PLAIN)
    yield good("xyz_commas", PLAIN.replace(" ", ","))
    yield good("xyz_commas_and_blanks", PLAIN.replace(" ", ", "))
    thousand = lines("%.3f %.3f %.3f", [tuple(100 * c + 150 for c in p) for p in SPHERE])
    for name, text in (("blanks", thousand), ("semicolons", thousand.replace(" ", ";")), ("tabs", thousand.replace(" ", "\t")),
                       ("small", lines("%.6f %.6f %.6f", SPHERE)), ("short", lines("%.1f;%.1f;%.1f", SPHERE))):
        yield bad(f"xyz_decimal_comma_{name}", text.replace(".", ","), "a.xyz:1", "separates no columns", "tr , .")
        yield bad(f"pts_decimal_comma_{name}", "1500\n" + text.replace(".", ","), "a.pts:2", "separates no columns")
    yield bad("xyz_decimal_comma_late", PLAIN + "1,5 2 3\n", "a.xyz:1501", "`1,5`")
    quoted = "".join('"%.6f","%.6f","%.6f"\n' % p for p in SPHERE)
    yield good("xyz_quotes", '"X","Y","Z"\n' + quoted)
    yield bad("xyz_quotes_decimal_comma", quoted.replace('","', ";").replace(".", ",").replace(";", '";"'), "separates no columns")
    yield good("xyz_at_lines", "@File_Version: 4\n@Type: 3\n#End\n" + PLAIN + "EOD\n")
    coloured = lines("%.6g %.6g %.6g 255 0 0 %.6g %.6g %.6g", [p + p for p in SPHERE])
    yield good("xyz_named_in_comment", "//X Y Z R G B Nx Ny Nz\n" + coloured)
    yield bad("xyz_letter_first", "1500\nsome words\n" + lines("C %g %g %g", SPHERE), "a.xyz:")
    grid = [(i / 20, j / 20, i * j / 800) for i in range(40) for j in range(40)]
    yield good("xyz_plane", lines("%g %g 0", [p[:2] for p in grid]), passes([(x, y, 0) for x in (0, 1.95) for y in (0, 1.95)]))
    yield bad("xyz_line", lines("%g %g %g", [(i, 2 * i, 3 * i) for i in range(500)]), "on a line", exit=4, silent=("geographic",))
    yield bad("xyz_one_place", "1 2 3\n" * 500, "a.xyz", exit=4, silent=("geographic",))
    yield good("xyz_each_three_times", "".join(line + "\n" + line + "\n" + line + "\n" for line in PLAIN.splitlines()), is_round(points=4500))
    far = [tuple(3 * c for c in p) for p in SPHERE]
    centre = (548213.25, 5804512.75, 120)
    yield good("xyz_utm", lines("%.4f %.4f %.4f", moved(far, centre)), is_round(centre, 3))
    degrees = [(p[0] * 3e-5 + 13.4, p[1] * 1.8e-5 + 52.5, p[2] * 2 + 35) for p in SPHERE]
    yield bad("xyz_degrees", lines("%.9f %.9f %.4f", degrees), "on a line", "look geographic", "13.4", "52.5", exit=4)
    yield good("xyz_far_outlier", PLAIN + "1e9 1e9 1e9\n", is_round(points=1501))
    yield good("pts_no_count", lines("%.7g %.7g %.7g 0.5 255 0 0", SPHERE))
    half = "750\n" + lines("%.7g %.7g %.7g -1200 255 0 0", SPHERE[:750])
    yield good("pts_two_scans", half + "750\n" + lines("%.7g %.7g %.7g 300 255 0 0", SPHERE[750:]))
    yield good("pts_one_more", "1499\n" + PLAIN, all_of(is_round(), warns("point-count")))
    yield bad("pts_too_few", "3000\n" + PLAIN, "1500 of 3000")


def pcd_cases():
    pcd, floats = shapes.pcd, shapes.packed("<3f", SPHERE)
    fields = ("x y z", "4 4 4", "F F F", "1 1 1", 1500)
    yield good("pcd_plain", pcd(*fields, floats))
    padded = b"".join(struct.pack("<3f4xfH10x", *p, 7.0, 3) for p in SPHERE)
    yield good("pcd_padding", pcd("x y z _ intensity ring _", "4 4 4 1 4 2 1", "F F F U F U U", "1 1 1 4 1 1 10", 1500, padded))
    columns = b"".join(struct.pack("<1500f", *(float("nan") if j % 50 == 0 else p[k] for j, p in enumerate(SPHERE))) for k in range(3))
    columns += struct.pack("<1500I", *[0xFF8040] * 1500)
    stored = b"".join(bytes([len(columns[i : i + 32]) - 1]) + columns[i : i + 32] for i in range(0, len(columns), 32))
    packed = struct.pack("<2I", len(stored), len(columns)) + stored
    yield good("pcd_compressed", pcd("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 1500, packed, "binary_compressed", 50, 30), is_round(points=1470))
    coloured = lines("%.7g %.7g %.7g 4.2108e+06", SPHERE).encode()
    yield good("pcd_ascii_colour", pcd("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 1500, coloured, "ascii"))
    yield good("pcd_viewpoint", pcd(*fields, floats, view="10 20 30 0.7071 0 0 0.7071"))
    centre = (548213.25, 5804512.75, 0)
    yield good("pcd_double", pcd("x y z", "8 8 8", "F F F", "1 1 1", 1500, shapes.packed("<3d", moved(SPHERE, centre))), is_round(centre))
    for size, code, scale in ((1, "b", 120), (2, "h", 10000), (4, "i", 1000), (8, "q", 1000)):
        whole = [tuple(round(c * scale) for c in p) for p in SPHERE]
        data = pcd("x y z", f"{size} " * 2 + str(size), "I I I", "1 1 1", 1500, shapes.packed(f"<3{code}", whole))
        # Of bytes some points fall together.
        check = is_round(radius=scale) if size > 1 else bounded([-scale] * 3, [scale] * 3, 0.1 * scale)
        yield good(f"pcd_signed_{size}", data, check)
    least = shapes.packed("<3i", moved([tuple(2 * c for c in p) for p in CUBE_POINTS], (-1, -1, -1)))
    cube = pcd("x y z", "4 4 4", "I I I", "1 1 1", 8, least)

    def is_cube(result):
        bounds = result.report["bounds"]
        return None if bounds == [[-1, -1, -1], [1, 1, 1]] else f"bounds {bounds}"

    yield good("pcd_signed_cube", cube, is_cube, inspects=True)
    bare = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1500\nHEIGHT 1\nPOINTS 1500\nDATA ascii\n"
    yield good("pcd_no_count_no_version", bare + PLAIN)
    yield bad("pcd_too_few", pcd("x y z", "4 4 4", "F F F", "1 1 1", 2000, floats), "2000 points")
    yield good("pcd_crlf_header", pcd(*fields, b"").replace(b"\n", b"\r\n") + floats)


def las_cases():
    las = shapes.las
    for name, given in (("14_6", {"further": 20}), ("14_7", {"form": 7, "legacy": 12}), ("14_8", {"form": 8, "further": 1}), ("14_10", {"form": 10}),
                        ("12_3", {"minor": 2, "form": 3, "legacy": 1500, "padding": 53}), ("12_0", {"minor": 2, "form": 0, "legacy": 1500}), ("long_header", {"head": 400})):
        yield good(f"las_{name}", las(SPHERE, **given))
    yield bad("las_promises_too_many", las(SPHERE, 2, 1, legacy=99999), "99999 points")
    yield bad("las_count_0", las(SPHERE, 2, 1, legacy=0), "promises 0 points", "1500 points of 28 bytes", "lasinfo")
    centre = (548213.25, 5804512.75, 120)
    far = moved([tuple(3 * c for c in p) for p in SPHERE], centre)
    yield good("las_utm", las(far, offset=(548000, 5804000, 0)), is_round(centre, 3))
    yield bad("las_scale_0", las(SPHERE, 2, 0, legacy=1500, scale=0), "scale 0")
    packed = bytearray(las(SPHERE, 2, 0, legacy=1500))
    packed[104] = 128
    yield bad("las_compressed", bytes(packed), "LAZ", "pdal translate")
    lost = bytearray(las(SPHERE))
    for k in range(0, 1500, 5):
        lost[375 + 30 * k + 4 : 375 + 30 * k + 8] = struct.pack("<i", -(1 << 31))
    yield good("las_without_place", bytes(lost), all_of(is_round(points=1200), warns("missing-points")),
               says=("300 points with the least 32-bit number for a coordinate",))
    yield good("las_withheld", las(SPHERE, withheld=True), all_of(is_round(points=1000), warns("noise-points")))


def ptx_cases():
    ptx, misses = shapes.ptx, lambda k: k % 10 == 0
    colours = " 0.5 255 128 0"
    yield good("ptx_two_scans", ptx(SPHERE[:750], 30, 25, behind=colours) + ptx(SPHERE[750:], 30, 25, behind=colours))
    yield good("ptx_columns_differ", ptx(SPHERE[:750], 30, 25, behind=colours) + ptx(SPHERE[750:], 30, 25))
    yield good("ptx_misses", ptx(SPHERE, 50, 30, misses=misses), is_round(points=1350), says=("150 points at the scanner's own place",))
    there = shapes.UNIT[:3] + [(548213.25, 5804512.75, 120, 1)]
    far = [tuple(3 * c for c in p) for p in SPHERE]
    yield good("ptx_utm", ptx(far, 50, 30, there), is_round((548213.25, 5804512.75, 120), 3))
    yield bad("ptx_short", ptx(SPHERE[:1400], 50, 30), "point 1400 of 1500")
    yield bad("ptx_matrix_word", ptx(SPHERE, 50, 30).replace("0 0 1 0\n", "0 0 x 0\n", 1), "a.ptx:9", "`x`")
    yield bad("ptx_matrix_nan", ptx(SPHERE, 50, 30, shapes.UNIT[:2] + [(0, 0, float("nan"), 0), (0, 0, 0, 1)]), "a.ptx:9", "`nan`")
    two = ptx(SPHERE[:750], 30, 25) + "\n\n" + ptx(SPHERE[750:], 30, 25)
    yield good("ptx_crlf_blank_lines", two.replace("\n", "\r\n"))
    text = ptx(SPHERE, 50, 30).split("\n")
    text[15] = "nan nan nan 0"
    yield good("ptx_nan", "\n".join(text), is_round(points=1499), says=("or not numbers",))
    yield good("ptx_empty_scan_first", ptx([], 0, 0) + ptx(SPHERE, 50, 30))
    yield bad("ptx_negative_size", ptx([], -1, 0) + ptx(SPHERE, 50, 30), "a.ptx:1", "`-1`")


def cloud_cases():
    head = shapes.ply_head
    yield good("ply_faces_0", head("ascii", 1500, 0) + PLAIN)
    normals = head("ascii", 1500, None, further=["float nx", "float ny", "float nz"])
    for k, p in enumerate(SPHERE):
        normals += "%.7g %.7g %.7g " % p + ("nan nan nan\n" if k % 7 == 0 else "0 0 0\n" if k % 7 == 1 else "%.6g %.6g %.6g\n" % p)
    yield good("ply_nan_normals", normals)
    more = [f"float f_dc_{i}" for i in range(3)] + [f"float f_rest_{i}" for i in range(9)] + ["float opacity"]
    more += [f"float scale_{i}" for i in range(3)] + [f"float rot_{i}" for i in range(4)]
    splats = head("binary_little_endian", 1500, None, further=more).encode()
    splats += b"".join(struct.pack("<23f", *p, *[0.5] * 3, *[0] * 9, 2, *[-5] * 3, 1, 0, 0, 0) for p in SPHERE)
    yield good("ply_splats", splats)
    yield good("obj_points", lines("v %.7g %.7g %.7g", SPHERE))
    yield good("obj_points_p", lines("v %.7g %.7g %.7g\np -1", SPHERE))
    yield good("off_points", "OFF\n1500 0 0\n" + PLAIN)


def named_cases():
    """Files whose names or beginnings promise something else."""
    ring, faces = torus()
    mesh = shapes.ply_binary(ring, faces)
    rubbish = b"\0\1\2\3 not really"
    for extension in ("e57", "laz", "fbx", "usd", "usda", "usdc", "3mf", "dae", "step", "x3d", "vtk", "blend"):
        yield bad(f"name_{extension}", rubbish, "converts it", path=f"a.{extension}", exit=2)
    for extension in ("csv", "asc", "txt", "wrl", "gz", "zip"):
        yield bad(f"name_{extension}", rubbish, "neither name nor content", path=f"a.{extension}")
    for extension in ("asc", "txt"):
        yield good(f"name_points_{extension}", PLAIN, path=f"a.{extension}")
    yield good("name_points_csv", "X,Y,Z\n" + PLAIN.replace(" ", ","), path="a.csv")
    yield good("name_points_csv_quotes", '"X";"Y";"Z"\n' + "".join('"%.6f";"%.6f";"%.6f"\n' % p for p in SPHERE), path="a.csv")
    yield good("name_points_at_lines", "@File_Version: 4\n" + PLAIN + "EOD\n", path="a.asc")
    packed = gzip.compress(mesh, mtime=0)
    for name, path in (("ply_gz", "a.ply.gz"), ("ply", "a.ply"), ("stl", "a.stl"), ("glb", "a.glb")):
        yield bad(f"gzip_{name}", packed, "compressed by gzip", "gunzip", path=path)
    yield bad("zip_obj", b"PK\3\4" + bytes(40), "ZIP archive", path="a.obj")
    pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 123\n"
    for extension in ("glb", "obj", "stl", "las", "bin"):
        yield bad(f"lfs_{extension}", pointer, "pointer of Git LFS", "git lfs pull", path=f"a.{extension}")
    yield bad("html_glb", "<!DOCTYPE html><html><body>404</body></html>", "web page", path="a.glb")
    yield bad("obj_named_stl", obj(ring, faces), "looks like Wavefront OBJ (.obj)", path="a.stl")
    yield bad("stl_named_obj", shapes.stl_text(shapes.corners_of(ring, faces)), "looks like STL (.stl)", path="a.obj")
    yield bad("ply_named_off", mesh, "looks like Stanford PLY (.ply)", path="a.off")
    yield bad("glb_magic_only", "glTF", "a.glb", path="a.glb")


def cases() -> list[Case]:
    return [*xyz_cases(), *pcd_cases(), *las_cases(), *ptx_cases(), *cloud_cases(), *named_cases()]
