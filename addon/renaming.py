# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions follow what they name: whoever renames an object, a light, a collection, a world or an edit, copies it with its edits,
appends, overrides or makes it local finds the new name in the expressions of edits and layers.

Blender tells nobody of that, so what each name means is remembered and looked at after each change of the scene.
No undo step is made: undoing the rename brings back both names, and a step in between is followed again."""
from __future__ import annotations

from collections import namedtuple
from typing import Any

import bpy

from . import compat, copies, expression_names, model, registration
from .export.scene_names import Homes

_HOMES = ("objects", "collections", "worlds")
_NOTICE_SECONDS = 6.0
_LOOK_SECONDS = 0.3

# What holds expressions, an entry or a scene: the path of its library, its stem, its expressions, {name in them: [_Meant]}
_Owner = namedtuple("_Owner", "library stem texts meanings")
# A thing that a name means, what it looks like, and whether it is in the owner's scene, not in an instance alone
_Meant = namedtuple("_Meant", "identity look is_here")

_owners: dict[Any, _Owner] = {}    # identity -> _Owner
_places: dict[tuple[str, str, str | None], Any] = {}    # where an owner or what a name means was found -> its identity
_known = None   # identities of all that can be named; None: nobody looked yet
_past: dict[str, Any] = {}      # old name -> identity of what was renamed
_copied: dict[tuple[tuple[str, str, str | None], str], str] = {}    # (place of an owner, expression it was copied with) -> the expression of its own
_seen = None    # how many there were of each kind; None: an expression changed


def expression_changed() -> None:
    """The names in use are to be remembered anew."""
    global _seen
    _seen = None


def _identity(item):
    """What stays when a datablock is renamed or made local, and through undo. An address alone may be another's after a deletion."""
    if compat.has_session_ids(bpy):
        return item.session_uid
    if not isinstance(item, bpy.types.Object):
        return item.as_pointer()
    data = item.data
    return item.as_pointer(), item.type, data.as_pointer() if data else 0


def _kind(item):
    return {"Collection": "collections", "World": "worlds", "Scene": "scenes"}.get(item.bl_rna.identifier, "objects")


def _place(item):
    return _kind(item), item.name, item.library and item.library.filepath


def _at(place):
    kind, name, library = place
    return getattr(bpy.data, kind).get((name, library))


def _holders():
    """(entry or scene, what of it holds an expression)."""
    for item in bpy.data.objects:
        if model.is_entry(item):
            yield item, item.sluice
    for scene in bpy.data.scenes:
        for layer in scene.view_layers:
            for light_layer in layer.sluice.layers:
                yield scene, light_layer


def _count():
    return tuple(len(getattr(bpy.data, kind)) for kind in (*_HOMES, "scenes"))


class _File:
    """All that can be named, as it is now."""

    def __init__(self) -> None:
        kinds = [getattr(bpy.data, kind) for kind in _HOMES]
        self.homes = Homes(*kinds)
        self.items: dict[Any, bpy.types.ID] = {}
        self._called: dict[str, list[bpy.types.ID]] = {}
        for item in (item for kind in kinds for item in kind):
            self.items[_identity(item)] = item
            for name in (item.name,) if item.library is None else (item.name, item.name_full):
                self._called.setdefault(name, []).append(item)

    def meant(self, name: str, library: bpy.types.Library | None) -> list[bpy.types.ID]:
        """What a name means in an expression of `library`."""
        homes, called = self.homes.meant(name, library), self._called.get(name, [])
        return [item for item in called if not homes or item.library in homes]

    def old(self, arrivals: set[bpy.types.ID]) -> list[bpy.types.ID]:
        return [item for item in self.items.values() if item not in arrivals]

    def called(self, targets: set[bpy.types.ID], library: bpy.types.Library | None) -> list[str]:
        """Names that mean these things and, where there are such names, nothing else."""
        return [item.name if set(self.meant(item.name, library)) <= targets else item.name_full for item in targets]


def _remember(file):
    global _known, _seen
    _known, _seen = set(file.items), _count()
    _owners.clear()
    _places.clear()
    for item, group in _holders():
        identity = _identity(item)
        owner = _owners.setdefault(identity, _Owner(_place(item)[2], copies.stem(item.name), set(), {}))
        owner.texts.add(group.expression)
        _places[_place(item)] = identity
        scenes = copies.scenes_of(item)
        for name in expression_names.names_in(group.expression):
            meant = file.meant(name, item.library)
            owner.meanings[name] = [_seen_as(other, scenes) for other in meant]
            _places.update((_place(other), _identity(other)) for other in meant)
    for name in [name for name, identity in _past.items() if identity not in file.items]:
        del _past[name]


def _seen_as(other, scenes):
    return _Meant(_identity(other), copies.look(other), bool(scenes & copies.scenes_of(other)))


def _meant_before(name, item, text, is_moved, file):
    """What a name in an owner's expression meant before the change that moved the owner here or renamed what it names: [_Meant]."""
    owner, library = _owners.get(_identity(item)), item.library
    if owner is None and is_moved and item.override_library is not None:
        library = item.override_library.reference.library
    elif owner is None and is_moved:  # it says what the one says that it was made of
        alike = [other for other in _owners.values() if other.stem == copies.stem(item.name) and text in other.texts]
        owner = min(alike, key=lambda other: other.library is not None, default=None)
    if owner is not None and owner.meanings.get(name):
        return owner.meanings[name]
    meant = file.meant(name, library)
    if not meant and _past.get(name) in file.items:  # undo may bring back an expression of before the renaming
        meant = [file.items[_past[name]]]
    return [_seen_as(other, copies.scenes_of(item)) for other in meant]


def _stand_in(meant, name, item, is_moved, file, arrivals):
    """What stands now where something stood for an owner: what was made of it together with the owner, or instead of it in the owner's
    scene; what took its name from it; else itself, or None: it is gone."""
    other, scenes, copy = file.items.get(meant.identity), copies.scenes_of(item), None
    if other is not None:
        copy = copies.override_of(other, file.items.values() if item.override_library is not None else arrivals)
    if copy is None and arrivals:
        copy = copies.of(meant.look, arrivals - {other}, file.old(arrivals), scenes)
    if copy is not None:
        is_together = is_moved and other not in arrivals
        has_left = other is None or not scenes & copies.scenes_of(other)
        is_instead = (meant.is_here or _owners.get(_identity(item)) is None) and scenes & copies.scenes_of(copy) and has_left
        if is_together or is_instead and (other is not None or not file.meant(name, item.library)):
            return copy
    if other is None or is_moved or other.name == name or other.library is not None:
        return other
    took = [new for new in file.meant(name, item.library) if _kind(new) == _kind(other)]
    if not took:
        _past[name] = _identity(other)
    return took[0] if took else other


def follow(is_undone: bool = False) -> None:
    """Looks whether what is named was renamed or copied. Cheap while nothing was: a few names are asked."""
    is_lost = any((item := _at(place)) is None or _identity(item) != identity for place, identity in _places.items())
    if not is_lost and _seen == _count():
        return
    file = _File()
    # After undo all may lie at other addresses
    arrivals = set() if is_undone or _known is None else {item for identity, item in file.items.items() if identity not in _known}
    told = [line for item, group in _holders() if item.library is None for line in _follow_in(item, group, file, arrivals, is_undone)]
    _remember(file)
    if told:
        notice(f"Renamed in {len(told)} expression{'s' if len(told) > 1 else ''}: {told[0]}")


def _follow_in(item, group, file, arrivals, is_undone):
    """Writes the names that an expression needs now; [what to tell of it]."""
    owner, old, changes = _owners.get(_identity(item)), group.expression, {}
    is_moved = bool(arrivals) if owner is None else owner.library != _place(item)[2]
    for name in expression_names.names_in(old):
        meant = _meant_before(name, item, old, is_moved, file)
        targets = {_stand_in(other, name, item, is_moved, file, arrivals) for other in meant} - {None}
        if targets and targets != set(file.meant(name, item.library)):
            changes[name] = sorted(file.called(targets, item.library), key=lambda new: (new == name, new))
    text = expression_names.renamed(old, changes)
    if text != old and is_moved:
        _copied[_place(item), old] = text
    again = _copied.get((_place(item), old), old) if is_undone else old  # as redo leaves it: the step of the copy was made before
    if again != old and all(file.meant(name, item.library) for name in expression_names.names_in(again)):
        text = again
    if text == old:
        return []
    group.expression = text
    return [f"{old} is now {text}"]


def notice(text: str) -> None:
    """A sentence in the status bar, for a while."""
    if bpy.app.background:
        print(f"sluice: {text}", flush=True)
        return
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(text)
    if not bpy.app.timers.is_registered(_clear_notice):
        bpy.app.timers.register(_clear_notice, first_interval=_NOTICE_SECONDS)


def _clear_notice():
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(None)


@bpy.app.handlers.persistent
def _scene_changed(*_):
    if not bpy.app.is_job_running('RENDER'):  # a render's own handlers run beside the interface
        follow()


def _look():
    """Blender tells of no update after some copies, Full Copy of a scene among them."""
    _scene_changed()
    return _LOOK_SECONDS


@bpy.app.handlers.persistent
def _render_begins(*_):
    if bpy.app.background:  # scripts render what they have just made
        follow()


@bpy.app.handlers.persistent
def _undone(*_):
    expression_changed()
    if not bpy.app.is_job_running('RENDER'):
        follow(is_undone=True)


@bpy.app.handlers.persistent
def _file_loaded(*_):
    global _known
    _known = None  # what the file before held may lie at the same addresses
    for kept in (_owners, _places, _past, _copied):
        kept.clear()
    _undone()


_handlers = {"depsgraph_update_post": _scene_changed, "save_pre": _scene_changed, "render_init": _render_begins, "undo_post": _undone,
             "redo_post": _undone, "load_post": _file_loaded}


def register() -> None:
    registration.add_handlers(_handlers)
    if not bpy.app.background:
        bpy.app.timers.register(_look, first_interval=_LOOK_SECONDS, persistent=True)


def unregister() -> None:
    global _known
    _known = None
    registration.remove_handlers(_handlers)
    for timer in (_look, _clear_notice):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
