# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes: which there are and of which kind, who asks for them (switches, links in the compositor), and that a picture has those and
no others. With the stand-in core, some with the real one."""
from types import SimpleNamespace

import bpy
import pytest
from blender_scenes import ask_for_all_passes, channels, compositor_of, save, write_layers

ALWAYS = {"Combined"}


@pytest.fixture
def made(edited_scene, tmp_path):
    """made(): the passes of an F12, as the file has them."""
    def run():
        write_layers(edited_scene)
        edited_scene.render.filepath = str(tmp_path / "image.exr")
        bpy.ops.render.render(write_still=True)
        return {name.split(".")[1] for name in channels(tmp_path / "image.exr")}
    return run


def render_layers(scene, layer="ViewLayer"):
    """A Render Layers node, and a node that takes what is linked from it."""
    nodes = compositor_of(scene).nodes
    nodes.clear()
    node = nodes.new('CompositorNodeRLayers')
    node.scene, node.layer = scene, layer
    return node, nodes.new('CompositorNodeViewer')


def sockets(node):
    bpy.context.view_layer.update()
    return {socket.name for socket in node.outputs if socket.enabled} - {"Image", "Alpha"}


def test_a_new_file_has_combined_and_noise(made, fake_core):
    assert made() == {"Combined", "Noise"} and fake_core.last_settings["render_passes"] == ["Combined", "Noise"]
    bpy.context.view_layer.sluice.use_pass_noise = False
    assert made() == ALWAYS


@pytest.mark.parametrize(("switch", "name"), [("use_pass_z", "Depth"), ("use_pass_normal", "Normal")])
def test_blenders_own_switches(made, fake_core, switch, name):
    setattr(bpy.context.view_layer, switch, True)
    assert made() == {"Combined", "Noise", name} and fake_core.last_settings["render_passes"] == ["Combined", name, "Noise"]


def test_a_switch_each(made, fake_core):
    settings = bpy.context.view_layer.sluice
    settings.use_pass_direct = settings.use_pass_bias = True
    assert made() == {"Combined", "Noise", "Direct", "Bias"}
    settings.use_pass_direct = False
    assert made() == {"Combined", "Noise", "Bias"}


def test_sockets_follow_the_switches(edited_scene, fake_core):
    node, _viewer = render_layers(edited_scene)
    assert sockets(node) == {"Noise"}
    bpy.context.view_layer.sluice.use_pass_direct = bpy.context.view_layer.use_pass_z = True
    assert sockets(node) == {"Noise", "Direct", "Depth"}
    bpy.context.view_layer.sluice.use_pass_noise = False
    assert sockets(node) == {"Direct", "Depth"}
    ask_for_all_passes(edited_scene)
    assert sockets(node) == {name for name, _channels in fake_core.passes[1:]}


def test_a_link_asks_too(edited_scene, made, fake_core, tmp_path):
    """As in files from before there were switches: they have the link and no switch."""
    node, viewer = render_layers(edited_scene)
    bpy.context.view_layer.sluice.use_pass_direct = True
    node.id_data.links.new(node.outputs["Direct"], viewer.inputs[0])
    bpy.context.view_layer.sluice.use_pass_direct = False
    assert "Direct" in sockets(node) and made() == {"Combined", "Noise", "Direct"}
    bpy.ops.wm.open_mainfile(filepath=str(save(tmp_path)))
    bpy.ops.render.render()
    assert "Direct" in fake_core.last_settings["render_passes"]
    scene = bpy.context.scene
    tree = scene.compositing_node_group if hasattr(scene, "compositing_node_group") else scene.node_tree
    tree.links.remove(tree.links[0])
    bpy.ops.render.render()
    assert fake_core.last_settings["render_passes"] == ["Combined", "Noise"]


def test_links_of_other_view_layers_and_scenes_do_not_ask(edited_scene, fake_core):
    from sluice.passes import linked
    edited_scene.view_layers.new("Second")
    node, viewer = render_layers(edited_scene, "Second")
    edited_scene.view_layers["Second"].use_pass_z = True
    bpy.context.view_layer.update()
    node.id_data.links.new(node.outputs["Depth"], viewer.inputs[0])
    assert linked(edited_scene, "Second") == {"Depth"} and linked(edited_scene, "ViewLayer") == set()
    assert linked(bpy.data.scenes.new("Other"), "Second") == set()
    ask = []
    engine = SimpleNamespace(register_pass=lambda *told: ask.append(told[2]))
    from sluice import passes
    passes.register_passes(engine, edited_scene, edited_scene.view_layers["ViewLayer"])
    assert ask == ["Combined", "Noise"]


def test_the_compositor_of_another_scene_asks(edited_scene, fake_core):
    from sluice.passes import linked
    node, viewer = render_layers(bpy.data.scenes.new("Other"))
    node.scene, node.layer = edited_scene, "ViewLayer"
    node.id_data.links.new(next(socket for socket in node.outputs if socket.name == "Image"), viewer.inputs[0])
    assert linked(edited_scene, "ViewLayer") == {"Image"}


def test_previews_and_the_viewport_ask_for_combined_alone(edited_scene, fake_core):
    from sluice import final, viewport
    from stand_ins import Engine
    ask_for_all_passes(edited_scene)
    bpy.context.view_layer.sluice.layers.add().name = "Key"
    engine, depsgraph = Engine(), bpy.context.evaluated_depsgraph_get()
    engine.is_preview = True
    final.update(engine, bpy.data, depsgraph)
    assert [item.name for item in engine.job.passes] == ["Combined"] and engine.job.settings["render_passes"] == []
    assert "layers" not in engine.job.description
    assert viewport._settings(depsgraph)["render_passes"] == []


def test_the_log_says_who_asks(edited_scene, fake_core, capsys):
    bpy.context.view_layer.use_pass_z = True
    bpy.context.view_layer.sluice.layers.add().name = "Key"
    bpy.ops.render.render()
    assert ("render passes: Combined (always there), Depth (switched on), Noise (switched on), Key (a light layer)\n") in capsys.readouterr().out


def test_switches_are_keyframed_kept_and_undone(tmp_path):
    settings = bpy.context.view_layer.sluice
    settings.use_pass_bias = True
    bpy.ops.wm.open_mainfile(filepath=str(save(tmp_path)))
    assert bpy.context.view_layer.sluice.use_pass_bias and bpy.context.view_layer.sluice.use_pass_noise
    bpy.ops.ed.undo_push(message="before")
    bpy.context.view_layer.sluice.use_pass_bias = False
    bpy.ops.ed.undo_push(message="switched off")
    bpy.ops.ed.undo()
    assert bpy.context.view_layer.sluice.use_pass_bias


def test_a_new_pass_of_the_core_needs_nothing_of_the_addon(made, fake_core, monkeypatch):
    """It is always there, until it gets a switch."""
    from sluice.passes import clean_name, fixed_passes
    monkeypatch.setattr(fake_core, "passes", (*fake_core.passes, ("Glow", "RGB"), ("Speed", "XYZ"), ("Age", "X")))
    kinds = {item.name: item.kind for item in fixed_passes()}
    assert kinds["Combined"] == kinds["Glow"] == 'COLOR' and kinds["Normal"] == kinds["Speed"] == 'VECTOR'
    assert kinds["Depth"] == kinds["Noise"] == kinds["Age"] == 'VALUE'
    assert made() == {"Combined", "Noise", "Glow", "Speed", "Age"}
    assert clean_name("Glow") == "Glow 2"


def test_without_a_core_combined_is_there_alone(edited_scene, monkeypatch):
    from sluice import core, passes

    def fail():
        raise core.CoreMissing("there is none")

    monkeypatch.setattr(core, "load", fail)
    registered = []
    engine = SimpleNamespace(register_pass=lambda *told: registered.append(told[2:]))
    passes.register_passes(engine, edited_scene, bpy.context.view_layer)
    assert registered == [("Combined", 4, "RGBA", 'COLOR')]


def test_the_real_cores_passes_have_their_kinds(core):
    from sluice.passes import COMBINED, fixed_passes
    found = fixed_passes()
    assert found[0] == COMBINED and [item.name for item in found if item.kind == 'VALUE'] == ["Depth", "Noise", "Bias"]
    assert [item.name for item in found if item.kind == 'VECTOR'] == ["Normal"] and len(found) == len(core.passes)


def test_blenders_panel_of_passes_stays_away():
    """It shows options that have no effect here."""
    for panel in bpy.types.Panel.__subclasses__():
        if "passes" in panel.__name__.lower() and not panel.__module__.startswith("sluice."):
            assert 'SLUICE' not in getattr(panel, "COMPAT_ENGINES", ()), panel.__name__
