# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that Blender calls on its events: {name in bpy.app.handlers: function}."""
import bpy


def add(functions):
    for name, function in functions.items():
        getattr(bpy.app.handlers, name).append(function)


def remove(functions):
    for name, function in functions.items():
        if function in getattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).remove(function)
