"""The command at work."""

import json
import queue
import signal
import subprocess
import threading

from .exchange import Surface, read_glb
from .settings import flags_of


class Job:
    """The command at work. Threads feed and empty its pipes, so that none can fill up, and do the work on what
    goes through them, so that Blender does not wait for it."""

    def __init__(self, arguments, text=str, take=bytes, good=(0, 5)):
        """text(): what the command gets; take(bytes): the result, of what it gives. `good`: exit codes of
        results; 5: not converged, and written all the same."""
        self.text, self.take, self.good = text, take, good
        self.process = subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE)
        self.made, self.failure, self.errors = None, None, []
        self.lines = queue.SimpleQueue()
        self.share = 0.0
        self.threads = [threading.Thread(target=work, daemon=True)
                        for work in (self._feed, self._read, self._listen)]
        for thread in self.threads:
            thread.start()

    def _feed(self):
        try:
            with self.process.stdin as pipe:
                pipe.write(self.text().encode())
        except BrokenPipeError:
            pass  # it ended before; its own message says why

    def _read(self):
        output = self.process.stdout.read()
        try:
            if self.process.wait() in self.good:
                self.made = self.take(output)
        except RuntimeError as error:
            self.failure = error
        except Exception as error:  # or nobody would learn of it
            self.failure = RuntimeError(f"what planish gave was not understood: {error!r}")

    def _listen(self):
        for line in self.process.stderr:
            self.lines.put(line)

    def wait(self, seconds):
        self.threads[1].join(seconds)

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
        """What was made of what the command gave. Raises RuntimeError with its message."""
        if self.failure is not None:
            raise self.failure
        status = self.process.wait()
        if status not in self.good:
            raise RuntimeError("; ".join(self.errors) or f"planish ended with exit code {status}")
        return self.made


def fit_line(program, device, options):
    """The command that fits a mesh on stdin and gives a GLB on stdout."""
    return [program, "fit", "-", "--input-format", "obj", "-o", "-", "--progress", "json", "--device", device,
            *flags_of(options)]


class Work:
    """A mesh, what rides on it and its shape keys, one job after another; as a Job has them, `share`, `errors`,
    wait(), poll() and cancel()."""

    def __init__(self, program, device, options, taken):
        """`taken`: what source.py took of the mesh."""
        self.program, self.device, self.options, self.taken = program, device, options, taken
        self.errors, self.failure = [], RuntimeError("planish was stopped")
        self.number, self.made = 0, None
        self.job = self._job()

    def _job(self, **more):
        line = fit_line(self.program, self.device, {**self.options, **more})
        number = self.number
        return Job(line, lambda: self.taken.text(number), self._take)

    @property
    def share(self):
        return (self.number + self.job.share) / self.taken.count

    def wait(self, seconds):
        self.job.wait(seconds)

    def poll(self):
        """Takes messages in, and what is ready. True while there is work."""
        if self.number == self.taken.count:
            return False
        if self.job.poll():
            return True
        try:
            self.job.result()
        except RuntimeError as error:
            if self.number == 0:
                self.number, self.failure = self.taken.count, error
                return False
            self.errors.append(str(error))
        if self.number == 0:
            self.errors += self.job.errors  # of the others they are the same
        self.number += 1
        if self.number == self.taken.count:
            return False
        # Of the same mesh the same is chosen; a shape key gets the method of the first.
        method = self.made.extras.get("method")
        is_key = self.number >= self.taken.riders.file_count
        self.job = self._job(**({"interpolation": method} if method and is_key else {}))
        return True

    def _take(self, output):
        """In the thread of file `number`, while nobody else looks."""
        made, riders, number = read_glb(output), self.taken.riders, self.number
        if number == 0:
            self.made = Surface(made)
        if number < riders.file_count:
            self.made.take(made, riders, number)
        else:
            self.made.take_key(made, self.taken.key_names[number - riders.file_count])
        if number + 1 == self.taken.count:
            self.made.merge()

    def cancel(self):
        """Stops the command; it leaves nothing behind."""
        self.number = self.taken.count
        self.job.cancel()
        self.made = None

    def surface(self):
        """What the command made. Raises RuntimeError with its message."""
        if self.made is None:
            raise self.failure
        return self.made
