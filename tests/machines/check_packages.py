#!/usr/bin/env python3
"""check_packages.py windows|arm64 FOLDER: what tools/package made there for another machine, tried on this one.

windows: the zip in a folder of its own, by Wine in a new prefix: the command writes a scene's known bytes, and C programs
of tests/c that are compiled against the zip alone link planish.dll and pass. Neither needs a file that Windows has not.
arm64: the archive in a root that has but glibc (as root), by QEMU, and the command of the Debian packages: known bytes,
too; the packages are of that architecture and name the libraries that the command loads."""
import glob
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/goblet.obj"


def run(*command, **settings):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, errors="replace", **settings)
    assert done.returncode == 0, (command, done.stdout[-2000:], done.stderr[-2000:])
    return done.stdout


def only(folder, pattern):
    found = glob.glob(f"{folder}/{pattern}")
    assert len(found) == 1, (pattern, found)
    return pathlib.Path(found[0])


def check_surface(file):
    """That it is what every machine makes of SCENE without a flag."""
    expected = json.loads((ROOT / "tests/machines/hashes.json").read_text())[f"{SCENE.name} glb"]["o.glb"]
    assert hashlib.sha256(file.read_bytes()).hexdigest().startswith(expected), file


def dlls_of(file):
    return {name.lower() for name in re.findall(r"DLL Name: (\S+)", run("x86_64-w64-mingw32-objdump", "-p", file))}


def check_windows(packages, work):
    with zipfile.ZipFile(only(packages, "planish-*-windows-x86_64.zip")) as packed:
        packed.extractall(work)
    folder = only(work, "planish-*")
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert files == {"planish.exe", "planish.dll", "planish.lib", "planish.def", "include/planish/c/planish.h",
                     "include/planish/c/editor.h", "LICENSE", "NOTICES.txt", "README.md", "CHANGELOG.md"}, files
    for program in "planish.exe", "planish.dll":
        own = dlls_of(folder / program) - {"kernel32.dll", "msvcrt.dll", "shell32.dll"}
        assert not own, (program, own)
    with_wine = {"cwd": work, "env": {**os.environ, "WINEPREFIX": str(work / "wine"), "WINEDEBUG": "-all"}}
    run("wine", folder / "planish.exe", "fit", SCENE, "-o", "o.glb", **with_wine)
    check_surface(work / "o.glb")
    # With threads of POSIX, of which mingw-w64 has a static library.
    for name in "answers_test", "riders_test", "editor_test", "threads_test":
        program = folder / f"{name}.exe"
        run("x86_64-w64-mingw32-gcc-posix", "-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", f"-I{folder}/include",
            ROOT / f"tests/c/{name}.c", folder / "planish.lib", "-Wl,-Bstatic", "-lwinpthread", "-o", program)
        assert "planish.dll" in dlls_of(program)
        run("wine", program, **with_wine)
    run("wineserver", "-w", **with_wine)


def check_arm64(packages, work):
    emulator = shutil.which("qemu-aarch64-static")
    system = pathlib.Path("/usr/lib/aarch64-linux-gnu")
    # The archive: `launch` is a script for that machine's own shell, so that what it sets is set here.
    root = work / "root"
    with tarfile.open(only(packages, "planish-*-linux-aarch64.tar.gz")) as packed:
        packed.extractall(root, filter="data")
    archive = only(root, "planish-*")
    (root / "lib").mkdir()
    for name in "ld-linux-aarch64.so.1", "libc.so.6", "libm.so.6":
        shutil.copy2(system / name, root / "lib")
    shutil.copy2(emulator, root / "emulator")
    shutil.copy2(SCENE, root)
    (root / "tmp").mkdir()
    inside = f"/{archive.name}"
    common = [f"{inside}/lib/common/{folder.name}" for folder in (archive / "lib/common").iterdir()]
    run("chroot", root, "/emulator", "-E", f"LD_LIBRARY_PATH={':'.join(['/lib', *common])}", f"{inside}/libexec/planish",
        "fit", f"/{SCENE.name}", "-o", "/tmp/o.glb")
    check_surface(root / "tmp/o.glb")
    # The packages, beside the libraries of that architecture that are installed here.
    unpacked = work / "unpacked"
    for package in "libplanish0.1", "libplanish-dev", "planish":
        file = only(packages, f"{package}_*_arm64.deb")
        assert run("dpkg-deb", "-f", file, "Architecture").strip() == "arm64"
        run("dpkg-deb", "-x", file, unpacked)
    depends = run("dpkg-deb", "-f", only(packages, "libplanish0.1_*_arm64.deb"), "Depends")
    for library in "libosdcpu3.5.0", "libtbb12", "libdraco7", "libmeshoptimizer2d", "libstdc++6", "libc6":
        assert re.search(rf"(^|, ){re.escape(library)} \(", depends), (library, depends)
    assert (unpacked / "usr/lib/aarch64-linux-gnu/libplanish.a").exists() or list(
        (unpacked / "usr/lib/aarch64-linux-gnu").glob("libplanish.so*"))
    run(emulator, "-E", f"LD_LIBRARY_PATH={unpacked}/usr/lib/aarch64-linux-gnu", unpacked / "usr/bin/planish", "fit", SCENE,
        "-o", work / "o.glb")
    check_surface(work / "o.glb")


def main():
    kind, folder = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    # Of letters that programs for Windows take for others, where they do not ask for UTF-8.
    with tempfile.TemporaryDirectory(prefix="plänish packages ") as work:
        {"windows": check_windows, "arm64": check_arm64}[kind](folder, pathlib.Path(work))
    print(f"The packages for {kind} in {folder.name} work")


if __name__ == "__main__":
    main()
