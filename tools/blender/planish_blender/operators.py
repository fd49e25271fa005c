"""What the panel's buttons do."""

import bpy

from .result import add_result, follow_pose, place_at, select
from .source import sources_of, start_job


class Waiting:
    """An operator that waits for commands: scripts until they are done, an artist works on meanwhile.
    begin() starts, goes_on() is asked again and again, and finish() gives the result in one step, for Undo."""

    bl_options = {"REGISTER", "UNDO"}
    job = None

    def execute(self, context):
        self.begin(context)
        while self.goes_on(context):
            self.job.wait(0.05)
        return self.finish(context)

    def invoke(self, context, event):
        """Works on while Blender is used; Esc stops it."""
        self.begin(context)
        if not self.goes_on(context):
            return self.finish(context)
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
        if self.goes_on(context):
            context.window_manager.progress_update(self.share)
            context.workspace.status_text_set(f"planish: {self.share:.0%}   (Esc stops it)")
            return {"RUNNING_MODAL"}
        self._end(context)
        return self.finish(context)

    def _end(self, context):
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)


class PlanishFit(Waiting, bpy.types.Operator):
    """Makes new objects: the smooth surfaces through all vertices of the selected meshes"""

    bl_idname = "mesh.planish_fit"
    bl_label = "Fit Surface"

    @classmethod
    def poll(cls, context):
        return context.mode in ("OBJECT", "EDIT_MESH") and bool(sources_of(context))

    def begin(self, context):
        self.waiting, self.made = sources_of(context), []
        self.count, self.active = len(self.waiting), context.object

    @property
    def share(self):
        return (self.count - len(self.waiting) - 1 + self.job.share) / self.count

    def goes_on(self, context):
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

    def finish(self, context):
        results = []
        for source, surface, warnings in self.made:
            result = add_result(context, source, surface)
            follow_pose(result, source)
            place_at(result, source)
            results.append((source, result))
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


OPERATORS = (PlanishFit,)
