"""A headless Chromium, steered by its DevTools protocol over two pipes: nothing but Python's own
library is needed, and no port is opened."""
import base64
import copy
import json
import os
import pathlib
import select
import shutil
import tempfile
import time

NAMES = ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"]
QUIET = ["--no-first-run", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", "--disable-quic", "--disable-extensions", "--hide-scrollbars"]
SOFTWARE_GL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
NO_GL = ["--disable-gpu", "--disable-software-rasterizer"]


def find():
    """The browser to use, or None: $PLANISH_BROWSER, else the first that is installed."""
    named = os.environ.get("PLANISH_BROWSER")
    return named or next(filter(None, map(shutil.which, NAMES)), None)


class Browser:
    """`flags`: SOFTWARE_GL or NO_GL."""

    def __init__(self, flags, seconds=240):
        self.folder = tempfile.mkdtemp(prefix="planish-browser-")
        self.seconds = seconds
        self.number, self.buffer, self.events = 0, b"", []
        commands, self.sink = os.pipe()
        self.source, answers = os.pipe()
        # The browser reads from 3 and writes to 4, whatever numbers the pipes have here.
        ends = [os.dup(commands), os.dup(answers)]
        high = [os.dup2(end, 100 + i) for i, end in enumerate(ends)]
        null = os.open(os.devnull, os.O_RDWR)
        actions = [(os.POSIX_SPAWN_DUP2, null, 0), (os.POSIX_SPAWN_DUP2, null, 1),
                   (os.POSIX_SPAWN_DUP2, null, 2), (os.POSIX_SPAWN_DUP2, high[0], 3),
                   (os.POSIX_SPAWN_DUP2, high[1], 4)]
        program = find()
        arguments = [program, "--headless", "--no-sandbox", "--disable-dev-shm-usage",
                     f"--user-data-dir={self.folder}", "--remote-debugging-pipe", *QUIET, *flags,
                     "about:blank"]
        self.process = os.posix_spawn(program, arguments, os.environ, file_actions=actions)
        for end in [commands, answers, null, *ends, *high]:
            os.close(end)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        try:
            self.call("Browser.close")
        except (RuntimeError, TimeoutError, OSError):
            os.kill(self.process, 9)
        os.waitpid(self.process, 0)
        os.close(self.sink)
        os.close(self.source)
        shutil.rmtree(self.folder, ignore_errors=True)

    def read(self):
        """The next message."""
        end = time.monotonic() + self.seconds
        while b"\0" not in self.buffer:
            if not select.select([self.source], [], [], max(0, end - time.monotonic()))[0]:
                raise TimeoutError("the browser is silent")
            piece = os.read(self.source, 1 << 20)
            if not piece:
                raise RuntimeError("the browser has ended")
            self.buffer += piece
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, session=None, **parameters):
        """The answer to a command; events that come before it are kept in `events`."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.sink, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.read()
            if answer.get("id") != self.number:
                self.events.append(answer)
                continue
            if "error" in answer:
                raise RuntimeError(f"{method}: {answer['error']['message']}")
            return answer["result"]

    def open(self, path, link="", **options):
        return Tab(self, path, link, **options)


class Tab:
    """A page in a window of its own: a file's path, or an address of http."""

    def __init__(self, browser, path, link, size=(1200, 900), script=True, scheme="light",
                 motion="reduce"):
        self.browser = browser
        target = browser.call("Target.createTarget", url="about:blank")["targetId"]
        self.target = target
        self.session = browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.listen()
        width, height = size
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=width < 600)
        self.scheme, self.motion = scheme, motion
        self.media("")
        if not script:
            self.call("Emulation.setScriptExecutionDisabled", value=True)
        address = path if str(path).startswith("http:") else pathlib.Path(path).absolute().as_uri()
        self.call("Page.navigate", url=address + (f"#{link}" if link else ""))

    def listen(self):
        for domain in ["Page", "Runtime", "Network", "Log"]:
            self.call(f"{domain}.enable")

    def frame(self):
        """The page's frame as a tab, where it has an origin of its own, and so a process; what it has said is in events."""
        end, found = time.monotonic() + self.browser.seconds, []
        while not found:  # its process starts after the frame has its address
            if time.monotonic() > end:
                raise TimeoutError("the page has no frame of its own origin")
            time.sleep(0.05)
            found = [target["targetId"] for target in self.browser.call("Target.getTargets")["targetInfos"]
                     if target["type"] == "iframe" and target.get("parentFrameId") == self.target]
        frame = copy.copy(self)
        frame.target = found[0]
        frame.session = self.browser.call("Target.attachToTarget", targetId=frame.target, flatten=True)["sessionId"]
        frame.listen()
        return frame

    def call(self, method, **parameters):
        return self.browser.call(method, session=self.session, **parameters)

    def media(self, kind):
        self.call("Emulation.setEmulatedMedia", media=kind,
                  features=[{"name": "prefers-color-scheme", "value": self.scheme},
                            {"name": "prefers-reduced-motion", "value": self.motion}])

    def close(self):
        self.browser.call("Target.closeTarget", targetId=self.target)

    def evaluate(self, expression):
        """The value of a script's expression, promises awaited."""
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True,
                           returnByValue=True, allowUnsafeEvalBlockedByCSP=False)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise RuntimeError(details.get("exception", {}).get("description", details["text"]))
        return result["result"].get("value")

    def wait(self, expression, seconds=240):
        """Waits until an expression is true and returns it."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                value = self.evaluate(expression)
            except RuntimeError:
                value = None  # the page is not there yet
            if value:
                return value
            time.sleep(0.05)
        raise TimeoutError(f"never true: {expression}")

    def ready(self, seconds=240):
        """Which view the page has made."""
        return self.wait("document.documentElement.dataset.ready", seconds)

    def key(self, key, shift=False):
        for kind in ["keyDown", "keyUp"]:
            text = {"text": key} if kind == "keyDown" and len(key) == 1 else {}
            self.call("Input.dispatchKeyEvent", type=kind, key=key, modifiers=8 if shift else 0, **text)

    def click(self, x, y):
        for kind in ["mousePressed", "mouseReleased"]:
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def drag(self, start, end):
        (x, y), (u, v) = start, end
        self.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", clickCount=1)
        for i in range(1, 6):
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + (u - x) * i / 5,
                      y=y + (v - y) * i / 5, button="left", buttons=1)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=u, y=v, button="left", clickCount=1)

    def screenshot(self, path, whole=False):
        shot = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        pathlib.Path(path).write_bytes(base64.b64decode(shot["data"]))

    def noise(self):
        """What the page has said on its console, and errors of its scripts."""
        said = []
        for event in self.browser.events:
            if event.get("sessionId") != self.session:
                continue
            details = event["params"]
            if event["method"] == "Runtime.consoleAPICalled":
                said.append(" ".join(str(a.get("value", a.get("description"))) for a in details["args"]))
            if event["method"] == "Runtime.exceptionThrown":
                said.append(details["exceptionDetails"].get("exception", {}).get("description", "?"))
            if event["method"] == "Log.entryAdded":
                said.append(details["entry"]["text"])
        return said

    def requests(self):
        """Addresses that the page has asked for."""
        return [event["params"]["request"]["url"] for event in self.browser.events
                if event.get("sessionId") == self.session
                and event["method"] == "Network.requestWillBeSent"]
