"""How long a live surface takes to follow its mesh, with the command on PATH:

blender --background --factory-startup --python measure_live.py -- planish_blender/__init__.py GOBLET.obj
"""

import pathlib
import resource
import sys
import time

import bpy

ADDON, GOBLET = sys.argv[sys.argv.index("--") + 1 :]
ROUNDS = 7


def load():
    sys.path.insert(0, str(pathlib.Path(ADDON).resolve().parents[1]))
    import planish_blender

    planish_blender.register()
    return planish_blender


def torus(around, across):
    bpy.ops.mesh.primitive_torus_add(major_segments=around, minor_segments=across)


def processor_seconds():
    """Of Blender's main thread, and of all threads with the commands that have ended."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.thread_time(), time.process_time() + children.ru_utime + children.ru_stime


def measure(addon, name):
    """Milliseconds of processor time, which other work on the machine does not stretch: of the two steps in
    which Blender waits, and of all from the change to the new surface; and of waiting for all."""
    source, context, rows = bpy.context.object, bpy.context, []
    for round_number in range(ROUNDS):
        source.data.vertices[0].co.x += 0.001 * (round_number + 1)
        source.data.update()
        context.view_layer.update()
        began, (thread, all_threads) = time.perf_counter(), processor_seconds()
        taken = addon.source.take_source(context, source, with_keys=False)
        work = addon.start_job(context, source, taken)
        to_take = processor_seconds()[0] - thread
        while work.poll():
            time.sleep(0.005)
        thread = processor_seconds()[0]
        addon.live.result_of(context, source, work.surface())
        context.view_layer.update()
        spans = to_take, processor_seconds()[0] - thread, processor_seconds()[1] - all_threads
        rows.append([1000 * span for span in (*spans, time.perf_counter() - began)])
    least = [min(row[i] for row in rows[1:]) for i in range(4)]
    result = source.planish.result
    print(f"| {name} | {len(source.data.polygons):,} | {len(result.data.polygons):,} | "
          + " | ".join(f"{value:.0f}" for value in least) + " |")


def main():
    addon = load()
    print("| mesh | faces | of its surface | taking it | showing it | all | waiting for all |")
    bpy.ops.mesh.primitive_cube_add()
    measure(addon, "cube")
    bpy.ops.wm.obj_import(filepath=GOBLET)
    bpy.context.view_layer.objects.active = bpy.context.selected_objects[0]
    measure(addon, "goblet")
    torus(50, 20)
    measure(addon, "torus")
    torus(125, 80)
    measure(addon, "torus")
    bpy.context.scene.planish.creases, bpy.context.scene.planish.quads = "use", "off"
    bpy.context.scene.planish.refine, bpy.context.scene.planish.interpolation = "off", "fair"
    measure(addon, "the same, nothing left to choose")
    bpy.context.scene.planish.level = 1
    measure(addon, "the same, level 1")


main()
