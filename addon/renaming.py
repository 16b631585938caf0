# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions follow what they name: whoever renames an object, a light, a collection, a world or an edit, copies it with its edits,
appends, overrides or makes it local finds the new name in the expressions of edits and layers.

Blender tells nobody of that, so what each name means is remembered and looked at after each change of the scene.
No undo step is made: undoing the rename brings back both names, and a step in between is followed again."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, TypeAlias

import bpy

from . import compat, copies, expression_names, model, registration
from .export.scene_names import Homes

# Where bpy.data has a datablock: the name of the list, its name in it, the path of its library.
Place: TypeAlias = tuple[str, str, str | None]

_HOMES = ("objects", "collections", "worlds")  # The lists in bpy.data that hold what can be named.
_NOTICE_SECONDS = 6.0
_LOOK_SECONDS = 0.3
_FEW = 40  # Finding so many things by their names, one by one, is quicker than walking through the file.


class _Meant(NamedTuple):
    """A thing that a name in an expression means."""

    identity: Any
    look: copies.Look
    is_here: bool  # in the owner's scene itself, not in an instance alone


class _Owner(NamedTuple):
    """A holder of expressions (an entry, or a scene with layers), as it was when it was last looked at."""

    library: str | None
    stem: str
    texts: set[str]
    meanings: dict[str, list[_Meant]]  # by the names in its expressions


class _Census(NamedTuple):
    """What the file held when it was last looked at."""

    names: tuple[set[str], ...]  # of the lists in _HOMES
    counts: tuple[int, ...]  # of the same lists, of scenes and of libraries


_owners: dict[Any, _Owner] = {}  # by identity
_places: dict[Place, Any] = {}  # where an owner, or what a name means, was found; its identity
_known: set[Any] | None = None  # identities of all that can be named; None: nobody has looked yet
_past: dict[str, Any] = {}  # old name of what was renamed; its identity
_copied: dict[tuple[Place, str], str] = {}  # (place of an owner, the expression it was copied with); the expression of its own
_census: _Census | None = None  # None: an expression has changed since


def expression_changed() -> None:
    """An expression changed: the names in use are to be remembered anew."""
    global _census
    _census = None


def _identity(item: Any) -> Any:
    """What stays when a datablock is renamed or made local, and through undo. An address alone may be another's after a deletion."""
    if compat.has_session_ids(bpy):
        return item.session_uid
    if not isinstance(item, bpy.types.Object):
        return item.as_pointer()
    data = item.data
    return item.as_pointer(), item.type, data.as_pointer() if data else 0


def _list_of(item: bpy.types.ID) -> str:
    """The name of the list in bpy.data that holds it."""
    return {"Collection": "collections", "World": "worlds", "Scene": "scenes"}.get(item.bl_rna.identifier, "objects")


def _place(item: bpy.types.ID) -> Place:
    return _list_of(item), item.name, item.library.filepath if item.library else None


def _at(place: Place) -> Any:
    kind, name, library = place
    return getattr(bpy.data, kind).get((name, library))


def _holders() -> Iterator[tuple[Any, Any]]:
    """All that holds expressions, as pairs: an entry or a scene, and what of it has the property `expression`."""
    for item in bpy.data.objects:
        if model.is_entry(item):
            yield item, item.sluice
    for scene in bpy.data.scenes:
        for layer in scene.view_layers:
            for light_layer in layer.sluice.layers:
                yield scene, light_layer


def _counts() -> tuple[int, ...]:
    return tuple(len(getattr(bpy.data, name)) for name in (*_HOMES, "scenes", "libraries"))


def _take_census() -> _Census:
    return _Census(tuple(set(getattr(bpy.data, name).keys()) for name in _HOMES), _counts())


class _File:
    """All that can be named, as it is now. Making one walks the whole file: 30 ms for 10,000 objects."""

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
        """The things that a name means in an expression of `library`."""
        homes, called = self.homes.meant(name, library), self._called.get(name, [])
        return [item for item in called if not homes or item.library in homes]

    def old(self, arrivals: set[bpy.types.ID]) -> list[bpy.types.ID]:
        """All but the new things."""
        return [item for item in self.items.values() if item not in arrivals]

    def called(self, targets: set[bpy.types.ID], library: bpy.types.Library | None) -> list[str]:
        """Names that mean these things; where there are such names, they mean nothing else."""
        return [item.name if set(self.meant(item.name, library)) <= targets else item.name_full for item in targets]


def _remember(file: _File) -> None:
    """Takes down what each name means now."""
    global _known, _census
    _known, _census = set(file.items), _take_census()
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


def _seen_as(other: bpy.types.ID, scenes: set[bpy.types.Scene]) -> _Meant:
    """A thing that is meant, for an owner in these scenes."""
    return _Meant(_identity(other), copies.look(other), bool(scenes & copies.scenes_of(other)))


def _meant_before(name: str, item: bpy.types.ID, text: str, is_moved: bool, file: _File) -> list[_Meant]:
    """What a name in an owner's expression meant before the change that moved the owner here or renamed what it names."""
    owner, library = _owners.get(_identity(item)), item.library
    if owner is None and is_moved and item.override_library is not None:
        library = item.override_library.reference.library
    elif owner is None and is_moved:  # It says what the owner said that it was made of.
        alike = [other for other in _owners.values() if other.stem == copies.stem(item.name) and text in other.texts]
        owner = min(alike, key=lambda other: other.library is not None, default=None)
    if owner is not None and owner.meanings.get(name):
        return owner.meanings[name]
    meant = file.meant(name, library)
    if not meant and _past.get(name) in file.items:  # Undo may bring back an expression from before the renaming.
        meant = [file.items[_past[name]]]
    return [_seen_as(other, copies.scenes_of(item)) for other in meant]


def _stand_in(meant: _Meant, name: str, item: Any, is_moved: bool, file: _File, arrivals: set[bpy.types.ID]) -> bpy.types.ID | None:
    """What stands now where something stood for the owner `item`. The first of these that holds:

    1. A copy of the thing came together with the owner, who was copied, appended or made local: the copy.
    2. A copy came into the owner's scene instead of the thing, which has left that scene (see _came_instead): the copy.
    3. The thing is gone: None.
    4. It is called as it was, or its name is another file's matter, or the owner is a new one: the thing itself.
    5. It was renamed, and something else of its kind took its name: that. What Blender numbered to make room was not renamed by anybody.
    6. It has another name: the thing itself, which from now on is known by its old name too."""
    other = file.items.get(meant.identity)
    copy = _copy_of(meant, other, item, file, arrivals)
    if copy is not None:
        came_together = is_moved and other not in arrivals
        if came_together or _came_instead(copy, other, meant, item) and (other is not None or not file.meant(name, item.library)):
            return copy
    if other is None or is_moved or other.name == name or other.library is not None:
        return other
    is_numbered = copies.stem(other.name) == copies.stem(name)
    took = None if is_numbered else next((new for new in file.meant(name, item.library) if _list_of(new) == _list_of(other)), None)
    if took is None:
        _past[name] = _identity(other)
    return other if took is None else took


def _copy_of(meant: _Meant, other: bpy.types.ID | None, item: Any, file: _File, arrivals: set[bpy.types.ID]) -> bpy.types.ID | None:
    """The new thing that was made of what was meant, or None. `other` is what was meant itself, if it is still there."""
    if other is not None:
        override = copies.override_of(other, file.items.values() if item.override_library is not None else arrivals)
        if override is not None:
            return override
    if not arrivals:
        return None
    return copies.of(meant.look, arrivals - {other}, file.old(arrivals), copies.scenes_of(item))


def _came_instead(copy: bpy.types.ID, other: bpy.types.ID | None, meant: _Meant, item: Any) -> bool:
    """Did the copy take the place of the thing in the owner's scene?"""
    scenes = copies.scenes_of(item)
    has_left = other is None or not scenes & copies.scenes_of(other)
    was_here = meant.is_here or _owners.get(_identity(item)) is None
    return was_here and bool(scenes & copies.scenes_of(copy)) and has_left


def follow(is_undone: bool = False) -> None:
    """Looks whether what is named was renamed or copied. Cheap while nothing was: a few names are asked, and those of new things."""
    is_lost = any((item := _at(place)) is None or _identity(item) != identity for place, identity in _places.items())
    if not is_lost and _census is not None and (_census.counts == _counts() or not is_undone and _only_unrelated_came(_census)):
        return
    file = _File()
    # After an undo everything may lie at another address, so nothing can be told to be new.
    arrivals = set() if is_undone or _known is None else {item for identity, item in file.items.items() if identity not in _known}
    told = [line for item, group in _holders() if item.library is None for line in _follow_in(item, group, file, arrivals, is_undone)]
    _remember(file)
    if told:
        notice(f"Renamed in {len(told)} expression{'s' if len(told) > 1 else ''}: {told[0]}")


def _only_unrelated_came(before: _Census) -> bool:
    """Did nothing happen since this census but that things came which no expression can mean, neither themselves nor as a copy? Then they
    are taken down here. False where that is not sure: names alone do not tell what left, what was linked and what overrides."""
    global _census
    now = _take_census()
    new_names = [names - old_names for names, old_names in zip(now.names, before.names)]  # those of renamed things, too
    if _known is None or now.counts[len(_HOMES):] != before.counts[len(_HOMES):] or sum(map(len, new_names)) > _FEW:
        return False
    came = []
    for kind, names, count, old_count in zip(_HOMES, new_names, now.counts, before.counts):
        found = [item for item in (getattr(bpy.data, kind)[name] for name in names) if _identity(item) not in _known]
        if len(found) != count - old_count:
            return False  # Something left, or something came under a name that something else has.
        came += found
    stems = {owner.stem for owner in _owners.values()}
    for owner in _owners.values():
        for name, meant in owner.meanings.items():
            stems.update((copies.stem(name), *(other.look.stem for other in meant)))
    if any(copies.stem(name) in stems for names in new_names for name in names):
        return False
    if any(item.override_library is not None or item.library is not None for item in came) or not _are_owners_the_same():
        return False
    _known.update(map(_identity, came))
    _census = now
    _look_anew()
    return True


def _are_owners_the_same() -> bool:
    """Does nobody hold expressions but those who did, and the same ones?"""
    for item, group in _holders():
        owner = _owners.get(_places.get(_place(item)))
        if owner is None or group.expression not in owner.texts:
            return False
    return True


def _look_anew() -> None:
    """Remembers anew what the named things look like and whether they are in the owner's scene. What names mean has not changed."""
    items = {identity: _at(place) for place, identity in _places.items()}
    for identity, owner in _owners.items():
        scenes = copies.scenes_of(items[identity])
        for name, meant in owner.meanings.items():
            owner.meanings[name] = [_seen_as(items[other.identity], scenes) for other in meant]


def _follow_in(item: Any, group: Any, file: _File, arrivals: set[bpy.types.ID], is_undone: bool) -> list[str]:
    """Writes the names that an expression of the owner `item` needs now. Returns what is to be told of it."""
    owner, old = _owners.get(_identity(item)), group.expression
    changes: dict[str, list[str]] = {}
    is_moved = bool(arrivals) if owner is None else owner.library != _place(item)[2]
    for name in expression_names.names_in(old):
        meant = _meant_before(name, item, old, is_moved, file)
        found = (_stand_in(other, name, item, is_moved, file, arrivals) for other in meant)
        targets = {thing for thing in found if thing is not None}
        if targets and targets != set(file.meant(name, item.library)):
            changes[name] = sorted(file.called(targets, item.library), key=lambda new: (new == name, new))
    text = expression_names.renamed(old, changes)
    if text != old and is_moved:
        _copied[_place(item), old] = text
    # Redo brings back a copied expression as it was before it followed: it is exchanged for what it was followed to.
    again = _copied.get((_place(item), old), old) if is_undone else old
    if again != old and all(file.meant(name, item.library) for name in expression_names.names_in(again)):
        text = again
    if text == old:
        return []
    group.expression = text
    return [f"{old} is now {text}"]


def notice(text: str) -> None:
    """Shows a sentence in the status bar for a while; without a window it is printed."""
    if bpy.app.background:
        print(f"sluice: {text}", flush=True)
        return
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(text)
    if not bpy.app.timers.is_registered(_clear_notice):
        bpy.app.timers.register(_clear_notice, first_interval=_NOTICE_SECONDS)


def _clear_notice() -> None:
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(None)


@bpy.app.handlers.persistent
def _scene_changed(*_: object) -> None:
    if not bpy.app.is_job_running('RENDER'):  # The handlers of a render run beside the interface, where nothing may be written.
        follow()


def _look() -> float:
    """A timer: Blender tells of no update after some copies, Full Copy of a scene among them."""
    _scene_changed()
    return _LOOK_SECONDS


@bpy.app.handlers.persistent
def _render_begins(*_: object) -> None:
    if bpy.app.background:  # Scripts render what they have just made, before Blender tells of any update.
        follow()


@bpy.app.handlers.persistent
def _undone(*_: object) -> None:
    expression_changed()
    if not bpy.app.is_job_running('RENDER'):
        follow(is_undone=True)


@bpy.app.handlers.persistent
def _file_loaded(*_: object) -> None:
    global _known
    _known = None  # Things of the file before may have lain at the same addresses.
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
