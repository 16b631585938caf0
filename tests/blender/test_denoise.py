# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising: the Denoise node in the compositor, where Blender has one that works, and the Python package, of which a stand-in is on the path."""
import json
import sys
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from blender_scenes import channels, compositor_of, oiiotool, write_layers

DENOISE, LAYERS = 'CompositorNodeDenoise', 'CompositorNodeRLayers'
STAND_IN = """
import json, sys
def denoise(color, albedo=None, normal=None, *, hdr=False):
    print("not a number of the picture")
    with open({told!r}, "w") as file:
        json.dump([[] if image is None else list(image.shape) for image in (color, albedo, normal)] + [hdr], file)
    {body}
"""


@pytest.fixture
def package(monkeypatch, tmp_path):
    """package(body): the stand-in of pyoidn is there, with this body. Returns the file that tells what it was given."""
    def make(body="return 1 - color"):
        told = tmp_path / "told.json"
        (tmp_path / "pyoidn.py").write_text(STAND_IN.format(told=str(told), body=body))
        monkeypatch.syspath_prepend(str(tmp_path))
        return told
    return make


@pytest.fixture
def no_package(monkeypatch):
    """As where nobody has installed it."""
    from sluice import denoising
    monkeypatch.setattr(denoising, "PACKAGE", "pyoidn_of_nobody")


@pytest.fixture
def node_works(monkeypatch, fake_core):
    """As in a Blender with OpenImageDenoise."""
    from sluice import compat
    monkeypatch.setattr(compat, "has_denoise_node", lambda: True)


@pytest.fixture
def rendered(edited_scene, tmp_path):
    """rendered(): the channels of an F12's file, by pass and channel, and its header."""
    def run():
        write_layers(edited_scene)
        edited_scene.render.use_compositing = False
        edited_scene.render.filepath = str(tmp_path / "image.exr")
        bpy.ops.render.render(write_still=True)
        found = {name.split(".", 1)[1]: pixels for name, pixels in channels(tmp_path / "image.exr").items()}
        return found, oiiotool("--info", "-v", tmp_path / "image.exr")
    return run


def set_up():
    """What the operator returns and says."""
    from sluice.denoise_operator import SLUICE_OT_set_up_denoising
    said = []
    result = SLUICE_OT_set_up_denoising.execute(SimpleNamespace(report=lambda *told: said.append(told)), bpy.context)
    return result, said


def tree_of(scene):
    return scene.compositing_node_group if hasattr(scene, "compositing_node_group") else scene.node_tree


def links(scene):
    """(node, socket, node, socket) of each link."""
    return sorted((link.from_node.name, link.from_socket.name, link.to_node.name, link.to_socket.name) for link in tree_of(scene).links)


def output_of(scene):
    return 'NodeGroupOutput' if hasattr(scene, "compositing_node_group") else 'CompositorNodeComposite'


def small_compositor(scene):
    """A compositor as users have it: (tree, Render Layers, the output), nothing linked yet."""
    tree = compositor_of(scene)
    tree.nodes.clear()
    if hasattr(scene, "compositing_node_group") and not tree.interface.items_tree:
        tree.interface.new_socket("Image", in_out='OUTPUT', socket_type='NodeSocketColor')
    return tree, tree.nodes.new(LAYERS), tree.nodes.new(output_of(scene))


def image_of(node):
    return next(socket for socket in node.outputs if socket.name == "Image")


# --- the compositor ----------------------------------------------------------------------------------------------------------


def test_this_blender_tells_whether_its_node_works():
    import _cycles
    from sluice import compat
    assert compat.has_denoise_node() == _cycles.with_openimagedenoise


def test_one_click_in_a_new_file(node_works):
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    assert set_up() == ({'FINISHED'}, [])
    assert view_layer.use_pass_normal and view_layer.sluice.use_pass_albedo and scene.render.use_compositing
    kinds = {(link.from_node.bl_idname, link.from_socket.name, link.to_node.bl_idname, link.to_socket.name) for link in tree_of(scene).links}
    assert kinds == {(LAYERS, name, DENOISE, name) for name in ("Image", "Albedo", "Normal")} | {(DENOISE, "Image", output_of(scene), "Image")}
    before = links(scene), len(tree_of(scene).nodes), [tuple(node.location) for node in tree_of(scene).nodes]
    assert set_up() == ({'FINISHED'}, [])
    assert (links(scene), len(tree_of(scene).nodes), [tuple(node.location) for node in tree_of(scene).nodes]) == before


def test_what_is_linked_stays_behind_the_denoise_node(node_works):
    scene = bpy.context.scene
    tree, source, output = small_compositor(scene)
    blur, viewer = tree.nodes.new('CompositorNodeBlur'), tree.nodes.new('CompositorNodeViewer')
    tree.links.new(image_of(source), blur.inputs[0])
    tree.links.new(blur.outputs[0], output.inputs[0])
    tree.links.new(image_of(source), viewer.inputs[0])
    assert set_up() == ({'FINISHED'}, [])
    assert links(scene) == sorted([
        (source.name, "Image", "Denoise", "Image"), (source.name, "Albedo", "Denoise", "Albedo"), (source.name, "Normal", "Denoise", "Normal"),
        ("Denoise", "Image", blur.name, "Image"), (blur.name, "Image", output.name, "Image"), (source.name, "Image", viewer.name, "Image")])
    before = links(scene)
    set_up()
    assert links(scene) == before


def test_a_denoise_node_that_is_there_gets_its_guides(node_works):
    """And a mix of the raw and the denoised picture stays one."""
    scene = bpy.context.scene
    tree, source, output = small_compositor(scene)
    denoise, mix = tree.nodes.new(DENOISE), tree.nodes.new('CompositorNodeAlphaOver')
    pictures = [socket for socket in mix.inputs if socket.type == 'RGBA']
    for way in (denoise.inputs["Image"], pictures[0]):
        tree.links.new(image_of(source), way)
    tree.links.new(denoise.outputs[0], pictures[1])
    tree.links.new(mix.outputs[0], output.inputs[0])
    before = set(links(scene))
    set_up()
    assert set(links(scene)) - before == {(source.name, name, denoise.name, name) for name in ("Albedo", "Normal")} and before <= set(links(scene))


def test_an_output_of_other_things_is_left_alone(node_works):
    scene = bpy.context.scene
    tree, source, output = small_compositor(scene)
    image = tree.nodes.new('CompositorNodeImage')
    image.image = bpy.data.images.new("Plate", 4, 4)
    tree.links.new(image.outputs[0], output.inputs[0])
    for _time in range(2):
        result, said = set_up()
        assert result == {'FINISHED'} and [kind for kind, _text in said] == [{'WARNING'}] and "link the Denoise node's Image" in said[0][1]
        assert (image.name, image.outputs[0].name, output.name, output.inputs[0].name) in links(scene)
        assert sum(node.bl_idname == DENOISE for node in tree.nodes) == 1 and len(links(scene)) == 4


def test_the_node_takes_the_place_of_the_package(node_works):
    bpy.context.view_layer.sluice.use_denoise = True
    set_up()
    assert not bpy.context.view_layer.sluice.use_denoise


def test_undo_is_one_step(node_works):
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.sluice.set_up_denoising('EXEC_DEFAULT', True)
    assert any(node.bl_idname == DENOISE for node in tree_of(bpy.context.scene).nodes)
    bpy.ops.ed.undo()
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    assert not view_layer.use_pass_normal and not view_layer.sluice.use_pass_albedo
    assert tree_of(scene) is None or not any(node.bl_idname == DENOISE for node in tree_of(scene).nodes)


# --- Blenders whose node does nothing ----------------------------------------------------------------------------------------


def test_without_the_node_the_package_is_named(monkeypatch, no_package):
    from sluice import compat
    monkeypatch.setattr(compat, "has_denoise_node", lambda: False)
    result, [(kind, said)] = set_up()
    assert result == {'CANCELLED'} and kind == {'WARNING'} and not bpy.context.view_layer.sluice.use_denoise
    assert "built without OpenImageDenoise" in said and "pip install" in said and "pyoidn_of_nobody" in said
    assert tree_of(bpy.context.scene) is None


def test_without_the_node_the_package_is_used(monkeypatch, package):
    from sluice import compat
    monkeypatch.setattr(compat, "has_denoise_node", lambda: False)
    package()
    result, [(kind, said)] = set_up()
    assert result == {'FINISHED'} and kind == {'INFO'} and "pyoidn" in said and bpy.context.view_layer.sluice.use_denoise


# --- the package -------------------------------------------------------------------------------------------------------------


def test_the_file_has_the_denoised_picture_and_the_raw_one(rendered, package, fake_core, capsys):
    told = package()
    raw, header = rendered()
    assert not told.exists() and "Noisy Image.R" not in raw and "Sluice denoised" not in header
    capsys.readouterr()
    bpy.context.view_layer.sluice.use_denoise = True
    found, header = rendered()
    assert json.loads(told.read_text()) == [[30, 40, 3], [30, 40, 3], [30, 40, 3], True]
    assert set(found) == set(raw) | {f"Noisy Image.{channel}" for channel in "RGBA"}  # without the guides: nobody asked for them
    for channel in "RGBA":
        np.testing.assert_array_equal(found[f"Noisy Image.{channel}"], raw[f"Combined.{channel}"])
        expected = raw["Combined.A"] if channel == "A" else 1 - raw[f"Combined.{channel}"]
        np.testing.assert_allclose(found[f"Combined.{channel}"], expected, atol=1e-6)
    assert fake_core.last_settings["render_passes"] == ["Combined", "Normal", "Albedo", "Noise"]
    said = capsys.readouterr().out
    assert "error before denoising 12 %" in said and ", denoised\n" in said and "Noisy Image (for Denoise)" in said
    assert "Sluice denoised" in header and "Sluice error" in header


def test_the_compositor_gets_the_raw_picture(fake_core):
    """And a light layer makes way for its name."""
    from sluice.passes import clean_name
    scene = bpy.context.scene
    tree = compositor_of(scene)
    source = tree.nodes.new(LAYERS)
    source.scene = scene
    bpy.context.view_layer.sluice.use_denoise = True
    bpy.context.view_layer.update()
    assert "Noisy Image" in {socket.name for socket in source.outputs if socket.enabled}
    bpy.context.view_layer.sluice.use_denoise = False
    bpy.context.view_layer.update()
    assert "Noisy Image" not in {socket.name for socket in source.outputs if socket.enabled}
    assert clean_name("Noisy Image") == "Noisy Image 2"


def test_esc_leaves_the_picture_raw(package, fake_core):
    """Who stops a render does not wait for more."""
    from sluice import final, passes
    from stand_ins import Engine, job_of_engine
    told = package()
    engine = Engine(escape_after=3)
    engine.job = job_of_engine()
    engine.job.denoise, engine.job.passes = True, (*engine.job.passes, passes.NOISY_IMAGE)
    final.render(engine)
    assert not told.exists() and engine.said[-1][0] == "end"


@pytest.mark.parametrize(("body", "why"), [("raise ValueError('no such filter')", "no such filter"), ("return color[:1]", "no picture"),
                                           ("return color * float('nan')", "no picture"), ("import os; os.abort()", "exit code")])
def test_a_package_that_fails_costs_no_picture(rendered, package, fake_core, capsys, body, why):
    raw, _header = rendered()
    package(body)
    bpy.context.view_layer.sluice.use_denoise = True
    capsys.readouterr()
    found, header = rendered()
    said = capsys.readouterr()
    assert why in said.err and "pyoidn" in said.err and "denoised" not in said.out and "Sluice denoised" not in header
    for channel in "RGBA":
        np.testing.assert_array_equal(found[f"Combined.{channel}"], raw[f"Combined.{channel}"])
        np.testing.assert_array_equal(found[f"Noisy Image.{channel}"], raw[f"Combined.{channel}"])


def test_a_missing_package_is_named_and_the_picture_stays_raw(rendered, no_package, fake_core, capsys):
    raw, _header = rendered()
    bpy.context.view_layer.sluice.use_denoise = True
    capsys.readouterr()
    found, _header = rendered()
    said = capsys.readouterr()
    assert "sluice: warning: Denoise: the Python package pyoidn_of_nobody is not there" in said.err and "pip install --target" in said.err
    assert fake_core.last_settings["render_passes"] == ["Combined", "Noise"] and "denoised" not in said.out
    for channel in "RGBA":
        np.testing.assert_array_equal(found[f"Combined.{channel}"], raw[f"Combined.{channel}"])


def test_panels_say_it(package, fake_core, edited_scene):
    """The Accuracy panel and the status line say which picture the error is of."""
    from sluice import render_progress, render_statistics
    package()
    bpy.context.view_layer.sluice.use_denoise = True
    bpy.ops.render.render()
    found = render_statistics.last()
    assert found.denoised
    line = render_progress.line(found.progress, 0, found.denoised)
    assert "| Error before denoising 12 % (" in line and line.endswith("| Denoised")
    assert "Error 12 %" in render_progress.line(found.progress) and "enois" not in render_progress.line(found.progress)


def test_the_real_core_gives_the_guides(room, package, tmp_path):
    """And does not write them where nobody asks. Albedo and Normal come in their order: the floor faces up and is grey."""
    package("import numpy as np; return np.where(np.abs(normal[..., 2:]) > 0.99, albedo, 0)")
    for name in ("albedo", "direct"):
        setattr(bpy.context.view_layer.sluice, f"use_pass_{name}", False)
    bpy.context.view_layer.use_pass_normal, bpy.context.view_layer.sluice.use_denoise = False, True
    write_layers(room)
    room.render.filepath = str(tmp_path / "room.exr")
    bpy.ops.render.render(write_still=True)
    found = {name.split(".", 1)[1]: pixels for name, pixels in channels(tmp_path / "room.exr").items()}
    assert "Noisy Image.R" in found and not any(name.split(".")[0] in {"Albedo", "Normal", "Direct"} for name in found)
    np.testing.assert_allclose(np.median(found["Combined.R"]), 0.8, atol=0.02)
    assert found["Noisy Image.R"].std() > 0


def test_the_real_package():
    """Where it is installed: noise falls, the mean stays."""
    from sluice import denoising
    if not denoising.is_there():
        pytest.skip("pyoidn is not installed")
    random = np.random.default_rng(1)
    flat = np.full((64, 64, 4), 0.5, np.float32)
    flat[..., :3] += random.normal(0, 0.1, (64, 64, 3))
    albedo, normal = np.full((64, 64, 3), 0.5, np.float32), np.zeros((64, 64, 3), np.float32)
    found = denoising.denoise({"Combined": flat, "Albedo": albedo, "Normal": normal})
    assert found[..., :3].std() < flat[..., :3].std() / 3 and abs(found[..., :3].mean() - 0.5) < 0.02
    np.testing.assert_array_equal(found[..., 3], flat[..., 3])


# --- the 3D view -------------------------------------------------------------------------------------------------------------


@pytest.fixture
def window(edited_scene, fake_core, monkeypatch):
    """A view that has not begun: 6 passes of 0.1 s."""
    from sluice import viewport
    from windowless import Window
    edited_scene.sluice.passes, edited_scene.sluice.photons = 6, 10**7
    found = Window(16, 8, edited_scene.camera, monkeypatch.setattr)
    yield found
    viewport.free(found.view)


def shown(window):
    """The pictures that a view shows until it is at rest, each once: the mean of each."""
    import time

    from sluice import viewport
    window.update()
    window.draw()
    found = []
    while not viewport._at_rest(window.view):
        window.draw()
        if window.view.level == 2 and window.view.texture is not None and (not found or window.view.texture is not found[-1]):
            found.append(window.view.texture)
        time.sleep(0.01)
    window.draw()
    return [float(picture[..., 1].mean()) for picture in found]


def test_the_view_is_raw_unless_asked(window, package):
    told = package()
    shown(window)
    assert not told.exists() and window.sessions[-1]._settings["render_passes"] == [] and "enois" not in window.engine.said[-1]


def test_the_view_is_denoised_after_some_passes(window, package):
    told = package("return color * 0 + 5")
    bpy.context.scene.sluice.use_preview_denoise = True
    means = shown(window)
    assert json.loads(told.read_text()) == [[8, 16, 3], [8, 16, 3], [8, 16, 3], True]
    assert [session._settings["render_passes"] for session in window.sessions] == [[], [], ["Albedo", "Normal"]]
    first = means.index(5)
    assert 0 < first and set(means[first:]) == {5}  # Raw ones come before it and none after it.
    assert "| Error before denoising" in window.engine.said[-1] and window.engine.said[-1].endswith("| Denoised")


def test_a_view_whose_package_fails_stays_raw(window, package, capsys):
    package("raise ValueError('no such filter')")
    bpy.context.scene.sluice.use_preview_denoise = True
    assert shown(window)
    assert capsys.readouterr().err.count("no such filter") == 1 and "enois" not in window.engine.said[-1]


def test_a_view_without_the_package_stays_raw(window, no_package):
    bpy.context.scene.sluice.use_preview_denoise = True
    shown(window)
    assert window.sessions[-1]._settings["render_passes"] == [] and "enois" not in window.engine.said[-1]


# --- the report --------------------------------------------------------------------------------------------------------------


def test_a_report_is_made_beside_blender(monkeypatch, tmp_path):
    import time

    from sluice import report_operator as operator
    assert operator.script() in (None, operator.Path(operator.__file__).resolve().parents[1] / "run")
    opened, said, noticed = [], [], []
    monkeypatch.setattr(operator.webbrowser, "open", opened.append)
    monkeypatch.setattr(operator.renaming, "notice", noticed.append)
    (tmp_path / "run").write_text('echo "half way"; [ "$1" = report ] && [ -f "$2" ] && echo "Report: /place/of it/index.html"')
    monkeypatch.setattr(operator, "script", lambda: tmp_path / "run")
    window = SimpleNamespace(report=lambda *told: said.append(told))
    assert operator.SLUICE_OT_make_report.execute(window, bpy.context) == {'CANCELLED'} and "Save the file first" in said[-1][1]

    def make():
        assert operator.SLUICE_OT_make_report.execute(window, bpy.context) == {'FINISHED'} and not bpy.ops.sluice.make_report.poll()
        while operator.look() is not None:
            time.sleep(0.02)
        bpy.app.timers.unregister(operator.look)

    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    make()
    assert opened == ["file:///place/of%20it/index.html"] and noticed == ["The report is done: /place/of it/index.html"]
    assert bpy.ops.sluice.make_report.poll()
    (tmp_path / "run").write_text('echo "report: there is no light" >&2; exit 1')
    make()
    assert len(opened) == 1 and noticed[-1] == "There is no report: report: there is no light"


def test_an_installed_addon_makes_no_report(monkeypatch):
    from sluice import report_operator as operator
    monkeypatch.setattr(operator, "__file__", "/nowhere/addons/sluice/report_operator.py")
    assert operator.script() is None and not bpy.ops.sluice.make_report.poll()
