# SPDX-License-Identifier: GPL-3.0-or-later
"""What the updates that a depsgraph lists mean to a picture that is being rendered of it. Needs no bpy."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import bpy

NOTHING, EDITS, THINGS = range(3)  # What may have changed: nothing that is seen; edits or settings at most; anything.
# Updates of these change no picture: a view has a camera of its own, and what an action moves is listed itself.
_UNSEEN = {"Action", "Brush", "Screen", "Text", "WindowManager", "WorkSpace", "Palette", "Sound", "Camera"}


def of(depsgraph: bpy.types.Depsgraph) -> int:
    """The largest of the three kinds of change above that the updates may be. An update of the scene may be a mere selection, but also that
    something was hidden or shown: roll() tells."""
    updates = list(depsgraph.updates)
    # From Blender 5.2 on, a change of a scene's property lists all objects of the scene as well, with changed shading. They are passed over:
    # what really changes the look of an object is a datablock of its own in the list.
    of_scene = any(update.id.bl_rna.identifier == "Scene" and update.is_updated_shading for update in updates)
    return max((EDITS if of_scene and _is_shading_alone(update) else _kind(update.id) for update in updates), default=NOTHING)


def _is_shading_alone(update: bpy.types.DepsgraphUpdate) -> bool:
    return update.id.bl_rna.identifier == "Object" and not (update.is_updated_geometry or update.is_updated_transform)


def _kind(datablock: Any) -> int:
    name = datablock.bl_rna.identifier
    if name in _UNSEEN or name == "Object" and datablock.type == 'CAMERA':
        return NOTHING
    if name == "Scene" or name == "Object" and datablock.type == 'EMPTY' and datablock.instance_type == 'NONE':
        return EDITS  # Children of an Empty are listed themselves.
    return THINGS


def roll(depsgraph: bpy.types.Depsgraph) -> tuple[list[str], str | None]:
    """What is in the picture. Two rolls are equal unless something was hidden, shown, added or exchanged in between."""
    world = depsgraph.scene_eval.world
    there = [instance.object.name_full for instance in depsgraph.object_instances
             if instance.object.type != 'EMPTY' and (instance.show_self or instance.is_instance)]
    return there, world.name_full if world else None


def same(a: object, b: object) -> bool:
    """Are two descriptions equal, with the arrays in them?"""
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)):
        return isinstance(b, (list, tuple)) and len(a) == len(b) and all(map(same, a, b))
    return np.array_equal(a, b) if hasattr(a, "shape") else a == b
