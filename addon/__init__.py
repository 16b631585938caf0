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
    accuracy_panels,
    arrivals,
    compat,
    core,
    denoise_operator,
    edit_list,
    edit_operators,
    edit_panels,
    edit_statistics,
    engine,
    exit_operators,
    gizmos,
    known_names,
    layers,
    menus,
    native_panels,
    overlay,
    panels,
    pass_panels,
    presets,
    properties,
    render_statistics,
    renaming,
    report_operator,
    translations,
)

_registered = (  # They are registered in this order and taken away in the opposite one.
    translations, properties, edit_operators, exit_operators, menus, presets, panels, accuracy_panels, edit_panels, edit_list,
    layers, pass_panels, native_panels, engine, arrivals, overlay, gizmos, renaming, known_names, edit_statistics, render_statistics,
    denoise_operator, report_operator,
)


@bpy.app.handlers.persistent
def _before_load(*_: object) -> None:
    core.stop_all()


def register() -> None:
    for module in _registered:
        module.register()
    bpy.app.handlers.load_pre.append(_before_load)
    atexit.register(_at_exit)


def unregister() -> None:
    if _before_load not in bpy.app.handlers.load_pre:
        return  # _at_exit has done it already: Blender as a Python module asks a second time.
    atexit.unregister(_at_exit)
    core.stop_all()
    bpy.app.handlers.load_pre.remove(_before_load)
    for module in reversed(_registered):
        module.unregister()


def _at_exit() -> None:
    """Stops what runs. Where Blender is a Python module, an engine class still registered at exit crashes or hangs it."""
    core.stop_all()
    if compat.is_bpy_module(bpy):
        unregister()
