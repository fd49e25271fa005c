"""times.py NATIVE NPM: processor time of file to GLB, level 2: the package's fitFile() under node, compiled and warm,
against the native command on one core. Fails above 2.5 times. The least of several runs each, in turn."""
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

BOUND = 2.5
ROOT = pathlib.Path(__file__).resolve().parents[2]
# One thread of its own compiles while the first runs go on; they are not counted.
SCRIPT = """
import { readFileSync } from 'node:fs';
const { load } = await import(process.argv[1]);
const planish = await load(), bytes = readFileSync(process.argv[2]);
let least = Infinity;
for (let i = 0; i < 12; ++i) {
  const before = process.cpuUsage();
  planish.fitFile(bytes, process.argv[2], { levels: 2 });
  const { user, system } = process.cpuUsage(before);
  if (i > 3) least = Math.min(least, (user + system) / 1000);
}
console.log(least);
"""


def native_ms(command, scene, output):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([command, "fit", scene, "-o", output, "--levels", "2", "--device", "cpu", "--force", "--quiet"],
                   check=True, preexec_fn=lambda: os.sched_setaffinity(0, {min(os.sched_getaffinity(0))}))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1000 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def wasm_ms(package, scene):
    index = (pathlib.Path(package) / "index.js").resolve().as_uri()
    return float(subprocess.check_output(["node", "--input-type=module", "-e", SCRIPT, index, scene]))


def main():
    native, package = sys.argv[1:]
    slow = []
    with tempfile.TemporaryDirectory() as folder:
        for name in ["goblet.obj", "rocker_arm.obj"]:
            scene, output = str(ROOT / "scenes" / name), pathlib.Path(folder) / "out.glb"
            pairs = [(native_ms(native, scene, output), wasm_ms(package, scene)) for _ in range(4)]
            one, other = (min(side) for side in zip(*pairs))
            print(f"{name}: native {one:.0f} ms, WebAssembly {other:.0f} ms, {other / one:.2f} times, {BOUND} at most")
            if other > BOUND * one:
                slow.append(name)
    sys.exit(f"too slow: {', '.join(slow)}" if slow else 0)


main()
