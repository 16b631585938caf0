# SPDX-License-Identifier: GPL-3.0-or-later
"""What scripts that run in a Blender with a window share: steps by timer, a screenshot after each. Arguments after --: the folder for
pictures.

Steps are generators: each yield is the name of a picture to take (None: only let Blender draw), or (name, seconds to wait before).
Ends Blender itself; a failure ends it with code 1."""
import os
import subprocess
import sys
import traceback
from pathlib import Path

import bpy
from mathutils import Quaternion

OUT = Path(sys.argv[sys.argv.index("--") + 1])
OUT.mkdir(parents=True, exist_ok=True)


def area(kind):
    return next(item for item in bpy.context.window_manager.windows[0].screen.areas if item.type == kind)


def in_view():
    """A timer has no window of its own: the 3D view's."""
    view = area('VIEW_3D')
    region = next(item for item in view.regions if item.type == 'WINDOW')
    return bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=view, region=region)


def show(context):
    """Properties editor on a tab; needs a redraw before the tab exists."""
    space = area('PROPERTIES').spaces.active
    space.context = context


def build_scene():
    """A table, a wall, a glass ball, a lamp, and an edit from the table to the wall."""
    scene = bpy.context.scene
    for item in list(scene.objects):
        bpy.data.objects.remove(item)
    scene.render.engine = 'SLUICE'
    bpy.ops.mesh.primitive_plane_add(size=6)
    bpy.context.object.name = "Table"
    bpy.ops.mesh.primitive_plane_add(size=6, location=(0, 3, 3), rotation=(1.5708, 0, 0))
    bpy.context.object.name = "Wall"
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.6, location=(0, 0, 0.6))
    bpy.context.object.name = "Egg"
    bpy.ops.object.light_add(type='AREA', location=(-2, -2, 4))
    scene.cursor.location = (1, 0.5, 0)
    bpy.ops.sluice.add_edit(expression="LS+", size=1.6)
    exit_ = bpy.context.object
    exit_.location, exit_.rotation_euler = (0.5, 3, 2), (1.5708, 0, 0)
    exit_.scale *= 1.3
    view = area('VIEW_3D').spaces.active.region_3d
    view.view_rotation, view.view_distance, view.view_location = Quaternion((0.83, 0.46, 0.15, 0.28)), 11, (0, 1, 1)


def edits():
    return [item for item in bpy.data.objects if item.sluice.role != 'NONE']


def screenshot(name):
    for item in bpy.context.window_manager.windows[0].screen.areas:
        item.tag_redraw()
    with in_view():
        bpy.ops.wm.redraw_timer(type='DRAW_WIN_SWAP', iterations=2)
    subprocess.run(["import", "-window", "root", str(OUT / f"{name}.png")], check=True)


def main(steps):
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.system.viewport_aa = 'OFF'  # the window is drawn by software
    sequence = steps()
    pending = []

    def tick():
        try:
            name = pending.pop() if pending else None
            if name:
                screenshot(name)
                return 0.1
            with in_view():
                step = next(sequence)
            name, seconds = step if isinstance(step, tuple) else (step, 0.4 if step else 0.05)
            pending.append(name)
            return seconds
        except StopIteration:
            print("gui: done", flush=True)
            with in_view():
                bpy.ops.wm.quit_blender()
        except Exception:
            traceback.print_exc()
            sys.stderr.flush()
            os._exit(1)

    bpy.app.timers.register(tick, first_interval=1.5)
