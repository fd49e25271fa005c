"""corpus.py NATIVE WASM [CHANGES]: what readers make of the fuzzers' corpus and of CHANGES damaged copies of each of its
files (20), natively and in WebAssembly: the same meshes, bit for bit, and the same messages. NATIVE, WASM:
planish_outcomes of both builds (tests/fuzz/outcomes.cpp), the latter a program for node. Draco's streams are read natively
only: there WebAssembly has to say so. And the document of a glTF whose streams stand for 7 GiB."""
import pathlib
import subprocess
import sys

CORPUS = pathlib.Path(__file__).resolve().parents[1] / "fuzz/corpus"


def lacks_draco(line):
    return "`KHR_draco_mesh_compression` cannot be read" in line or "built without libdraco" in line


def is_of_quaternions(line):
    """Positions behind meshopt's filter for rotations, which its decoders round and cut each in their way."""
    return line.startswith("meshopt/quaternion ")


def outcomes(*command):
    done = subprocess.run(command, capture_output=True, text=True, errors="backslashreplace", check=False)
    return done.returncode, done.stdout.splitlines(), done.stderr


def main():
    native, wasm, *changes = sys.argv[1:]
    given = [str(CORPUS), changes[0] if changes else "20"]
    runs = [outcomes(native, *given), outcomes("node", wasm, *given)]
    bad = []
    for words, (status, lines, said) in zip(["native", "WebAssembly"], runs):
        if status != 0:
            bad.append(f"{words} ends with {status} at {lines[-1:]}: {said[-400:]}")
    one, two = (lines for _, lines, _ in runs)
    large, other = outcomes(native), outcomes("node", wasm)
    if large != other or '"byteOffset":6442450944' not in str(large):
        bad.append(f"a large document is natively {large}\n  in WebAssembly {other}")
    bad += [f"natively {a}\n  in WebAssembly {b}" for a, b in zip(one, two)
            if a != b and not lacks_draco(b) and not is_of_quaternions(a)]
    files, read = sum(" 0: " in line for line in one), sum(" vertices, " in line or " points, " in line for line in one)
    if files < 200 or len(one) != len(two):
        bad.append(f"{len(one)} and {len(two)} outcomes of {files} files")
    draco = sum(map(lacks_draco, two))
    print(f"{files} files and {len(one) - files} damaged copies: {read} are read, {len(one) - read} refused, "
          f"{len(bad)} differ between native and WebAssembly, besides {draco} of Draco")
    sys.exit("\n".join(bad[:20]) if bad else 0)


main()
