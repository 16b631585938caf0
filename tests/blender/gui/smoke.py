# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels, overlay, undo, rendered mode and F12, with the stand-in core."""
import os
import subprocess
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from session import OUT, area, build_scene, edits, in_view, main, show


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
    show('VIEW_LAYER')
    yield "view_layer_panel"
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
    yield from copied_scene_steps()
    yield from rendered_steps()


def copied_scene_steps():
    """Blender tells of no update after Full Copy; expressions follow all the same, and undo brings the first scene back as it was."""
    first = bpy.context.window_manager.windows[0].scene
    bpy.ops.ed.undo_push(message="before the copy")
    with in_view():
        bpy.ops.scene.new(type='FULL_COPY')
    bpy.ops.ed.undo_push(message="copied")
    name = first.name
    yield None, 1.0
    told = {item.sluice.expression for item in edits() if item.sluice.role == 'ENTRY'}
    assert told == {"LS'Egg'+", "LS'Egg.001'+"}, told
    bpy.ops.ed.undo()
    yield None, 1.0
    told = [item.sluice.expression for item in edits() if item.sluice.role == 'ENTRY']
    assert told == ["LS'Egg'+"] and [scene.name for scene in bpy.data.scenes] == [name], told
    bpy.ops.ed.redo()
    yield None, 1.0
    told = {item.sluice.expression for item in edits() if item.sluice.role == 'ENTRY'}
    assert told == {"LS'Egg'+", "LS'Egg.001'+"}, told
    bpy.ops.ed.undo()
    yield None, 1.0


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


main(steps)
