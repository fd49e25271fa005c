"""Surfaces as objects: beside their source, with its materials, groups, shape keys, pose and parent."""

import re

import bpy
import numpy as np

from .exchange import fill_mesh
from .source import armatures_of


def result_name(source):
    """What surfaces of "Cube" are called, and those of its surface "Cube.planish", too."""
    return re.sub(r"\.planish(\.\d+)?$", "", source) + ".planish"


def set_groups(thing, source, surface):
    """The source's vertex groups, in its order."""
    thing.vertex_groups.clear()
    for group in source.vertex_groups:
        thing.vertex_groups.new(name=group.name)
    for name, weights in surface.groups:
        group, weights = thing.vertex_groups[name], weights[surface.firsts]
        # Blender adds lists of vertices by one weight each.
        order = np.argsort(weights, kind="stable")
        order = order[weights[order] > 1e-6]
        values, starts = np.unique(weights[order], return_index=True)
        for value, vertices in zip(values.tolist(), np.split(order, starts[1:])):
            group.add(vertices.tolist(), min(value, 1.0), "REPLACE")


def add_keys(thing, surface, source_keys):
    """Shape keys with the values and limits of those that they come from, and what moves these."""
    if not surface.keys:
        return
    thing.shape_key_add(name=source_keys.reference_key.name, from_mix=False)
    for name, places in surface.keys:
        key = thing.shape_key_add(name=name, from_mix=False)
        key.data.foreach_set("co", places[surface.firsts].astype(np.float32).ravel())
    blocks = thing.data.shape_keys.key_blocks
    for name, _ in surface.keys:
        key, given = blocks[name], source_keys.key_blocks[name]
        key.slider_min, key.slider_max = given.slider_min, given.slider_max
        key.value, key.mute, key.vertex_group = given.value, given.mute, given.vertex_group
        if given.relative_key.name in blocks:
            key.relative_key = blocks[given.relative_key.name]
    moved_by = source_keys.animation_data
    if moved_by is not None:
        animation = thing.data.shape_keys.animation_data_create()
        animation.action = moved_by.action  # its curves name keys, which are called the same
        for driver in moved_by.drivers:
            animation.drivers.from_existing(src_driver=driver)


def follow_pose(thing, source):
    """Gives a surface the armatures of its source."""
    if source.parent_type == "ARMATURE":
        thing.modifiers.new("Armature", "ARMATURE").object = source.parent
    for given in armatures_of(source):
        modifier = thing.modifiers.new(given.name, "ARMATURE")
        for name, known in given.bl_rna.properties.items():
            if not known.is_readonly and name not in ("name", "type"):
                setattr(modifier, name, getattr(given, name))


def place_at(thing, source):
    """Where the source is, with its parent."""
    if source.parent is not None:
        is_bound = source.parent_type == "ARMATURE"  # which is a modifier at the surface
        thing.parent, thing.parent_type = source.parent, "OBJECT" if is_bound else source.parent_type
        thing.parent_bone = source.parent_bone
        if source.parent_type.startswith("VERTEX"):
            thing.parent_vertices = source.parent_vertices
        thing.matrix_parent_inverse = source.matrix_parent_inverse
    thing.matrix_world = source.matrix_world


def fill_result(thing, source, surface, has_normals=True):
    """Makes an object the surface, which had another one or none; its materials and modifiers stay."""
    mesh = thing.data
    if mesh.shape_keys is not None:
        thing.shape_key_clear()
    mesh.clear_geometry()
    fill_mesh(mesh, surface, has_normals)
    for slot in source.material_slots[len(mesh.materials):]:
        mesh.materials.append(slot.material)
    set_groups(thing, source, surface)
    add_keys(thing, surface, source.data.shape_keys)


def add_result(context, source, surface, name=None, has_normals=True):
    """The surface as a new object in the source's collections."""
    name = name or result_name(source.name)
    result = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    fill_result(result, source, surface, has_normals)
    context.view_layer.update()  # where scripts have just moved the source
    for collection in source.users_collection or [context.collection]:
        collection.objects.link(result)
    return result


def remove_object(thing):
    """An object and the mesh that was its alone."""
    mesh = thing.data
    bpy.data.objects.remove(thing)
    if mesh is not None and mesh.users == 0:
        bpy.data.meshes.remove(mesh)


def select(context, results, active):
    """Selects what was made and nothing else; of the active source its surface becomes active. In edit mode
    the meshes that are edited stay selected."""
    if context.mode != "OBJECT":
        return
    for other in context.selected_objects:
        other.select_set(False)
    for source, result in results:
        result.select_set(True)
        if source == active or context.view_layer.objects.active == active:
            context.view_layer.objects.active = result
