"""What the panel's buttons do."""

import json
import os
import pathlib
import re
import shutil
import tempfile

import bpy
from mathutils import Matrix, Vector

from .job import Job
from .result import add_result, follow_pose, place_at, remove_object, result_name, select
from .settings import CHOICES, flags_of, options_of, program_of, settings_of
from .source import sources_of, start_job, take_source


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
            self.clean()
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

    def clean(self):
        """Removes files between."""


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


def mesh_in(folder, name, taken):
    """A mesh as a file for the command; its path."""
    path = os.path.join(folder, name + ".obj")
    pathlib.Path(path).write_text(taken.text(0), encoding="utf-8")
    return path


def is_open(settings):
    """Whether settings leave something to the command's choice."""
    initial = [settings.bl_rna.properties[name].default for name in CHOICES]
    return settings.scheme == "doo-sabin" and any(
        getattr(settings, name) == value for name, value in zip(CHOICES, initial))


def source_of(thing):
    """The mesh of a surface that was tried; an object itself."""
    return thing.planish.tried or thing


def tried_of(thing):
    """The surfaces of an object of which one may be kept."""
    return [other for other in bpy.data.objects if other.planish.tried == source_of(thing)]


def figures_of(tried):
    """What a surface that was tried is weighed by, in a line."""
    words = [] if tried["cost"] is None else [f"cost {tried['cost']:.2f}"]
    if tried["folded"]:
        words.append(f"folded {tried['folded']:.1%}")
    if tried["normals"] is not None:
        words.append(f"normals {tried['normals']:.1f}°")
    return ", ".join(words)


class PlanishTry(Waiting, bpy.types.Operator):
    """Makes each surface that a fit of the active mesh chooses from, side by side, to keep one"""

    bl_idname = "mesh.planish_try"
    bl_label = "Try"

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT" or context.object is None or context.object.type != "MESH":
            return False
        if is_open(settings_of(context.scene, source_of(context.object))):
            return True
        cls.poll_message_set("Nothing is left to try: leave method, creases, quads or refine of a Doo-Sabin "
                             "surface to the choice")
        return False

    def begin(self, context):
        """Asks the command what there is."""
        self.source, self.made = source_of(context.object), []
        self.waiting, self.tried, self.failure = None, [], None
        self.folder = tempfile.mkdtemp(prefix="planish")
        try:
            program = program_of(context.scene)
            self.taken = take_source(context, self.source)
            path = mesh_in(self.folder, "tried", self.taken)
            options = options_of(context.scene, self.source)
            self.job = Job([program, "try", path, "--report", "-", "--progress", "json",
                            "--device", context.scene.planish.device, *flags_of(options)], take=json.loads)
        except (OSError, RuntimeError) as error:
            self.failure = error

    @property
    def share(self):
        if self.waiting is None:
            return self.job.share / 2
        count = len(self.tried)
        return 0.5 + (count - len(self.waiting) - 1 + self.job.share) / (2 * count)

    def goes_on(self, context):
        if self.failure is not None:
            return False
        if self.job.poll():
            return True
        try:
            if self.waiting is None:
                self.tried = [one for one in self.job.result()["surfaces"] if "error" not in one]
                self.waiting = list(self.tried)
            else:
                self.made.append(self.job.surface())
            if not self.waiting:
                return False
            self.job = start_job(context, self.source, self.taken, **self.waiting.pop(0)["settings"])
            return True
        except (OSError, RuntimeError) as error:
            self.failure = error
            return False

    def clean(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def finish(self, context):
        self.clean()
        if self.failure is not None:
            self.report({"ERROR"}, str(self.failure))
            return {"CANCELLED"}
        for other in tried_of(self.source):
            remove_object(other)
        width = 1.2 * max((self.source.matrix_world @ Vector(corner)).x for corner in self.source.bound_box)
        width -= 1.2 * min((self.source.matrix_world @ Vector(corner)).x for corner in self.source.bound_box)
        for number, (tried, surface) in enumerate(zip(self.tried, self.made)):
            name = tried["title"] + (", taken" if tried["taken"] else "")
            result = add_result(context, self.source, surface, name)
            result.matrix_world = Matrix.Translation(((number + 1) * width, 0, 0)) @ self.source.matrix_world
            result.show_name = True
            known = result.planish
            known.tried, known.order = self.source, number
            known.taken, known.title = tried["taken"], tried["title"]
            known.figures, known.choice = figures_of(tried), json.dumps(tried["settings"])
        self.report({"INFO"}, f"{len(self.made)} surfaces of {self.source.name}; keep one in the panel")
        return {"FINISHED"}


class PlanishKeep(bpy.types.Operator):
    """Keeps this surface in the mesh's place, with its settings as the mesh's own; removes the others"""

    bl_idname = "mesh.planish_keep"
    bl_label = "Keep"
    bl_options = {"REGISTER", "UNDO"}

    name: bpy.props.StringProperty(name="Surface", description="Its object; empty: the active one")

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and context.object is not None and bool(tried_of(context.object))

    def execute(self, context):
        kept = bpy.data.objects.get(self.name) if self.name else context.object
        source = kept.planish.tried if kept is not None else None
        if source is None:
            self.report({"ERROR"}, "this is no surface that was tried")
            return {"CANCELLED"}
        for other in tried_of(source):
            if other != kept:
                remove_object(other)
        choice = json.loads(kept.planish.choice)
        if choice:  # else parts have what no settings name
            source.planish.own = True
        for name, value in choice.items():
            setattr(source.planish, name, value)
        kept.planish.tried = None
        kept.show_name = False
        kept.name = kept.data.name = result_name(source.name)
        follow_pose(kept, source)
        place_at(kept, source)
        select(context, [(source, kept)], source)
        return {"FINISHED"}


class PlanishDropTried(bpy.types.Operator):
    """Removes all surfaces that were tried"""

    bl_idname = "mesh.planish_drop_tried"
    bl_label = "Keep None"
    bl_options = {"REGISTER", "UNDO"}

    poll = PlanishKeep.poll

    def execute(self, context):
        source = source_of(context.object)
        for other in tried_of(source):
            remove_object(other)
        context.view_layer.objects.active = source
        return {"FINISHED"}


class PlanishSheetRow(bpy.types.PropertyGroup):
    """A line of the contact sheet."""

    figures: bpy.props.StringProperty()


def unique_names(sources):
    """A file name for each object, none twice on any system."""
    names = {}
    for source in sources:
        plain = re.sub(r"[^\w.-]", "_", source.name)
        name, number = plain, 1
        while name.lower() in (taken.lower() for taken in names):
            number += 1
            name = f"{plain}_{number}"
        names[name] = source
    return names


def sheet_figures(job):
    """What a job of a batch report comes to, in a line."""
    if "error" in job:
        return "failed: " + job["error"]
    surface = job["surface"]
    words = [job["solve"]["method"]]
    if surface["folded_area"]:
        words.append(f"folded {surface['folded_area']:.1%}")
    if job["warnings"]:
        words.append(f"{len(job['warnings'])} warnings")
    words.append(f"normals {surface['rms_normal_deviation']:.1f}°")
    return ", ".join(words)


class PlanishSheet(Waiting, bpy.types.Operator):
    """Makes a page with a picture and figures of each selected mesh and its surface, the worst first"""

    bl_idname = "mesh.planish_sheet"
    bl_label = "Contact Sheet"
    bl_options = {"REGISTER"}

    poll = PlanishFit.poll

    def begin(self, context):
        self.names, self.refused, self.failure = unique_names(sources_of(context)), [], None
        named = bpy.path.abspath(context.scene.planish.sheet)
        self.pages = named or os.path.join(bpy.app.tempdir, "planish_sheet")
        self.folder = tempfile.mkdtemp(prefix="planish")
        jobs = []
        try:
            program = program_of(context.scene)
            for name, source in self.names.items():
                try:
                    path = mesh_in(self.folder, name, take_source(context, source, with_keys=False))
                except RuntimeError as error:
                    self.refused.append((source.name, str(error).removeprefix(source.name + " ")))
                    continue
                jobs.append({"name": name, "input": path, **options_of(context.scene, source)})
            scene = os.path.join(self.folder, "scene.json")
            pathlib.Path(scene).write_text(json.dumps({"version": 1, "jobs": jobs}), encoding="utf-8")
            self.job = Job([program, "run", scene, "--page", os.path.join(self.pages, ""), "--report", "-",
                            "--force", "--progress", "json", "--device", context.scene.planish.device],
                           take=json.loads, good=(0, 5, 8))
        except (OSError, RuntimeError) as error:
            self.failure = error

    @property
    def share(self):
        return self.job.share

    def goes_on(self, context):
        return self.failure is None and self.job.poll()

    def clean(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def finish(self, context):
        self.clean()
        try:
            if self.failure is not None:
                raise self.failure
            report = self.job.result()
        except (OSError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        rows = context.window_manager.planish_sheet
        rows.clear()
        jobs = {job["job"]: sheet_figures(job) for job in report["jobs"]}
        for name, figures in [*self.refused, *((self.names[job].name, jobs[job]) for job in report["worst_first"])]:
            row = rows.add()
            row.name, row.figures = name, figures
        page = pathlib.Path(self.pages, "index.html")
        self.report({"INFO"}, f"the worst is {rows[0].name}: {rows[0].figures}; all are in {page}")
        if not bpy.app.background:
            bpy.ops.wm.url_open(url=page.as_uri())
        return {"FINISHED"}


class PlanishShow(bpy.types.Operator):
    """Makes this object the active one"""

    bl_idname = "object.planish_show"
    bl_label = "Show"
    bl_options = {"REGISTER", "UNDO"}

    name: bpy.props.StringProperty(name="Object")

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        thing = context.view_layer.objects.get(self.name)
        if thing is None:
            self.report({"ERROR"}, f"{self.name} is not there any more")
            return {"CANCELLED"}
        for other in context.selected_objects:
            other.select_set(False)
        thing.select_set(True)
        context.view_layer.objects.active = thing
        return {"FINISHED"}


OPERATORS = (PlanishFit, PlanishTry, PlanishKeep, PlanishDropTried, PlanishSheet, PlanishShow)
