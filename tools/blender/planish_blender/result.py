"""Surfaces as objects: beside their source, with its materials, groups and shape keys."""

import re

import bpy
import numpy as np

from .exchange import fill_mesh


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
    """Shape keys with the values and limits of those that they come from."""
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
        key.value, key.mute = given.value, given.mute


def place_at(thing, source):
    """Where the source is."""
    thing.matrix_world = source.matrix_world


def fill_result(thing, source, surface):
    """Makes an object the surface, which had another one or none; its materials and modifiers stay."""
    mesh = thing.data
    if mesh.shape_keys is not None:
        thing.shape_key_clear()
    mesh.clear_geometry()
    fill_mesh(mesh, surface)
    for slot in source.material_slots[len(mesh.materials):]:
        mesh.materials.append(slot.material)
    set_groups(thing, source, surface)
    add_keys(thing, surface, source.data.shape_keys)


def add_result(context, source, surface, name=None):
    """The surface as a new object in the source's collections."""
    name = name or result_name(source.name)
    result = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    fill_result(result, source, surface)
    context.view_layer.update()  # where scripts have just moved the source
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
