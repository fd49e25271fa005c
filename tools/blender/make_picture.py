"""A picture of the panel beside the surfaces that it tried; needs the command on PATH and a display:

xvfb-run -a -s "-screen 0 1280x800x24" blender --factory-startup --enable-event-simulate \
  --window-geometry 0 0 1280 800 --python make_picture.py -- planish_blender/__init__.py MESH.obj PICTURE.png
"""

import pathlib
import sys

import bpy

ADDON, MESH, PICTURE = sys.argv[sys.argv.index("--") + 1 :]


def load():
    sys.path.insert(0, str(pathlib.Path(ADDON).resolve().parents[1]))
    import planish_blender

    planish_blender.register()
    return planish_blender


def make_scene():
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    bpy.ops.wm.obj_import(filepath=MESH)
    source = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = source
    bpy.ops.mesh.planish_try()


def arrange():
    area = next(area for area in bpy.context.screen.areas if area.type == "VIEW_3D")
    area.spaces.active.show_region_ui = True
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(area=area, region=region):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()


def open_tab():
    """Clicks on the sidebar's last tab."""
    window = bpy.context.window_manager.windows[0]
    for kind, value in (("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")):
        window.event_simulate(kind, value, x=1043, y=800 - 248)


def shoot():
    bpy.ops.screen.screenshot(filepath=PICTURE)
    bpy.ops.wm.quit_blender()


bpy.context.preferences.view.show_splash = False
load()
make_scene()
arrange()
bpy.app.timers.register(open_tab, first_interval=8)
bpy.app.timers.register(shoot, first_interval=14)
