"""check_examples.py NPM [PICTURES]: the npm package as its users have it: packed, installed into an empty folder, and used
by the examples of tools/wasm/examples: a program of node, types by tsc, a page of Vite with three.js in a browser, served
with a strict policy and no headers for threads. PICTURES: a folder for pictures."""
import base64
import functools
import http.server
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading

for folder in "page", "doors":
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / folder))
import browser as browsers  # noqa: E402
import table  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "tools/wasm/examples"
MODULES = pathlib.Path(__file__).resolve().parent / "modules/node_modules"
POLICY = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'unsafe-inline'"


def check(true, words):
    if not true:
        sys.exit(f"failed: {words}")


def run(*command, folder, status=0):
    done = subprocess.run([str(part) for part in command], cwd=folder, capture_output=True, text=True, check=False)
    check(done.returncode == status, f"{' '.join(map(str, command))}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def install(npm, folder):
    packed = run("npm", "pack", "--silent", "--pack-destination", folder, npm, folder=folder).strip()
    (folder / "package.json").write_text('{"type": "module", "private": true}')
    run("npm", "install", "--silent", "--offline", "--no-audit", "--no-fund", folder / packed, folder=folder)
    for example in EXAMPLES.iterdir():
        run("cp", "-r", example, folder, folder=folder)


def check_node(folder):
    said = run("node", "convert.mjs", ROOT / "scenes/goblet.obj", "goblet.glb", folder=folder)
    check(re.search(r"goblet.glb: \w+, the vertices are off by at most \d\.\de-\d", said), said)
    check((folder / "goblet.glb").read_bytes()[:4] == b"glTF", "no GLB")
    (folder / "bad.obj").write_text("v 0 0 0\nf 1 2 3\n")
    said = run("node", "convert.mjs", "bad.obj", "bad.glb", folder=folder, status=1)
    check("bad.obj:2: face names vertex 3 of 1" in said and "at " not in said, said)
    check(not (folder / "bad.glb").exists(), "a surface of nothing")


def link_modules(folder):
    (folder / "node_modules/@types").mkdir(exist_ok=True)
    for name in ["three", "@types/three"]:
        os.symlink(MODULES / name, folder / "node_modules" / name)


def given_options():
    """All values of options that fitFile() takes, but for those that do nothing to a file in memory, and lists as texts."""
    lines = ["import type { FitFileOptions } from 'planish';"]
    for name, row in table.ROWS.items():
        if "npm" in row.refused or name in ("device", "textures", "attributes"):
            continue
        key = re.sub("_(.)", lambda found: found[1].upper(), name)
        for value in [row.value, *row.also]:
            lines.append(f"export const {key}{len(lines)}: FitFileOptions = {json.dumps({key: value})};")
    return "\n".join(lines) + "\n"


def check_types(folder):
    """README's examples and the page's, as strict as tsc can be; and that what is wrong is seen."""
    blocks = re.findall(r"```js\n(.*?)```", (ROOT / "tools/wasm/js/README.md").read_text(), re.DOTALL)
    check(len(blocks) > 3, "README has lost its examples")
    text = "import type { Mesh as ThreeMesh } from 'three';\ndeclare const mesh: ThreeMesh;\n" \
           "declare const bytes: Uint8Array;\ndeclare function show(...given: unknown[]): void;\n" + "".join(blocks)
    # Two of them have a fit of their own.
    parts = text.split("import { PlanishWorker }")
    (folder / "readme.ts").write_text(parts[0])
    head = parts[0][:parts[0].index("import { load")]
    (folder / "readme_worker.ts").write_text(head + "import { PlanishWorker }" + parts[1])
    tsc = ["node", MODULES / "typescript/bin/tsc", "--noEmit", "--strict", "--exactOptionalPropertyTypes", "--target", "es2022",
           "--lib", "es2022,dom", "--module", "esnext", "--moduleResolution", "bundler"]
    (folder / "assets.d.ts").write_text("declare module '*?url' { const url: string; export default url; }\n")
    run(*tsc, "--skipLibCheck", "readme.ts", "readme_worker.ts", "three/main.ts", "assets.d.ts", folder=folder)
    (folder / "options.ts").write_text(given_options())
    run(*tsc, "--skipLibCheck", "options.ts", folder=folder)
    # The package's own types, whole.
    run(*tsc, "node_modules/planish/index.d.ts", folder=folder)
    for wrong, words in [("planish.fit({ positions: [] }, { interpolation: 'best' })", "'\"best\"' is not assignable"),
                         ("planish.fitFile(new Uint8Array(), 'a.glb', { compress: 'zip' })", "'\"zip\"' is not assignable"),
                         ("planish.fit({ faces: [] })", "'positions' is missing"),
                         ("planish.fitFile(new Uint8Array(), 'a.obj', { level: 2 })", "'level' does not exist")]:
        (folder / "wrong.ts").write_text(f"import {{ load }} from 'planish';\nconst planish = await load();\n{wrong};\n")
        said = run(*tsc, "--skipLibCheck", "wrong.ts", folder=folder, status=2)
        check(words in said, f"{wrong}: {said}")


class Handler(http.server.SimpleHTTPRequestHandler):
    def end_headers(self):
        self.send_header("Content-Security-Policy", POLICY)
        super().end_headers()

    def log_message(self, *_):
        pass


def given_point(tab, shot):
    """Where a whole blue point is in a picture, or None."""
    return tab.evaluate(f"""(async () => {{
        const bytes = Uint8Array.from(atob('{shot}'), (letter) => letter.charCodeAt(0));
        const image = await createImageBitmap(new Blob([bytes]));
        const {{ width, height }} = image;
        const context = new OffscreenCanvas(width, height).getContext('2d');
        context.drawImage(image, 0, 0);
        const {{ data }} = context.getImageData(0, 0, width, height);
        const isBlue = (x, y) => [27, 79, 143].every((value, i) => Math.abs(data[4 * (y * width + x) + i] - value) < 3);
        const six = [0, 1, 2, 3, 4, 5];
        for (let y = 0; y + 6 < height; ++y) for (let x = 0; x + 6 < width; ++x)
          if (six.every((i) => six.every((j) => isBlue(x + i, y + j)))) return [x + 3, y + 3];
        return null;
    }})()""")


def check_page(folder, pictures):
    project = folder / "three"
    run("cp", ROOT / "scenes/goblet.obj", project, folder=folder)
    said = run("node", MODULES / "vite/bin/vite.js", "build", folder=project)
    made = [path.name for path in (project / "dist").rglob("*") if path.is_file()]
    # The library once, though page and worker use it.
    check(sum(name.endswith(".wasm") for name in made) == 1, f"{made}\n{said}")
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=project / "dist"))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with browsers.Browser(browsers.SOFTWARE_GL, seconds=120) as browser:
        tab = browser.open(f"http://127.0.0.1:{server.server_address[1]}/", size=(1000, 600))
        tab.wait("document.getElementById('said').textContent.includes('faces fitted')", seconds=120)
        check(not tab.evaluate("self.crossOriginIsolated"), "the server sends headers that pages rarely have")
        shots = []

        def shoot():
            tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
            shots.append(tab.call("Page.captureScreenshot", format="png")["data"])
            if pictures:
                (pictures / f"three_{len(shots)}.png").write_bytes(base64.b64decode(shots[-1]))

        shoot()
        place = given_point(tab, shots[0])
        check(place, "no given point is drawn")
        tab.drag(place, [place[0] + 40, place[1] - 60])
        said = tab.evaluate("document.getElementById('said').textContent")
        check(re.fullmatch(r"vertex \d+ moved; the surface is off by at most \de-\d+ of the diagonal", said), said)
        shoot()
        check(shots[0] != shots[1], "the surface does not follow")
        for _ in range(5):  # as many moves as the drag has
            tab.call("Input.dispatchKeyEvent", type="keyDown", key="z", modifiers=2)
        shoot()
        moved = given_point(tab, shots[2])
        check(moved == place, f"taken back, the point is at {moved} instead of {place}")
        bad = [event for event in browser.events if event.get("method") == "Runtime.exceptionThrown"
               or event.get("method") == "Log.entryAdded" and event["params"]["entry"]["level"] == "error"]
        check(not bad, f"the console says {bad}")
    server.shutdown()


def main():
    npm = pathlib.Path(sys.argv[1]).resolve()
    pictures = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        install(npm, folder)
        check_node(folder)
        print("a program of node converts a file")
        if not (MODULES / ".package-lock.json").exists():
            print(f"skipped: types and three.js; npm ci --prefix {MODULES.parent} fetches what they need")
            return
        link_modules(folder)
        check_types(folder)
        print("the types hold")
        if not browsers.find():
            print("skipped: three.js; no browser is installed")
            return
        check_page(folder, pictures)
        print("a page of Vite draws by three.js, and a point is dragged")


main()
