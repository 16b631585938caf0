# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders whose answer is known on paper. Error bars come from independent seeds; density estimates may be off by a bias that is
stated with each and shrinks with the radius. Lamps have Blender's radiometry: a point lamp of P watts sends P / 4π W/sr, an area lamp
P / 4 W/sr along its axis (so P π / 4 in all), a sun of P lights a plane that faces it with P W/m²."""

import itertools
import math

import numpy as np
import pytest
from scenes import LUMINANCE, PARTS, Scene, both, defaults, diffuse, emission, exit_at, glass, looking, mirror, quad, render, seeds  # noqa: F401: in both kinds
from statistics_of_renders import assert_blocks, assert_mean, blocks, interval

ALBEDO = 0.8


def pixel_centres(size=32, view=1.0):
    """World x, y below the default camera's pixels."""
    x = ((np.arange(size) + 0.5) / size * 2 - 1) * view
    return np.meshgrid(x, x)


def over_pixels(function, size=32, view=1.0, fine=4):
    """Means of a function of x, y over the pixels' squares."""
    return blocks(function(*pixel_centres(size * fine, view)), fine)


# --- direct light ---------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [0.0, 0.02])
@pytest.mark.parametrize("tilt", [0.0, 0.6, 1.3])
def test_sun_on_a_plane(tilt, angle):
    """L = ρ E cos θ / π; a sun of a small angle lights as one without, up to the angle's square."""
    scene = Scene()
    scene.floor(diffuse(ALBEDO))
    scene.sun((math.sin(tilt), 0, -math.cos(tilt)), 3.0, angle=angle)
    expected = ALBEDO * 3.0 * math.cos(tilt) / math.pi
    got = seeds(scene, 4 if angle else 2, passes=8)
    if angle:
        assert_mean(got.stack().mean((1, 2, 3)), expected, bias=angle**2)
    else:
        np.testing.assert_allclose(got.stack(), expected, rtol=1e-5)
    np.testing.assert_array_equal(got.stack("Direct"), got.stack())


@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_point_and_sphere_light_over_a_plane(radius):
    """A uniform sphere that lies above the horizon lights like a point in its centre: E = I cos θ / d²."""
    scene = Scene()
    scene.floor(diffuse(ALBEDO))
    scene.point((0.3, -0.2, 0.7), 12.0, radius=radius)
    distance2 = lambda x, y: (x - 0.3) ** 2 + (y + 0.2) ** 2 + 0.49  # noqa: E731
    expected = over_pixels(lambda x, y: ALBEDO / math.pi * 12 / (4 * math.pi) * 0.7 / distance2(x, y) ** 1.5)
    got = seeds(scene, passes=16, use_indirect=False).stack() @ LUMINANCE
    assert_blocks(blocks(got, 4), blocks(expected, 4), bias=1e-3)


@pytest.mark.parametrize("spot_cosine", [True, False])
def test_spot(spot_cosine):
    """Inside the cone and its blend a spot lights like a point lamp, in Blender 3 times the cosine to its axis; beyond it is dark."""
    scene = Scene()
    scene.floor(diffuse(ALBEDO))
    scene.light("Spot", "Spot", looking((0, 0, 1), (0, 0, -1)), 12.0, spot_angle=1.2, spot_blend=0.0, spot_cosine=spot_cosine)
    picture = render(scene, passes=16)["Combined"]
    r = np.hypot(*pixel_centres())
    inside, outside = r < math.tan(0.6) - 0.06, r > math.tan(0.6) + 0.06
    assert inside.sum() > 200 and outside.sum() > 200
    expected = over_pixels(lambda x, y: ALBEDO / math.pi * 12 / (4 * math.pi) / (x * x + y * y + 1) ** (2 if spot_cosine else 1.5))
    np.testing.assert_allclose(picture[inside], np.repeat(expected[inside][:, None], 3, 1), rtol=0.01)
    np.testing.assert_allclose(picture[inside].mean(), expected[inside].mean(), rtol=1e-3)
    assert (picture[outside] == 0).all()


def rectangle_irradiance(x, y, half, height):
    """Lambert's formula: of a Lambertian rectangle of radiance 1 parallel to the floor, centred above the origin."""
    corners = [np.stack(np.broadcast_arrays(sx * half[0] - x, sy * half[1] - y, height), -1) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    corners = [c / np.linalg.norm(c, axis=-1, keepdims=True) for c in corners]
    total = 0
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        across = np.cross(a, b)
        total = total + np.arccos((a * b).sum(-1)) * across[..., 2] / np.linalg.norm(across, axis=-1)
    return np.abs(total) / 2


def disk_irradiance(x, y, radius, height):
    """Of a parallel disk of radiance 1 (e.g. Howell's catalogue, configuration B-14)."""
    r2 = x * x + y * y
    a = r2 + height**2
    return math.pi / 2 * (1 - (a - radius**2) / np.sqrt((a + radius**2) ** 2 - 4 * radius**2 * r2))


@pytest.mark.parametrize("shape", ["Rectangle", "Disk"])
def test_area_light_over_a_plane(shape):
    scene = Scene()
    scene.floor(diffuse(ALBEDO))
    size = {"size_x": 0.8, "size_y": 0.5}
    scene.area((0, 0, 0.6), (0, 0, -1), 6.0, shape=shape, **size)
    area = 0.4 if shape == "Rectangle" else math.pi * 0.16
    irradiance = (lambda x, y: rectangle_irradiance(x, y, (0.4, 0.25), 0.6)) if shape == "Rectangle" else (lambda x, y: disk_irradiance(x, y, 0.4, 0.6))
    expected = over_pixels(lambda x, y: ALBEDO / math.pi * 6.0 / (4 * area) * irradiance(x, y))
    scene.camera(looking((0, 0, 0.55), (0, 0, -1)), 1.0)  # below the lamp
    got = seeds(scene, passes=16, use_indirect=False).stack() @ LUMINANCE
    assert_blocks(blocks(got, 4), blocks(expected, 4), bias=1e-3)


@pytest.mark.parametrize("half", [1.0, 200.0])
def test_emissive_mesh_lights_as_an_area_light(half):
    """A mesh shines on both sides; below it the floor sees L = strength. On a floor of any size: the larger a triangle, the further
    rays start off it, and the light must not fall into its own shadow."""
    scene = Scene()
    scene.floor(diffuse(ALBEDO), half=half)
    scene.plane("Panel", [(-0.4, -0.25, 0.6), (0.4, -0.25, 0.6), (0.4, 0.25, 0.6), (-0.4, 0.25, 0.6)], emission(1.0, 4.0))
    scene.camera(looking((0, 0, 0.55), (0, 0, -1)), 1.0)
    expected = over_pixels(lambda x, y: ALBEDO / math.pi * 4.0 * rectangle_irradiance(x, y, (0.4, 0.25), 0.6))
    got = seeds(scene, passes=16, use_indirect=False).stack() @ LUMINANCE
    assert_blocks(blocks(got, 4), blocks(expected, 4), bias=1e-3)


# --- furnaces ---------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("depth", [1, 2, 12])
def test_furnace_in_a_sphere(depth):
    """Albedo and emission ½ everywhere: L = 1 - 2^-(depth + 1), 1 for all bounces. A disk cut out of a sphere by a chord r has the area
    π r² exactly, so density estimation has no bias here but the sphere's facets."""
    scene = Scene(size=16)
    scene.sphere("Sphere", (0, 0, 0), 1.0, both(diffuse(0.5), emission(0.5)), rings=48)
    scene.perspective(looking((0.2, 0.1, -0.1), (0.3, 1, 0.2)), 1.5)
    got = seeds(scene, 6, passes=8, photons=16384, max_depth=depth)
    assert_mean(got.stack().mean((1, 2, 3)), 1 - 2.0 ** -(depth + 1), bias=0.002)
    np.testing.assert_allclose(got.stack("Emission"), 0.5, rtol=1e-5)
    assert_mean(got.stack("Direct").mean((1, 2, 3)), 0.25)


def test_furnace_in_a_box():
    """As above; at the walls' edges the disk of the estimate is cut, which loses 2 r / 3π of a wall's light per length of its edges:
    at most 4 · 2 r / 3π of the indirect light in a cube of side 1, as r goes to 0."""
    scene = Scene(size=32)
    scene.box("Box", (0, 0, 0), (1, 1, 1), both(diffuse(0.5), emission(0.5)))
    scene.perspective(looking((0.3, 0.4, 0.5), (0.3, 1, 0.2)), 1.5)
    loss, radius = [], []
    for photons, count in ((8192, 12), (131072, 8)):  # more photons, smaller disks
        got = seeds(scene, count, passes=8, photons=photons, max_depth=24)
        mean, error = interval(got.stack().mean((1, 2, 3)))
        assert error < 0.004
        loss.append(1 - mean)
        radius.append(got.renders[0].statistics["radius"][0])
        assert -error <= 1 - mean <= error + 0.25 * 4 * 2 * radius[-1] / (3 * math.pi)
    assert radius[1] < 0.5 * radius[0]
    assert loss[0] > 0.002  # the bias is there, and it falls
    assert loss[1] < 0.75 * loss[0]


# --- glass and mirrors --------------------------------------------------------------------------------------------------------------------


def fresnel(cosine, ior):
    sine2 = (1 - cosine**2) / ior**2
    inner = math.sqrt(1 - sine2)
    s, p = (cosine - ior * inner) / (cosine + ior * inner), (inner - ior * cosine) / (inner + ior * cosine)
    return (s * s + p * p) / 2


@pytest.mark.parametrize("tilt", [0.0, 0.7])
def test_light_through_a_slab(tilt):
    """Straight through, two faces: ρ E cos θ (1 − R)² / π. With all inner reflections (1 − R) / (1 + R), and the floor's light sent
    back by the slab is more: a bound from below."""
    scene = Scene(size=16, view=0.3)
    scene.floor(diffuse(ALBEDO), half=1.5)
    scene.box("Slab", (-1.4, -1.4, 0.2), (1.4, 1.4, 0.3), glass(1.5))
    scene.camera(looking((0, 0, 0.19), (0, 0, -1)), 0.3)
    scene.sun((math.sin(tilt), 0, -math.cos(tilt)), 2.0)
    r = fresnel(math.cos(tilt), 1.5)
    lit = ALBEDO * 2.0 * math.cos(tilt) / math.pi
    straight = seeds(scene, 6, passes=4, photons=32768, max_depth=3)
    assert (straight.stack("Direct") == 0).all()  # the shadow of glass is black: its light is a caustic
    assert_mean(straight.stack("Caustics").mean((1, 2, 3)), lit * (1 - r) ** 2)
    assert_blocks(blocks(straight.stack("Caustics") @ LUMINANCE, 4), np.full((4, 4), lit * (1 - r) ** 2), bias=1e-3)
    full = seeds(scene, 6, passes=4, photons=32768, max_depth=24)
    mean, error = interval(full.stack("Caustics").mean((1, 2, 3)))
    assert lit * (1 - r) / (1 + r) - error <= mean <= 1.15 * lit


def test_a_mirror_sends_light_to_a_wall():
    """Sun from above, a mirror at 45° turns it level: the wall gets E times the mirror's colour, on the mirror's outline."""
    color = (0.9, 0.6, 0.3)
    scene = Scene(size=32, view=1.0)
    scene.plane("Mirror", [(-1, -1, -1), (1, -1, -1), (1, 1, 1), (-1, 1, 1)], mirror(color))  # z = y, light goes to +y or -y
    scene.plane("Wall", [(-2, -1.5, -2), (-2, -1.5, 2), (2, -1.5, 2), (2, -1.5, -2)], diffuse(ALBEDO))
    scene.camera(looking((0, -1.2, 0), (0, -1, 0), up=(0, 0, 1)), 1.5)
    scene.sun((0, 0, -1), 2.0)
    got = seeds(scene, 6, passes=4, photons=32768, max_depth=2, caustic_radius_factor=0.75)
    inside = got.stack("Caustics")[:, 8:24, 8:24]  # ±0.75 of ±1
    for channel in range(3):
        assert_mean(inside[..., channel].mean((1, 2)), ALBEDO * 2.0 * color[channel] / math.pi)
    outside = got.stack("Caustics")[:, :, [0, 1, 2, 29, 30, 31]]  # beyond ±1.2, further than the widest kernel reaches
    assert (outside == 0).all()


# --- the bias of density estimation -------------------------------------------------------------------------------------------------------


def test_bias_falls_as_the_square_of_the_radius():
    """All widths alike. The light of a low point lamp is moved aside, so that it is estimated from photons. Below the lamp at height h the mean of E under
    the round kernel of radius r, 2/(πR²) (1 − ρ²/R²) with R² = 1.5 r², is E(0) 4 / (1 + √(1 + R²/h²))² = E(0) (1 − ¾ r²/h² + …): the
    render misses the peak by just that, and by a quarter of it when the radius is halved."""
    height, off = 0.375, []
    x, y = pixel_centres(48, 1.5)
    peak = np.hypot(x - 0.75, y) < 0.05  # 4 pixels
    at_peak = over_pixels(lambda x, y: ALBEDO / math.pi * 10 / (4 * math.pi) * height * ((x - 0.75) ** 2 + y**2 + height**2) ** -1.5, 48, 1.5)[peak].mean()
    for radius in (0.18, 0.09, 0.045):
        scene = Scene(size=48, view=1.5)
        scene.floor(diffuse(ALBEDO), half=5)
        scene.point((-0.8, 0, height), 10.0)
        scene.edit("L", quad((-0.8, 0, 0), (0.4, 0, 0), (0, 0.4, 0)), [exit_at((0.75, 0, 0), (0.4, 0, 0), (0, 0.4, 0))])
        got = seeds(scene, 12, passes=1, photons=65536, caustic_radius_factor=radius / (3 / 48), caustic_radius_range=1)
        assert got.renders[0].statistics["radius"][1] == pytest.approx(radius, rel=1e-3)
        mean, error = interval(got.stack("Edited")[:, peak].mean((1, 2)))
        exact = 4 / (1 + math.sqrt(1 + 1.5 * radius**2 / height**2)) ** 2 - 1
        off.append((mean / at_peak - 1, error / at_peak, exact))
    for got, error, exact in off:
        assert abs(got - exact) <= error + 0.05 * abs(exact), off
    assert off[0][0] < -5 * off[0][1]
    assert off[0][0] / off[1][0] == pytest.approx(4, rel=0.25), off


# --- energy -------------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["point", "sphere", "square", "disk", "mesh", "spot"])
def test_the_ledger_knows_the_watts_of_lamps(kind):
    color, power = (1.0, 0.5, 0.25), 7.0
    watts = float(LUMINANCE @ np.array(color)) * power
    scene = Scene()
    scene.floor(diffuse(ALBEDO))
    if kind in ("point", "sphere"):
        scene.point((0.1, 0.2, 0.8), power, color=color, radius=0.15 if kind == "sphere" else 0.0)
    elif kind == "mesh":
        scene.plane("Panel", [(-0.3, -0.2, 0.8), (0.3, -0.2, 0.8), (0.3, 0.2, 0.8), (-0.3, 0.2, 0.8)], emission(color, power))
        watts *= 2 * math.pi * 0.6 * 0.4
    elif kind == "spot":
        scene.light("Spot", "Spot", looking((0, 0, 1), (0.3, 0, -1)), power, spot_angle=1.0, spot_blend=0.0, color=color)
        watts *= (1 - math.cos(0.5) ** 2) / 4  # the integral of the cosine over the cone, over 4π
    else:
        scene.area((0.1, 0.2, 0.8), (0.3, 0.1, -1), power, shape=kind.title(), size_x=0.4, color=color)
        watts *= math.pi / 4
    got = seeds(scene, 6, passes=2, photons=16384)
    assert_mean(got.ledger("emitted"), watts, finest=0.03)


def test_what_a_floor_absorbs_is_what_it_gets():
    """Sun on a floor: absorbed (1 − ρ) E A; the rest goes up and escapes, beside what never met it."""
    scene = Scene()
    scene.floor(diffuse(ALBEDO), half=1.0)
    scene.sun((0.5, 0, -1), 2.0)
    got = seeds(scene, 6, passes=4, photons=16384)
    onto = 2.0 * 4.0 / math.hypot(0.5, 1)
    assert_mean(got.ledger("absorbed"), (1 - ALBEDO) * onto)
    assert_mean(got.ledger("escaped") + got.ledger("absorbed") - got.ledger("sampling"), got.ledger("emitted").mean())


@pytest.mark.parametrize("removed", [False, True])
def test_the_ledger_of_an_edit(removed):
    """A gate of gain 3 adds twice what it takes, one without exit removes all of it; the edit's own counts say the same."""
    scene = Scene()
    scene.floor(diffuse(ALBEDO), half=1.0)
    scene.sun((0, 0, -1), 2.0)
    exits = [] if removed else [exit_at((0.5, 0, 0), (0.3, 0, 0), (0, 0.3, 0), intensity=3.0)]
    scene.edit("L", quad((-0.5, 0, 0), (0.3, 0, 0), (0, 0.3, 0)), exits)
    got = seeds(scene, 8, passes=4, photons=32768)
    taken = 2.0 * 0.36
    assert_mean(got.ledger("removed" if removed else "added"), taken if removed else 2 * taken, finest=0.03)
    for r in got.renders:
        edit = r.edit()
        assert edit["energy_out"] == pytest.approx(0 if removed else 3 * edit["energy_in"], rel=1e-5)
        assert edit["moved"] == (0 if removed else edit["matched"])
    assert_mean([r.edit()["energy_in"] / 4 for r in got.renders], taken, finest=0.03)


# --- only what the scene calls for ----------------------------------------------------------------------------------------------------------


def lone_floor(nodes=None):
    scene = Scene()
    scene.floor(nodes or diffuse(ALBEDO))
    scene.sun()
    return scene


def reason(result, effect):
    return next(why for name, _, why in result.statistics["effects"] if name == effect)


def test_effects_that_nothing_can_produce_are_skipped():
    done = render(lone_floor(), use_indirect=False)
    assert done.ran("direct") and not any(done.ran(e) for e in ("caustics", "edited light", "indirect", "photons"))
    assert "specular" in reason(done, "caustics") and "edit" in reason(done, "edited light") and reason(done, "indirect") == "switched off"
    counts = done.statistics
    assert [counts[k] for k in ("photon_paths", "photons_stored", "gathers", "photons_gathered", "edit_queries")] == [0] * 5
    assert done.progress["photons"] == 0 and counts["bytes_per_photon"] == 0
    assert "caustics: skipped" in counts["report"] and "photons: skipped" in counts["report"]


def test_nothing_runs_in_a_dark_or_black_scene():
    dark, black = Scene(), lone_floor(emission(0.5))
    dark.floor(diffuse(ALBEDO))
    for scene, level in ((dark, 0.0), (black, 0.5)):
        scene.description["lights"] = [] if scene is dark else scene.description["lights"]
        done = render(scene)
        assert not any(runs for _, runs, _ in done.statistics["effects"])
        assert done.statistics["photon_paths"] == 0
        np.testing.assert_allclose(done["Combined"], level, rtol=1e-6)


def test_a_scene_with_everything_runs_everything():
    scene = lone_floor()
    scene.sphere("Ball", (0, 0, 0.5), 0.2, glass(), rings=16)
    scene.edit("LS+", quad((0, 0, 0), (0.3, 0, 0), (0, 0.3, 0)), [exit_at((0.5, 0, 0), (0.3, 0, 0), (0, 0.3, 0))])
    done = render(scene)
    assert all(runs for _, runs, _ in done.statistics["effects"])
    assert done.statistics["photon_paths"] > 0 and done.statistics["gathers"] > 0


def test_parts_switched_off_are_zero_and_leave_the_others():
    """A switch acts on its own part; the others keep their expectation (here: their bits, as every part draws its own numbers)."""
    scene = lone_floor()
    scene.sphere("Ball", (0, 0, 0.5), 0.2, glass(), rings=16)
    scene.box("Block", (-0.8, -0.8, 0), (-0.5, 0.8, 0.5), both(diffuse(0.5), emission(0.2)))
    scene.edit("LS+", quad((0, 0, 0), (0.3, 0, 0), (0, 0.3, 0)), [exit_at((0.5, 0, 0), (0.3, 0, 0), (0, 0.3, 0))])
    switches = {"Direct": "use_direct", "Caustics": "use_caustics", "Edited": "use_edited", "Indirect": "use_indirect"}
    everything = seeds(scene, 6)
    for part, switch in switches.items():
        assert everything.mean(part).max() > 0
        without = seeds(scene, 6, seed=100, **{switch: False})
        assert (without.stack(part) == 0).all()
        for other in PARTS:
            if other == part:
                continue
            (a, ea), (b, eb) = (interval(s.stack(other).mean((1, 2, 3))) for s in (everything, without))
            assert abs(a - b) <= ea + eb + 1e-6 * a, (switch, other)
