# SPDX-License-Identifier: GPL-3.0-or-later
"""Which new thing was made of which old one: by Full Copy of a scene, Make Single User, duplicating, appending, Make Local, overriding.

Blender tells it of overrides alone. Other copies are known by their names ("Egg" and "Egg.001"), by the scenes that they are in, and by
what they look like."""
from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

import bpy

_NUMBER = re.compile(r"\.\d+$")


def stem(name: str) -> str:
    """A name without the number by which Blender tells copies apart."""
    return _NUMBER.sub("", name)


def scenes_of(item: bpy.types.ID) -> set[bpy.types.Scene]:
    """The scenes that an object, a collection, a world or a scene is in."""
    if isinstance(item, bpy.types.Scene):
        return {item}
    if isinstance(item, bpy.types.Object):
        return {scene for scene in bpy.data.scenes if _is_in(scene, item)}
    if isinstance(item, bpy.types.World):
        return {scene for scene in bpy.data.scenes if scene.world == item}
    return {scene for scene in bpy.data.scenes if item in scene.collection.children_recursive}


def _is_in(scene: bpy.types.Scene, item: bpy.types.Object) -> bool:
    """Does the scene hold the object? Several times quicker than Object.users_scene, which copies the list of all objects."""
    found = scene.objects.get(item.name)
    return found == item or found is not None and item in scene.objects[:]  # A linked object may have the name of a local one.


class Look(NamedTuple):
    """What a thing looks like, by which its copies are known: their kind and their stem are the same. Of several such things the one of
    the same likeness is taken: objects that lie where the original lies, collections that hold things of the same names."""

    kind: str
    stem: str
    likeness: tuple[object, ...]


def look(item: bpy.types.ID) -> Look:
    """What a thing looks like. It is remembered, since a thing that is made local may be gone when its copy is there."""
    likeness: tuple[object, ...] = ()
    if isinstance(item, bpy.types.Object):
        likeness = item.type, *(number for row in item.matrix_basis for number in row)
    elif isinstance(item, bpy.types.Collection):
        likeness = tuple(sorted(stem(other.name) for kind in (item.objects, item.children) for other in kind))
    return Look(item.bl_rna.identifier, stem(item.name), likeness)


def override_of(item: bpy.types.ID, items: Iterable[bpy.types.ID]) -> bpy.types.ID | None:
    """The one of the items that overrides a linked `item`, or None."""
    return next((new for new in items if new.override_library is not None and new.override_library.reference == item), None)


def of(wanted: Look, arrivals: set[bpy.types.ID], rivals: Iterable[bpy.types.ID], scenes: set[bpy.types.Scene]) -> bpy.types.ID | None:
    """The one of the new things (arrivals) that was made of what looked like `wanted`; None if none was. One in these scenes is preferred.
    `rivals` are all things that are not new."""
    looks = {new: look(new) for new in arrivals if stem(new.name) == wanted.stem and new.library is None}
    found = [new for new, seen in looks.items() if seen.kind == wanted.kind]
    # What is appended is made of something that was never in this file. So any of them will do that is like none of the rivals.
    if found and wanted not in looks.values():
        others = [look(rival) for rival in rivals if stem(rival.name) == wanted.stem]
        found = [new for new in found if looks[new] not in others]
    for is_better in (lambda new: scenes & scenes_of(new), lambda new: looks[new] == wanted):
        found = list(filter(is_better, found)) or found
    return min(found, key=lambda new: (len(new.name), new.name), default=None)
