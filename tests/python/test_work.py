"""Work goes on without Python's lock, tells how far it is, and stops when asked."""

import _thread
import threading
import time

import pytest

import planish


def test_progress_is_told(grid):
    told = []
    planish.fit(*grid(30), progress=lambda step, fraction: told.append((step, fraction)))
    assert "solve" in {step for step, _ in told}
    assert all(0 <= fraction <= 1 for _, fraction in told)


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
    timer = threading.Timer(0.2, _thread.interrupt_main)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        while True:  # however fast the machine is
            planish.fit(*arrays, method="fair")
    timer.join()


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
