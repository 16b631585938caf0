# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene does not call for costs nothing: no rays, no photons, no memory (design §6). Counters are exact, so they are compared with
those of the same scene without the feature."""

import numpy as np
import pytest
import sluice_core
from scenes import Scene, diffuse, exit_at, glass, mirror, quad, render, start

SIZE = 48


def lit_block(*things):
    scene = Scene(SIZE)
    scene.floor(diffuse(0.5), 3)
    scene.box("Block", (-0.5, -0.5, 0), (0.5, 0.5, 0.8), diffuse(0.5))
    scene.point((0.9, 0.7, 3), 50)
    for thing in things:
        thing(scene)
    return scene


def work(done):
    """All counters of work, and the memory of film and photons."""
    names = ("rays", "shadow_rays", "photon_paths", "photons_stored", "view_paths", "gathers", "photons_gathered", "edit_queries")
    return {name: done.statistics[name] for name in names} | {"memory": done.progress["memory"], "hash": done.hash}


def ball(scene):
    scene.sphere("Ball", (0, 1.2, 0.4), 0.3, glass(), rings=24)


def moves(expression, **settings):
    def add(scene):
        scene.edit(expression, quad((0.5, 0.8, 0.01), (0.3, 0, 0), (0, 0.3, 0)), [exit_at((-1, -0.5, 0.01), (0.3, 0, 0), (0, 0.3, 0))], **settings)
    return add


@pytest.mark.parametrize("lamp, rays", [("Point", 2), ("Sun", 2), ("Area", 3)])
def test_direct_light_alone_takes_the_rays_of_a_direct_light_renderer(lamp, rays):
    """One from the camera, one to the lamp, and one of the lobe where it can meet a lamp."""
    scene = lit_block()
    scene.description["lights"] = []
    if lamp == "Point":
        scene.point((0.9, 0.7, 3), 50)
    elif lamp == "Sun":
        scene.sun((-0.2, -0.1, -1), 3)
    else:
        scene.area((0.9, 0.7, 3), (0, 0, -1), 50, size_x=0.5, size_y=0.5, shape="Square")
    done = render(scene, use_indirect=False, use_adaptive_sampling=False)
    paths = SIZE * SIZE * done.progress["pass"]
    assert done.statistics["view_paths"] == paths
    assert 0.95 * rays * paths <= done.statistics["rays"] <= 1.05 * rays * paths
    assert [done.statistics[name] for name in ("photon_paths", "photons_stored", "gathers", "edit_queries")] == [0] * 4
    assert done.statistics["bytes_per_photon"] == 0


def test_an_effect_that_is_off_costs_what_its_absence_does():
    """Each switch, where the scene has what it is for, beside a scene that has none of it."""
    everything = lit_block(ball, moves("LS+"))
    for switched_off in ({"use_caustics": False}, {"use_edited": False}, {"use_indirect": False}):
        done = render(everything, **switched_off)
        part = {"use_caustics": "Caustics", "use_edited": "Edited", "use_indirect": "Indirect"}[next(iter(switched_off))]
        assert not done[part].any()
    dark = render(everything, use_direct=False, use_caustics=False, use_edited=False, use_indirect=False)
    # Edits are asked all the same: what shines by itself may be seen through them.
    assert [work(dark)[name] for name in ("shadow_rays", "photon_paths", "photons_stored", "gathers")] == [0] * 4
    without = render(lit_block(ball), use_indirect=False, use_caustics=False)
    assert without.statistics["photon_paths"] == without.statistics["gathers"] == 0


@pytest.mark.parametrize("expression", ["LS'Floor'+", "LG+D", "LDS", "LD'Ball'"])
def test_an_edit_that_no_path_can_match_costs_nothing(expression):
    """The same bits, the same memory, and the same work to the last ray."""
    plain, edited = render(lit_block()), render(lit_block(moves(expression)))
    assert work(edited) == work(plain)
    assert ("edit Edit", False, "no path of this scene can match its expression") in edited.statistics["effects"]


def test_edits_all_at_once_off_cost_nothing():
    plain, off = render(lit_block(ball)), render(lit_block(ball, moves("LS+")), use_edits=False)
    assert work(off) == work(plain)


def test_layers_are_asked_for_one_by_one():
    """One changes no picture and adds its own plane; none leaves nothing."""
    def layer(scene):
        scene.layer("Direct on the floor", "LD'Floor'E")

    plain, with_layer = render(lit_block()), render(lit_block(layer))
    assert (plain["Combined"] == with_layer["Combined"]).all()
    assert with_layer.progress["memory"] - plain.progress["memory"] == 2 * 8 * 3 * SIZE * SIZE
    assert ("layer Direct on the floor", True, "every path is asked for it") in with_layer.statistics["effects"]


def test_mirrors_that_no_light_leaves_cost_no_photons_of_their_own():
    """Where caustics are switched off, a mirror is followed from the eye alone."""
    def looking_glass(scene):
        scene.plane("Mirror", [(-1, 1.5, 0), (1, 1.5, 0), (1, 1.5, 1.5), (-1, 1.5, 1.5)], mirror(0.9))

    done = render(lit_block(looking_glass), use_caustics=False, use_indirect=False)
    assert done.statistics["photon_paths"] == 0 and not done["Caustics"].any()


def memory_of(size, **settings):
    scene = Scene(8)
    scene.floor(diffuse(0.5))
    scene.point((0, 0, 1), 10)
    scene.description["frame"] |= {"width": size[0], "height": size[1], "x0": 0, "y0": 0, "x1": size[0], "y1": size[1]}
    session = start(scene, passes=1, photons=1000, threads=2, **settings)
    while not session.wait(10):
        pass
    assert session.progress()["state"] == "finished", session.progress()
    return session, session.progress()["memory"]


def test_the_film_holds_what_is_asked_for():
    """Each pass its doubles, in two blocks, and no others; pictures do not depend on what else is held."""
    names = dict(sluice_core.passes)
    sizes = {}
    for asked in ([], ["Depth"], ["Albedo"], ["Direct", "Indirect"], ["Bias"], list(names)):
        session, sizes[tuple(asked)] = memory_of((64, 64), render_passes=asked)
        held = session.snapshot(["Combined", "Noise", *asked])
        assert {name: picture.shape[-1] for name, picture in held.items()} == {
            name: len(names[name]) for name in ("Combined", "Noise", *asked)}  # fmt: skip
        assert session.snapshot([next((n for n in names if n not in (*asked, "Combined", "Noise")), "none")]) is None
    own = {name: 2 * 8 * len(channels) * 64 * 64 for name, channels in names.items()} | {"Combined": 0, "Noise": 0}
    for asked, size in sizes.items():
        assert size - sizes[()] == sum(own[name] for name in asked), asked
    everything, few = memory_of((64, 64))[0], memory_of((64, 64), render_passes=["Direct"])[0]
    for name in ("Combined", "Direct", "Noise"):
        np.testing.assert_array_equal(everything.snapshot([name])[name], few.snapshot([name])[name])


def test_a_picture_in_full_hd_fits_into_350_megabytes():
    _, memory = memory_of((1920, 1080), render_passes=["Noise"])
    assert memory <= 350e6


def test_a_pass_that_does_not_exist_is_named():
    session = start(lit_block(), render_passes=["Glow"])
    while not session.wait(10):
        pass
    assert session.progress()["state"] == "failed" and "Glow" in session.progress()["error"]["item"]
