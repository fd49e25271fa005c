"""Blender add-on: smooth surfaces through all vertices of meshes, by planish.

A zip of this folder is installed under Edit > Preferences > Add-ons; the panel stands in the sidebar
of the 3-D view (N), under planish. The command `planish` does the work: it gets a mesh as OBJ and
gives the surface as GLB, both through pipes.

settings.py has what the panel sets, source.py takes meshes, exchange.py makes them texts and surfaces of
bytes, job.py runs the command, result.py makes objects; operators.py, live.py and panel.py are what an
artist sees.
"""

import bpy

from . import live
from .operators import OPERATORS, PlanishSheetRow
from .panel import PlanishPanel
from .settings import PlanishObject, PlanishScene
from .source import start_job

bl_info = {
    "name": "planish",
    "author": "The planish authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > planish",
    "description": "Smooth surface through all vertices of a mesh",
    "category": "Mesh",
}

CLASSES = (PlanishScene, PlanishObject, PlanishSheetRow, *OPERATORS, PlanishPanel)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.planish = bpy.props.PointerProperty(type=PlanishScene)
    bpy.types.Object.planish = bpy.props.PointerProperty(type=PlanishObject)
    bpy.types.WindowManager.planish_sheet = bpy.props.CollectionProperty(type=PlanishSheetRow)
    live.register()


def unregister():
    live.unregister()
    del bpy.types.WindowManager.planish_sheet
    del bpy.types.Object.planish
    del bpy.types.Scene.planish
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)


if __name__ == "__main__":
    register()
