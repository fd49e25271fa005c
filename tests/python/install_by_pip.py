"""pip makes a wheel of a clone without a network, and what it installs works by itself.

Arguments: the clone, a folder in which the module has been built, and a folder to work in.
"""

import os
import pathlib
import shutil
import subprocess
import sys

CLONE, BUILT, WORK = map(pathlib.Path, sys.argv[1:])
USE = """
import planish, pathlib
vertices = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
fit = planish.fit(vertices, faces)
assert fit.converged and fit.evaluate(1).quads.shape == (24, 4)
folder = pathlib.Path(planish.__file__).parent
assert folder.parent.name == "site", folder
assert (folder / "py.typed").exists() and (folder / "_planish.pyi").exists()
from importlib.metadata import version
assert version("planish") == planish.__version__
own = str(folder.parent / "planish.libs") + "/"
mapped = {line.split()[-1] for line in open("/proc/self/maps") if "/" in line}
assert any(path.startswith(own) for path in mapped), mapped
for name in "libosdCPU", "libtbb", "libmeshoptimizer":
    assert all(path.startswith(own) for path in mapped if f"/{name}" in path), mapped
"""


def pip(*arguments):
    subprocess.run([sys.executable, "-m", "pip", "--disable-pip-version-check", *map(str, arguments),
                    "--no-index", "--no-deps"], check=True)


shutil.rmtree(WORK, ignore_errors=True)
pip("wheel", CLONE, "-w", WORK, "--config-settings", f"built={BUILT}")
(wheel,) = WORK.glob("planish-*.whl")
pip("install", wheel, "--target", WORK / "site")
environment = {**os.environ, "PYTHONPATH": str(WORK / "site")}
subprocess.run([sys.executable, "-c", USE], check=True, env=environment, cwd=WORK)
print(f"{wheel.name}: {wheel.stat().st_size} bytes")
