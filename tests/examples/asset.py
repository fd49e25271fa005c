"""A whole glTF by one call of Python, as tools/python/README.md shows it."""

import sys

sys.path.insert(0, sys.argv[1])

# README begins
import planish

planish.fit_file(
    "chair.gltf", "smooth.glb", compress="meshopt", page="smooth.html", report="smooth.json"
)
# README ends
