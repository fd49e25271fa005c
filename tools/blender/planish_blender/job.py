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

from .exchange import Riders, Surface, obj_text, read_glb, vertex_positions


def command_line(settings, interpolation=None):
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
            "--levels", str(settings.level), "--scheme", settings.scheme,
            "--interpolation", interpolation or settings.interpolation,
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

    def result(self):
        """What the command made, as read_glb() has it. Raises RuntimeError with its message."""
        status = self.process.wait()
        if status not in (0, 5):  # 5: not converged, and written all the same
            raise RuntimeError("; ".join(self.errors) or f"planish ended with exit code {status}")
        return read_glb(self.output)


class Work:
    """A mesh, what rides on it and its shape keys, one job after another; as a Job has them, `share`, `errors`,
    poll() and cancel()."""

    def __init__(self, settings, mesh, group_names, keys):
        """keys: (name, positions of the mesh's vertices). What is needed of the mesh is taken here."""
        self.settings, self.errors = settings, []
        self.riders = Riders(mesh, group_names)
        positions = vertex_positions(mesh)
        self.texts = [obj_text(mesh, positions, *self.riders.of_file(number))
                      for number in range(self.riders.file_count)]
        self.key_names = [name for name, _ in keys]
        self.texts += [obj_text(mesh, places) for _, places in keys]
        self.number, self.made = 0, None
        self.job = Job(command_line(settings), self.texts[0])

    @property
    def share(self):
        return (self.number + self.job.share) / len(self.texts)

    def wait(self, seconds):
        self.job.threads[1].join(seconds)

    def poll(self):
        """Takes messages in, and what is ready. True while there is work."""
        if self.job.poll():
            return True
        if self.number == len(self.texts):
            return False
        self._take()
        if self.number == len(self.texts):
            return False
        method = self.made.extras.get("method") if self.made else None
        self.job = Job(command_line(self.settings, method), self.texts[self.number])
        return True

    def _take(self):
        if self.number == 0:
            self.errors += self.job.errors  # of the others they are the same
        number, self.number = self.number, self.number + 1
        try:
            given = self.job.result()
            if number == 0:
                self.made = Surface(given)
            if number < self.riders.file_count:
                self.made.take(given, self.riders, number)
            else:
                self.made.take_key(given, self.key_names[number - self.riders.file_count])
        except RuntimeError as error:
            if number == 0:
                self.number = len(self.texts)
                self.failure = error
            else:
                self.errors.append(str(error))

    def cancel(self):
        """Stops the command; it leaves nothing behind."""
        self.texts = self.texts[: self.number + 1]
        self.job.cancel()

    def surface(self):
        """What the command made. Raises RuntimeError with its message."""
        if self.made is None:
            raise getattr(self, "failure", RuntimeError("planish was stopped"))
        return self.made
