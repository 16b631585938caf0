# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on with the real core: F12 gives a lit picture, bad input gives sentences, and the same bits come out however it is asked."""
import time

import bpy
import numpy as np
import pytest
from mathutils import Matrix

PARTS = ("Direct", "Caustics", "Edited", "Indirect", "Emission")


def test_f12_shows_a_lit_scene(picture):
    found = picture()
    combined = sum(found[f"Combined.{channel}"] for channel in "RGB")
    assert combined.mean() > 0.1 and np.isfinite(combined).all() and (found["Combined.A"] == 1).all()
    for channel in "RGB":  # the parts sum up to the whole
        total = sum(found[f"{part}.{channel}"] for part in PARTS)
        np.testing.assert_allclose(total, found[f"Combined.{channel}"], rtol=1e-4, atol=1e-5)
    assert found["Edited.R"].sum() > 0 and found["Caustics.R"].sum() > 0 and found["Direct.R"].sum() > 0
    assert 4 < found["Depth.Z"].max() < 5.5  # the floor is 5 m below the camera
    np.testing.assert_allclose(found["Normal.Z"][2, 2], 1, atol=1e-3)


def test_the_edit_takes_light_away_and_lays_it_down(picture, room):
    """Direct light vanishes on the entry, and as much arrives at the exit as edited light."""
    after = picture("after")
    room.sluice.use_edits = False
    before = picture("before")
    assert not (before["Edited.R"] > 0).any()

    def mean(found, name, y):
        """Over the middle of a quad of half side 0.3 m round (0.5, y), seen from 5 m by a 50 mm lens."""
        scale = 48 * 50 / 36 / 5
        x, row = 24 + 0.5 * scale, 18 + y * scale
        return found[name][int(row - 2):int(row + 2), int(x - 2):int(x + 2)].mean()

    assert mean(after, "Direct.R", -0.8) == 0 and mean(before, "Direct.R", -0.8) > 0
    assert mean(after, "Edited.R", 0.8) == pytest.approx(mean(before, "Direct.R", -0.8), rel=0.15)
    assert mean(after, "Direct.R", 0.8) == pytest.approx(mean(before, "Direct.R", 0.8), rel=0.05)


def test_same_bits(picture, room):
    """One hash for the same scene twice, for other thread counts, and for edits that do nothing."""
    first = picture()["hash"]
    room.render.threads_mode, room.render.threads = 'FIXED', 1
    assert picture()["hash"] == first
    room.render.threads = 2
    assert picture()["hash"] == first
    room.sluice.seed = 1
    assert picture()["hash"] != first
    room.sluice.use_edits = False
    plain = picture()["hash"]
    room.sluice.use_edits = True
    room.objects["Entry"].sluice.enabled = False
    assert picture()["hash"] == plain
    room.objects["Entry"].sluice.enabled, room.objects["Entry"].sluice.expression = True, "LSSSSSSSSSD"
    assert picture()["hash"] == plain


def test_animated_seeds_differ_and_fixed_ones_do_not(picture, room):
    hashes = set()
    for frame in (1, 2):
        room.frame_set(frame)
        hashes.add(picture()["hash"])
    assert len(hashes) == 1
    room.sluice.use_animated_seed = True
    for frame in (1, 2):
        room.frame_set(frame)
        hashes.add(picture()["hash"])
    assert len(hashes) == 3


def test_a_border_is_the_crop_of_the_full_frame(picture, room):
    full = picture("full")
    render = room.render
    render.use_border, render.use_crop_to_border = True, True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.125, 0.5
    part = picture("part")
    x0, x1, y0, y1 = int(0.25 * 48), int(0.75 * 48), int(0.125 * 36), int(0.5 * 36)
    for name, pixels in part.items():
        if name != "hash":
            np.testing.assert_array_equal(pixels, full[name][y0:y1, x0:x1], err_msg=name)


def test_three_sessions_at_once_are_as_if_alone(room, core, export_now):
    from sluice.export.camera import export_camera, export_frame
    from sluice.export.settings import export_settings
    item = room.camera
    description = export_now()[0]
    description["camera"] = export_camera(item, item.matrix_world, None)
    description["frame"] = export_frame(48, 36, room.render)

    def start(seed):
        session = core.Session()
        session.start(description, {**export_settings(room), "seed": seed})
        return session

    def hash_of(session):
        assert session.wait(60)
        return session.film_hash()

    alone = [hash_of(start(seed)) for seed in range(3)]
    together = [start(seed) for seed in range(3)]
    assert [hash_of(session) for session in together] == alone and len(set(alone)) == 3


def test_transparent_film(picture, room):
    room.objects["Floor"].scale = (0.2, 0.2, 1)
    opaque = picture("opaque")
    room.render.film_transparent = True
    found = picture("transparent")
    assert (opaque["Combined.A"] == 1).all()
    assert found["Combined.A"][0, 0] == 0 and found["Combined.A"].max() == pytest.approx(1, abs=1e-3)


# --- bad input -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("expression, column", [("L(S", 2), ("L'Floor", 2), ("D+", 1), ("LQ", 2), ("", 1)])
def test_expression_errors_name_the_edit_and_the_column(room, expression, column, tmp_path):
    room.objects["Entry"].sluice.expression = expression
    room.render.filepath = str(tmp_path / "frame.png")
    with pytest.raises(RuntimeError, match=f"Entry: column {column}: "):
        bpy.ops.render.render(write_still=True)
    assert not list(tmp_path.glob("frame*"))


@pytest.mark.parametrize("how", ["-f 1", "-a"])
def test_an_expression_error_ends_blender_with_a_code(room, launch, tmp_path, how):
    import os
    from pathlib import Path
    from sluice import core as door
    room.objects["Entry"].sluice.expression = "L(S"
    path = tmp_path / "scene.blend"
    room.frame_end = 2
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    folder = os.environ.get("SLUICE_CORE") or Path(door.__file__).parent
    done = launch(path, "-o", tmp_path / "frame_", *how.split(), core=folder)
    assert done.returncode != 0 and "sluice: error: Entry: column 2: " in done.stderr and not list(tmp_path.glob("frame_*"))


def _flatten(item):
    item.scale = (0, 1, 1)


def _no_numbers(item):
    item.data.vertices[0].co.x = float("nan")


@pytest.mark.parametrize("name, harm", [
    ("Entry", _flatten), ("Ball", _no_numbers), ("Ball", _flatten),
    ("Lamp", lambda item: bpy.data.objects.remove(item)),
    ("Floor", lambda item: setattr(item, "scale", (1e9, 1e9, 1))),
    ("Ball", lambda item: setattr(item, "location", (1e7, 0, 0))),
    ("Lamp", lambda item: setattr(item.data, "energy", 0)),
    ("Ball", lambda item: item.data.materials.clear()),
    ("Lamp", lambda item: setattr(item, "scale", (0, 0, 0))),
], ids=["flat quad", "NaN vertex", "flat mesh", "no light", "huge floor", "far ball", "dark lamp", "no material", "flat lamp"])
def test_bad_scenes_still_give_an_image(picture, room, name, harm):
    harm(room.objects[name])
    found = picture()
    for key, pixels in found.items():
        if key != "hash" and not key.startswith("Depth"):
            assert np.isfinite(pixels).all(), key


@pytest.mark.parametrize("name, harm", [("Entry", _flatten), ("Ball", _no_numbers)], ids=["flat quad", "NaN vertex"])
def test_bad_things_are_named(room, capfd, name, harm):
    harm(room.objects[name])
    bpy.ops.render.render()
    assert f"sluice: warning: {name}" in capfd.readouterr().err


def test_an_empty_scene(core, camera, capfd):
    scene = bpy.context.scene
    scene.sluice.passes, scene.render.resolution_x, scene.render.resolution_y = 1, 16, 16
    bpy.ops.render.render()
    assert "sluice: warning: " in capfd.readouterr().err


def test_a_missing_texture_is_named_and_replaced(room, capfd):
    material = bpy.data.materials.new("Paint")
    material.use_nodes = True
    image = bpy.data.images.new("Lost", 4, 4)
    image.source, image.filepath = 'FILE', "//nowhere.png"
    node = material.node_tree.nodes.new('ShaderNodeTexImage')
    node.image = image
    shader = next(item for item in material.node_tree.nodes if item.bl_idname == 'ShaderNodeBsdfPrincipled')
    material.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    room.objects["Floor"].data.materials.append(material)
    bpy.ops.render.render()
    assert "sluice: warning: Lost: image not found" in capfd.readouterr().err


# --- stopping ------------------------------------------------------------------------------------------------------------------


def test_stops_by_time_and_by_error(room, capfd):
    room.sluice.passes, room.sluice.time_limit = 1000000, 1
    begin = time.monotonic()
    bpy.ops.render.render()
    assert time.monotonic() - begin < 4 and "stopped by the time limit" in capfd.readouterr().out
    room.sluice.time_limit, room.sluice.error_target = 20, 50
    bpy.ops.render.render()
    assert "stopped at the error target" in capfd.readouterr().out


def test_a_cancel_ends_within_half_a_second(room, core, export_now):
    """While the scene is built and while passes run."""
    from sluice.export.camera import export_camera, export_frame
    from sluice.export.settings import export_settings
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=700, y_subdivisions=700)
    description = export_now()[0]
    description["camera"] = export_camera(room.camera, room.camera.matrix_world, None)
    description["frame"] = export_frame(480, 360, room.render)
    for delay in (0.0, 0.1, 0.4, 1.5):
        session = core.Session()
        session.start(description, {**export_settings(room), "passes": 100000, "photons": 5000000})
        session.wait(delay)
        begin = time.monotonic()
        session.cancel()
        assert session.wait(5) and time.monotonic() - begin < 0.5, delay
        assert session.progress()["state"] == 'cancelled'
