"""The panel in the sidebar of the 3-D view."""

import bpy

from . import live
from .operators import (PlanishDropTried, PlanishFit, PlanishKeep, PlanishSheet, PlanishShow, PlanishTry,
                        tried_of)
from .settings import settings_of


class PlanishPanel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_planish"
    bl_label = "planish"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "planish"

    def draw(self, context):
        layout, scene = self.layout, context.scene
        layout.use_property_split = True
        layout.use_property_decorate = False
        active = context.object if context.object is not None and context.object.type == "MESH" else None
        if active is not None:
            self._wide(layout, active.planish, "own", text=f"Own Settings of {active.name}")
        self._settings(layout, settings_of(scene, active))
        layout.prop(scene.planish, "device")
        layout.prop(scene.planish, "program")
        layout.operator(PlanishFit.bl_idname)
        if active is not None:
            self._wide(layout, active.planish, "live", toggle=True)
            message = live.messages.get(active.name)
            if message:
                layout.label(text=message, icon="ERROR")
            layout.operator(PlanishTry.bl_idname)
            self._tried(layout, active)
        layout.operator(PlanishSheet.bl_idname)
        layout.prop(scene.planish, "sheet")
        for row in context.window_manager.planish_sheet:
            box = layout.box().column(align=True)
            box.operator(PlanishShow.bl_idname, text=row.name).name = row.name
            box.label(text=row.figures)

    def _wide(self, layout, *known, **more):
        row = layout.row()
        row.use_property_split = False
        row.prop(*known, **more)

    def _settings(self, layout, settings):
        layout.prop(settings, "level")
        layout.prop(settings, "scheme")
        row = layout.row()
        row.active = settings.scheme == "doo-sabin"
        row.prop(settings, "interpolation")
        layout.prop(settings, "tolerance")
        layout.prop(settings, "within")
        layout.prop(settings, "creases")
        row = layout.row()
        row.active = settings.creases == "angle"
        row.prop(settings, "crease_angle")
        layout.prop(settings, "quads")
        layout.prop(settings, "refine")

    def _tried(self, layout, active):
        """What may be kept, as the command has it: what it takes first, then by cost."""
        tried = sorted(tried_of(active), key=lambda thing: thing.planish.order)
        for thing in tried:
            box = layout.box().column(align=True)
            box.label(text=thing.planish.title, icon="CHECKMARK" if thing.planish.taken else "BLANK1")
            box.label(text=thing.planish.figures, icon="BLANK1")
            box.operator(PlanishKeep.bl_idname).name = thing.name
        if tried:
            layout.operator(PlanishDropTried.bl_idname)
