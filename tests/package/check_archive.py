"""check_archive.py SOURCE BUILD WORK: makes the folder of tools/package's archive of BUILD's command, and runs
it in a root of its own whose libstdc++ is as old as the archive's, newer, older, or missing: the newer of
both is loaded, and Mesa's driver with it. Every program and library in it has its licence beside it.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import check_gpu_check as empty
from check_gpu_check import ENVIRONMENT, ICD, clear, make_root, way_into

TRIPLET = "x86_64-linux-gnu"
LIBRARY = "libstdc++.so.6"
# What newest_symbols() of common.sh finds, behind the end of the library itself.
NEWER = b"\0GLIBCXX_3.4.999\0"


def make_archive(source, build, folder):
    (folder / "bin").mkdir(parents=True)
    for program in ("planish", "planish-reconstruct"):
        if (build / "bin" / program).exists():
            shutil.copy2(build / "bin" / program, folder / "bin" / program)
    script = (f'set -euo pipefail; . "{source}/tools/portable/libraries.sh"; make_runnable "{folder}"; '
              f'document_licences "{folder}" "{source}"')
    subprocess.run(["bash", "-c", script], check=True)
    assert not list((folder / "lib").glob("libstdc++*")), "in the way of the system's"


def owner_of(library, programs):
    """Debian's package of the library that the programs load by that name."""
    text = subprocess.run(["ldd", *programs], capture_output=True, text=True, check=True).stdout
    path = re.search(rf"^\s*{re.escape(library)} => (\S+)", text, re.MULTILINE).group(1)
    found = [re.sub("^/usr", "", path), "/usr" + re.sub("^/usr", "", path)]
    done = subprocess.run(["dpkg-query", "-S", *found], capture_output=True, text=True)
    return done.stdout.split(":")[0]


def check_licences(build, folder):
    """Each library has what Debian says of it, each program its licence, and no file is of something else."""
    doc = folder / "doc"
    text = (doc / "LICENCES.txt").read_text()
    programs = [build / "bin" / program.name for program in (folder / "libexec").iterdir()]
    libraries = [path for path in (folder / "lib").rglob("*.so*") if path.is_file()]
    assert len(libraries) > 5, libraries
    for library in (path.name for path in libraries if not path.name.startswith("libplanish")):
        owner = owner_of(library, programs)
        assert f"  {library} (copyright.{owner})\n" in text, (library, owner, text)
    assert "planish, libplanish: MIT (LICENSE)" in text
    assert "Permission is hereby granted" in (doc / "LICENSE").read_text()
    named = {"libcli11-dev", "nlohmann-json3-dev", "libglm-dev", "libosd-dev"}
    if folder / "libexec/planish-reconstruct" in (folder / "libexec").iterdir():
        named |= {"libcgal-dev", "libboost1.74-dev"}
        assert "\nplanish-reconstruct: GPL-3.0-or-later (GPL-3.txt)" in text, text
        assert re.search(r"GNU GENERAL PUBLIC LICENSE\s+Version 3", (doc / "GPL-3.txt").read_text())
    for package in named:
        assert f"  {package} (copyright.{package})\n" in text, package
    assert set(re.findall(r"copyright\.[a-z0-9.+-]+", text)) == {file.name for file in doc.glob("copyright.*")}
    for file in doc.glob("copyright.*"):
        for licence in re.findall(r"/usr/share/common-licenses/([\w.-]*\w)", file.read_text(errors="replace")):
            assert (doc / f"{licence}.txt").exists(), (file, licence)


def run(way, *command, **environment):
    done = subprocess.run([*way, *command], env={**ENVIRONMENT, **environment}, capture_output=True, text=True)
    assert done.returncode == 0, (command, done.stdout[-2000:], done.stderr[-2000:])
    return done


def loaded(way):
    """The file that `planish devices` takes its libstdc++ from, having found Mesa's device."""
    done = run(way, "/archive/bin/planish", "devices", "--json", LD_DEBUG="files")
    assert "llvmpipe" in done.stdout, done.stdout
    paths = {line.split("calling init: ")[1].strip() for line in done.stderr.splitlines()
             if "calling init: " in line and LIBRARY in line}
    assert len(paths) == 1, paths
    return os.path.normpath(paths.pop())


def make_surfaces(source, root, way):
    """A surface and its page from a mesh, and from points, for which the command starts the mesher."""
    shutil.copy(source / "scenes/goblet.obj", root / "tmp")
    run(way, "/archive/bin/planish", "fit", "/tmp/goblet.obj", "-o", "/tmp/goblet.glb", "--page", "/tmp/goblet.html",
        "--device", "vulkan")
    assert (root / "tmp/goblet.glb").read_bytes()[:4] == b"glTF"
    assert "<canvas" in (root / "tmp/goblet.html").read_text()
    if (root / "archive/libexec/planish-reconstruct").exists():
        side = [0, 0.25, 0.5, 0.75, 1]
        points = {(x, y, z) for x in side for y in side for z in side if {x, y, z} & {0, 1}}
        (root / "tmp/box.xyz").write_text("".join(f"{x} {y} {z}\n" for x, y, z in sorted(points)))
        run(way, "/archive/bin/planish", "fit", "/tmp/box.xyz", "-o", "/tmp/box.obj")
        assert "\nf " in (root / "tmp/box.obj").read_text()


def append(path, tail):
    path.write_bytes(path.read_bytes() + tail)


def main():
    source, build, work = (Path(argument).resolve() for argument in sys.argv[1:])
    required = os.environ.get("PLANISH_REQUIRE_VULKAN") == "1"
    if not ICD.exists():
        print("skipped: Mesa's software driver is not installed")
        sys.exit(1 if required else 77)
    clear(work)
    root = work / "root"
    root.mkdir(parents=True)
    empty.TOOLS += ["readlink"]
    make_root(root)
    # The command loads it by name: without one there are no devices.
    loader = Path(f"/usr/lib/{TRIPLET}/libvulkan.so.1")
    empty.copy_into(root, loader)
    make_archive(source, build, root / "archive")
    check_licences(build, root / "archive")
    way = way_into(root)
    if not way:
        print("skipped: no chroot is allowed here")
        sys.exit(77)
    own = f"/archive/lib/common/{LIBRARY}/{LIBRARY}"
    system = next(path for path in root.rglob(LIBRARY) if "archive" not in path.parts)
    systems = "/" + str(system.relative_to(root))
    run(way, "/archive/bin/planish", "--version")
    make_surfaces(source, root, way)
    expected = {"as old": systems}
    found = {"as old": loaded(way)}
    append(system, NEWER)
    expected["newer"], found["newer"] = systems, loaded(way)
    append(root / own.lstrip("/"), NEWER.replace(b"999", b"1000"))
    expected["older"], found["older"] = own, loaded(way)
    system.unlink()
    run(way, "ldconfig")
    expected["missing"], found["missing"] = own, loaded(way)
    # By another name, from another folder.
    (root / "usr/bin/surface").symlink_to("/archive/bin/planish")
    run(way, "surface", "--version")
    print(found)
    assert found == expected, expected
    clear(work)


if __name__ == "__main__":
    main()
