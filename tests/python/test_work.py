"""Work goes on without Python's lock, tells how far it is, and stops when asked."""

import _thread
import signal
import threading
import time

import pytest

import planish


class Host:
    """Bears calls on its own thread alone, one at a time, whose fractions rise to 1."""

    def __init__(self):
        self.thread = threading.get_ident()
        self.inside = False
        self.complaints = []
        self.told = []

    def enter(self):
        if threading.get_ident() != self.thread:
            self.complaints.append("another thread")
        if self.inside:
            self.complaints.append("two at once")
        self.inside = True
        time.sleep(0)  # gives the lock away

    def progress(self, step, fraction):
        self.enter()
        if self.told and not self.told[-1][1] <= fraction <= 1:
            self.complaints.append(f"{fraction} after {self.told[-1]}")
        self.told.append((step, fraction))
        self.inside = False

    def cancelled(self):
        self.enter()
        self.inside = False
        return False

    def expect_good(self):
        assert self.complaints == []
        assert self.told[-1][1] == 1


def test_callbacks_come_on_the_callers_thread_and_end_at_1(grid, tmp_path):
    made = planish.fit(*grid(200))
    planish.write(tmp_path / "in.obj", made.cage)
    for call in [
        lambda **host: planish.fit(*grid(200), **host),
        lambda **host: planish.fit(*grid(200), method="fair", **host),
        lambda **host: planish.fit_file(tmp_path / "in.obj", tmp_path / "a.glb", 3, **host),
        lambda **host: planish.fit_file(tmp_path / "in.obj", tmp_path / "a.ply", 2, **host),
        lambda **host: made.evaluate(3, **host),
        lambda **host: made.tessellate(chord_error=1e-4, **host),
    ]:
        host = Host()
        call(progress=host.progress, cancelled=host.cancelled)
        host.expect_good()
        assert len(host.told) > 5


def test_progress_is_told_all_along(grid):
    arrays = grid(700)
    began = time.monotonic()
    times = [0.0]
    planish.fit(*arrays, progress=lambda step, fraction: times.append(time.monotonic() - began))
    times.append(time.monotonic() - began)
    gaps = [after - before for before, after in zip(times, times[1:])]
    assert max(gaps) < max(1.0, 0.3 * times[-1])


def test_one_thread_is_one_thread(grid, tmp_path):
    """Of the processor's time hardly any is other threads'."""
    planish.fit(*grid(100))  # those that are kept for later begin

    def share_of_others(work):
        process, thread = time.process_time(), time.thread_time()
        work()
        own = time.thread_time() - thread
        return (time.process_time() - process - own) / own

    made = planish.fit(*grid(200), threads=1)
    limit = planish.LimitSurface(made)
    points = made.evaluate(0).positions[:2000] + 0.01
    for work in [
        lambda: planish.fit(*grid(200), threads=1),
        lambda: planish.fit(*grid(200), method="fair", threads=1),
        lambda: made.evaluate(4),
        lambda: made.tessellate(chord_error=1e-4),
        lambda: planish.write(tmp_path / "a.glb", made, level=4),
        lambda: limit.closest_point(points),
    ]:
        # Threads that have just worked look for more for a moment.
        assert min(share_of_others(work) for _ in range(4)) < 0.05


def test_an_exception_of_progress_comes_through(grid):
    def fail(step, fraction):
        raise LookupError("mine")

    with pytest.raises(LookupError, match="mine"):
        planish.fit(*grid(30), progress=fail)


def test_cancelling_stops_work(grid):
    arrays = grid(900)
    start = time.monotonic()
    with pytest.raises(planish.Cancelled):
        planish.fit(*arrays, method="fair", cancelled=lambda: time.monotonic() > start + 0.1)


def test_an_exception_of_cancelled_comes_through(grid):
    def fail():
        raise LookupError("mine")

    with pytest.raises(LookupError, match="mine"):
        planish.fit(*grid(900), method="fair", cancelled=fail)


def test_keyboard_interrupt_stops_work(grid):
    arrays = grid(900)
    # What a shell starts in the background ignores interruptions; then the work would never end.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.2, _thread.interrupt_main)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        while True:  # however fast the machine is
            planish.fit(*arrays, method="fair")
    timer.join()
    signal.signal(signal.SIGINT, before)


def test_other_threads_run_meanwhile(grid):
    arrays = grid(500)
    counts = []
    ended = threading.Event()

    def count():
        n = 0
        while not ended.is_set():
            n += 1
            time.sleep(0.001)
        counts.append(n)

    counter = threading.Thread(target=count)
    counter.start()
    start = time.monotonic()
    planish.fit(*arrays, method="fair")
    took = time.monotonic() - start
    ended.set()
    counter.join()
    # With the lock held it would count what sleep lets through before and after.
    assert counts[0] > 20 * took


def test_several_threads_fit_at_once(cube):
    expected = planish.fit(*cube).evaluate(3).positions.tobytes()
    results = []

    def work():
        results.append(planish.fit(*cube).evaluate(3).positions.tobytes())

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [expected] * 4
