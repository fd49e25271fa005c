#!/usr/bin/env python3
"""check_tiles.py PLANISH SCENES FOLDER: makes sets of 3D Tiles, has the Khronos validator look at
every tile, and 3d-tiles-renderer show the set in a headless Chromium, far and near.

Ends with 77 where node's modules or a browser are missing, unless PLANISH_REQUIRE_NODE=1 and
PLANISH_REQUIRE_BROWSER=1. With --pictures FOLDER it leaves pictures there, level by colour."""
import base64
import functools
import http.server
import os
import pathlib
import shutil
import subprocess
import sys
import threading

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "page"))
import browser  # noqa: E402

MODULES = HERE.parent / "files" / "gltf" / "node_modules"
failures = []


def check(name, good, detail=""):
    if not good:
        failures.append(name)
    print(f"{'ok  ' if good else 'FAIL'} {name} {detail}", flush=True)


class Handler(http.server.SimpleHTTPRequestHandler):
    """The sets, and node's modules below /modules/."""
    extensions_map = {".js": "text/javascript", ".json": "application/json", ".html": "text/html",
                      ".glb": "model/gltf-binary"}
    missing = []

    def translate_path(self, path):
        path = path.split("?")[0]
        if path.startswith("/modules/"):
            return str(MODULES / path[len("/modules/"):])
        if path == "/view.html":
            return str(HERE / "view.html")
        return super().translate_path(path)

    def log_message(self, *_):
        pass

    def log_error(self, *arguments):
        if "favicon" not in self.path:
            self.missing.append((self.path, *arguments))


def make_sets(planish, scenes, folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    sets = {"rocker": ("rocker_arm.obj", ["--levels", "3", "--tile-vertices", "4096"]),
            "skirts": ("rocker_arm.obj", ["--levels", "3", "--tile-vertices", "4096", "--skirts"]),
            "packed": ("rocker_arm.obj", ["--levels", "3", "--tile-vertices", "4096", "--compress", "meshopt"]),
            "shorts": ("rocker_arm.obj", ["--levels", "3", "--tile-vertices", "4096", "--compress", "quantize",
                                          "--tolerance", "1e-4"]),
            "mapped": ("mapped_cube.obj", ["--levels", "3", "--tile-vertices", "256", "--creases", "use"]),
            "holes": ("cube_with_windows.obj", ["--levels", "3", "--tile-vertices", "256", "--creases", "use"]),
            "many": ("rocker_arm.obj", ["--levels", "1", "--tile-vertices", "256"])}
    for name, (scene, flags) in sets.items():
        subprocess.run([planish, "fit", scenes / scene, "-o", folder / f"{name}.json", "--quiet",
                        "--device", "cpu", *flags], check=True)


def validate(folder):
    tiles = sorted(folder.rglob("*.glb"))
    result = subprocess.run(["node", MODULES.parent / "validate.js", *tiles], text=True,
                            capture_output=True, check=False)
    noisy = [line for line in result.stdout.splitlines() if "0 errors, 0 warnings" not in line
             and not line.startswith("  ")]
    check(f"the validator has nothing against {len(tiles)} tiles", result.returncode == 0,
          "\n".join(noisy[:20]) + result.stderr[-2000:])


def save_picture(tab, path):
    data = tab.call("Page.captureScreenshot", format="png")["data"]
    path.write_bytes(base64.b64decode(data))


def check_view(chromium, port, name, pictures):
    tab = chromium.open(HERE / "view.html", size=(800, 600))
    tab.call("Page.navigate", url=f"http://127.0.0.1:{port}/view.html?set=/{name}.json")
    tab.wait("document.documentElement.dataset.ready")
    direction = "[1, -1.2, 0.7]"
    coloured = "true" if pictures and name == "rocker" else "false"
    far = tab.evaluate(f"look(150, {direction}, {coloured})")
    middle = tab.evaluate(f"look(2.6, {direction}, {coloured})")
    if coloured == "true":
        save_picture(tab, pictures / "tiles_far.png")
    near = tab.evaluate(f"look(1.2, {direction}, {coloured})")
    if coloured == "true":
        save_picture(tab, pictures / "tiles_near.png")
    for view in [far, middle, near]:
        check(f"{name}: no load error", not view["errors"], view["errors"])
    check(f"{name}: level 1 from afar", set(far["levels"]) == {"1"}, far)
    check(f"{name}: something is seen", far["covered"] > 0 and middle["covered"] > 0.05, middle)
    last = 1 if name == "many" else 3
    check(f"{name}: the finest level from near", str(last) in near["levels"], near)
    tab.close()


def check_views(folder, pictures):
    handler = functools.partial(Handler, directory=str(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with browser.Browser(browser.SOFTWARE_GL) as chromium:
        for name in ["rocker", "skirts", "packed", "shorts", "mapped", "holes", "many"]:
            check_view(chromium, server.server_port, name, pictures)
    check("the server was asked for nothing that is not there", not Handler.missing,
          Handler.missing)
    server.shutdown()


def missing(what, variable):
    print(f"no {what}: see tools/test")
    return 1 if os.environ.get(variable) == "1" else 77


def main():
    planish, scenes, folder = (pathlib.Path(a).absolute() for a in sys.argv[1:4])
    pictures = pathlib.Path(sys.argv[5]) if sys.argv[4:5] == ["--pictures"] else None
    make_sets(planish, scenes, folder)
    if not shutil.which("node") or not (MODULES / "3d-tiles-renderer").is_dir():
        return missing("node or none of its modules", "PLANISH_REQUIRE_NODE")
    validate(folder)
    if not browser.find():
        return missing("browser", "PLANISH_REQUIRE_BROWSER") if not failures else 1
    check_views(folder, pictures)
    print(f"{len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
