# SPDX-License-Identifier: GPL-3.0-or-later
"""View edits: the camera looks down on a mirror, which shows a ceiling of coloured squares. An entry on the mirror takes the reflected
view rays; pixel by pixel the picture is what the exit's place shows, by a mapping written anew here. Emission alone, so without noise;
then a lit ceiling."""

import math

import numpy as np
import pytest
from floor_tracer import Quad, tinted, turn_hue
from scenes import Scene, diffuse, emission, exit_at, looking, mirror, quad, render, seeds
from statistics_of_renders import assert_mean, assert_same_mean

SIZE, MIRROR, CEILING = 32, np.array((0.9, 0.8, 0.7)), 2.0
RANDOM = np.random.default_rng(5)
COLORS = np.round(RANDOM.uniform(0.1, 1.0, (6, 6, 3)), 3)  # of squares of side 0.5 between ±1.5


def scene_with(ceiling):
    scene = Scene(size=SIZE)
    scene.plane("Mirror", [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], mirror(MIRROR))
    scene.camera(looking((0, 0, 1), (0, 0, -1)), 1.0)
    if ceiling == "emits":
        for i, j in np.ndindex(6, 6):
            x, y = j / 2 - 1.5, i / 2 - 1.5
            scene.plane(f"Square {i} {j}", [(x, y, CEILING), (x, y + 0.5, CEILING), (x + 0.5, y + 0.5, CEILING), (x + 0.5, y, CEILING)], emission(COLORS[i, j]))
    else:
        scene.plane("Ceiling", [(-1.5, -1.5, CEILING), (-1.5, 1.5, CEILING), (1.5, 1.5, CEILING), (1.5, -1.5, CEILING)], diffuse(0.6))
        scene.point((0.3, -0.2, 1.2), 20.0)
    return scene


def seen(points):
    """What the ceiling shows at points; black beyond it."""
    index = np.floor((points[:, :2] + 1.5) * 2).astype(int)
    inside = ((index >= 0) & (index < 6)).all(1)
    index = np.clip(index, 0, 5)
    return np.where(inside[:, None], COLORS[index[:, 1], index[:, 0]], 0.0)


def straight(points):
    return seen(points)


def through(entry, leaves):
    """The picture that an edit makes, as a function of mirror points; NaN outside of the entry."""
    entry, out = Quad(entry), Quad(leaves["quad"])

    def show(points):
        t, uv = entry.cross(points, np.broadcast_to([0, 0, 1.0], points.shape))
        origin = out.point(uv)
        d = out.to_world(entry.to_local(np.broadcast_to([0, 0, 1.0], points.shape)))
        up = d[0, 2] > 0
        at = origin + d * ((CEILING - origin[:, 2]) / d[:, 2])[:, None] if up else np.full_like(origin, 1e9)
        color = seen(at)
        if leaves.get("hue_shift"):
            color = np.stack([turn_hue(c, leaves["hue_shift"]) if c.any() else c for c in color])
        color = tinted(color, leaves.get("tint", (1, 1, 1))) * leaves.get("intensity", 1.0)
        return np.where(np.isfinite(t)[:, None], color, np.nan)

    return show


def expected(edits):
    """Per pixel, from 7 × 7 points up to its corners: the colour where all points agree, NaN elsewhere. `edits`: list of (entry,
    [functions that add])."""
    across = ((np.arange(SIZE)[:, None] + np.linspace(1e-6, 1 - 1e-6, 7)) / SIZE * 2 - 1).ravel()
    x, y = np.meshgrid(across, across)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)
    color = straight(points)
    for entry, shows in edits:
        inside = np.isfinite(Quad(entry).cross(points, np.broadcast_to([0, 0, 1.0], points.shape))[0])
        color = np.where(inside[:, None], sum((show(points) for show in shows), np.zeros_like(color)), color)
    fine = (color * MIRROR).reshape(SIZE, 7, SIZE, 7, 3)
    low, high = fine.min((1, 3)), fine.max((1, 3))
    return np.where((high - low).max(-1, keepdims=True) < 1e-9, low, np.nan)


def compare(picture, want, least=600):
    pure = np.isfinite(want).all(-1)
    assert pure.sum() >= least
    np.testing.assert_allclose(picture[pure], want[pure], rtol=2e-5, atol=1e-6)


ENTRY = quad((-0.25, 0.125, 0), (0.5, 0, 0), (0, 0.375, 0))
UP = {"x": (0.5, 0, 0), "y": (0, 0.375, 0)}
EXITS = {
    "re-aimed": exit_at((0.5, -0.625, 1.5), **UP),
    "rotated": exit_at((0.25, -0.25, 0.7), (0, 0.5, 0), (-0.375, 0, 0)),
    "mirrored": exit_at((0.25, -0.25, 0.7), (-0.5, 0, 0), (0, 0.375, 0)),
    "smaller": exit_at((0.5, -0.5, 0.7), (0.25, 0, 0), (0, 0.1875, 0)),
    "larger, flux kept": exit_at((0.25, 0, 0.7), (1.0, 0, 0), (0, 0.75, 0), keep_brightness=False),
    "tilted": exit_at((0.4, -0.3, 1.0), (0.4, 0, 0.3), (0, 0.375, 0), (-0.6, 0, 0.8)),
    "tilted, mirrored": exit_at((0.4, -0.3, 1.0), (-0.4, 0, 0.3), (0, 0.375, 0), (0.6, 0, 0.8)),
    "dimmed": exit_at((0.5, -0.625, 1.5), **UP, intensity=0.25),
    "recoloured": exit_at((-0.25, 0.125, 0), **UP, hue_shift=1.7),
    "moved and recoloured": exit_at((0.5, -0.625, 1.5), **UP, hue_shift=-0.8, intensity=2.0),
    "tinted": exit_at((0.5, -0.625, 1.5), **UP, tint=(0.1, 0.6, 0.2)),
    "recoloured and tinted": exit_at((-0.25, 0.125, 0), **UP, hue_shift=1.7, tint=(0.6, 0.3, 0.05)),
}


def test_the_ceiling_in_the_mirror():
    """Without edits: each pixel is the square above it, times the mirror's colour."""
    picture = render(scene_with("emits"), passes=2)
    compare(picture["Emission"], expected([]), least=SIZE * SIZE)


@pytest.mark.parametrize("way", EXITS)
def test_the_mirror_shows_the_exits_place(way):
    scene = scene_with("emits")
    scene.edit("S'Mirror'E", ENTRY, [EXITS[way]])
    done = render(scene, passes=2)
    want = expected([(ENTRY, [through(ENTRY, EXITS[way])])])
    compare(done["Combined"], want)
    assert np.abs(np.nan_to_num(want - expected([]))).max() > 0.05  # the edit is seen
    assert done.edit()["matched"] == done.edit()["moved"] > 0


@pytest.mark.parametrize("expression", ["S'Mirror'E", "LS'Mirror'"])
def test_a_tint_on_the_mirror(expression):
    """On what the eye sees in it and on the light that it sends to the eye, which a view path meets backward: the same picture."""
    tints = exit_at((-0.25, 0.125, 0), **UP, tint=(0.6, 0.3, 0.05))
    scene = scene_with("emits")
    scene.edit(expression, ENTRY, [tints])
    compare(render(scene, passes=2)["Combined"], expected([(ENTRY, [through(ENTRY, tints)])]))


@pytest.mark.parametrize("way", ["re-aimed", "rotated", "mirrored", "tilted, mirrored"])
def test_a_slanted_entry_in_the_air(way):
    """The rays meet it obliquely about both axes, so that each component of the direction counts."""
    entry = quad((-0.25, 0.125, 0.4), (0.4, 0, 0.2), (0.05, 0.3, 0.15), np.cross((0.4, 0, 0.2), (0.05, 0.3, 0.15)))
    scene = scene_with("emits")
    scene.edit("S'Mirror'E", entry, [EXITS[way]])
    done = render(scene, passes=2)
    compare(done["Combined"], expected([(entry, [through(entry, EXITS[way])])]))
    assert done.edit()["matched"] > 200


def test_no_exit_removes_the_reflection_and_nothing_else():
    scene = scene_with("emits")
    scene.edit("S'Mirror'E", ENTRY)
    done, plain = render(scene, passes=2), render(scene, passes=2, use_edits=False)
    compare(done["Combined"], expected([(ENTRY, [])]))
    outside = (done["Combined"] != plain["Combined"]).any(-1)
    assert outside.sum() <= 17 * 13 and done["Combined"][outside].max() < plain["Combined"].max()
    np.testing.assert_array_equal(done["Combined"][~outside], plain["Combined"][~outside])


def test_the_other_side_of_a_quad_acts_too():
    """With the arrow into the mirror the entry lies below the surface: rays that go up do not meet it. In front of it both sides take."""
    for place, arrow, acts in (((-0.25, 0.125, 0), -1, False), ((-0.25, 0.125, 0.5), -1, True), ((-0.25, 0.125, 0.5), 1, True)):
        scene = scene_with("emits")
        entry = quad(place, (0.5, 0, 0), (0, 0.375 * arrow, 0), (0, 0, arrow))
        scene.edit("SE", entry)
        done = render(scene, passes=2)
        assert (done.edit()["matched"] > 0) == acts
        compare(done["Combined"], expected([(entry, [])] if acts else []))


def test_exits_add_and_amount_mixes():
    a, b = EXITS["re-aimed"], EXITS["rotated"]
    scene = scene_with("emits")
    scene.edit("S'Mirror'E", ENTRY, [a, b])
    compare(render(scene, passes=2)["Combined"], expected([(ENTRY, [through(ENTRY, a), through(ENTRY, b)])]))
    scene = scene_with("emits")
    scene.edit("S'Mirror'E", ENTRY, [a], amount=0.25)
    mixed = [lambda p: 0.25 * through(ENTRY, a)(p), lambda p: 0.75 * straight(p)]
    compare(render(scene, passes=2)["Combined"], expected([(ENTRY, mixed)]))


@pytest.mark.parametrize("expression", ["S'Mirror'E", "SE", ".E", "(D|S)E", "S'Mirror','Lens'E".replace("','", ",")])
def test_expressions_that_mean_the_reflection(expression):
    scene = scene_with("emits")
    scene.edit(expression, ENTRY, [EXITS["re-aimed"]])
    compare(render(scene, passes=2)["Combined"], expected([(ENTRY, [through(ENTRY, EXITS["re-aimed"])])]))


def test_a_chain_of_view_edits():
    """The second lies on the first's exit and asks for what came through it; its own expression reads F, mirror, eye."""
    first, second = exit_at((0.25, -0.25, 0.7), **UP), EXITS["re-aimed"]
    scene = scene_with("emits")
    scene.edit("S'Mirror'E", ENTRY, [first], name="First")
    scene.edit("F'First'S'Mirror'E", quad((0.25, -0.25, 0.7), **UP), [second], name="Second")
    done = render(scene, passes=2)
    compare(done["Combined"], expected([(ENTRY, [through(ENTRY, second)])]))
    assert done.edit("First")["matched"] == done.edit("Second")["matched"] > 0


def test_an_edit_in_front_of_the_camera():
    """Expression E: what the camera sees through the quad is what the exit sees; here, the ceiling at once, without the mirror's colour."""
    entry = quad((-0.25, 0.125, 0.5), (0.5, 0, 0), (0, 0.375, 0))
    leaves = exit_at((0.5, -0.625, 1.5), (0.5, 0, 0), (0, 0.375, 0), (0, 0, -1))  # in from the front, so out through the back: up
    scene = scene_with("emits")
    scene.edit("E", entry, [leaves])
    done = render(scene, passes=2)
    assert done.edit()["matched"] > 0
    flat = through(quad((-0.25, 0.125, 0.5), **UP), exit_at((0.5, -0.625, 1.5), **UP))
    compare(done["Combined"], expected([(entry, [lambda p: flat(p) / MIRROR])]))


# --- a lit ceiling ---------------------------------------------------------------------------------------------------------------------------


def lit(x, y):
    distance2 = (x - 0.3) ** 2 + (y + 0.2) ** 2 + 0.64
    return 0.6 / math.pi * 20 / (4 * math.pi) * 0.8 / distance2**1.5


def test_a_lit_ceiling_is_shown_through_the_exit():
    scene = scene_with("lit")
    scene.edit("S'Mirror'E", ENTRY, [exit_at((0.5, -0.5, 1.5), **UP)])
    got = seeds(scene, 6, passes=16, use_indirect=False, use_caustics=False)
    x, y = np.meshgrid(*[(np.arange(SIZE) + 0.5) / SIZE * 2 - 1] * 2)
    inside = (np.abs(x + 0.25) < 0.5) & (np.abs(y - 0.125) < 0.375)
    want = np.where(inside, lit(x + 0.75, y - 0.625), lit(x, y))[..., None] * MIRROR
    np.testing.assert_allclose(got.mean("Direct"), want, rtol=0.01)  # a pixel's own slope, at 4 samples
    assert_mean(got.stack("Direct")[:, inside].mean((1, 2)), want[inside].mean(), bias=1e-3)
    assert_mean(got.stack("Direct").mean((1, 2, 3)), want.mean(), bias=1e-3)


def test_identity_view_edit_is_no_edit():
    """Same place, same direction: the same picture in each part, all over and under the entry. Not number by number, as only paths without
    a gate share what their gather segments find."""
    scene = scene_with("lit")
    scene.sphere("Block", (0.2, -0.2, 1.7), 0.2, diffuse((0.7, 0.3, 0.3)), rings=24)  # indirect light and caustics too
    scene.edit("S'Mirror'E", ENTRY, [exit_at((-0.25, 0.125, 0), **UP)])
    same = seeds(scene, 10, passes=32, photons=16384)
    plain = seeds(scene, 10, passes=32, photons=16384, use_edits=False, seed=100)
    assert all(render.edit()["moved"] > 0 for render in same.renders)
    x, y = np.meshgrid(*[(np.arange(SIZE) + 0.5) / SIZE * 2 - 1] * 2)
    inside = (np.abs(x + 0.25) < 0.5) & (np.abs(y - 0.125) < 0.375)
    for part in ("Direct", "Indirect", "Caustics"):
        assert plain.stack(part).mean() > 0
        for where in (inside, ~inside):
            assert_same_mean(same.stack(part)[:, where].mean((1, 2)), plain.stack(part)[:, where].mean((1, 2)), finest=0.2)


def test_a_light_edit_is_seen_through_a_view_edit():
    """A light edit moves lamp light on the ceiling; the mirror, re-aimed by a view edit, shows it where the exit looks."""
    scene = scene_with("lit")
    lamp_entry = quad((0.5, -0.5, CEILING), (0.25, 0, 0), (0, -0.25, 0), (0, 0, -1))
    scene.edit("L", lamp_entry, [exit_at((-0.75, 0.75, CEILING), (0.25, 0, 0), (0, -0.25, 0), (0, 0, -1))], name="Light")
    scene.edit("S'Mirror'E", ENTRY, [exit_at((0.5, -0.5, 1.5), **UP)], name="View")
    got = seeds(scene, 8, passes=4, photons=32768, use_indirect=False, caustic_radius_factor=1.0)
    x, y = np.meshgrid(*[(np.arange(SIZE) + 0.5) / SIZE * 2 - 1] * 2)
    inside = (np.abs(x + 0.25) < 0.5) & (np.abs(y - 0.125) < 0.375)
    sx, sy = np.where(inside, x + 0.75, x), np.where(inside, y - 0.625, y)  # what each pixel shows
    taken = (np.abs(sx - 0.5) < 0.25) & (np.abs(sy + 0.5) < 0.25)
    given = (np.abs(sx + 0.75) < 0.17) & (np.abs(sy - 0.75) < 0.17)
    assert (taken & inside).sum() > 30 and (taken & ~inside).sum() > 30 and (given & ~inside).sum() > 20
    assert not got.stack("Direct")[:, taken].any()
    np.testing.assert_allclose(got.mean("Direct")[~taken], (lit(sx, sy)[..., None] * MIRROR)[~taken], rtol=0.03)
    moved = (lit(sx + 1.25, sy - 1.25)[..., None] * MIRROR)[given].mean()
    assert_mean(got.stack("Edited")[:, given].mean((1, 2)), moved, bias=0.01, finest=0.04)
