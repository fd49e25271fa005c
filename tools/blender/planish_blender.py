"""Blender add-on: the smooth surface through all vertices of the selected mesh, by planish.

Install this file under Edit > Preferences > Add-ons; the panel stands in the sidebar of the 3-D view
(N), under planish. The command `planish` does the work: it gets the mesh as OBJ and gives the surface
as GLB, both through pipes. Edges that are marked sharp or creased stay sharp; texture coordinates and
materials come along.
"""

import json
import os
import queue
import shutil
import signal
import struct
import subprocess
import threading

import bpy
import numpy as np

bl_info = {
    "name": "planish",
    "author": "The planish authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > planish",
    "description": "Smooth surface through all vertices of a mesh",
    "category": "Mesh",
}

INFINITE_SHARPNESS = 10

# -- What goes to the command ---------------------------------------------------------------------


def obj_text(mesh):
    """A Blender mesh as OBJ with OpenSubdiv's tags. Materials are called after their slots."""
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    lines = ["v %.9g %.9g %.9g" % tuple(p) for p in positions.reshape(-1, 3)]
    layer = mesh.uv_layers.active
    if layer:
        uvs = np.empty(2 * len(mesh.loops), np.float32)
        layer.data.foreach_get("uv", uvs)
        # Corners that share a vertex and a coordinate share its number, or seams would be everywhere.
        unique, numbers = np.unique(uvs.reshape(-1, 2), axis=0, return_inverse=True)
        lines += ["vt %.9g %.9g" % tuple(uv) for uv in unique]
        numbers = numbers.ravel()
    slot = None
    for polygon in mesh.polygons:
        if polygon.material_index != slot:
            slot = polygon.material_index
            lines.append(f"usemtl slot{slot}")
        corners = []
        for loop in polygon.loop_indices:
            vertex = mesh.loops[loop].vertex_index + 1
            corners.append(f"{vertex}/{numbers[loop] + 1}" if layer else str(vertex))
        lines.append("f " + " ".join(corners))
    for edge in mesh.edges:
        if edge.use_edge_sharp or edge.crease >= 1:
            v0, v1 = edge.vertices
            lines.append(f"t crease 2/1/0 {v0} {v1} {INFINITE_SHARPNESS}")
    return "\n".join(lines) + "\n"


def command_line(settings):
    """The command that fits a mesh on stdin and gives a GLB on stdout."""
    program = bpy.path.abspath(settings.program) if settings.program else shutil.which("planish")
    if not program or not os.access(program, os.X_OK):
        raise RuntimeError(
            f"the command planish is not at {settings.program}" if settings.program
            else "the command planish is not on PATH; name it in the panel")
    creases = "use"
    if settings.detects_creases:
        creases = f"auto:{np.degrees(settings.crease_angle):.6g}"
    return [program, "fit", "-", "--input-format", "obj", "-o", "-", "--progress", "json",
            "--levels", str(settings.level), "--interpolation", settings.interpolation,
            "--tolerance", f"{settings.tolerance:.9g}", "--creases", creases,
            "--device", settings.device]


# -- What comes back ------------------------------------------------------------------------------

COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def read_glb(data):
    """Positions, normals, texture coordinates or None, triangles and their materials' names."""
    if data[:4] != b"glTF":
        raise RuntimeError("the command gave no GLB")
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + length])
    binary = memoryview(data)[28 + length :]

    def values(index):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        width = WIDTHS[accessor["type"]]
        return np.frombuffer(binary, COMPONENTS[accessor["componentType"]],
                             accessor["count"] * width,
                             view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
                             ).reshape(-1, width)

    parts, first = [], 0
    names = [material.get("name", "") for material in document.get("materials", [])]
    for primitive in document["meshes"][0]["primitives"]:
        attributes = primitive["attributes"]
        positions = values(attributes["POSITION"])
        triangles = values(primitive["indices"]).reshape(-1, 3).astype(np.int64) + first
        uvs = values(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else None
        name = names[primitive["material"]] if "material" in primitive else ""
        parts.append((positions, values(attributes["NORMAL"]), uvs, triangles,
                      [name] * len(triangles)))
        first += len(positions)
    offset = document["nodes"][0].get("translation", (0, 0, 0))
    all_uvs = None
    if all(part[2] is not None for part in parts):
        all_uvs = np.concatenate([part[2] for part in parts]) * (1, -1) + (0, 1)
    return {
        "positions": np.concatenate([part[0] for part in parts]) + np.array(offset),
        "normals": np.concatenate([part[1] for part in parts]),
        "uvs": all_uvs,
        "triangles": np.concatenate([part[3] for part in parts]),
        "materials": sum((part[4] for part in parts), []),
        "extras": document["asset"].get("extras", {}),
    }


def joined_quads(triangles):
    """Quads of the pairs of triangles that the writer cut them into: rows (n, 4), or None."""
    if len(triangles) % 2:
        return None
    first, second = triangles[0::2], triangles[1::2]
    is_shared = (first[:, :, None] == second[:, None, :]).any(axis=2)
    is_new = ~(second[:, :, None] == first[:, None, :]).any(axis=2)
    if not ((is_shared.sum(axis=1) == 2) & (is_new.sum(axis=1) == 1)).all():
        return None
    rows = np.arange(len(first))
    lone = (~is_shared).argmax(axis=1)  # the corner that the second triangle lacks
    corner = [first[rows, (lone + i) % 3] for i in range(3)]
    return np.stack([corner[0], corner[1], second[rows, is_new.argmax(axis=1)], corner[2]], axis=1)


def build_mesh(name, surface):
    """A Blender mesh of what read_glb() returned, with its exact normals."""
    # Vertices on seams and creases come once for each side; in Blender corners hold what differs.
    _, firsts, numbers = np.unique(surface["positions"], axis=0, return_index=True,
                                   return_inverse=True)
    numbers = numbers.ravel()
    faces, step = joined_quads(surface["triangles"]), 2
    if faces is None:
        faces, step = surface["triangles"], 1
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(surface["positions"][firsts].tolist(), [], numbers[faces].tolist())
    corners = faces.ravel()
    slots = [int(text[4:]) if text.startswith("slot") else 0
             for text in surface["materials"][::step]]
    mesh.polygons.foreach_set("material_index", slots)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    if surface["uvs"] is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", surface["uvs"][corners].astype(np.float32).ravel())
    mesh.update()
    mesh.use_auto_smooth = True  # or Blender leaves custom normals out
    mesh.normals_split_custom_set(surface["normals"][corners].tolist())
    return mesh


# -- The process ----------------------------------------------------------------------------------

class Job:
    """The command at work on a mesh. Threads feed and empty its pipes, so that none can fill up."""

    def __init__(self, arguments, text):
        self.process = subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE)
        self.output, self.errors = b"", []
        self.lines = queue.SimpleQueue()
        self.share = 0.0
        self.threads = [threading.Thread(target=work, daemon=True)
                        for work in (lambda: self._feed(text.encode()), self._read, self._listen)]
        for thread in self.threads:
            thread.start()

    def _feed(self, data):
        try:
            self.process.stdin.write(data)
            self.process.stdin.close()
        except BrokenPipeError:
            pass  # it ended before; its own message says why

    def _read(self):
        self.output = self.process.stdout.read()

    def _listen(self):
        for line in self.process.stderr:
            self.lines.put(line)

    def poll(self):
        """Takes messages in. True while the command works."""
        while not self.lines.empty():
            line = self.lines.get()
            try:
                message = json.loads(line)
            except ValueError:
                message = {"level": "error", "message": line.decode(errors="replace").strip()}
            self.share = message.get("share", self.share)
            if message.get("level") in ("error", "warning") and message.get("message"):
                self.errors.append(message["message"])
        if any(thread.is_alive() for thread in self.threads):
            return True
        return self.process.poll() is None or not self.lines.empty()

    def cancel(self):
        """Stops the command; it leaves nothing behind."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.wait()

    def surface(self):
        """What the command made. Raises RuntimeError with its message."""
        status = self.process.wait()
        if status not in (0, 5):  # 5: not converged, and written all the same
            raise RuntimeError("; ".join(self.errors) or f"planish ended with exit code {status}")
        return read_glb(self.output)


def start_job(context, source):
    """Starts the command on the mesh of an object, modifiers applied."""
    evaluated = source.evaluated_get(context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        if not mesh.polygons:
            raise RuntimeError(f"{source.name} has no faces")
        return Job(command_line(context.scene.planish), obj_text(mesh))
    finally:
        evaluated.to_mesh_clear()


def add_result(context, source, surface):
    """The surface as an object beside its source, with its materials."""
    name = f"{source.name}.planish"
    mesh = build_mesh(name, surface)
    for slot in source.material_slots:
        mesh.materials.append(slot.material)
    result = bpy.data.objects.new(name, mesh)
    context.view_layer.update()  # where scripts have just moved the source
    result.matrix_world = source.matrix_world
    for collection in source.users_collection or [context.collection]:
        collection.objects.link(result)
    for other in context.selected_objects:
        other.select_set(False)
    result.select_set(True)
    context.view_layer.objects.active = result
    return result


class PlanishSettings(bpy.types.PropertyGroup):
    """What the panel shows."""

    level: bpy.props.IntProperty(
        name="Level", min=0, max=6, default=2,
        description="How often each face of the control mesh is split in four")
    interpolation: bpy.props.EnumProperty(
        name="Method", default="auto",
        items=[("auto", "Auto", "The better of both by measurement"),
               ("progressive", "Progressive", "Moves the control points of the mesh"),
               ("fair", "Fair", "Builds control points that do not fold uneven meshes")])
    tolerance: bpy.props.FloatProperty(
        name="Tolerance", min=1e-12, max=1, default=1e-6, precision=9,
        description="Largest distance of a vertex from the surface, of the bounding box's diagonal")
    detects_creases: bpy.props.BoolProperty(
        name="Find Creases", description="Keeps edges sharp whose faces turn by more than an angle")
    crease_angle: bpy.props.FloatProperty(
        name="Angle", subtype="ANGLE", min=0.02, max=3.14, default=np.radians(30),
        description="Edges whose faces turn by more stay sharp")
    device: bpy.props.EnumProperty(
        name="Device", default="auto",
        items=[("auto", "Auto", "A hardware Vulkan device where there is one, else the CPU"),
               ("cpu", "CPU", "All cores"), ("vulkan", "Vulkan", "Any Vulkan device")])
    program: bpy.props.StringProperty(
        name="Command", subtype="FILE_PATH", description="Where planish is; empty: on PATH")


class PlanishFit(bpy.types.Operator):
    """Makes a new object: the smooth surface through all vertices of the active mesh"""

    bl_idname = "mesh.planish_fit"
    bl_label = "Fit Surface"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH" and (
            context.mode == "OBJECT")

    def execute(self, context):
        """Waits for the command, as scripts want it."""
        if not self._start(context):
            return {"CANCELLED"}
        while self.job.poll():
            self.job.threads[1].join(0.05)
        return self._finish(context)

    def invoke(self, context, event):
        """Works on while Blender is used; Esc stops it."""
        if not self._start(context):
            return {"CANCELLED"}
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
        if self.job.poll():
            context.window_manager.progress_update(self.job.share)
            context.workspace.status_text_set(f"planish: {self.job.share:.0%}   (Esc stops it)")
            return {"RUNNING_MODAL"}
        self._end(context)
        return self._finish(context)

    def _start(self, context):
        self.source = context.object
        try:
            self.job = start_job(context, self.source)
        except (OSError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return False
        return True

    def _end(self, context):
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _finish(self, context):
        try:
            surface = self.job.surface()
        except RuntimeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        add_result(context, self.source, surface)
        for message in self.job.errors:
            self.report({"WARNING"}, message)
        extras = surface["extras"]
        self.report({"INFO"}, f"{extras.get('method')}: the vertices are off by at most "
                              f"{extras.get('max_error', 0):.1e} of the diagonal")
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
        for name in ("level", "interpolation", "tolerance", "detects_creases"):
            layout.prop(settings, name)
        row = layout.row()
        row.active = settings.detects_creases
        row.prop(settings, "crease_angle")
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
