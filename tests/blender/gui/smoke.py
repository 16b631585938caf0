# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs in a Blender with a window: one step per timer tick, a screenshot after each. Arguments after --: the folder for pictures.

Steps are generators: each yield is the name of a picture to take (None: only let Blender draw), or (name, seconds to wait before).
Ends Blender itself; a failure ends it with code 1."""
import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy

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
    from mathutils import Quaternion
    view.view_rotation, view.view_distance, view.view_location = Quaternion((0.83, 0.46, 0.15, 0.28)), 11, (0, 1, 1)


def steps():
    build_scene()
    yield "overlay"
    entry = bpy.data.objects["Light Edit"]
    bpy.ops.sluice.select_one(name=entry.name)
    show('DATA')
    yield "entry_panel"
    entry.sluice.expression = "LS+('Egg'"
    yield "expression_error"
    entry.sluice.expression = "LS'Egg'+"
    entry.sluice.enabled = False
    yield "disabled"
    entry.sluice.enabled = True
    bpy.ops.sluice.select_exits()
    show('DATA')
    yield "exit_panel"
    show('RENDER')
    yield "render_panel"
    bpy.ops.sluice.select_one(name="Area") if "Area" in bpy.data.objects else None
    show('DATA')
    yield "lamp_panel"
    area('VIEW_3D').spaces.active.show_region_ui = True
    bpy.ops.sluice.select_one(name=entry.name)
    yield "sidebar"
    area('VIEW_3D').spaces.active.show_region_ui = False
    area('VIEW_3D').spaces.active.overlay.show_overlays = False
    yield "overlays_off"
    area('VIEW_3D').spaces.active.overlay.show_overlays = True
    yield from undo_steps()
    yield from rendered_steps()


def undo_steps():
    """Each operator is one step."""
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.sluice.add_edit()
    bpy.ops.ed.undo_push(message="added")
    assert len(edits()) == 4
    bpy.ops.ed.undo()
    assert len(edits()) == 2
    yield "undone"
    bpy.ops.ed.redo()
    assert len(edits()) == 4
    bpy.ops.ed.undo()
    yield None


def rendered_steps():
    """Rendered mode follows the view and the scene; undo and redo below it; then F12 while it runs."""
    area('VIEW_3D').spaces.active.shading.type = 'RENDERED'
    bpy.context.scene.sluice.passes = 200
    yield "rendered", 3
    for turn in range(int(os.environ.get("SLUICE_TURNS", "4"))):
        bpy.data.objects["Light Edit Exit"].location.x += 0.05
        bpy.ops.ed.undo_push(message=f"move {turn}")
        area('VIEW_3D').spaces.active.region_3d.view_distance += 0.05
        yield None
        bpy.ops.ed.undo()
        yield None
    yield "rendered_after_undo", 3
    bpy.data.objects["Light Edit"].sluice.expression = "LS+("
    yield "rendered_error", 1
    bpy.data.objects["Light Edit"].sluice.expression = "LS+"
    bpy.ops.object.camera_add(location=(7, -7, 5), rotation=(1.1, 0, 0.8))
    bpy.context.scene.camera = bpy.context.object
    yield from escape_steps()  # before F12: Blender ends with code 1 when the last render was escaped
    bpy.context.scene.sluice.passes = 16
    bpy.ops.render.render('INVOKE_DEFAULT')
    yield "render_running", 1
    yield "render_done", 4
    bpy.data.images["Render Result"].save_render(str(OUT / "f12.png"))
    area('VIEW_3D').spaces.active.shading.type = 'SOLID'
    yield None


def escape_steps():
    """A real key press stops a render that would take hours; what it had so far stays. (How soon is asked of the session itself: here
    the software renderer of the test window is the slow one.)"""
    bpy.context.scene.sluice.passes = 1000000
    bpy.ops.render.render('INVOKE_DEFAULT')
    yield None, 1.5
    assert bpy.app.is_job_running('RENDER')
    subprocess.Popen(["xdotool", "mousemove", "500", "300", "key", "Escape"])
    begin = time.monotonic()
    while bpy.app.is_job_running('RENDER'):
        assert time.monotonic() - begin < 20, "Esc does not stop the render"
        yield None, 0.05
    print(f"gui: stopped {time.monotonic() - begin:.2f} s after Esc", flush=True)
    yield "render_escaped"
    bpy.data.images["Render Result"].save_render(str(OUT / "escaped.png"))


def edits():
    return [item for item in bpy.data.objects if item.sluice.role != 'NONE']


def screenshot(name):
    for item in bpy.context.window_manager.windows[0].screen.areas:
        item.tag_redraw()
    with in_view():
        bpy.ops.wm.redraw_timer(type='DRAW_WIN_SWAP', iterations=2)
    subprocess.run(["import", "-window", "root", str(OUT / f"{name}.png")], check=True)


def main():
    bpy.context.preferences.view.show_splash = False
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


main()
