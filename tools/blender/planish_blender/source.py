"""What is fitted of an object: its mesh at rest, with what rides on it and its shape keys."""

import hashlib

import numpy as np

from .exchange import Given, Riders, vertex_positions
from .job import Work
from .settings import options_of, program_of


def armatures_of(thing):
    """The modifiers by which an object follows a pose."""
    return [modifier for modifier in thing.modifiers if modifier.type == "ARMATURE"]


class AtRest:
    """An object without its pose: armatures move the surface afterwards, as they move the mesh."""

    def __init__(self, context, source):
        self.context, self.source = context, source

    def __enter__(self):
        shown = [modifier for modifier in armatures_of(self.source) if modifier.show_viewport]
        self.shown = [modifier.name for modifier in shown]
        # A parent of this type is a modifier that no list has.
        self.is_bound = self.source.parent_type == "ARMATURE"
        for modifier in shown:
            modifier.show_viewport = False
        if self.is_bound:
            self.source.parent_type = "OBJECT"
        self._update()
        return self

    def __exit__(self, *error):
        for name in self.shown:
            self.source.modifiers[name].show_viewport = True
        if self.is_bound:
            self.source.parent_type = "ARMATURE"
        self._update()

    def _update(self):
        if self.is_bound:
            self.source.update_tag(refresh={"DATA"})
        if self.is_bound or self.shown:
            self.context.view_layer.update()


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


def evaluated_mesh(context, source, take):
    """take(mesh) of an object with its modifiers applied; in edit mode as it is at the moment."""
    evaluated = source.evaluated_get(context.evaluated_depsgraph_get())
    try:
        return take(evaluated.to_mesh())
    finally:
        evaluated.to_mesh_clear()


class Taken:
    """A mesh with all that comes along, and the texts of it for the command: files of its riders, then one of
    each shape key."""

    def __init__(self, source, mesh, keys):
        """keys: (name, positions of the mesh's vertices)."""
        if not mesh.polygons:
            raise RuntimeError(f"{source.name} has no faces")
        self.riders = Riders(mesh, [group.name for group in source.vertex_groups])
        self.given, self.positions = Given(mesh), vertex_positions(mesh)
        self.key_names = [name for name, _ in keys]
        self.keys = [places for _, places in keys]
        self.count = self.riders.file_count + len(keys)

    def text(self, number):
        if number < self.riders.file_count:
            return self.given.obj_text(self.positions, *self.riders.of_file(number))
        return self.given.obj_text(self.keys[number - self.riders.file_count])

    def digest(self):
        """Tells whether another one would give the same texts."""
        parts = [self.positions, *self.keys, *(values for _, values in self.riders.uvs), *self.riders.triples]
        digest = hashlib.blake2b(self.given.bytes())
        for part in parts:
            digest.update(np.ascontiguousarray(part))
        return digest.digest()


def take_source(context, source, with_keys=True):
    """The Taken of an object; of shape keys the first is the mesh, unless the modifiers give the others more
    or fewer vertices. Without keys it is what the object shows, as in edit mode, where keys are edited."""
    with AtRest(context, source):
        keys = source.data.shape_keys
        if not with_keys or source.mode != "OBJECT" or keys is None or len(keys.key_blocks) < 2 or not keys.use_relative:
            return evaluated_mesh(context, source, lambda mesh: Taken(source, mesh, []))
        with OneKey(context, source) as one:
            places = []
            for index, block in enumerate(keys.key_blocks):
                one.show(index)
                places.append((block.name, evaluated_mesh(context, source, vertex_positions)))
            one.show(0)
            same = [(name, at) for name, at in places[1:] if len(at) == len(places[0][1])]
            return evaluated_mesh(context, source, lambda mesh: Taken(source, mesh, same))


def start_job(context, source, taken=None, **options):
    """Starts the command on an object. `options`: in place of the object's own."""
    return Work(program_of(context.scene), context.scene.planish.device,
                {**options_of(context.scene, source), **options}, taken or take_source(context, source))


def sources_of(context):
    """The selected meshes, in edit mode those that are edited; the active one where none is selected."""
    things = context.objects_in_mode if context.mode == "EDIT_MESH" else context.selected_objects
    selected = [thing for thing in things if thing.type == "MESH"]
    active = context.object
    return selected or ([active] if active is not None and active.type == "MESH" else [])
