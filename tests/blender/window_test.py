"""A live surface in Blender's window, as an artist has it: while vertices are dragged, and through Undo.

xvfb-run -a blender --factory-startup --enable-event-simulate --window-geometry 0 0 1280 800 \
  --python window_test.py -- ADDON PLANISH
"""

import os
import pathlib
import sys
import time
import traceback

import bpy

ADDON, PROGRAM = sys.argv[sys.argv.index("--") + 1 :]
SECONDS = 200
"""For each step: a display without a GPU takes long to draw."""


def load():
    sys.path.insert(0, str(pathlib.Path(ADDON).resolve().parents[1]))
    import planish_blender

    planish_blender.register()
    return planish_blender


def event(kind, value="PRESS", x=500, **keys):
    bpy.context.window_manager.windows[0].event_simulate(kind, value, x=x, y=400, **keys)


def press(kind, **keys):
    event(kind, **keys)
    event(kind, "RELEASE", **keys)


def cube():
    return bpy.data.objects["Cube"]


def top(thing):
    """The largest coordinate of an object's vertices."""
    return max(max(corner) for corner in thing.bound_box)


def steps(live):
    """What happens; each yields what has to come true before the next."""
    bpy.context.view_layer.objects.active = cube()
    scene = bpy.context.scene.planish
    scene.program, scene.creases = PROGRAM, "use"

    def is_idle():
        return not live.changed and not live.works and cube().planish.result is not None

    cube().planish.live = True
    yield is_idle
    first = top(cube().planish.result)
    event("MOUSEMOVE", "NOTHING")
    press("TAB")
    yield lambda: cube().mode == "EDIT"
    press("G")
    tops = []
    for number in range(1, 200):
        event("MOUSEMOVE", "NOTHING", 500 + 2 * number)
        yield lambda: True
        tops.append(round(top(cube().planish.result), 3))
        if len(set(tops)) > 3:
            break
    assert len(set(tops)) > 3, "the surface does not follow while vertices are dragged"
    press("LEFTMOUSE")
    yield lambda: is_idle() and top(cube().planish.result) > first + 0.02
    press("Z", ctrl=True)
    yield lambda: is_idle() and abs(top(cube().planish.result) - first) < 1e-4
    press("TAB")
    yield lambda: cube().mode == "OBJECT" and is_idle()
    press("Z", ctrl=True)
    yield lambda: cube().mode == "EDIT" and is_idle()
    press("Z", ctrl=True)
    # Before it was live.
    yield lambda: cube().mode == "OBJECT" and not cube().planish.live and "Cube.planish" not in bpy.data.objects
    assert not live.changed and not live.works and not live.messages


def runner(live):
    going, condition, since = steps(live), None, time.monotonic()

    def run():
        nonlocal condition, since
        try:
            if condition is None or condition():
                condition, since = next(going), time.monotonic()
            assert time.monotonic() - since < SECONDS, f"step at line {going.gi_frame.f_lineno} did not come about"
            return 0.1
        except StopIteration:
            print("the add-on works in Blender's window", flush=True)
        except Exception:
            traceback.print_exc()
        os._exit(0)  # an artist would be asked whether to save

    return run


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(runner(load().live), first_interval=2)
