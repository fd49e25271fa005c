#!/usr/bin/env python3
"""picture.py PAGE.html LINK OUT.png [WIDTHxHEIGHT]: a page as a browser shows it; tools/make_pictures
uses it."""
import sys

import browser


def main():
    page, link, out = sys.argv[1:4]
    size = tuple(map(int, (sys.argv[4] if len(sys.argv) > 4 else "1200x900").split("x")))
    if not browser.find():
        sys.exit("no browser is installed: set PLANISH_BROWSER, or install chromium-headless-shell")
    with browser.Browser(browser.SOFTWARE_GL) as chromium:
        tab = chromium.open(page, link, size=size)
        tab.ready()
        tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        tab.screenshot(out)


if __name__ == "__main__":
    main()
