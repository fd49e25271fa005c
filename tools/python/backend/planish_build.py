"""Builds a wheel of planish with CMake and Ninja: a PEP 517 backend that needs Python alone.

Settings (pip install . --config-settings NAME=VALUE): `cmake` is put behind CMake's arguments, such
as -DPLANISH_VULKAN=ON; `build-folder` names a folder that is kept from build to build; `built` one in
which the module has been built already, by other settings than these.

The wheel has the shared libraries that not every Linux has, with their licences where Debian's
packages tell them, and says from which glibc on it runs.
"""

import base64
import hashlib
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[3]


def _project():
    """The table [project] of pyproject.toml, which holds one value a line."""
    values, inside = {}, False
    for line in (ROOT / "pyproject.toml").read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            inside = line.strip() == "[project]"
        elif inside and " = " in line:
            key, value = line.split(" = ", 1)
            values[key] = value.strip('"')
    return values


def _metadata():
    project = _project()
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return (
        "Metadata-Version: 2.1\n"
        f"Name: {project['name']}\nVersion: {project['version']}\n"
        f"Summary: {project['description']}\nLicense: MIT\n"
        f"Requires-Python: {project['requires-python']}\nRequires-Dist: numpy\n"
        f"Description-Content-Type: text/markdown\n\n{readme}"
    )


# Of those that our libraries need, what PEP 600 lets wheels take from the system.
_OF_SYSTEM = re.compile(r"linux-vdso|ld-linux|lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+|z)\.so")


def _libraries(module):
    """The shared libraries that a module needs beside the system's, by name."""
    listed = subprocess.run(["ldd", module], check=True, capture_output=True, text=True).stdout
    found = dict(re.findall(r"^\s*(\S+) => (/\S+)", listed, re.MULTILINE))
    return {name: pathlib.Path(path) for name, path in sorted(found.items())
            if not _OF_SYSTEM.match(name)}


def _licence(library):
    """What Debian's package says of a library, or None."""
    try:
        owner = subprocess.run(["dpkg", "-S", library.resolve()], check=True, capture_output=True,
                               text=True).stdout.split(":")[0]
        return pathlib.Path("/usr/share/doc", owner, "copyright").read_bytes()
    except (OSError, subprocess.CalledProcessError):
        return None


def _platform(libraries):
    """The tag of the oldest glibc that has what all of these take from it and, in distributions of
    its time, from libstdc++."""
    machine = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    if not machine.startswith("linux"):
        return machine
    needed = subprocess.run(["readelf", "--version-info", "--wide", *libraries], check=True,
                            capture_output=True, text=True).stdout
    newest = max(map(int, re.findall(r"Name: GLIBC_2\.(\d+)", needed)))
    glibc_of = {30: 35, 31: 38, 32: 38, 33: 40}  # of libstdc++ 12 to 14; older ones come with 2.34
    for version in re.findall(r"Name: GLIBCXX_3\.4\.(\d+)", needed):
        newest = max(newest, glibc_of.get(int(version), 0))
    return machine.replace("linux", f"manylinux_2_{newest}", 1)


def _tag(libraries):
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{version}-{version}-{_platform(libraries)}"


def _install(folder, prefix):
    subprocess.run(["cmake", "--install", folder, "--component", "python", "--prefix", prefix,
                    "--strip"], check=True)


def _build(prefix, settings):
    """Installs the package, and no more, below `prefix`."""
    settings = settings or {}
    if "built" in settings:
        _install(settings["built"], prefix)
        return
    kept = settings.get("build-folder")
    folder = kept or tempfile.mkdtemp(prefix="planish-build-")
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    try:
        subprocess.run(
            ["cmake", "-S", str(ROOT), "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
             "-DPLANISH_PYTHON=ON", f"-DPython3_EXECUTABLE={sys.executable}",
             f"-DPYTHON_EXECUTABLE={sys.executable}", "-DPLANISH_PYTHON_FOLDER=.",
             "-DPLANISH_PRODUCTS=OFF", "-DPLANISH_DEV=OFF",
             "-DPLANISH_VULKAN=OFF", "-DPLANISH_RECONSTRUCT=OFF",
             "-DPLANISH_OPENSSL=OFF",  # a wheel would have to follow its security updates
             *launcher,
             *shlex.split(settings.get("cmake", ""))],
            check=True,
        )
        subprocess.run(["cmake", "--build", folder, "--target", "planish_python"], check=True)
        _install(folder, prefix)
    finally:
        if not kept:
            shutil.rmtree(folder, ignore_errors=True)


def _record_line(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """PEP 517: makes the wheel and returns its name."""
    project = _project()
    stem = f"{project['name']}-{project['version']}"
    info = f"{stem}.dist-info"
    with tempfile.TemporaryDirectory() as prefix:
        _build(prefix, config_settings)
        package = next(pathlib.Path(prefix).rglob("__init__.py")).parent
        files = {f"planish/{path.name}": path.read_bytes() for path in sorted(package.iterdir())}
        module = next(package.glob("_planish*.so"))
        libraries = _libraries(module) if sys.platform == "linux" else {}
        tag = _tag([module, *libraries.values()])
    for library, path in libraries.items():
        files[f"planish.libs/{library}"] = path.read_bytes()
        if licence := _licence(path):
            files[f"{info}/licenses/{library}"] = licence
    name = f"{stem}-{tag}.whl"
    files[f"{info}/METADATA"] = _metadata().encode()
    files[f"{info}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: planish_build\nRoot-Is-Purelib: false\nTag: {tag}\n"
    ).encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = "".join(_record_line(path, data) for path, data in files.items())
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))  # the same bytes every time
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
    return name


def build_sdist(sdist_directory, config_settings=None):
    """PEP 517: packs the files that git tracks."""
    project = _project()
    stem = f"{project['name']}-{project['version']}"
    listed = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z"], check=True,
                            capture_output=True).stdout
    with tarfile.open(os.path.join(sdist_directory, f"{stem}.tar.gz"), "w:gz") as archive:
        for path in filter(None, listed.decode().split("\0")):
            archive.add(ROOT / path, f"{stem}/{path}")
        info = pathlib.Path(sdist_directory, "PKG-INFO")
        info.write_text(_metadata(), encoding="utf-8")
        archive.add(info, f"{stem}/PKG-INFO")
        info.unlink()
    return f"{stem}.tar.gz"
