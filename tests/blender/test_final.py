# SPDX-License-Identifier: GPL-3.0-or-later
"""The final render's protocol with Blender, with a stand-in core: what a failure does, what is written, what is said."""
import subprocess

import bpy
import numpy as np
import pytest
from blender_scenes import ask_for_all_passes, channels, oiiotool, save, write_layers
from stand_ins import Engine, job_of_engine


@pytest.fixture
def rendered(edited_scene, fake_core, tmp_path):
    """rendered(): renders the scene in this process and returns {pass: (h, w, channels)} read back from the EXR file."""
    def run(name="image"):
        path = tmp_path / f"{name}.exr"
        write_layers(edited_scene)
        edited_scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        return path
    return run


# --- failures ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", ["-f 1", "-a"])
def test_an_expression_error_stops_the_render(edited_scene, launch, tmp_path, how):
    bpy.data.objects["Light Edit"].sluice.expression = "L(S"
    done = launch(save(tmp_path), "-o", tmp_path / "out" / "frame_", "-F", "PNG", *how.split())
    assert done.returncode != 0
    assert "sluice: error: Light Edit: column 4: a parenthesis is open; write )\n" in done.stderr
    assert not list(tmp_path.rglob("frame_*"))


@pytest.mark.parametrize("how", ["-f 1", "-a"])
def test_warnings_let_the_render_go_on(edited_scene, launch, tmp_path, how):
    edited_scene.objects["Light Edit"].scale = (0, 1, 1)
    edited_scene.objects["Light Edit Exit"].sluice.entry = None
    done = launch(save(tmp_path), "-o", tmp_path / "out" / "frame_", "-F", "PNG", *how.split())
    assert done.returncode == 0
    for item in ("Light Edit: the quad has no area; the edit is off", "Light Edit Exit: this exit has no entry"):
        assert f"sluice: warning: {item}" in done.stderr
        assert f"Sluice: {item}" in done.stdout  # Blender's own report
    assert len(list(tmp_path.rglob("frame_*"))) == (1 if how == "-f 1" else 2)


def test_a_failure_keeps_the_warnings(edited_scene, launch, tmp_path):
    """They may say why."""
    edited_scene.objects["Light Edit"].scale = (0, 1, 1)
    edited_scene.objects["Light Edit"].sluice.expression = "L(S"
    done = launch(save(tmp_path), "-o", tmp_path / "frame_", "-f", 1)
    assert done.returncode != 0 and "sluice: error: Light Edit: column 4" in done.stderr
    assert "sluice: warning: Light Edit: the quad has no area" in done.stderr


def test_no_camera_is_blenders_own_error(edited_scene, launch, tmp_path):
    edited_scene.camera = None
    done = launch(save(tmp_path), "-o", tmp_path / "frame_", "-f", 1)
    assert done.returncode != 0 and "no camera" in done.stdout and not list(tmp_path.glob("frame_*"))


def test_no_core_is_one_sentence(edited_scene, launch, tmp_path):
    done = launch(save(tmp_path), "-o", tmp_path / "frame_", "-f", 1, core=tmp_path)
    assert done.returncode != 0 and "core is not built" in done.stderr and not list(tmp_path.glob("frame_*"))


@pytest.mark.parametrize("content, sentence", [("__version__ = '9.9.9'", "is version 9.9.9"), ("import nowhere", "does not load")])
def test_a_core_that_does_not_fit_is_one_sentence(edited_scene, launch, tmp_path, content, sentence):
    (tmp_path / "sluice_core.py").write_text(content)
    done = launch(save(tmp_path), "-o", tmp_path / "frame_", "-f", 1, core=tmp_path)
    assert done.returncode != 0 and sentence in done.stderr and not list(tmp_path.glob("frame_*"))


@pytest.mark.parametrize("place", ["export", "start", "snapshot", "statistics"])
def test_whatever_raises_becomes_a_failure(edited_scene, fake_core, monkeypatch, tmp_path, place):
    """A bug of ours must not write a black frame."""
    def fail(*_, **__):
        raise RuntimeError("a bug")
    if place == "export":
        from sluice.export import geometry
        monkeypatch.setattr(geometry, "export_mesh", fail)
    else:
        monkeypatch.setattr(fake_core.Session, place, fail)
    edited_scene.render.filepath = str(tmp_path / "frame.png")
    with pytest.raises(RuntimeError, match="internal error: RuntimeError: a bug"):
        bpy.ops.render.render(write_still=True)
    assert not list(tmp_path.glob("frame*"))


def test_an_error_in_one_view_layer_is_an_error(edited_scene, fake_core, tmp_path):
    """The bad edit is excluded from the first layer only."""
    collection = bpy.data.collections.new("Bad")
    edited_scene.collection.children.link(collection)
    entry = edited_scene.objects["Light Edit"]
    collection.objects.link(entry)
    edited_scene.collection.objects.unlink(entry)
    entry.sluice.expression = "L)"
    edited_scene.view_layers[0].layer_collection.children["Bad"].exclude = True
    edited_scene.render.filepath = str(tmp_path / "frame.png")
    bpy.ops.render.render(write_still=True)
    assert len(list(tmp_path.glob("frame*"))) == 1
    edited_scene.view_layers.new("Second")
    edited_scene.render.filepath = str(tmp_path / "other.png")
    with pytest.raises(RuntimeError, match="column 2"):
        bpy.ops.render.render(write_still=True)
    assert not list(tmp_path.glob("other*"))


# --- what is written ---------------------------------------------------------------------------------------------------------


def test_every_pass_reaches_the_file(rendered, edited_scene, fake_core):
    ask_for_all_passes(edited_scene)
    found = channels(rendered())
    expected = {f"ViewLayer.{name}.{channel}" for name, letters in fake_core.passes for channel in letters}
    assert set(found) == expected
    rows, columns = np.mgrid[0:30, 0:40]
    for name, pixels in found.items():
        assert pixels.shape == (30, 40)
        _layer, render_pass, channel = name.split(".")
        value = rows / 30 + 10 * columns / 40 + len(render_pass)
        if render_pass == "Combined":
            value = np.ones_like(value) if channel == "A" else value / 20
        np.testing.assert_allclose(pixels, value, atol=1e-4, err_msg=name)


def test_the_header_tells_what_made_the_image(rendered, edited_scene):
    edited_scene.sluice.seed = 7
    header = oiiotool("--info", "-v", rendered())
    for line in ('Sluice seed: "7"', 'Sluice passes: "3"', 'Sluice photons: "3000"', 'Sluice stop: "passes"',
                 'Sluice film hash: "0123456789abcdef"', 'Sluice version: "0.1.0"', 'Sluice frame: "1"', 'Sluice warnings: "0"',
                 'Sluice error: "12.5 %"', 'Sluice noise: "10 %"', 'Sluice bias: "7.5 %"'):
        assert line in header


@pytest.mark.parametrize("crop", [False, True])
def test_a_border_is_the_crop_of_the_full_frame(rendered, edited_scene, crop):
    render = edited_scene.render
    full = channels(rendered("full"))
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.21, 0.68, 0.13, 0.9
    part = channels(rendered("part"))
    x0, x1, y0, y1 = int(0.21 * 40), int(0.68 * 40), int(0.13 * 30), int(0.9 * 30)
    for name, pixels in part.items():
        inside = pixels if crop else pixels[y0:y1, x0:x1]
        np.testing.assert_array_equal(inside, full[name][y0:y1, x0:x1], err_msg=name)


@pytest.mark.parametrize("percentage", [50, 33])
def test_resolution_percentage(rendered, edited_scene, percentage):
    edited_scene.render.resolution_percentage, bpy.context.view_layer.use_pass_z = percentage, True
    depth = channels(rendered())["ViewLayer.Depth.Z"]
    assert depth.shape == (30 * percentage // 100, 40 * percentage // 100)


def test_frame_and_film_reach_the_core(edited_scene, fake_core):
    render = edited_scene.render
    render.pixel_aspect_x, render.film_transparent, edited_scene.sluice.use_caustics = 1.5, True, False
    bpy.ops.render.render()
    assert fake_core.last_description["frame"]["pixel_aspect_x"] == 1.5
    assert fake_core.last_settings["film_transparent"] and not fake_core.last_settings["use_caustics"]


def test_view_layers_show_their_own_objects(edited_scene, fake_core, monkeypatch):
    collection = bpy.data.collections.new("Extra")
    edited_scene.collection.children.link(collection)
    collection.objects.link(bpy.data.objects.new("Second", bpy.data.meshes["Cube"]))
    edited_scene.view_layers.new("Other").layer_collection.children["Extra"].exclude = True
    seen = []
    start = fake_core.Session.start
    monkeypatch.setattr(fake_core.Session, "start", lambda self, description, settings: (
        seen.append(sorted(item["names"][0] for item in description["instances"])), start(self, description, settings)))
    bpy.ops.render.render()
    assert seen == [["Cube", "Second"], ["Cube"]]


def test_the_camera_may_be_overridden_by_a_marker(edited_scene, fake_core, new_object):
    other = new_object("Other Camera", bpy.data.cameras.new("Other"))
    edited_scene.timeline_markers.new("m", frame=1).camera = other
    edited_scene.frame_set(1)
    bpy.ops.render.render()
    assert fake_core.last_description["camera"]["name"] == "Other Camera"


# --- stopping ----------------------------------------------------------------------------------------------------------------


def test_esc_keeps_the_partial_image_and_is_quick(fake_core):
    import time

    from sluice import final
    engine = Engine(escape_after=2)
    engine.job = job_of_engine()
    begin = time.monotonic()
    final.render(engine)
    assert time.monotonic() - begin < 0.5
    (_end, result), = [said for said in engine.said if said[0] == "end"]
    assert all(item.rect.stored is not None for item in result.layers[0].passes)
    assert not any(said[0] == {'ERROR'} for said in engine.said)


def test_an_interrupt_in_background_writes_nothing(edited_scene, tmp_path):
    """Ctrl-C on a farm: Blender ends soon, with a code, without a file."""
    import os
    import signal
    import time

    from conftest import HERE
    edited_scene.sluice.passes = 10**7
    command = [bpy.app.binary_path, "--factory-startup", "-b", "--addons", "sluice", save(tmp_path), "-o", tmp_path / "frame_", "-f", "1"]
    blender = subprocess.Popen([str(part) for part in command], env=dict(os.environ, SLUICE_CORE=str(HERE / "fakes")),
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    said = next((line for line in blender.stdout if "Pass" in line), "")  # it renders
    blender.send_signal(signal.SIGINT)
    begin = time.monotonic()
    rest, _none = blender.communicate(timeout=30)
    assert said and blender.returncode != 0 and not list(tmp_path.glob("frame_*")), rest
    assert time.monotonic() - begin < 5 and "sluice: cancelled" in rest


def test_esc_before_the_first_image_ends_without_one(fake_core):
    from sluice import final
    engine = Engine(escape_after=0)
    engine.job = job_of_engine()
    engine.job.settings["photons"] = 10**9  # one pass takes 10 s
    final.render(engine)
    assert engine.said == []


def test_esc_while_the_scene_is_copied(edited_scene, fake_core):
    from sluice import final
    engine = Engine(escape_after=0)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    final.update(engine, bpy.data, depsgraph)
    assert engine.job.cancelled
    final.render(engine)
    assert engine.said == []


def test_the_time_limit_is_told(fake_core, capsys):
    from sluice import final
    engine = Engine()
    engine.job = job_of_engine()
    engine.job.settings["time_limit"] = 0.05
    final.render(engine)
    assert any(said[0] == {'INFO'} and "time limit" in said[1] for said in engine.said)
    assert "sluice: stopped by the time limit" in capsys.readouterr().out


def test_previews_are_quiet_and_small(fake_core, capsys):
    from sluice import final
    engine = Engine()
    engine.is_preview, engine.job = True, job_of_engine()
    engine.job.failure = final.Failure("no")
    final.render(engine)
    assert engine.said == [] and capsys.readouterr().err == ""


def test_sessions_are_stopped_by_unregister(fake_core):
    from sluice import core
    session = core.new_session()
    session.start(job_of_engine().description, job_of_engine().settings)
    core.stop_all()
    assert session.progress()["state"] == 'cancelled'
    core.stop_all()
