# SPDX-License-Identifier: GPL-3.0-or-later
"""Which new thing was made of which old one: by Full Copy of a scene, Make Single User, duplicating, appending, Make Local, overriding.

Blender tells it of overrides alone. The others show it by their names, "Egg" and "Egg.001", by the scene that they are in, and by what
they are like."""
import re

import bpy

_NUMBER = re.compile(r"\.\d+$")


def stem(name):
    """Without the number by which Blender tells copies apart."""
    return _NUMBER.sub("", name)


def scenes_of(item):
    """The scenes that an object, a collection, a world or a scene is in."""
    if isinstance(item, bpy.types.Scene):
        return {item}
    if isinstance(item, bpy.types.Object):
        return set(item.users_scene)
    if isinstance(item, bpy.types.World):
        return {scene for scene in bpy.data.scenes if scene.world == item}
    return {scene for scene in bpy.data.scenes if item in scene.collection.children_recursive}


def override_of(item, items):
    """The one that overrides a linked `item`, or None."""
    return next((new for new in items if new.override_library is not None and new.override_library.reference == item), None)


def of(item, arrivals, rivals, scenes):
    """The one of the new things that was made of `item`, best one in these scenes; None if none was. `rivals`: what else there was."""
    override = override_of(item, arrivals)
    if override is not None:
        return override
    found = [new for new in arrivals if _may_be(new, item)]
    if found and not any(_is_like(new, item) for new in found):  # made of an unknown one, as what is appended, but of none of the rivals
        found = [new for new in found if not any(_may_be(new, rival) and _is_like(new, rival) for rival in rivals)]
    for is_better in (lambda new: scenes & scenes_of(new), lambda new: _is_like(new, item)):
        found = list(filter(is_better, found)) or found
    return min(found, key=lambda new: (len(new.name), new.name), default=None)


def _may_be(new, item):
    return new != item and new.library is None and new.override_library is None and type(new) is type(item) and stem(new.name) == stem(item.name)


def _is_like(new, item):
    """Copies lie where the original lies, or hold the like."""
    if isinstance(item, bpy.types.Object):
        return new.type == item.type and new.matrix_basis == item.matrix_basis
    if isinstance(item, bpy.types.Collection):
        return _stems(new.objects) == _stems(item.objects) and _stems(new.children) == _stems(item.children)
    return True


def _stems(items):
    return sorted(stem(item.name) for item in items)
