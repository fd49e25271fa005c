"""The command at work."""

import json
import os
import queue
import shutil
import signal
import subprocess
import threading

import bpy
import numpy as np

from .exchange import read_glb


def command_line(settings):
    """The command that fits a mesh on stdin and gives a GLB on stdout."""
    program = bpy.path.abspath(settings.program) if settings.program else shutil.which("planish")
    if not program or not os.access(program, os.X_OK):
        raise RuntimeError(
            f"the command planish is not at {settings.program}" if settings.program
            else "the command planish is not on PATH; name it in the panel")
    creases = settings.creases
    if creases == "auto":
        creases = f"auto:{np.degrees(settings.crease_angle):.6g}"
    return [program, "fit", "-", "--input-format", "obj", "-o", "-", "--progress", "json",
            "--levels", str(settings.level), "--interpolation", settings.interpolation,
            "--tolerance", f"{settings.tolerance:.9g}", "--within", f"{settings.within:.9g}",
            "--creases", creases, "--quads", settings.quads, "--device", settings.device]


class Job:
    """The command at work on a mesh. Threads feed and empty its pipes, so that none can fill up."""

    def __init__(self, arguments, text):
        self.process = subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE)
        self.output, self.errors = b"", []
        self.lines = queue.SimpleQueue()
        self.share = 0.0
        self.threads = [threading.Thread(target=work, daemon=True)
                        for work in (lambda: self._feed(text.encode()), self._read, self._listen)]
        for thread in self.threads:
            thread.start()

    def _feed(self, data):
        try:
            self.process.stdin.write(data)
            self.process.stdin.close()
        except BrokenPipeError:
            pass  # it ended before; its own message says why

    def _read(self):
        self.output = self.process.stdout.read()

    def _listen(self):
        for line in self.process.stderr:
            self.lines.put(line)

    def poll(self):
        """Takes messages in. True while the command works."""
        while not self.lines.empty():
            line = self.lines.get()
            try:
                message = json.loads(line)
            except ValueError:
                message = {"level": "error", "message": line.decode(errors="replace").strip()}
            self.share = message.get("share", self.share)
            if message.get("level") in ("error", "warning") and message.get("message"):
                self.errors.append(message["message"])
        if any(thread.is_alive() for thread in self.threads):
            return True
        return self.process.poll() is None or not self.lines.empty()

    def cancel(self):
        """Stops the command; it leaves nothing behind."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.wait()

    def surface(self):
        """What the command made. Raises RuntimeError with its message."""
        status = self.process.wait()
        if status not in (0, 5):  # 5: not converged, and written all the same
            raise RuntimeError("; ".join(self.errors) or f"planish ended with exit code {status}")
        return read_glb(self.output)
