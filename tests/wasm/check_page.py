"""check_page.py PAGE [PICTURES]: the page, opened from disk in a browser without a network: fits its goblet and files
that are given to it, says what is wrong with others, stops; desktop, phone, dark. PICTURES: a folder for pictures."""
import base64
import json
import pathlib
import re
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "page"))
import browser as browsers  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
LEAST_PICTURE = 20_000  # characters of base64; an empty frame has 4,000
READY = "!document.getElementById('result').hidden && document.getElementById('stop').hidden"
ERROR = "!document.getElementById('error').hidden && document.getElementById('error').textContent"


def check(true, words):
    if not true:
        sys.exit(f"failed: {words}")


def give(tab, *files):
    """Pastes files: (name, bytes)."""
    made = ",".join(f"new File([Uint8Array.from(atob('{base64.b64encode(data).decode()}'),"
                    f"c=>c.charCodeAt(0))],'{name}')" for name, data in files)
    tab.evaluate(f"(()=>{{const t=new DataTransfer();for(const f of [{made}])t.items.add(f);"
                 "document.getElementById('files').files=t.files;"
                 "document.getElementById('files').dispatchEvent(new Event('change'));})()")
    tab.wait("!document.getElementById('fit').disabled || !document.getElementById('error').hidden")


def picture(tab, folder, name):
    if folder:
        data = tab.call("Page.captureScreenshot", format="png")["data"]
        (folder / name).write_bytes(base64.b64decode(data))


def drawn(tab):
    """The frame, scrolled to, once its page has run its script and shows more than its background; None: it does not."""
    frame = tab.frame()
    frame.ready(seconds=60)
    box = tab.evaluate("document.getElementById('report').scrollIntoView(),"
                       "(({x,y,width,height})=>({x:x+scrollX,y:y+scrollY,width,height,scale:1}))"
                       "(document.getElementById('report').getBoundingClientRect())")
    end = time.monotonic() + 60
    while time.monotonic() < end:
        if len(tab.call("Page.captureScreenshot", format="png", clip=box)["data"]) > LEAST_PICTURE:
            return frame
        time.sleep(0.2)
    return None


def pixels(tab, condition, *shots):
    """How many pixels fulfil a condition on a and b, their colours in two pictures or in one."""
    return tab.evaluate(f"""(async () => {{
        const read = async (shot) => {{
            const bytes = Uint8Array.from(atob(shot), (letter) => letter.charCodeAt(0));
            const image = await createImageBitmap(new Blob([bytes]));
            const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
            context.drawImage(image, 0, 0);
            return context.getImageData(0, 0, image.width, image.height).data;
        }};
        const [one, two] = await Promise.all({list(shots)}.map(read));
        let count = 0;
        for (let i = 0; i < one.length; i += 4) {{
            const [a, b] = [one, two ?? one].map((data) => data.subarray(i, i + 3));
            if ({condition}) ++count;
        }}
        return count;
    }})()""")


def changed(tab, *shots):
    return pixels(tab, "a.some((value, k) => Math.abs(value - b[k]) > 8)", *shots)


def orange(tab, shot):
    return pixels(tab, "[217, 89, 0].every((value, k) => Math.abs(a[k] - value) < 3)", shot) > 20


def problems(browser):
    return [event for event in browser.events
            if event.get("method") == "Runtime.exceptionThrown"
            or event.get("method") == "Log.entryAdded" and event["params"]["entry"]["level"] == "error"]


def check_editing(browser, page, folder):
    """A vertex is dragged, the surface follows, and what is around it; it is taken back, made again, and saved; keys."""
    tab = browser.open(page)
    tab.wait("location.protocol === 'file:' && document.readyState === 'complete'")
    tab.evaluate("document.getElementById('example').click()")
    tab.wait(READY, seconds=120)
    tab.evaluate("document.getElementById('edit').click()")
    tab.wait("!document.getElementById('editing').hidden", seconds=120)
    tab.evaluate("document.getElementById('editing').scrollIntoView()")
    box = tab.evaluate("(({x,y,width,height})=>({x,y,width,height,scale:1}))(document.getElementById('canvas').getBoundingClientRect())")
    edge = 9  # the ring of what has the focus, and corners
    clip = {"x": box["x"] + edge, "y": box["y"] + edge + tab.evaluate("scrollY"), "width": box["width"] - 2 * edge,
            "height": box["height"] - 2 * edge, "scale": 1}

    def shoot(name):
        tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        picture(tab, folder, name)
        return tab.call("Page.captureScreenshot", format="png", clip=clip)["data"]

    def settled(undo, redo):
        tab.wait(f"document.getElementById('undo').disabled === {undo} && document.getElementById('redo').disabled === {redo}")
        time.sleep(0.5)

    def press(key, **more):
        for kind in ["keyDown", "keyUp"]:
            tab.call("Input.dispatchKeyEvent", type=kind, key=key, **more)

    settled("true", "true")
    before = shoot("edit_start.png")
    middle = [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]
    tab.drag(middle, [middle[0] + 30, middle[1] + 90])
    settled("false", "true")
    check(orange(tab, shoot("edit_held.png")), "the held point looks like all others")
    press("Escape")
    after = shoot("edit_moved.png")
    check(before != after, "the surface does not follow")
    said = tab.evaluate("document.getElementById('moved').textContent")
    check(re.fullmatch(r"The surface is off its vertices by at most \de-\d+ of the diagonal.", said), said)
    check(int(re.search(r"e-(\d+)", said)[1]) >= 6, said)
    tab.evaluate("document.getElementById('undo').click()")
    settled("true", "false")
    check(shoot("edit_back.png") == before, "what is taken back stays")
    tab.evaluate("document.getElementById('redo').click()")
    settled("false", "true")
    check(shoot("edit_again.png") == after, "what is made again differs")
    tab.evaluate("document.getElementById('undo').click()")
    settled("true", "false")
    tab.evaluate("document.getElementById('reach').value='0.3',document.getElementById('reach').dispatchEvent(new Event('input'))")
    check(tab.evaluate("document.getElementById('reached').textContent") == "30 % of the diagonal", "the reach is not said")
    tab.drag(middle, [middle[0] + 30, middle[1] + 90])
    settled("false", "true")
    press("Escape")
    wide = shoot("edit_wide.png")
    check(changed(tab, before, wide) > 3 * changed(tab, before, after), "what is around the vertex stays")
    tab.evaluate("document.getElementById('undo').click()")
    settled("true", "false")
    check(shoot("edit_wide_back.png") == before, "what was around the vertex stays moved")
    # By keys alone.
    tab.evaluate("document.getElementById('canvas').focus()")
    press("n")
    held = shoot("edit_key.png")
    check(orange(tab, held), "no point is taken hold of by a key")
    press("ArrowUp", modifiers=8)
    settled("false", "true")
    check(shoot("edit_key_moved.png") != held, "no point is moved by a key")
    press("z", modifiers=2)
    settled("true", "false")
    check(shoot("edit_key_back.png") == held, "what a key has moved is not taken back")
    press("p")
    check(shoot("edit_key_before.png") != held, "the point before is the same")
    press("Escape")
    check(shoot("edit_key_none.png") == before, "a point is held on")
    press("ArrowLeft")
    check(shoot("edit_key_turned.png") != before, "keys do not turn")
    press("ArrowRight")
    # Beside the surface it turns.
    tab.drag([box["x"] + 20, box["y"] + 20], [box["x"] + 120, box["y"] + 40])
    check(shoot("edit_turned.png") != after, "the view does not turn")
    with tempfile.TemporaryDirectory() as name:
        tab.call("Page.setDownloadBehavior", behavior="allow", downloadPath=name)
        tab.evaluate("document.getElementById('saveMoved').click()")
        saved = pathlib.Path(name) / "goblet.glb"
        end = time.monotonic() + 30
        while not saved.exists() and time.monotonic() < end:
            time.sleep(0.1)
        check(saved.exists(), "nothing is saved")
        data = saved.read_bytes()
        check(data[:4] == b"glTF" and int.from_bytes(data[8:12], "little") == len(data), "no whole GLB is saved")
    tab.evaluate("document.getElementById('leave').click()")
    check(tab.evaluate("document.getElementById('editing').hidden && !document.getElementById('result').hidden"), "no way back")
    check(not tab.evaluate(ERROR), "an error is shown")
    tab.close()


def main():
    page = pathlib.Path(sys.argv[1])
    folder = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    if not browsers.find():
        print("skipped: no browser is installed")
        return
    with browsers.Browser(browsers.SOFTWARE_GL, seconds=120) as browser:
        for name, options in [("desktop", {}), ("phone", {"size": (390, 800)}), ("dark", {"scheme": "dark"})]:
            tab = browser.open(page, **options)
            tab.wait("location.protocol === 'file:' && document.readyState === 'complete'")
            tab.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=-1,
                     uploadThroughput=-1)
            picture(tab, folder, f"{name}_start.png")
            check(tab.evaluate("document.documentElement.scrollWidth <= innerWidth"), f"{name}: wider than the window")
            tab.evaluate("document.getElementById('example').click()")
            tab.wait(READY, seconds=120)
            links = tab.evaluate("[...document.querySelectorAll('#downloads a')].map(a=>a.download).join()")
            check(links == "goblet.glb,report.json,goblet.html", f"links: {links}")
            check(tab.evaluate("document.querySelector('#downloads a').textContent.includes('MB')"), "its size")
            glb = tab.evaluate("fetch(document.querySelector('#downloads a').href).then(r=>r.text(),e=>'refused')")
            check(glb == "refused", "the policy lets a page fetch")
            picture(tab, folder, f"{name}_result.png")
            check(drawn(tab), f"{name}: the report's frame stays empty")
            picture(tab, folder, f"{name}_report.png")
            tab.close()

        check_editing(browser, page, folder)
        tab = browser.open(page)
        tab.wait("location.protocol === 'file:' && document.readyState === 'complete'")
        for bad, words in [(("bad.obj", b"v 0 0 0\nf 1 2 3\n"), "bad.obj:2: face names vertex 3 of 1"),
                           (("cloud.xyz", b"0 0 0\n"), "planish fit cloud.xyz"),
                           (("picture.bmp", b"BM"), "no format")]:
            give(tab, bad)
            tab.evaluate("document.getElementById('fit').click()")
            said = tab.wait(ERROR)
            check(words in said, said)
        # What the choice is between, of one mesh; nothing but the page is made.
        give(tab, ("cube.obj", (ROOT / "scenes/cube.obj").read_bytes()))
        tab.evaluate("document.getElementById('try').click()")
        tab.wait(READY, seconds=120)
        links = tab.evaluate("[...document.querySelectorAll('#downloads a')].map(a=>a.download).join()")
        check(links == "cube_tried.html", f"links: {links}")
        said = tab.evaluate("document.getElementById('said').textContent")
        check("taken" in said and "--quads off" in said, said)
        frame = drawn(tab)
        check(frame, "the frame of what was tried stays empty")
        check(frame.evaluate("getComputedStyle(document.querySelector('.trial')).display") == "grid", "its style is refused")
        kept = "document.querySelector('.keep:not([hidden]) pre').textContent"
        first = frame.evaluate(kept)
        check("planish fit" in first, first)
        frame.evaluate("document.querySelectorAll('.card')[2].click()")
        frame.wait(f"{kept} !== {json.dumps(first)}", seconds=60)
        picture(tab, folder, "tried.png")
        # Several at once, with a cage; each is in the one report page.
        obj = (ROOT / "scenes/goblet.obj").read_bytes()
        give(tab, ("a.obj", obj), ("b c.obj", obj))
        check(tab.evaluate("document.getElementById('try').disabled"), "several meshes are tried")
        tab.evaluate("document.getElementById('cage').click();document.getElementById('levels').value='0';"
                     "document.getElementById('fit').click()")
        tab.wait(READY, seconds=120)
        links = tab.evaluate("[...document.querySelectorAll('#downloads a')].map(a=>a.download).sort().join()")
        check("a.glb" in links and "b c.glb" in links and "cage" in links, f"links: {links}")
        # Stop ends it at once.
        give(tab, ("goblet.obj", obj))
        tab.evaluate("document.getElementById('levels').value='4';document.getElementById('fit').click()")
        tab.wait("!document.getElementById('stop').hidden")
        tab.evaluate("document.getElementById('stop').click()")
        check("Stopped" in tab.wait(ERROR), "stop")
        refused = ["Fetch API cannot load", "connect-src"]  # what was asked for above
        bad = [event for event in problems(browser) if not any(words in str(event) for words in refused)]
        check(not bad, f"the console says {bad}")
    print("the page fits, tries, refuses, stops")


main()
