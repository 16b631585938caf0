# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions follow the names of things: whoever renames an object, a light, a collection, a world or an edit finds the new name in
the expressions of edits and layers.

Blender tells nobody that something was renamed, so who bears each name is remembered and looked at after each change of the scene.
No undo step is made: undoing the rename brings back both names, and a step in between is followed again."""
import bpy

from . import handlers, names

_HOMES = ("objects", "collections", "worlds")
_NOTICE_SECONDS = 6.0

_bearers = {}   # (home, name in some expression) -> identity of what bears it
_past = {}      # old name -> (home, identity) of what was renamed
_seen = None    # number of objects when names were remembered; None: an expression changed


def expression_changed():
    """The names in use are to be remembered anew."""
    global _seen
    _seen = None


def _identity(item):
    """What stays when a datablock is renamed, and through undo. An address alone may be another's after a deletion."""
    unique = getattr(item, "session_uid", None)  # 4.1
    data = getattr(item, "data", None)
    return unique or (item.as_pointer(), getattr(item, "type", ""), data.as_pointer() if data else 0)


def _local(home, name):
    """A datablock of this file; those of libraries keep their names."""
    return getattr(bpy.data, home).get((name, None))


def _expressions():
    """Whatever holds an expression that can be written."""
    for item in bpy.data.objects:
        if item.type == 'EMPTY' and item.sluice.role == 'ENTRY' and (item.library is None):
            yield item.sluice
    for scene in bpy.data.scenes:
        if scene.library is None:
            for layer in scene.view_layers:
                yield from layer.sluice.layers


def _count():
    return tuple(len(getattr(bpy.data, home)) for home in _HOMES)


def _remember():
    global _seen
    _seen = _count()
    used = {name for owner in _expressions() for name in names.names_in(owner.expression)}
    found = {(home, name): _local(home, name) for home in _HOMES for name in used}
    _bearers.clear()
    _bearers.update({key: _identity(item) for key, item in found.items() if item is not None})


def _find(home, identity):
    return next((item for item in getattr(bpy.data, home) if item.library is None and _identity(item) == identity), None)


def _changes():
    """{old name: the names to write instead} of what bears another name now."""
    changes = {}
    for (home, name), identity in _bearers.items():
        item = _find(home, identity) if _local(home, name) is None else None  # one that took its place is meant from now on
        if item is not None:
            _past[name] = (home, identity)
            others = any(_local(other, name) is not None for other in _HOMES)  # bear the name too: then all are meant
            changes[name] = [item.name, name] if others else [item.name]
    for name, (home, identity) in list(_past.items()):  # undo may bring back an expression of before the renaming
        item = _find(home, identity)
        if item is None:
            del _past[name]
        elif name not in changes and all(_local(other, name) is None for other in _HOMES):
            changes[name] = [item.name]
    return changes


def follow(*_):
    """Looks whether something was renamed. Cheap while nothing was: a few names are asked."""
    lost = any((item := _local(*key)) is None or _identity(item) != identity for key, identity in _bearers.items())
    if not lost and _seen == _count():
        return
    changes = _changes()
    told = []
    for owner in _expressions() if changes else ():
        text = names.renamed(owner.expression, changes)
        if text != owner.expression:
            told.append(f"{owner.expression} is now {text}")
            owner.expression = text
    _remember()
    if told:
        notice(f"Renamed in {len(told)} expression{'s' if len(told) > 1 else ''}: {told[0]}")


def notice(text):
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


@bpy.app.handlers.persistent
def _undone(*_):
    expression_changed()
    _scene_changed()


@bpy.app.handlers.persistent
def _file_loaded(*_):
    _bearers.clear()
    _past.clear()
    _remember()


_handlers = {"depsgraph_update_post": _scene_changed, "undo_post": _undone, "redo_post": _undone, "load_post": _file_loaded}


def register():
    handlers.add(_handlers)


def unregister():
    handlers.remove(_handlers)
    if bpy.app.timers.is_registered(_clear_notice):
        bpy.app.timers.unregister(_clear_notice)
