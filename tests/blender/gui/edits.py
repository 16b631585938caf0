# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist's hands, with the real core and simulated mouse and keys: an edit from the menu, gizmos dragged, undo, expressions in words
and with errors, presets, the list of edits, figures after a render."""
import math
import os
import sys
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parent))
from session import area, build_scene, edits, in_view, main, show


def window():
    return bpy.context.window_manager.windows[0]


def press(kind, value='PRESS', at=(0, 0), **more):
    window().event_simulate(type=kind, value=value, x=int(at[0]), y=int(at[1]), **more)


def click(at, kind='LEFTMOUSE'):
    press('MOUSEMOVE', 'NOTHING', at)
    press(kind, 'PRESS', at)
    press(kind, 'RELEASE', at)


def drag(start, *path):
    """As a hand does it, a little at a time: Blender must draw between the moves."""
    press('MOUSEMOVE', 'NOTHING', start)
    yield None, 0.3
    press('MOUSEMOVE', 'NOTHING', start)
    press('LEFTMOUSE', 'PRESS', start)
    yield None, 0.1
    for place in path:
        press('MOUSEMOVE', 'NOTHING', place)
        yield None, 0.05
    press('LEFTMOUSE', 'RELEASE', path[-1])
    yield None, 0.2
    press('MOUSEMOVE', 'NOTHING', (5, 5))  # nothing stays highlighted
    yield None, 0.1


def line(start, end, steps=5):
    return [start] + [[a + (b - a) * step / steps for a, b in zip(start, end)] for step in range(1, steps + 1)]


def on_screen(place):
    """Where a point of the scene is in the window."""
    from bpy_extras.view3d_utils import location_3d_to_region_2d
    view = area('VIEW_3D')
    region = next(item for item in view.regions if item.type == 'WINDOW')
    there = location_3d_to_region_2d(region, view.spaces.active.region_3d, place)
    return region.x + there.x, region.y + there.y


def undo():
    press('Z', ctrl=True, at=on_screen((0, 0, 0)))
    press('Z', 'RELEASE', ctrl=True, at=on_screen((0, 0, 0)))


def steps():
    build_scene()
    with in_view():
        bpy.ops.ed.undo_push(message="scene")
    yield None
    for name in os.environ.get("SLUICE_STEPS", "menu expression gizmo layers rendered views list").split():  # some alone, while one works on them
        yield from globals()[f"{name}_steps"]()


def menu_steps():
    """Shift+A, and an edit by it."""
    middle = on_screen((0, 0, 0))
    press('MOUSEMOVE', 'NOTHING', middle)
    press('A', shift=True, at=middle)
    press('A', 'RELEASE', shift=True, at=middle)
    yield "add_menu", 0.5
    press('ESC', at=middle)
    press('ESC', 'RELEASE', at=middle)
    yield None, 0.3
    bpy.ops.wm.call_menu(name="SLUICE_MT_add_edit")
    yield "light_edit_menu", 0.5
    press('ESC', at=middle)
    press('ESC', 'RELEASE', at=middle)
    yield None, 0.3
    bpy.ops.wm.call_menu(name="SLUICE_MT_dim_light")
    yield "dim_menu", 0.5
    press('RET', at=middle)
    press('RET', 'RELEASE', at=middle)
    yield None, 0.5
    yield "added", 0.3
    added = bpy.context.object  # the menu's first line: a caustic, dimmed where it is
    assert len(edits()) == 4 and added.sluice.intensity == 0.5 and added.sluice.entry.sluice.expression == "LS+"
    undo()
    yield None, 0.5
    assert len(edits()) == 2
    yield from here_steps(middle)


def here_steps(middle):
    """Which light falls at the cursor, in a menu; its first line becomes an edit."""
    bpy.data.objects["Light Edit"].sluice.enabled = False
    press('MOUSEMOVE', 'NOTHING', middle)
    bpy.ops.sluice.edit_light_here('INVOKE_DEFAULT')
    yield "arrives_here", 4
    press('RET', at=middle)
    press('RET', 'RELEASE', at=middle)
    yield "edited_here", 0.5
    added = bpy.context.object.sluice  # moved, though the last one was dimmed; the box's light comes from the world above all
    assert len(edits()) == 4 and added.intensity == 1 and added.entry.sluice.expression == "L'World'"
    assert added.entry.name == "Light from World"
    undo()
    yield None, 0.5
    assert len(edits()) == 2
    bpy.data.objects["Light Edit"].sluice.enabled = True


def expression_steps():
    entry = bpy.data.objects["Light Edit"]
    bpy.ops.sluice.select_one(name=entry.name)
    show('DATA')
    for name, text in (("words", "LS+"), ("words_error", "LS'Egg'+("), ("words_unknown", "L.*D'Redwall'")):
        entry.sluice.expression = text
        yield name
    view = bpy.context.preferences.view
    view.language, view.use_translate_interface = 'fr_FR', True
    yield "words_french"
    view.language = 'en_US'
    entry.sluice.expression = "LS'Egg'+"
    yield None
    bpy.ops.ed.undo_push(message="named")
    bpy.data.objects["Egg"].name = "Glass egg"
    bpy.ops.ed.undo_push(message="Rename")  # as Blender's fields do, before anyone could follow
    yield "renamed"
    assert entry.sluice.expression == "LS'Glass egg'+"
    yield from undone_rename()
    bpy.ops.sluice.insert_name('INVOKE_DEFAULT')
    yield "names", 0.6
    press('ESC', at=(700, 300))
    press('ESC', 'RELEASE', at=(700, 300))
    yield None, 0.3
    bpy.ops.wm.call_panel(name="SLUICE_PT_expressions")
    yield "presets", 0.6
    press('ESC', at=(700, 300))
    press('ESC', 'RELEASE', at=(700, 300))
    yield None, 0.3


def undone_rename():
    """A renaming with what follows it is one step, also after another step upon it."""
    bpy.data.objects["Light Edit"].sluice.amount = 0.5
    bpy.ops.ed.undo_push(message="Amount")
    back, again = bpy.ops.ed.undo, bpy.ops.ed.redo
    for step, name, amount in ((back, "Glass egg", 1), (back, "Egg", 1), (again, "Glass egg", 1), (again, "Glass egg", 0.5)):
        step()
        yield None, 0.3
        edit = bpy.data.objects["Light Edit"].sluice
        assert name in bpy.data.objects and (edit.expression, edit.amount) == (f"LS'{name}'+", amount)


def gizmo_steps():
    """Each drag changes one number and is one step of undo."""
    exit_ = bpy.data.objects["Light Edit Exit"]
    bpy.ops.sluice.select_one(name=exit_.name)
    bpy.context.scene["mark"] = 1
    bpy.ops.ed.undo_push(message="exit")
    yield "gizmos_exit", 0.5
    before = exit_.scale.copy()
    matrix, s = exit_.matrix_world, exit_.empty_display_size
    yield from drag(*line(on_screen(matrix @ point(s, s)), on_screen(matrix @ point(1.4 * s, 1.4 * s))))
    yield "gizmo_size"
    exit_ = bpy.data.objects["Light Edit Exit"]
    assert exit_.scale.x > 1.15 * before.x and exit_.scale.y > 1.15 * before.y
    undo()
    yield None, 0.5
    exit_ = bpy.data.objects["Light Edit Exit"]
    assert (exit_.scale - before).length < 1e-6 and len(edits()) == 2
    assert bpy.context.scene["mark"] == 1  # no step further back
    head = head_of(exit_)
    yield from drag(*line(on_screen(head), on_screen(head + 0.6 * (head - exit_.matrix_world.translation))))
    yield "gizmo_intensity"
    exit_ = bpy.data.objects["Light Edit Exit"]
    assert 1.2 < exit_.sluice.intensity < 4
    undo()
    yield None, 0.5
    assert bpy.data.objects["Light Edit Exit"].sluice.intensity == 1 and bpy.context.scene["mark"] == 1
    yield from dial_steps()
    area('VIEW_3D').spaces.active.show_gizmo = False
    yield "gizmos_off"
    area('VIEW_3D').spaces.active.show_gizmo = True
    entry = bpy.data.objects["Light Edit"]
    border = entry.matrix_world @ point(1, 0.5)
    yield from drag(on_screen(border), on_screen(border))
    yield "picked"
    assert bpy.context.view_layer.objects.active == bpy.data.objects["Light Edit"]


def dial_steps():
    """A sixth of a turn round the dial is a sixth of the hue circle."""
    from sluice import gizmos
    exit_ = bpy.data.objects["Light Edit Exit"]
    axes, centre = gizmos._frame(exit_)
    right = area('VIEW_3D').spaces.active.region_3d.view_rotation @ Vector((1, 0, 0))
    pixels = (Vector(on_screen(centre + right)) - Vector(on_screen(centre))).length  # per metre
    radius = 0.6 * bpy.context.preferences.view.gizmo_size / pixels
    turns = [math.radians(200 + 10 * step) for step in range(7)]
    ring = [on_screen(centre + radius * (math.cos(turn) * axes.col[0].xyz + math.sin(turn) * axes.col[1].xyz)) for turn in turns]
    yield from drag(*ring)
    yield "gizmo_hue"
    hue = bpy.data.objects["Light Edit Exit"].sluice.hue_shift
    assert abs(hue - math.radians(60)) < 0.1
    undo()
    yield None, 0.5
    assert bpy.data.objects["Light Edit Exit"].sluice.hue_shift == 0 and bpy.context.scene["mark"] == 1


def point(x, y):
    """Of a quad's plane, in the Empty's own space."""
    return Vector((x, y, 0))


def head_of(exit_):
    """Where the arrow's head is at intensity 1."""
    from sluice import gizmos
    axes, centre = gizmos._frame(exit_)
    return centre + gizmos._arrow_axes(axes, centre, area('VIEW_3D').spaces.active.region_3d).col[2].xyz * gizmos._get_intensity()


def layers_steps():
    """A layer from the button, one step of undo; another whose expression ends too early."""
    show('VIEW_LAYER')
    bpy.ops.sluice.add_layer()
    bpy.ops.ed.undo_push(message="first layer")
    bpy.ops.sluice.add_layer()
    bpy.ops.ed.undo_push(message="second layer")
    layers = bpy.context.view_layer.sluice.layers
    layers[0].name, layers[0].expression = "Caustics", "L.*S+D[SF]*E"
    layers[1].name, layers[1].expression = "Moved", "L.*F'Light Edit'.*E"
    bpy.ops.ed.undo_push(message="what they show")
    yield "layers"
    layers[1].expression = "L.*F'Light Edit'"
    yield "layers_error"
    assert len(layers) == 2
    for left in (2, 1):
        undo()
        yield None, 0.5
        assert len(bpy.context.view_layer.sluice.layers) == left
    assert bpy.context.view_layer.sluice.layers[0].name == "Layer"


def rendered_steps():
    """Rendered mode with Blender's own lists of updates: the scene is copied for things alone."""
    from sluice import viewport
    copies = []
    copy_all = viewport._copy_all
    viewport._copy_all = lambda *arguments: copies.append(copy_all(*arguments))
    bpy.data.objects["Light Edit"].sluice.expression, bpy.data.objects["Light Edit"].sluice.amount = "L", 1
    space = area('VIEW_3D').spaces.active
    space.shading.type, space.overlay.show_overlays = 'RENDERED', False
    yield None, 4
    yield "followed_before"
    exit_, wall = bpy.data.objects["Light Edit Exit"], bpy.data.objects["Wall"]
    assert len(copies) == 1
    for change in (lambda: setattr(exit_, "location", exit_.location + Vector((0, 0, 0.3))), lambda: setattr(exit_.sluice, "intensity", 3),
                   lambda: setattr(bpy.context.scene.sluice, "photons", 150000), lambda: exit_.select_set(True),
                   lambda: setattr(bpy.context.scene.sluice, "use_edits", False), lambda: setattr(bpy.context.scene.sluice, "use_edits", True),
                   lambda: setattr(space.region_3d, "view_distance", 10)):  # fmt: skip
        change()
        yield None, 0.3
    assert len(copies) == 1
    yield None, 3
    yield "followed"
    for count, change in enumerate((lambda: wall.hide_set(True), lambda: wall.hide_set(False), lambda: setattr(wall, "location", (0, 3.2, 3)),
                                    lambda: setattr(bpy.data.objects["Area"].data, "energy", 200)), 2):  # fmt: skip
        change()
        yield None, 0.5
        assert len(copies) == count
    viewport._copy_all, space.region_3d.view_distance = copy_all, 11
    space.shading.type, space.overlay.show_overlays = 'SOLID', True
    yield None


def views_steps():
    """Quad view: each of the four looks its own way, at light that it renders itself. Playback and undo compile no thing anew."""
    from sluice import viewport
    views, draw = {}, viewport.draw

    def note(engine, context, depsgraph):
        draw(engine, context, depsgraph)
        views[context.region.as_pointer()] = engine.view

    viewport.draw = note
    space, exit_, scene = area('VIEW_3D').spaces.active, bpy.data.objects["Light Edit Exit"], bpy.context.scene
    with in_view():
        bpy.ops.screen.region_quadview()
    space.shading.type, space.overlay.show_overlays = 'RENDERED', False
    yield "quad", 6
    assert len(views) == len(set(views.values())) == len({view.seen for view in views.values()}) == 4
    assert all(view.texture is not None for view in views.values())
    bases = [view.base for view in views.values()]
    for frame, height in ((1, 2), (9, 2.6)):
        exit_.location.z = height
        exit_.keyframe_insert("location", frame=frame)
    scene.frame_end = 9
    with in_view():
        bpy.ops.screen.animation_play()
    yield None, 1.5
    with in_view():
        bpy.ops.screen.animation_cancel()
    bpy.ops.ed.undo_push(message="played")
    exit_.sluice.intensity = 5
    bpy.ops.ed.undo_push(message="brighter")
    yield None, 0.5
    bpy.ops.ed.undo()
    yield None, 1
    bpy.data.objects["Light Edit Exit"].animation_data_clear()
    assert [view.base for view in views.values()] == bases
    viewport.draw = draw
    with in_view():
        bpy.ops.screen.region_quadview()
    space.shading.type, space.overlay.show_overlays = 'SOLID', True
    yield None


def list_steps():
    """A render tells each edit's figures; one of the edits finds no light."""
    scene = bpy.context.scene
    scene.cursor.location = (-2, -2, 0)
    bpy.ops.sluice.add_edit(expression="LS'Wall'S'Wall'", size=0.5)
    bpy.context.object.location.z = 1
    bpy.data.objects["Light Edit"].sluice.expression = "L"
    bpy.ops.object.camera_add(location=(7, -7, 5), rotation=(1.1, 0, 0.8))
    scene.camera = bpy.context.object
    scene.render.resolution_x, scene.render.resolution_y = 96, 54
    scene.sluice.passes, scene.sluice.photons = 8, 20000
    bpy.ops.render.render()
    bpy.ops.sluice.select_one(name="Light Edit")
    show('DATA')
    yield "figures", 0.5
    bpy.ops.sluice.select_one(name="Light Edit.001")
    yield "no_match", 0.5
    show('SCENE')
    area('VIEW_3D').spaces.active.show_region_ui = True
    bpy.ops.sluice.solo_edit(name="Light Edit.001")
    yield "list", 0.5


main(steps)
