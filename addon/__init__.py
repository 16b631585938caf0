# SPDX-License-Identifier: GPL-3.0-or-later
"""Sluice: a render engine for Blender in which artists move, copy, recolour and remove light itself."""

bl_info = {
    "name": "Sluice",
    "author": "The Sluice authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render Properties ▸ Render Engine ▸ Sluice; Add ▸ Light Edit",
    "description": "Photon mapping in which artists edit light itself: caustics, colour bleeding, reflections, direct light",
    "doc_url": "",
    "category": "Render",
}

import atexit  # noqa: E402  (Blender reads bl_info from the top of the file)

import bpy  # noqa: E402

from . import (  # noqa: E402
    arrivals, compat, core, edit_list, edit_panels, engine, gizmos, layers, native_panels, operators, overlay, panels, present, presets, properties,
    renaming, statistics, translations,
)

_rooms = (translations, properties, operators, presets, panels, edit_panels, edit_list, layers, native_panels, engine, arrivals, overlay, gizmos,
          renaming, present, statistics)


@bpy.app.handlers.persistent
def _before_load(*_):
    core.stop_all()


def register():
    for room in _rooms:
        room.register()
    bpy.app.handlers.load_pre.append(_before_load)
    atexit.register(_at_exit)


def unregister():
    if _before_load not in bpy.app.handlers.load_pre:
        return  # done by _at_exit; Blender as a module asks again
    atexit.unregister(_at_exit)
    core.stop_all()
    bpy.app.handlers.load_pre.remove(_before_load)
    for room in reversed(_rooms):
        room.unregister()


def _at_exit():
    """Stops what runs. Where Blender is a Python module, an engine class still registered at exit crashes or hangs it."""
    core.stop_all()
    if compat.is_bpy_module(bpy):
        unregister()
