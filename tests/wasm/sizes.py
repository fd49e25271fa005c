"""sizes.py BUILD: holds what users fetch against its bounds. Packed: brotli, as servers send it, by node's own."""
import pathlib
import subprocess
import sys

BOUNDS = {"npm/planish_library.wasm": (True, 970_000), "planish.html": (False, 1_900_000)}
PACK = ("const z=require('zlib');process.stdout.write(String(z.brotliCompressSync("
        "require('fs').readFileSync(process.argv[1])).length))")

large = []
for name, (packed, bound) in BOUNDS.items():
    path = pathlib.Path(sys.argv[1]) / name
    size = int(subprocess.check_output(["node", "-e", PACK, path])) if packed else path.stat().st_size
    print(f"{name}: {size:,} bytes{' packed' if packed else ''}, {bound:,} at most")
    if size > bound:
        large.append(name)
sys.exit(f"too large: {', '.join(large)}" if large else 0)
