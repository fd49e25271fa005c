#!/usr/bin/env python3
"""check_pages.py PLANISH SCENES FOLDER: makes pages and looks at them in a headless Chromium.

Pictures are compared by content: how much of the view is covered, and by how many colours. Ends
with 77 where no browser is found, unless PLANISH_REQUIRE_BROWSER=1."""
import json
import os
import pathlib
import re
import subprocess
import sys
import time

import browser

MODES = ["smooth", "zebra", "isophotes", "error", "deviation", "fold", "mean", "gauss"]
HOSTILE = "\"><img src=x onerror=hit=1>\u202egnp.`$(id)`"

# The view at a small size: share of the pixels that are drawn, number of colours, and a sum that
# tells pictures apart.
LOOK = """(() => {
  const small = new OffscreenCanvas(200, 120), context = small.getContext('2d');
  context.drawImage(document.getElementById('canvas'), 0, 0, 200, 120);
  const pixels = context.getImageData(0, 0, 200, 120).data, colours = new Set();
  let covered = 0, sum = 0, left = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    sum = (sum * 31 + pixels[i] * 7 + pixels[i + 1] * 3 + pixels[i + 2]) % 1000000007;
    if (pixels[i + 3] < 128) continue;
    covered++;
    if ((i / 4) % 200 < 100) left++;
    colours.add((pixels[i] >> 4) << 8 | (pixels[i + 1] >> 4) << 4 | pixels[i + 2] >> 4);
  }
  return { covered: covered / 24000, colours: colours.size, sum, left: left / Math.max(1, covered) };
})()"""
# How many still pictures are seen.
STILLS = """[...document.querySelectorAll('img.still')].filter((i) =>
  i.naturalWidth === 720 && i.getBoundingClientRect().width > 100).length"""
# Two frames on, everything that was asked for is drawn.
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"

failures = []


def check(name, good, detail=""):
    if not good:
        failures.append(name)
    print(f"{'ok  ' if good else 'FAIL'} {name} {detail}", flush=True)


def look(tab):
    tab.evaluate(DRAWN)
    return tab.evaluate(LOOK)


def text(tab, element):
    return tab.evaluate(f"document.getElementById('{element}').textContent")


def check_quiet(tab, name):
    """Nothing was said on the console, and nothing but the page itself was asked for."""
    requests = [url for url in tab.requests() if not url.startswith(("blob:", "data:"))]
    check(f"{name}: silent, one request", not tab.noise() and len(requests) == 1,
          f"{tab.noise()} {requests}")


def make_pages(planish, scenes, folder):
    """Pages of scenes of few triangles; the report of the first."""
    def run(*arguments):
        done = subprocess.run([planish, *arguments], cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{arguments}: {done.returncode}: {done.stderr}")
    hostile = folder / f"{HOSTILE}.obj"
    hostile.write_bytes((scenes / "cube.obj").read_bytes())
    run("fit", str(scenes / "mixed_polygons.obj"), "--page", "one.html", "--report", "one.json",
        "--interpolation", "progressive", "--device", "cpu", "-f")
    run("fit", str(scenes / "mapped_cube.obj"), "--page", "mapped.html", "--device", "cpu", "-f")
    run("fit", hostile.name, "--page", "hostile.html", "--device", "cpu", "-f")
    jobs = [{"name": name, "input": str(scenes / "bearing_block.obj"), "interpolation": name,
             "levels": [1]} for name in ["progressive", "fair"]]
    (folder / "two.json").write_text(json.dumps(
        {"version": 1, "defaults": {"device": "cpu"}, "jobs": jobs}))
    run("run", "two.json", "--page", "two.html", "-f")
    run("fit", hostile.name, *(str(scenes / f"{name}.obj") for name in ("torus", "bust", "open_grid")),
        "-o", "sheet/", "--page", "sheet/", "--levels", "0", "--device", "cpu", "-f")
    run("try", hostile.name, "--page", "trial.html", "--device", "cpu", "-f")
    return json.loads((folder / "one.json").read_text())


def check_modes(tab):
    sums = set()
    for number, mode in enumerate(MODES, 1):
        tab.evaluate("document.getElementById('canvas').focus()")
        tab.key(str(number))
        seen = look(tab)
        sums.add(seen["sum"])
        check(f"{mode} is drawn", seen["covered"] > 0.05 and seen["colours"] > 4
              and tab.evaluate("document.getElementById('mode').value") == mode,
              f"{seen['covered']:.0%} covered, {seen['colours']} colours")
    check("every mode looks different", len(sums) == len(MODES))


def check_keys(tab, report):
    tab.evaluate("document.getElementById('canvas').focus()")
    tab.key("4")
    label = tab.evaluate("document.getElementById('canvas').getAttribute('aria-label')")
    check("the view says what it shows", "Interpolation error" in label, label)
    for key, shift in [("ArrowLeft", False), ("ArrowUp", False), ("ArrowRight", True), ("+", False),
                       ("m", False), ("l", False), ("c", False), ("p", False)]:
        before = look(tab)["sum"]
        tab.key(key, shift)
        check(f"key {'shift-' if shift else ''}{key} changes the picture", look(tab)["sum"] != before)
    tab.key("w")
    error = report["solve"]["error"]
    said = tab.wait("document.getElementById('picked').textContent")
    largest = float(re.search(r"Interpolation error: ([\d.e-]+)", said)[1])
    check("the worst vertex is the report's", f"Worst vertex {error['worst_vertex']} " in said, said)
    check("so is its error", abs(largest - error["max"]) <= 0.01 * error["max"], str(largest))
    tab.key("f")
    check("a fold is named", text(tab, "picked").startswith("Fold 1 of "), text(tab, "picked"))
    time.sleep(0.7)  # the flight
    off = tab.evaluate("""(() => {
        const at = (id) => document.getElementById(id).getBoundingClientRect();
        const mark = at('mark'), stage = at('stage');
        return Math.hypot(mark.x + mark.width / 2 - stage.x - stage.width / 2,
            mark.y + mark.height / 2 - stage.y - stage.height / 2); })()""")
    check("a ring marks it in the middle", off is not None and off < 8, str(off))
    tab.key("Home")
    check("Home shows the whole", look(tab)["covered"] > 0.05)


def check_hands(tab):
    box = tab.evaluate("(({x, y, width, height}) => [x, y, width, height])"
                       "(document.getElementById('canvas').getBoundingClientRect())")
    middle = (box[0] + box[2] / 2, box[1] + box[3] / 2)
    before = look(tab)["sum"]
    tab.drag(middle, (middle[0] + 60, middle[1] + 20))
    check("dragging turns", look(tab)["sum"] != before)
    # The worst vertex is brought to the middle, where a click must find it.
    tab.evaluate("document.getElementById('worst').click()")
    look(tab)
    worst = text(tab, "picked").split(" at ")[0].replace("Worst vertex", "Vertex")
    tab.click(*middle)
    check("a click names a vertex", text(tab, "picked").startswith(worst), text(tab, "picked"))


def check_link(chromium, folder, tab):
    tab.evaluate("document.getElementById('canvas').focus()")
    tab.key("Home")
    tab.key("2")
    tab.key("ArrowLeft")
    time.sleep(0.5)
    there, link = look(tab), tab.evaluate("location.hash.slice(1)")
    sums = []
    for _ in range(2):
        other = chromium.open(folder / "one.html", link)
        other.ready()
        seen = look(other)
        sums.append(seen["sum"])
        other.close()
    # The address rounds the camera, so the pictures may differ by a hair.
    check("a link shows what was seen", abs(seen["covered"] - there["covered"]) < 0.003
          and abs(seen["left"] - there["left"]) < 0.003 and "mode=zebra" in link, link)
    check("and the same each time", sums[0] == sums[1])


def check_safety(tab):
    blocked = tab.evaluate("""(async () => {
      const tries = [
        () => document.body.insertAdjacentHTML('beforeend', '<img src=x onerror="window.hit=1">'),
        () => { document.body.innerHTML = ''; },
        () => { const s = document.createElement('script'); s.textContent = 'window.hit=1'; document.body.append(s); },
        () => (0, eval)('window.hit=1'),
        () => fetch('data:text/plain,x'),
      ];
      let failed = 0;
      for (const attempt of tries) try { await attempt(); } catch { failed++; }
      return failed;
    })()""")
    check("injected markup, scripts and requests are blocked", blocked == 5, str(blocked))
    check("and nothing of it has run", tab.evaluate("window.hit === undefined"))


def check_one(chromium, folder, report):
    tab = chromium.open(folder / "one.html")
    check("WebGL 2 is used", tab.ready() == "GlView")
    check("no note is shown", tab.evaluate("document.getElementById('plain').hidden"))
    check("nor the still picture", not tab.evaluate(STILLS))
    check_modes(tab)
    check_keys(tab, report)
    check_hands(tab)
    check_link(chromium, folder, tab)
    unlabelled = tab.evaluate("[...document.querySelectorAll('input, select')]"
                              ".filter((e) => !e.labels.length).length")
    check("all controls have labels", unlabelled == 0)
    check_quiet(tab, "one job")
    check_safety(tab)
    tab.close()


def check_board(chromium, folder):
    """The texture as a board of squares, where there is one."""
    tab = chromium.open(folder / "mapped.html")
    tab.ready()
    smooth = look(tab)["sum"]
    tab.evaluate("document.getElementById('canvas').focus()")
    tab.key("9")
    seen = look(tab)
    check("a board is drawn", seen["covered"] > 0.05 and seen["colours"] > 4
          and seen["sum"] != smooth
          and tab.evaluate("document.getElementById('mode').value") == "checker"
          and not tab.evaluate("document.getElementById('stripesLabel').hidden"),
          f"{seen['covered']:.0%} covered, {seen['colours']} colours")
    tab.evaluate("document.getElementById('stripes').value = 5;"
                 "document.getElementById('tools').dispatchEvent(new Event('input'))")
    check("of squares as large as is said", look(tab)["sum"] != seen["sum"])
    tab.close()
    tab = chromium.open(folder / "one.html", "mode=checker")
    tab.ready()
    check("without texture coordinates there is no board",
          tab.evaluate("document.getElementById('mode').value") == "smooth")
    tab.evaluate("document.getElementById('canvas').focus()")
    tab.key("9")
    check("nor by its key", tab.evaluate("document.getElementById('mode').value") == "smooth")
    tab.close()


def check_two(chromium, folder):
    tab = chromium.open(folder / "two.html", "mode=deviation&other=1")
    tab.ready()
    shown = tab.evaluate("[...document.querySelectorAll('.side')].map((e) => e.textContent)")
    check("both sides are named", shown == ["progressive", "fair"], str(shown))
    check("one job's words are shown",
          tab.evaluate("document.querySelectorAll('section.job:not([hidden])').length") == 1)
    middle = look(tab)
    tab.evaluate("document.getElementById('divider').focus()")
    for _ in range(20):
        tab.key("ArrowLeft")
    moved = look(tab)
    check("the divider moves", moved["sum"] != middle["sum"])
    check("both sides are one shape", abs(moved["covered"] - middle["covered"]) < 0.01)
    check("its place is told", tab.evaluate(
        "document.getElementById('divider').getAttribute('aria-valuenow')") == "10")
    tab.evaluate("document.querySelector('tr[data-job=\"1\"] a').click()")
    tab.wait("document.getElementById('job1').hidden === false")
    check("the table leads to a job", tab.evaluate("document.getElementById('divider').hidden"))
    tab.media("print")
    tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    check("on paper stand all jobs, without controls", tab.evaluate(
        "document.querySelectorAll('section.job:not([hidden])').length === 2"
        " && getComputedStyle(document.getElementById('tools')).display === 'none'"))
    check_quiet(tab, "two jobs")
    tab.close()


def check_looks(chromium, folder):
    dark = chromium.open(folder / "one.html", scheme="dark")
    dark.ready()
    check("dark is dark", dark.evaluate(
        "getComputedStyle(document.documentElement).backgroundColor") == "rgb(13, 17, 23)")
    dark.close()
    for page in ["one.html", "two.html", "hostile.html"]:
        phone = chromium.open(folder / page, size=(360, 740))
        phone.ready()
        check(f"{page} fits a phone", phone.evaluate("document.documentElement.scrollWidth") <= 360)
        check(f"{page} shows its surface there", look(phone)["covered"] > 0.05)
        phone.close()


def check_hostile(chromium, folder):
    tab = chromium.open(folder / "hostile.html")
    tab.ready()
    check("a hostile name is text", tab.evaluate(
        "window.hit === undefined && document.images.length === 1 && document.images[0].src.startsWith('data:')"))
    name = tab.evaluate("document.querySelector('h1').textContent")
    check("and all of it can be seen", "\u202e" not in name and "\\u202e" in name, ascii(name))
    check_quiet(tab, "hostile")
    tab.close()


def check_sheet(chromium, folder):
    tab = chromium.open(folder / "sheet/index.html")
    tab.ready()
    rows = "[...document.querySelectorAll('.sheet tbody tr')]"
    check("sheet: a file a row, a picture of input and surface each", tab.evaluate(
        f"{rows}.length === 4 && {rows}.every((row) => [...row.querySelectorAll('img')].filter("
        "(i) => i.naturalWidth === 144).length === 2)"))
    names = f"{rows}.map((row) => row.querySelector('th').textContent)"
    check("sheet: the worst first", tab.evaluate(names)[0] == "bust", tab.evaluate(names))
    press = "[...document.querySelectorAll('.sheet thead button')].find((b) => b.textContent === '{}').click()"
    tab.evaluate(press.format("vertices"))
    check("sheet: the most vertices first", tab.evaluate(names)[:2] == ["bust", "torus"])
    tab.evaluate(press.format("vertices"))
    check("sheet: once more turns round", tab.evaluate(names)[2:] == ["torus", "bust"])
    tab.evaluate(press.format("file"))
    check("sheet: names from a to z", tab.evaluate(names)[-3:] == ["bust", "open_grid", "torus"])
    check("sheet: a hostile name is text", tab.evaluate("window.hit === undefined"))
    links = tab.evaluate("[...document.querySelectorAll('.sheet a')].map((a) => decodeURIComponent(a.getAttribute('href')))")
    check("sheet: each opens its own page", all((folder / "sheet" / link).is_file() for link in links), links)
    check_quiet(tab, "sheet")
    tab.close()


def check_trial(chromium, folder):
    tab = chromium.open(folder / "trial.html")
    tab.ready()
    cards = "[...document.querySelectorAll('.card')]"
    count = tab.evaluate(f"{cards}.length")
    check("trial: a picture of each surface", count >= 4 and tab.evaluate(
        f"{cards}.every((card) => card.querySelector('img').naturalWidth === 288)"), str(count))
    check("trial: the one that is taken comes first", tab.evaluate(
        f"{cards}.findIndex((card) => card.querySelector('.pill')) === 0"))
    kept = "[...document.querySelectorAll('.keep:not([hidden])')].map((s) => s.querySelector('pre').textContent)"
    first = tab.evaluate(kept)
    check("trial: it is kept at first", len(first) == 1 and "planish fit" in first[0], str(first))
    before = look(tab)["sum"]
    x, y = tab.evaluate(f"(({{x, y, width, height}}) => [x + width / 2, y + height / 2])"
                        f"({cards}[{count - 1}].getBoundingClientRect())")
    tab.click(x, y)
    tab.wait(f"document.querySelector('tr[aria-current]').dataset.job === '{count - 1}'")
    second = tab.evaluate(kept)
    check("trial: a click keeps another", len(second) == 1 and second != first
          and tab.evaluate(f"{cards}[{count - 1}].getAttribute('aria-current')") == "true", str(second))
    check("trial: and the view shows it", look(tab)["sum"] != before)
    tab.evaluate("document.querySelector('tr[data-job=\"0\"] a').click()")
    tab.wait("document.querySelector('tr[aria-current]').dataset.job === '0'")
    check("trial: a row of the table does, too", tab.evaluate(kept) == first)
    tab.evaluate("document.querySelector('.keep:not([hidden]) .copy').click()")
    check("trial: a command line is copied, or selected", tab.wait(
        "/Copied|Selected/.test(document.querySelector('.keep:not([hidden]) .copy').textContent)"))
    check("trial: a hostile name is text", tab.evaluate(
        "window.hit === undefined && [...document.images].every((image) => image.src.startsWith('data:'))"))
    check_quiet(tab, "trial")
    tab.close()
    phone = chromium.open(folder / "trial.html", size=(360, 740))
    phone.ready()
    check("trial: fits a phone", phone.evaluate("document.documentElement.scrollWidth") <= 360)
    phone.close()
    plain = chromium.open(folder / "trial.html", script=False)
    time.sleep(1)
    check("trial: without script every command line", plain.evaluate(
        "[...document.querySelectorAll('.keep')].filter((s) => s.getBoundingClientRect().height > 50).length") == count)
    plain.close()


def check_no_script(chromium, folder):
    tab = chromium.open(folder / "two.html", script=False)
    time.sleep(1)
    words = tab.evaluate("document.querySelector('main').innerText")
    check("without script: all jobs' figures", words.count("Convergence") == 2
          and words.count("It passes through all of them") == 2, f"{len(words)} characters")
    check("without script: plots", tab.evaluate(
        "document.querySelector('svg.plot').getBoundingClientRect().height") > 100)
    check("without script: a picture of each job", tab.evaluate(STILLS) == 2)
    check("without script: a note, no view", tab.evaluate(
        "document.getElementById('view').hidden && !document.getElementById('plain').hidden"))
    tab.close()


def check_no_webgl(folder):
    with browser.Browser(browser.NO_GL) as chromium:
        tab = chromium.open(folder / "two.html")
        check("without WebGL there is no view", tab.ready() == "failed"
              and tab.evaluate("document.getElementById('view').hidden"))
        check("a sentence says so", not tab.evaluate("document.getElementById('plain').hidden")
              and "no WebGL 2" in text(tab, "plain"), text(tab, "plain"))
        check("a picture of each job is there", tab.evaluate(STILLS) == 2)
        check("and all jobs' figures", tab.evaluate(
            "document.querySelectorAll('section.job:not([hidden])').length") == 2)
        check_quiet(tab, "without WebGL")
        tab.close()


def main():
    if not browser.find():
        print("no browser is installed: set PLANISH_BROWSER, or install chromium-headless-shell")
        return 1 if os.environ.get("PLANISH_REQUIRE_BROWSER") == "1" else 77
    planish, scenes, folder = (pathlib.Path(a).absolute() for a in sys.argv[1:4])
    folder.mkdir(parents=True, exist_ok=True)
    report = make_pages(planish, scenes, folder)
    start = time.monotonic()
    with browser.Browser(browser.SOFTWARE_GL) as chromium:
        check_one(chromium, folder, report)
        check_board(chromium, folder)
        check_two(chromium, folder)
        check_looks(chromium, folder)
        check_hostile(chromium, folder)
        check_sheet(chromium, folder)
        check_trial(chromium, folder)
        check_no_script(chromium, folder)
    check_no_webgl(folder)
    print(f"{len(failures)} failed, {time.monotonic() - start:.1f} s")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
