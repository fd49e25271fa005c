"""Blender add-on: smooth surfaces through all vertices of the selected meshes, by planish.

A zip of this folder is installed under Edit > Preferences > Add-ons; the panel stands in the sidebar
of the 3-D view (N), under planish. The command `planish` does the work: it gets a mesh as OBJ and
gives the surface as GLB, both through pipes. Edges that are marked sharp or fully creased stay sharp, others
with a crease are semi-sharp on Catmull-Clark surfaces; all layers of texture coordinates and colours, vertex
groups, shape keys and materials come along.
"""

import re

import bpy
import numpy as np

from .exchange import add_groups, add_keys, build_mesh, vertex_positions
from .job import Work

bl_info = {
    "name": "planish",
    "author": "The planish authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > planish",
    "description": "Smooth surface through all vertices of a mesh",
    "category": "Mesh",
}


def evaluated_mesh(context, source, take):
    """take(mesh) of an object with its modifiers applied."""
    evaluated = source.evaluated_get(context.evaluated_depsgraph_get())
    try:
        return take(evaluated.to_mesh())
    finally:
        evaluated.to_mesh_clear()


class OneKey:
    """Shows one shape key of an object after another, then the mix of before."""

    def __init__(self, context, source):
        self.context, self.source = context, source

    def __enter__(self):
        self.before = self.source.active_shape_key_index, self.source.show_only_shape_key
        self.source.show_only_shape_key = True
        return self

    def show(self, index):
        self.source.active_shape_key_index = index
        self.context.view_layer.update()

    def __exit__(self, *error):
        self.source.active_shape_key_index, self.source.show_only_shape_key = self.before
        self.context.view_layer.update()


def start_job(context, source):
    """Starts the command on the mesh of an object, modifiers applied; of shape keys the first is the
    mesh, unless the modifiers give the others more or fewer vertices."""
    settings, groups = context.scene.planish, [group.name for group in source.vertex_groups]

    def work(mesh, keys=()):
        if not mesh.polygons:
            raise RuntimeError(f"{source.name} has no faces")
        return Work(settings, mesh, groups, keys)

    blocks = source.data.shape_keys.key_blocks if source.data.shape_keys else ()
    if len(blocks) < 2 or not source.data.shape_keys.use_relative:
        return evaluated_mesh(context, source, work)
    with OneKey(context, source) as one:
        keys = []
        for index in range(1, len(blocks)):
            one.show(index)
            keys.append((blocks[index].name, evaluated_mesh(context, source, vertex_positions)))
        one.show(0)
        count = evaluated_mesh(context, source, lambda mesh: len(mesh.vertices))
        keys = [(name, places) for name, places in keys if len(places) == count]
        return evaluated_mesh(context, source, lambda mesh: work(mesh, keys))


def sources_of(context):
    """The selected meshes; the active one where none is selected."""
    selected = [thing for thing in context.selected_objects if thing.type == "MESH"]
    active = context.object
    return selected or ([active] if active is not None and active.type == "MESH" else [])


def result_name(source):
    """What surfaces of "Cube" are called, and those of its surface "Cube.planish", too."""
    return re.sub(r"\.planish(\.\d+)?$", "", source) + ".planish"


def add_result(context, source, surface):
    """The surface as an object beside its source, with its materials."""
    name = result_name(source.name)
    mesh, firsts = build_mesh(name, surface)
    for slot in source.material_slots:
        mesh.materials.append(slot.material)
    result = bpy.data.objects.new(name, mesh)
    add_groups(result, surface, firsts)
    add_keys(result, surface, firsts, source.data.shape_keys)
    context.view_layer.update()  # where scripts have just moved the source
    result.matrix_world = source.matrix_world
    for collection in source.users_collection or [context.collection]:
        collection.objects.link(result)
    return result


def select(context, results, active):
    """Selects what was made and nothing else; of the active source its surface becomes active."""
    for other in context.selected_objects:
        other.select_set(False)
    for source, result in results:
        result.select_set(True)
        if source == active or context.view_layer.objects.active == active:
            context.view_layer.objects.active = result


class PlanishSettings(bpy.types.PropertyGroup):
    """What the panel shows."""

    level: bpy.props.IntProperty(
        name="Level", min=0, max=6, default=2,
        description="How often each face of the control mesh is split in four")
    scheme: bpy.props.EnumProperty(
        name="Surface", default="doo-sabin",
        items=[("doo-sabin", "Doo-Sabin", "Follows the mesh with the least waves; edges are sharp or smooth"),
               ("catmull-clark", "Catmull-Clark", "Curvature without jumps; creases below 1 are semi-sharp")])
    interpolation: bpy.props.EnumProperty(
        name="Method", default="auto",
        items=[("auto", "Auto", "The better of both by measurement"),
               ("progressive", "Progressive", "Moves the control points of the mesh"),
               ("fair", "Fair", "Builds control points that do not fold uneven meshes")])
    tolerance: bpy.props.FloatProperty(
        name="Tolerance", min=1e-12, max=1, default=1e-6, precision=9,
        description="Largest distance of a vertex from the surface, of the bounding box's diagonal")
    within: bpy.props.FloatProperty(
        name="Within", min=0, max=0.0999, default=0, precision=6,
        description="Leaves vertices by up to this fraction of the diagonal to bend less; 0: exact")
    creases: bpy.props.EnumProperty(
        name="Creases", default="choose",
        items=[("choose", "By Measurement", "Edges stay sharp where the surface is better for it"),
               ("use", "Marked", "Edges that are marked stay sharp, no others"),
               ("auto", "By Angle", "Edges whose faces turn by more than an angle stay sharp, too")])
    crease_angle: bpy.props.FloatProperty(
        name="Angle", subtype="ANGLE", min=0.02, max=3.14, default=np.radians(30),
        description="Edges whose faces turn by more stay sharp")
    quads: bpy.props.EnumProperty(
        name="Quads", default="auto",
        items=[("auto", "Auto", "Joins triangles to quads where the surface is better for it"),
               ("on", "On", "Joins triangles to quads"),
               ("off", "Off", "Leaves triangles as they are")])
    device: bpy.props.EnumProperty(
        name="Device", default="auto",
        items=[("auto", "Auto", "What is fastest for most meshes: the CPU"),
               ("cpu", "CPU", "All cores"), ("vulkan", "Vulkan", "The best Vulkan device")])
    program: bpy.props.StringProperty(
        name="Command", subtype="FILE_PATH", description="Where planish is; empty: on PATH")


class PlanishFit(bpy.types.Operator):
    """Makes new objects: the smooth surfaces through all vertices of the selected meshes"""

    bl_idname = "mesh.planish_fit"
    bl_label = "Fit Surface"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and bool(sources_of(context))

    def execute(self, context):
        """Waits for the command, as scripts want it."""
        self._begin(context)
        while self._goes_on(context):
            self.job.wait(0.05)
        return self._finish(context)

    def invoke(self, context, event):
        """Works on while Blender is used; Esc stops it."""
        self._begin(context)
        if not self._goes_on(context):
            return self._finish(context)
        manager = context.window_manager
        manager.progress_begin(0, 1)
        self.timer = manager.event_timer_add(0.05, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.job.cancel()
            self._end(context)
            self.report({"INFO"}, "planish was stopped")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self._goes_on(context):
            share = (self.count - len(self.waiting) - 1 + self.job.share) / self.count
            context.window_manager.progress_update(share)
            context.workspace.status_text_set(f"planish: {share:.0%}   (Esc stops it)")
            return {"RUNNING_MODAL"}
        self._end(context)
        return self._finish(context)

    def _begin(self, context):
        self.waiting, self.made, self.job = sources_of(context), [], None
        self.count, self.active = len(self.waiting), context.object

    def _goes_on(self, context):
        """Takes in what the job at hand has made, and starts the next. False: all are done."""
        if self.job is not None:
            if self.job.poll():
                return True
            try:
                self.made.append((self.source, self.job.surface(), self.job.errors))
            except RuntimeError as error:
                self._refuse(error)
            self.job = None
        while self.waiting:
            self.source = self.waiting.pop(0)
            try:
                self.job = start_job(context, self.source)
                return True
            except (OSError, RuntimeError) as error:
                self._refuse(error)
        return False

    def _refuse(self, error):
        text, name = str(error), self.source.name
        self.report({"ERROR"}, text if self.count == 1 or text.startswith(name) else f"{name}: {text}")

    def _end(self, context):
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _finish(self, context):
        """Adds all surfaces in one step, for Undo."""
        results = []
        for source, surface, warnings in self.made:
            results.append((source, add_result(context, source, surface)))
            several = f"{source.name}: " if self.count > 1 else ""
            for message in warnings:
                self.report({"WARNING"}, several + message)
            extras = surface.extras
            self.report({"INFO"}, f"{several}{extras.get('method')}: the vertices are off by at most "
                                  f"{extras.get('max_error', 0):.1e} of the diagonal")
        if not results:
            return {"CANCELLED"}
        select(context, results, self.active)
        return {"FINISHED"}


class PlanishPanel(bpy.types.Panel):
    """The settings, and the button."""

    bl_idname = "VIEW3D_PT_planish"
    bl_label = "planish"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "planish"

    def draw(self, context):
        settings, layout = context.scene.planish, self.layout
        layout.use_property_split = True
        for name in ("level", "scheme", "interpolation", "tolerance", "within", "creases"):
            layout.prop(settings, name)
        row = layout.row()
        row.active = settings.creases == "auto"
        row.prop(settings, "crease_angle")
        layout.prop(settings, "quads")
        layout.prop(settings, "device")
        layout.prop(settings, "program")
        layout.operator(PlanishFit.bl_idname)


CLASSES = (PlanishSettings, PlanishFit, PlanishPanel)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.planish = bpy.props.PointerProperty(type=PlanishSettings)


def unregister():
    del bpy.types.Scene.planish
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)


if __name__ == "__main__":
    register()
