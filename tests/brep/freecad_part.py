"""What FreeCAD makes of STEP files: freecadcmd freecad_part.py, with paths in PARTS (JSON).

Prints a line of JSON for each: validity, volume, a section across the middle, and STL's way back.
"""

import json
import os
import sys

import FreeCAD
import Mesh
import MeshPart
import Part

DIRECTIONS = [FreeCAD.Vector(1, 0, 0), FreeCAD.Vector(0, 1, 0), FreeCAD.Vector(0, 0, 1)]


def of_part(path):
    shape = Part.read(path)
    box = shape.BoundBox
    middle = [box.Center.x, box.Center.y, box.Center.z]
    # A little aside, where no edge lies.
    places = [m + 0.0137 * box.DiagonalLength for m in middle]
    sections = [shape.slice(d, at) for d, at in zip(DIRECTIONS, places)]
    # Both sides of a cut are to have the volume that was there.
    half = Part.makeBox(
        box.DiagonalLength, 3 * box.DiagonalLength, 3 * box.DiagonalLength,
        FreeCAD.Vector(places[0], middle[1] - box.DiagonalLength, middle[2] - box.DiagonalLength))
    outside, inside = shape.cut(half), shape.common(half)
    mesh = MeshPart.meshFromShape(
        Shape=shape, LinearDeflection=1e-3 * box.DiagonalLength, AngularDeflection=0.2)
    stl = path + ".stl"
    mesh.write(stl)
    back = Mesh.Mesh(stl)
    return {
        "is_valid": shape.isValid(),
        "is_closed": shape.isClosed(),
        "solids": len(shape.Solids),
        "faces": len(shape.Faces),
        "planes": sum(isinstance(f.Surface, Part.Plane) for f in shape.Faces),
        "volume": shape.Volume,
        "parts_are_valid": outside.isValid() and inside.isValid(),
        "volume_of_parts": [outside.Volume, inside.Volume],
        "sections": [[w.isClosed() for w in section] for section in sections],
        "largest_tolerance": max(e.Tolerance for e in shape.Edges),
        "stl": {"is_solid": back.isSolid(), "volume": back.Volume, "facets": back.CountFacets},
    }


for name in json.loads(os.environ["PARTS"]):
    print("PART " + json.dumps(of_part(name)))
    sys.stdout.flush()
