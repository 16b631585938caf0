# SPDX-License-Identifier: GPL-3.0-or-later
"""Light layers: their names, their list, sockets in the compositor, and that they reach the file, from the stand-in core and the real one."""
import bpy
import numpy as np
import pytest
from blender_scenes import compositor_of, save


def add(name, expression="L.*E"):
    layer = bpy.context.view_layer.sluice.layers.add()
    layer.name, layer.expression = name, expression
    return layer


@pytest.mark.parametrize(("name", "clean"), [
    ("Key light", "Key light"), (" a.b\tc\n", "a b c"), ("", "Layer"), ("...", "Layer"), ("Direct", "Direct 2"), ("Image", "Image 2"),
    ("é" * 30, "é" * 20), ("x" * 60, "x" * 40), ("Taken", "Taken 3"), ("y" * 40, "y" * 36 + " 2")])  # fmt: skip
def test_clean_names(fake_core, name, clean):
    from sluice.passes import clean_name
    assert clean_name(name, {"Taken", "Taken 2", "y" * 40}) == clean
    assert clean_name(clean) == clean


def test_a_new_name_makes_way_for_the_others(capsys):
    first, second = add("Key"), add("Key")
    assert "Light layer 'Key' is called 'Key 2' now" in capsys.readouterr().out
    assert (first.name, second.name) == ("Key", "Key 2")
    first.name = "Key 2"
    assert (first.name, second.name) == ("Key 2 2", "Key 2")
    first.name = "Depth.x"
    assert first.name == "Depth x"


def test_names_that_scripts_leave_out():
    from sluice.passes import export_layers
    layers = bpy.context.view_layer.sluice.layers
    layers.add(), layers.add()
    assert [item["name"] for item in export_layers(bpy.context.view_layer)] == ["Layer", "Layer 2"]


def test_the_list():
    settings = bpy.context.view_layer.sluice
    assert not bpy.ops.sluice.remove_layer.poll()
    for _ in range(3):
        bpy.ops.sluice.add_layer()
    assert [item.name for item in settings.layers] == ["Layer", "Layer 2", "Layer 3"] and settings.active_layer == 2
    bpy.ops.sluice.move_layer(direction='UP')
    assert [item.name for item in settings.layers] == ["Layer", "Layer 3", "Layer 2"] and settings.active_layer == 1
    bpy.ops.sluice.remove_layer()
    assert [item.name for item in settings.layers] == ["Layer", "Layer 2"] and settings.active_layer == 1
    bpy.ops.sluice.remove_layer()
    bpy.ops.sluice.remove_layer()
    assert not settings.layers and settings.active_layer == 0


def test_sockets_follow_the_list(edited_scene, fake_core):
    node = compositor_of(edited_scene).nodes.new('CompositorNodeRLayers')
    node.scene = edited_scene

    def sockets():
        bpy.context.view_layer.update()
        return {socket.name for socket in node.outputs if socket.enabled}

    layer = add("Key")
    assert "Key" in sockets()
    layer.name = "Fill"
    assert "Fill" in sockets() and "Key" not in sockets()
    bpy.ops.sluice.remove_layer()
    assert "Fill" not in sockets()


def test_only_their_own_view_layer_has_them(edited_scene, fake_core, monkeypatch):
    seen, start = [], fake_core.Session.start

    def note(session, description, settings):
        seen.append(description["layers"])
        start(session, description, settings)

    monkeypatch.setattr(fake_core.Session, "start", note)
    add("Key", "L'Key'.*E")
    edited_scene.view_layers.new("Second").sluice.layers.add().name = "Other"
    bpy.ops.render.render()
    assert seen == [[{"name": "Key", "expression": "L'Key'.*E"}], [{"name": "Other", "expression": "L.*E"}]]


def test_the_view_shows_none(edited_scene, fake_core):
    from types import SimpleNamespace

    from sluice import viewport
    add("Key")
    engine = SimpleNamespace(view=None, update_stats=print, tag_redraw=print)
    viewport.update(engine, bpy.context, bpy.context.evaluated_depsgraph_get())
    assert not engine.view.description.get("layers")


# --- with the real core --------------------------------------------------------------------------------------------------------------


def test_layers_are_in_the_file_and_sum_to_the_picture(room, picture):
    plain = picture("plain")
    for name, expression in {"Untouched": "L!F*E", "Moved by Entry": "L.*F'Entry'.*E", "Through the ball": "L.*S'Ball'.*E"}.items():
        add(name, expression)
    found = picture()
    for channel in "RGB":
        combined, moved = found[f"Combined.{channel}"], found[f"Moved by Entry.{channel}"]
        np.testing.assert_array_equal(combined, plain[f"Combined.{channel}"])
        np.testing.assert_allclose(found[f"Untouched.{channel}"] + moved, combined, atol=1e-4 * combined.mean())
        assert moved.sum() >= 0.99 * found[f"Edited.{channel}"].sum() > 0
        assert 0 < found[f"Through the ball.{channel}"].sum() < combined.sum()


@pytest.mark.parametrize("how", ["-f 1", "-a"])
def test_a_bad_expression_stops_the_render(room, core, launch, tmp_path, how):
    add("Good"), add("Half", "L.*D")
    room.frame_end = 1
    done = launch(save(tmp_path), "-o", tmp_path / "out" / "frame_", "-F", "PNG", *how.split(), core=core.__file__)
    assert done.returncode != 0 and "sluice: error: layer 'Half': column 4: " in done.stderr and "write E last" in done.stderr
    assert not list(tmp_path.rglob("frame_*"))


def test_an_unknown_name_is_said(room, core, capfd):
    add("Moved", "L.*F'Entri'.*E")
    bpy.ops.render.render()
    assert "sluice: warning: layer 'Moved': no edit or collection is named 'Entri'; the nearest name is 'Entry'" in capfd.readouterr().err
