# SPDX-License-Identifier: GPL-3.0-or-later
"""What will be simulated and why, how accurate the last render was, and the image of its curve; with the stand-in core and the real one."""
import bpy
import numpy as np
import pytest
from blender_scenes import save


def sentences(told):
    return [text for text, _icon in told]


# --- what will be simulated ------------------------------------------------------------------------------------------------------


def test_before_any_render_the_settings_tell_what_they_can(edited_scene):
    from sluice import render_statistics, simulated
    render_statistics.forget()
    edited_scene.sluice.use_caustics = False
    assert sentences(simulated.effects(edited_scene)) == [
        "Direct: switched on", "Caustics: off: switched off above", "Edited light: switched on", "Indirect: switched on",
        "Whether the scene calls for it is found when it is compiled"]
    assert sentences(simulated.edits(edited_scene)) == ["Light Edit: whether light that matches comes here is found by a render"]
    bpy.context.view_layer.sluice.layers.add().name = "Key"
    assert sentences(simulated.layers(bpy.context.view_layer)) == ["Key: how much it shows is found by a render"]
    bpy.context.view_layer.use_pass_z = True
    assert sentences(simulated.render_passes(edited_scene, bpy.context.view_layer)) == [
        "Combined: always there", "Depth: switched on", "Noise: switched on"]


def test_after_a_render_the_scene_tells(room, core):
    from sluice import simulated
    layers = bpy.context.view_layer.sluice.layers
    for name, expression in (("All", "L.*E"), ("None", "LSSSSSSSSDE")):
        layer = layers.add()
        layer.name, layer.expression = name, expression
    bpy.data.objects["Ball"].data.materials.clear()
    bpy.ops.render.render()
    told = dict(text.split(": ", 1) for text in sentences(simulated.effects(room)))
    assert set(told) == {"Direct", "Caustics", "Edited light", "Indirect", "Photons"}
    assert told["Direct"] == "runs: surfaces are lit by lights" and told["Caustics"] == "off: nothing in the scene is specular"
    assert sentences(simulated.edits(room))[0].startswith("Entry: took ")
    assert sentences(simulated.layers(bpy.context.view_layer)) == ["All: 100 % of the picture's light", "None: nothing in the picture matches"]
    room.sluice.use_direct = False
    assert sentences(simulated.effects(room))[0] == "Direct: off: switched off above"
    bpy.ops.render.render()
    assert sentences(simulated.edits(room))[0].startswith("Entry: took ")
    bpy.data.objects["Entry"].sluice.expression = "LS+"  # nothing is specular
    bpy.ops.render.render()
    assert sentences(simulated.edits(room)) == ["Entry: off in the last render: no path of this scene can match its expression"]
    room.sluice.use_direct = True  # what the last render says of it was the switch
    assert sentences(simulated.effects(room))[0] == "Direct: switched on"


def test_switches_of_edits_override_what_was_found(edited_scene, fake_core):
    from sluice import simulated
    entry, settings = edited_scene.objects["Light Edit"], edited_scene.sluice
    entry.sluice.expression = "L(("
    assert "not understood" in sentences(simulated.edits(edited_scene))[0]
    other = bpy.data.objects.new("Other", None)
    edited_scene.collection.objects.link(other)
    other.sluice.role, settings.solo = 'ENTRY', other
    assert sentences(simulated.edits(edited_scene))[0] == "Light Edit: off: Other acts alone (Solo)"
    entry.sluice.enabled = False
    assert sentences(simulated.edits(edited_scene))[0] == "Light Edit: off: not enabled"
    settings.use_edits = False
    assert sentences(simulated.edits(edited_scene)) == [f"{name}: off: Light Edits are switched off above" for name in ("Light Edit", "Other")]


def test_figures_are_gone_with_the_file(room, core, tmp_path):
    from sluice import render_statistics
    bpy.ops.render.render()
    assert render_statistics.last().accuracy and render_statistics.last().effects
    bpy.ops.wm.open_mainfile(filepath=str(save(tmp_path)))
    assert render_statistics.last() == render_statistics.Found()


# --- accuracy --------------------------------------------------------------------------------------------------------------------


ROW = {"pass": 4, "seconds": 2.0, "error": 0.05, "noise": 0.04, "bias": 0.03,
       "parts": [{"name": "Direct", "noise": 0.02, "bias": 0.0}, {"name": "Caustics", "noise": 0.03, "bias": 0.03}, {"name": "Emission", "noise": 0.0, "bias": 0.0}],
       "edits": [{"name": "Move", "noise": 0.01, "bias": 0.0}]}


def test_shares_of_the_error():
    from sluice import render_statistics
    parts, edits = render_statistics.shares(ROW)
    assert [row[0] for row in parts] == ["Caustics", "Direct"] and sum(row[1] for row in parts) == pytest.approx(1)
    assert parts[0][1:] == pytest.approx((18 / 22, 0.03, 0.03)) and edits == [("Move", pytest.approx(1 / 22), 0.01, 0)]


def test_the_curve_shows_what_was_measured():
    from sluice import accuracy_curve
    rows = [{"seconds": 2.0 ** step, "error": 0.2 / 2 ** (step / 2), "noise": 0.1 / 2 ** (step / 2), "bias": 0.01} for step in range(8)]
    pixels = accuracy_curve.draw(rows)
    assert pixels.shape == (accuracy_curve.HEIGHT, accuracy_curve.WIDTH, 4) and pixels.dtype == np.float32 and (pixels[..., 3] == 1).all()
    inside = pixels[50:-40, 80:-20, :3]
    for name, color in accuracy_curve.CURVES:
        where = np.argwhere((np.abs(inside - color) < 1e-3).all(axis=2))
        assert len(where) > 500, name
        rises = where[where[:, 1] < 100][:, 0].mean() - where[where[:, 1] > 400][:, 0].mean()
        assert abs(rises) < 1 if name == "bias" else rises > 50, name  # row 0 is at the bottom


@pytest.mark.parametrize("rows", [
    [], [{"seconds": 1.0, "error": None, "noise": None, "bias": None}], [{"seconds": 1.0, "error": 0.1, "noise": 0.1, "bias": 0.0}],
    [{"seconds": 1e-4, "error": 90.0, "noise": 1e-7, "bias": 0.5}, {"seconds": 1e6, "error": 50.0, "noise": 1e-8, "bias": 0.0}],
], ids=["none", "not known", "one point", "many decades"])
def test_the_curve_of_odd_renders(rows):
    from sluice import accuracy_curve
    assert np.isfinite(accuracy_curve.draw(rows)).all()


def test_the_image(room, core):
    assert not bpy.ops.sluice.show_curve.poll()
    bpy.ops.render.render()
    assert bpy.ops.sluice.show_curve() == {'FINISHED'}
    image = bpy.data.images["Sluice Accuracy"]
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)
    assert pixels.std() > 0.01 and not image.is_dirty
    bpy.ops.sluice.show_curve()
    assert [item.name for item in bpy.data.images if "Accuracy" in item.name] == ["Sluice Accuracy"]
    image.scale(8, 8)
    bpy.ops.sluice.show_curve()
    assert tuple(bpy.data.images["Sluice Accuracy"].size) == (720, 480)
