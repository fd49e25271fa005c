"""check_gpu_check.py SOURCE BUILD WORK: makes tools/gpu_check's folder of BUILD's programs, and runs its
`check --quick` where nothing of planish's libraries is: in a root of its own that has glibc, a shell
with its tools and Mesa's software driver, but no Vulkan loader. That takes mounts and chroot, as root or
in a user namespace; where neither is allowed it runs in an empty environment of this system, and says so.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from json_schema import problems

MOST_BYTES = 60_000_000
ICD = Path("/usr/share/vulkan/icd.d/lvp_icd.x86_64.json")
PROGRAMS = ["planish", "planish-bench", "vulkan_test"]
TOOLS = ["sh", "awk", "cat", "cut", "dirname", "basename", "find", "getconf", "grep", "head", "ldconfig", "ln",
         "ls", "mkdir", "rm", "sed", "sort", "tail", "tee", "timeout", "tr", "uname"]
ENVIRONMENT = {"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "VK_DRIVER_FILES": str(ICD),
               "VK_ICD_FILENAMES": str(ICD), "TMPDIR": "/tmp", "HOME": "/tmp"}


def libraries_of(files):
    """Paths of all that they load, the loader of programs included."""
    text = subprocess.run(["ldd", *files], capture_output=True, text=True, check=True).stdout
    return sorted(set(re.findall(r"(?:=> |^\s*)(/\S+) \(0x", text, re.MULTILINE)))


def copy_into(root, path):
    target = root / str(path).lstrip("/")
    if target.exists():
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy2(os.path.realpath(path), target)


def make_root(root):
    """What a machine has of itself: nothing of planish's, and no Vulkan loader."""
    for folder in ["bin", "sbin"]:
        (root / "usr" / folder).mkdir(parents=True)
        (root / folder).symlink_to("usr/" + folder)
    driver = Path(json.loads(ICD.read_text())["ICD"]["library_path"])
    tools = [Path(shutil.which(tool, path=ENVIRONMENT["PATH"])) for tool in TOOLS]
    for file in [*tools, driver, *libraries_of([*tools, driver])]:
        copy_into(root, file)
    for folder in ["tmp", "dev", "proc", "etc", "usr/share/vulkan/icd.d"]:
        (root / folder).mkdir(parents=True, exist_ok=True)
    (root / "etc/os-release").write_text('PRETTY_NAME="An empty root"\n')
    shutil.copy(ICD, root / str(ICD).lstrip("/"))
    # Where the loader of programs looks beside its own folders.
    (root / "etc/ld.so.conf").write_text("/lib/x86_64-linux-gnu\n/usr/lib/x86_64-linux-gnu\n")
    assert not list(root.rglob("libvulkan.so*")) and not list(root.rglob("libosd*"))


def way_into(root):
    """The command that runs another one in the root; None where that is not allowed."""
    # Programs find what lies beside them by /proc.
    script = 'mount --rbind /proc "$0/proc" && mount --rbind /dev "$0/dev" && exec chroot "$0" "$@"'
    for flags in (["--mount"], ["--map-root-user", "--mount"]):
        way = ["unshare", *flags, "sh", "-c", script, str(root)]
        if shutil.which("unshare") and subprocess.run(
                [*way, "/bin/sh", "-c", "ldconfig && exit 0"], env=ENVIRONMENT,
                capture_output=True).returncode == 0:
            return way
    return None


def clear(work):
    """Removes the folder, but never through a mount: those end with the process that made them."""
    assert not any(os.path.ismount(work / "root" / name) for name in ("proc", "dev"))
    shutil.rmtree(work, ignore_errors=True)


def make_folder(source, build, folder):
    environment = {**os.environ, "PLANISH_GPU_CHECK_BUILD": str(build)}
    subprocess.run([source / "tools/gpu_check", folder], env=environment, check=True)
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    assert size <= MOST_BYTES, f"{size} bytes"
    for program in PROGRAMS:
        text = subprocess.run(["readelf", "-d", folder / "bin" / program], capture_output=True,
                              text=True, check=True).stdout
        paths = re.findall(r"\((RPATH|RUNPATH)\)\s+Library \w+: \[(.*)\]", text)
        # After these two there is what BUILD itself needs, where its libraries are shared.
        assert len(paths) == 1 and paths[0][0] == "RPATH", paths
        assert paths[0][1].split(":")[0] == "$ORIGIN/../lib", paths
    print(f"{folder}: {size} bytes")


def read_result(folder):
    """result.json, which is as the schemas beside it say."""
    result = json.loads((folder / "result.json").read_text())
    schema, bench = (json.loads((folder / "doc" / f"{name}.schema.json").read_text())
                     for name in ("check", "bench"))
    assert problems(result, schema) == []
    assert problems({**result, "quick": "yes", "more": 1}, schema) != []
    for group in result["bench"].values():
        assert group["result"] is None or problems(group["result"], bench) == []
    return result


def check_result(folder, in_root):
    result = read_result(folder)
    text = (folder / "result.txt").read_text()
    assert result["all_passed"] is True, text[-2000:]
    assert result["device"] == "llvmpipe"
    assert result["devices"]["devices"], "no devices are listed"
    validations = [run["validation"] for run in result["tests"]]
    assert validations[0] is False and len(validations) == len(set(validations))
    for run in result["tests"]:
        counts = run["result"]
        assert run["exit_code"] == 0 and counts["tests"] > 3 and counts["failures"] == 0, counts
    bench = result["bench"]
    kernels = bench["kernels"]["result"]["rows"]
    # One size is refused by name, and what comes after it goes on.
    assert "maxStorageBufferRange is 65536" in kernels[0]["refused"], kernels[0]
    assert any(row["peer"] == "interpolation_step" for row in kernels)
    loops = [row for row in bench["frame"]["result"]["rows"] if row["peer"] == "loop"]
    assert loops and loops[0]["figures"]["frames_per_second"] > 0
    assert "interpolation_step" in text and "maxStorageBufferRange" in text
    if in_root:
        assert result["system"] == "An empty root"
        assert "libvulkan.so.1" in result["own_libraries"], result["own_libraries"]
        assert validations == [False] and "is not installed" in text


def check_without_device(place, check):
    """No driver, and a device that is not there: each is said, and nothing takes its time."""
    none = {**ENVIRONMENT, "VK_DRIVER_FILES": "/none.json", "VK_ICD_FILENAMES": "/none.json"}
    done = subprocess.run(check, env=none, capture_output=True, text=True)
    assert done.returncode == 6 and "No device, so nothing else was run" in done.stdout, done
    result = read_result(place)
    assert result["all_passed"] is False and result["tests"] == [] and result["bench"] == {}
    assert result["devices"]["no_vulkan_because"]
    done = subprocess.run([*check, "--device", "no such device"], env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode == 6 and "no such device" in done.stdout and "llvmpipe" in done.stdout, done
    assert read_result(place)["device"] == "no such device"


def main():
    source, build, work = (Path(argument).resolve() for argument in sys.argv[1:])
    if not ICD.exists():
        print("skipped: Mesa's software driver is not installed")
        sys.exit(1 if os.environ.get("PLANISH_REQUIRE_VULKAN") == "1" else 77)
    clear(work)
    work.mkdir(parents=True)
    folder = work / "gpu_check"
    make_folder(source, build, folder)
    root = work / "root"
    root.mkdir()
    make_root(root)
    way = way_into(root)
    place = folder
    if way:
        place = root / "gpu_check"
        shutil.copytree(folder, place)
    else:
        print("no chroot is allowed: run in an empty environment of this system")
    check = [*(way or []), "/gpu_check/check" if way else str(folder / "check"), "--quick"]
    check_without_device(place, check)
    command = [*check, "--device", "llvmpipe", "--max-range", "65536", "--points", "2500", "--points", "900"]
    done = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True)
    print(done.stdout[-3000:], done.stderr[-2000:])
    check_result(place, way is not None)
    assert done.returncode == 0
    clear(work)


if __name__ == "__main__":
    main()
