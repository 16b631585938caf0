# SPDX-License-Identifier: GPL-3.0-or-later
"""Which names expressions can use: those that something in the scene answers to. Panels ask at each redraw, so they are kept until
something happens that may change them."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import bpy

from . import compat, registration
from .export.scene_names import Homes, Names


class Known(NamedTuple):
    """What names mean."""

    homes: Homes
    here: tuple[str, ...]  # names of things in the scene
    elsewhere: frozenset[str]  # names of those that only the file has


_known: dict[tuple[str, int, int, int], Known] = {}  # The key is the name of the scene and how many things there are.


def known(context: bpy.types.Context) -> Known:
    """What names mean in the scene that the artist looks at."""
    data = bpy.data
    key = (context.scene.name_full, len(data.objects), len(data.collections), len(data.worlds))
    if key not in _known:
        _known.clear()
        _known[key] = _find(context.scene)
    return _known[key]


def _find(scene: bpy.types.Scene) -> Known:
    names = Names(bpy.data.collections, bpy.data.objects, bpy.data.worlds)
    here = {name for item in _objects(scene) for name in names.of(item)}
    here.update(name for item in scene.collection.children_recursive for name in names.homes.own(item))
    if scene.world is not None:
        here.add(names.of_world(scene.world))
    things = (item for kind in (bpy.data.objects, bpy.data.collections, bpy.data.worlds) for item in kind)
    return Known(names.homes, tuple(sorted(here)), frozenset(name for item in things for name in names.homes.own(item)) - here)


def _objects(scene: bpy.types.Scene) -> set[bpy.types.Object]:
    """The scene's objects and all that they instance."""
    found, queue = set(), list(scene.objects)
    while queue:
        item = queue.pop()
        if item in found:
            continue
        found.add(item)
        for thing in _instanced(item):
            queue.extend([thing] if isinstance(thing, bpy.types.Object) else thing.all_objects)
    return found


def _instanced(item: bpy.types.Object) -> list[bpy.types.Object | bpy.types.Collection]:
    """Objects and collections that an object may make instances of."""
    things: list[Any] = [item.instance_collection] if item.instance_type == 'COLLECTION' else []
    for system in item.particle_systems:
        things += [system.settings.instance_object, system.settings.instance_collection]
    for modifier in item.modifiers:
        if modifier.type == 'NODES' and modifier.node_group is not None:
            things += [*compat.modifier_inputs(modifier), *_in_nodes(modifier.node_group, set())]
    return [thing for thing in things if isinstance(thing, (bpy.types.Object, bpy.types.Collection))]


def _in_nodes(tree: bpy.types.NodeTree, seen: set[bpy.types.NodeTree]) -> Iterator[Any]:
    """What the sockets of a tree and of the groups in it hold."""
    seen.add(tree)
    for node in tree.nodes:
        yield from (getattr(socket, "default_value", None) for socket in node.inputs)
        group = getattr(node, "node_tree", None)
        if group is not None and group not in seen:
            yield from _in_nodes(group, seen)


def _only_moves(update: bpy.types.DepsgraphUpdate) -> bool:
    return isinstance(update.id, bpy.types.Object) and update.is_updated_transform and not update.is_updated_geometry


@bpy.app.handlers.persistent
def _scene_changed(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    if depsgraph is None or not all(map(_only_moves, depsgraph.updates)):
        _known.clear()


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    _known.clear()


_handlers = {"depsgraph_update_post": _scene_changed, "undo_post": _forget, "redo_post": _forget, "load_post": _forget}


def register() -> None:
    registration.add_handlers(_handlers)


def unregister() -> None:
    registration.remove_handlers(_handlers)
    _known.clear()
