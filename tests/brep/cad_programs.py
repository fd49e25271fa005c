"""STEP files in programs that people have: cad_programs.py freecad|gmsh PLANISH SCENES FOLDER.

FreeCAD opens, measures, cuts and triangulates parts, and gmsh fills one with tetrahedra. Volumes are held
against those of the surface's own meshes. Exit code 77 where the program is not installed.
"""

import json
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path

KIND, PLANISH, SCENES, FOLDER = sys.argv[1:5]
# Faces, planes; one solid each.
PARTS = {"cube": (6, 0), "l_bracket": (None, None), "torus": (None, 0)}


def need(*names):
    for name in names:
        if found := shutil.which(name):
            return found
    print(f"skipped: none of {', '.join(names)} is installed")
    sys.exit(77)


def fit(name, output, *flags):
    # Splines, whose volume is that of the meshes.
    splines = ["--step-analytic", "off"] if output.endswith(".step") else []
    subprocess.run([PLANISH, "fit", f"{SCENES}/{name}.obj", "--device", "cpu", "-f", "-o", output, *splines, *flags],
                   check=True, capture_output=True)


def volume_of_stl(path):
    data = Path(path).read_bytes()
    count = struct.unpack_from("<I", data, 80)[0]
    total = 0.0
    for i in range(count):
        a, b, c = (struct.unpack_from("<3f", data, 84 + 50 * i + 12 * k) for k in (1, 2, 3))
        total += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                  + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    return total


def exact_volume(name):
    """Of meshes, to second order in their edges."""
    volumes = []
    for level in (3, 4):
        stl = f"{FOLDER}/{name}_{level}.stl"
        fit(name, stl, "--levels", str(level))
        volumes.append(volume_of_stl(stl))
    return (4 * volumes[1] - volumes[0]) / 3


def near(value, wanted, part, what):
    assert abs(value - wanted) <= part * abs(wanted), f"{what}: {value}, {wanted} wanted"


def freecad():
    program = need("freecadcmd", "FreeCADCmd")
    paths = [f"{FOLDER}/{name}.step" for name in PARTS]
    for name, path in zip(PARTS, paths):
        fit(name, path)
    script = Path(__file__).with_name("freecad_part.py")
    done = subprocess.run([program, str(script)], capture_output=True, text=True, timeout=250,
                          stdin=subprocess.DEVNULL, env={**os.environ, "PARTS": json.dumps(paths)})
    lines = [line[5:] for line in done.stdout.splitlines() if line.startswith("PART ")]
    assert len(lines) == len(PARTS), done.stdout + done.stderr
    for (name, (faces, planes)), line in zip(PARTS.items(), lines):
        part = json.loads(line)
        print(name, line)
        assert part["is_valid"] and part["is_closed"] and part["solids"] == 1
        assert part["faces"] == (faces or part["faces"]) and part["planes"] == (planes or part["planes"])
        # FreeCAD integrates with few points a face.
        near(part["volume"], exact_volume(name), 1e-3, name)
        assert part["parts_are_valid"]
        near(sum(part["volume_of_parts"]), part["volume"], 1e-3, f"{name}, parts")
        assert min(part["volume_of_parts"]) > 0.05 * part["volume"]
        assert all(part["sections"]) and all(all(s) for s in part["sections"])
        assert part["largest_tolerance"] <= 1e-6
        assert part["stl"]["is_solid"]
        near(part["stl"]["volume"], part["volume"], 0.02, f"{name}, STL")


def gmsh():
    program = need("gmsh")
    for name in ("cube", "torus"):
        path = f"{FOLDER}/{name}_g.step"
        fit(name, path)
        done = subprocess.run([program, path, "-3", "-clscale", "0.5", "-format", "msh2", "-o", f"{FOLDER}/{name}.msh", "-nt", "1"],
                              capture_output=True, text=True, timeout=250, stdin=subprocess.DEVNULL)
        assert done.returncode == 0 and "Error" not in done.stdout + done.stderr, done.stdout + done.stderr
        lines = Path(f"{FOLDER}/{name}.msh").read_text().splitlines()
        at = lines.index("$Nodes") + 1
        points = {}
        for line in lines[at + 1 : at + 1 + int(lines[at])]:
            number, *xyz = line.split()
            points[number] = [float(x) for x in xyz]
        at = lines.index("$Elements") + 1
        total, count, smallest = 0.0, 0, 1.0
        for line in lines[at + 1 : at + 1 + int(lines[at])]:
            words = line.split()
            if words[1] != "4":  # a tetrahedron
                continue
            a, b, c, d = (points[v] for v in words[-4:])
            u, v, w = ([q[k] - a[k] for k in range(3)] for q in (b, c, d))
            volume = (u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2])
                      + u[2] * (v[0] * w[1] - v[1] * w[0])) / 6
            total, count, smallest = total + volume, count + 1, min(smallest, volume)
        print(name, count, "tetrahedra,", total)
        assert count > 100 and smallest > 0
        # Its boundary is made of flat triangles.
        near(total, exact_volume(name), 0.03, name)


Path(FOLDER).mkdir(parents=True, exist_ok=True)
{"freecad": freecad, "gmsh": gmsh}[KIND]()
