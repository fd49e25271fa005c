"""The panel in the sidebar of the 3-D view."""

import bpy

from .operators import PlanishFit
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
