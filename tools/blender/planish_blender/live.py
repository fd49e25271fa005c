"""Surfaces that follow their mesh: fitted again in the background whenever it changes.

A handler notes what changed, a timer starts the command and takes in what it made. A run that has begun is
brought to its end, and the next begins with the mesh as it is then: a mesh that is dragged about would else
never have a surface. Objects are known by name, for Undo and new files make other Python objects of them."""

import contextlib

import bpy
from bpy.app.handlers import persistent

from .result import add_result, fill_result, follow_pose, place_at
from .settings import options_of
from .source import armatures_of, start_job, take_source

SECONDS = 0.03
"""Between two looks of the timer."""

changed = set()
works = {}
shown = {}
"""Of each object what its surface was made of: digest and options."""
messages = {}
"""Why an object has no surface, for the panel."""
is_ours = False
"""While the add-on itself changes what is shown of an object."""
may_be_gone = False
"""Whether objects may have been deleted."""


def live_objects():
    return [thing for thing in bpy.data.objects if thing.type == "MESH" and thing.planish.live]


def wake():
    if not bpy.app.timers.is_registered(tick):
        bpy.app.timers.register(tick, first_interval=SECONDS)


def request(thing):
    changed.add(thing.name)
    wake()


def settings_changed(settings):
    """Of a scene or an object."""
    owner = settings.id_data
    for thing in live_objects():
        if thing == owner or (isinstance(owner, bpy.types.Scene) and not thing.planish.own):
            request(thing)


def toggled(source):
    """An object gets a live surface, or its surface becomes an object as any other."""
    if source.planish.live:
        if source.display_type == "TEXTURED":
            source.display_type = "WIRE"  # or it covers its surface in part
        request(source)
        return
    forget(source.name)
    if source.display_type == "WIRE":
        source.display_type = "TEXTURED"
    result, source.planish.result = source.planish.result, None
    if result is not None and result.planish.source == source:
        release(result)
        result.parent = None
        place_at(result, source)


def release(result):
    result.planish.source = None
    result.hide_select = False


def forget(name):
    changed.discard(name)
    shown.pop(name, None)
    messages.pop(name, None)
    work = works.pop(name, None)
    if work is not None:
        work.cancel()


def part_from_deleted(scene):
    """Surfaces whose source was deleted stay as any other object; who deletes a surface wants none."""
    things = list(scene.objects)
    for thing in things:
        known = thing.planish
        if known.source is not None and known.source not in things:
            release(thing)
        if known.live and known.result is not None and known.result not in things:
            known.live = False


def result_of(context, source, surface):
    """The object that shows the surface: its own, filled anew, or a new one."""
    result = source.planish.result
    if result is not None and result.planish.source == source:  # else the source was duplicated
        fill_result(result, source, surface, has_normals=False)
    else:
        result = add_result(context, source, surface, has_normals=False)
        # As a child it goes where its source goes.
        result.parent = source
        result.hide_select = True  # a click shall find the mesh
        result.planish.source, source.planish.result = source, result
    if not armatures_of(result):
        follow_pose(result, source)
    return result


def start(context, source):
    """Starts the command, if what it gets differs from what is shown."""
    with ours():
        taken = take_source(context, source, with_keys=False)
    key = taken.digest(), options_of(context.scene, source)
    if shown.get(source.name) != key:
        works[source.name] = start_job(context, source, taken)
        shown[source.name] = key


@contextlib.contextmanager
def ours():
    global is_ours
    is_ours = True
    try:
        yield
    finally:
        is_ours = False


def has_time(context, source):
    """Whether an object may be looked at: not while strokes are drawn on it, bones are posed or frames are
    played, which the surface follows by itself."""
    active = context.view_layer.objects.active
    return (source.mode in ("OBJECT", "EDIT") and not (active is not None and active.mode == "POSE")
            and not any(window.screen.is_animation_playing or window.screen.is_scrubbing
                        for window in context.window_manager.windows))


def step(context, source):
    """One object's next step."""
    name = source.name
    work = works.get(name)
    if work is not None:
        if work.poll():
            return
        result = source.planish.result
        if result is not None and result.mode != "OBJECT":
            return  # until the surface is edited no more
        del works[name]
        messages.pop(name, None)
        with ours():
            result_of(context, source, work.surface())
        redraw()
    if name in changed and has_time(context, source):
        changed.discard(name)
        start(context, source)


def tick():
    """The timer: seconds until the next look, or None where nothing is left to do."""
    global may_be_gone
    context = bpy.context
    if may_be_gone:
        may_be_gone = False
        part_from_deleted(context.scene)
    for name in sorted(changed | set(works)):
        source = context.scene.objects.get(name)
        if source is None or not source.planish.live:
            forget(name)
            continue
        try:
            step(context, source)
        except (OSError, RuntimeError) as error:
            messages[name] = str(error)
            redraw()
    return SECONDS if changed or works else None


def redraw():
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@persistent
def mesh_changed(scene, depsgraph):
    global may_be_gone
    if is_ours or depsgraph.mode == "RENDER":
        return
    for update in depsgraph.updates:
        thing = update.id.original
        if isinstance(thing, bpy.types.Scene):
            may_be_gone = True
            wake()
        elif (isinstance(thing, bpy.types.Object) and update.is_updated_geometry and thing.type == "MESH"
              and thing.planish.live):
            request(thing)


@persistent
def everything_changed(*ignored):
    """After Undo and Redo, and in a file that was just opened."""
    for name in set(works) | changed | set(shown):
        forget(name)
    for thing in live_objects():
        request(thing)


HANDLERS = (("depsgraph_update_post", mesh_changed), ("undo_post", everything_changed),
            ("redo_post", everything_changed), ("load_post", everything_changed))


def register():
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    for name in set(works) | changed | set(shown):
        forget(name)
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
