"""What the panel sets, of a scene or of one object, as the command's options."""

import os
import shutil

import bpy
import numpy as np


def changed(self, context):
    from . import live  # which imports this

    live.settings_changed(self)


class SurfaceSettings:
    """How a surface is made. Texts of choices are the command's own, but for `angle`."""

    level: bpy.props.IntProperty(
        name="Level", min=0, max=6, default=2, update=changed,
        description="How often each face of the control mesh is split in four")
    scheme: bpy.props.EnumProperty(
        name="Surface", default="doo-sabin", update=changed,
        items=[("doo-sabin", "Doo-Sabin", "Follows the mesh with the least waves"),
               ("catmull-clark", "Catmull-Clark", "Curvature without jumps")])
    interpolation: bpy.props.EnumProperty(
        name="Method", default="auto", update=changed,
        items=[("auto", "Auto", "The better of both by measurement"),
               ("progressive", "Progressive", "Moves the control points of the mesh"),
               ("fair", "Fair", "Builds control points that do not fold uneven meshes")])
    tolerance: bpy.props.FloatProperty(
        name="Tolerance", min=1e-12, max=1, default=1e-6, precision=9, update=changed,
        description="Largest distance of a vertex from the surface, of the bounding box's diagonal")
    within: bpy.props.FloatProperty(
        name="Within", min=0, max=0.0999, default=0, precision=6, update=changed,
        description="Leaves vertices by up to this fraction of the diagonal to bend less; 0: exact")
    creases: bpy.props.EnumProperty(
        name="Creases", default="choose", update=changed,
        items=[("choose", "By Measurement", "Edges stay sharp where the surface is better for it"),
               ("use", "Marked", "Edges that are marked stay sharp, no others"),
               ("auto", "Marked and Found", "Edges that are found to be sharp stay so, too"),
               ("angle", "By Angle", "Edges whose faces turn by more than an angle stay sharp, too"),
               ("ignore", "None", "All edges become round")])
    crease_angle: bpy.props.FloatProperty(
        name="Angle", subtype="ANGLE", min=0.02, max=3.14, default=np.radians(30), update=changed,
        description="Edges whose faces turn by more stay sharp")
    quads: bpy.props.EnumProperty(
        name="Quads", default="auto", update=changed,
        items=[("auto", "Auto", "Joins triangles to quads where the surface is better for it"),
               ("on", "On", "Joins triangles to quads"),
               ("off", "Off", "Leaves triangles as they are")])
    refine: bpy.props.EnumProperty(
        name="Refine", default="auto", update=changed,
        items=[("auto", "Auto", "Adds vertices between uneven triangles where the surface bends less for it"),
               ("on", "On", "Adds vertices between uneven triangles"),
               ("off", "Off", "Adds no vertices")])


SURFACE = tuple(SurfaceSettings.__annotations__)
CHOICES = ("interpolation", "creases", "quads", "refine")
"""What the command chooses by measurement where nothing is named, and `planish try` shows."""


class PlanishScene(SurfaceSettings, bpy.types.PropertyGroup):
    """Settings of all objects that have none of their own."""

    device: bpy.props.EnumProperty(
        name="Device", default="auto",
        items=[("auto", "Auto", "What is fastest for most meshes: the CPU"),
               ("cpu", "CPU", "All cores"), ("vulkan", "Vulkan", "The best Vulkan device")])
    program: bpy.props.StringProperty(
        name="Command", subtype="FILE_PATH", description="Where planish is; empty: on PATH")
    sheet: bpy.props.StringProperty(
        name="Sheet in", subtype="DIR_PATH",
        description="Folder of the contact sheet; empty: one that goes when Blender is closed")


def take_own(self, context):
    """An object's own settings begin as those that it had."""
    if self.own:
        for name in SURFACE:
            if not self.is_property_set(name):
                setattr(self, name, getattr(context.scene.planish, name))
    changed(self, context)


def live_toggled(self, context):
    from . import live

    live.toggled(self.id_data)


class PlanishObject(SurfaceSettings, bpy.types.PropertyGroup):
    """What the add-on knows of an object."""

    own: bpy.props.BoolProperty(
        name="Own Settings", update=take_own,
        description="This object has settings of its own, not the scene's")
    live: bpy.props.BoolProperty(
        name="Live", update=live_toggled,
        description="Fits the mesh again whenever it changes, in the background")
    result: bpy.props.PointerProperty(type=bpy.types.Object, description="Its live surface")
    source: bpy.props.PointerProperty(
        type=bpy.types.Object, description="The mesh whose live surface this is")
    tried: bpy.props.PointerProperty(
        type=bpy.types.Object, description="The mesh of which this surface may be kept")
    order: bpy.props.IntProperty(description="Of a tried surface: its place among them")
    title: bpy.props.StringProperty(description="Of a tried surface")
    figures: bpy.props.StringProperty(description="Of a tried surface")
    choice: bpy.props.StringProperty(description="Of a tried surface: its settings, as JSON")
    taken: bpy.props.BoolProperty(description="Of a tried surface: what a fit takes by itself")


def settings_of(scene, thing):
    """Those that hold for an object."""
    return thing.planish if thing is not None and thing.planish.own else scene.planish


def options_of(scene, thing):
    """The command's options by name, as scene files have them."""
    settings = settings_of(scene, thing)
    creases = settings.creases
    if creases == "angle":
        creases = f"auto:{np.degrees(settings.crease_angle):.6g}"
    return {"levels": [settings.level], "scheme": settings.scheme, "interpolation": settings.interpolation,
            "tolerance": float(f"{settings.tolerance:.9g}"), "within": float(f"{settings.within:.9g}"),
            "creases": creases, "quads": settings.quads, "refine": settings.refine}


def flags_of(options):
    words = []
    for name, value in options.items():
        values = value if isinstance(value, list) else [value]
        words += ["--" + name, ",".join(f"{one:.9g}" if isinstance(one, float) else str(one) for one in values)]
    return words


def program_of(scene):
    """The command. Raises RuntimeError where it is not there."""
    named = scene.planish.program
    program = bpy.path.abspath(named) if named else shutil.which("planish")
    if not program or not os.access(program, os.X_OK):
        raise RuntimeError(f"the command planish is not at {named}" if named
                           else "the command planish is not on PATH; name it in the panel")
    return program
