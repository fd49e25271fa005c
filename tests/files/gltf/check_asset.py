#!/usr/bin/env python3
"""check_asset.py SAMPLES FOLDER: has gltf_write_samples write its files and three.js draw an asset and its surface in a
headless Chromium: they must lie over each other, at rest and bent and swollen, with the same colours.

Ends with 77 where three.js or a browser is missing, unless PLANISH_REQUIRE_NODE=1 and PLANISH_REQUIRE_BROWSER=1.
With --pictures FOLDER it leaves pictures there."""
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
sys.path.insert(0, str(HERE.parent.parent / "page"))
import browser  # noqa: E402

MODULES = HERE / "node_modules"
failures = []


def check(name, good, detail=""):
    if not good:
        failures.append(name)
    print(f"{'ok  ' if good else 'FAIL'} {name} {detail}", flush=True)


class Handler(http.server.SimpleHTTPRequestHandler):
    """The samples, node's modules below /modules/, and the page."""
    extensions_map = {".js": "text/javascript", ".html": "text/html", ".glb": "model/gltf-binary"}

    def translate_path(self, path):
        path = path.split("?")[0]
        if path.startswith("/modules/"):
            return str(MODULES / path[len("/modules/"):])
        return str(HERE / "draw_asset.html") if path == "/draw_asset.html" else super().translate_path(path)

    def log_message(self, *_):
        pass


def save_picture(tab, path):
    path.write_bytes(base64.b64decode(tab.call("Page.captureScreenshot", format="png")["data"]))


def check_pictures(chromium, port, pictures):
    tab = chromium.open(HERE / "draw_asset.html", size=(420, 340))
    tab.call("Page.navigate", url=f"http://127.0.0.1:{port}/draw_asset.html")
    tab.wait("document.documentElement.dataset.ready")
    for time in [0, 0.5, 1]:
        found = tab.evaluate(f"compare('given/asset.glb', 'asset.glb', {time})")
        check(f"the surface lies over the asset at {time} s", found["overlap"] > 0.93 and found["covered"] > 0.04, found)
        check(f"its colours are the asset's at {time} s", found["apart"] < 10, found)  # of 255; without materials 72
        if pictures:
            save_picture(tab, pictures / f"asset_{time}.png")
        found = tab.evaluate(f"compare('asset.glb', 'details.glb', {time})")
        check(f"with levels of detail it looks the same at {time} s", found["most"] == 0, found)
    # So that the checks above could fail.
    found = tab.evaluate("compare('asset.glb', 'asset.glb', 0, 1)")
    check("the animation bends and swells it", found["overlap"] < 0.9, found)
    tab.close()


def missing(what, variable):
    print(f"no {what}: see tools/test")
    return 1 if os.environ.get(variable) == "1" else 77


def main(program, folder, pictures=None):
    if not (MODULES / "three").is_dir():
        return missing("three.js", "PLANISH_REQUIRE_NODE")
    if browser.find() is None:
        return missing("browser", "PLANISH_REQUIRE_BROWSER")
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    subprocess.run([program, folder], check=True)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with browser.Browser(browser.SOFTWARE_GL) as chromium:
        check_pictures(chromium, server.server_port, pictures and pathlib.Path(pictures))
    server.shutdown()
    print(f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    given = [argument for argument in sys.argv[1:] if argument != "--pictures"]
    sys.exit(main(*given))
