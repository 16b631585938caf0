# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes for the tests of sluice_core, rendered without Blender: a builder, a render that checks what must hold of every render,
and several seeds of one scene with their mean and spread."""

import math

import numpy as np
import pytest
import sluice_core

PARTS = ("Direct", "Caustics", "Edited", "Indirect", "Emission")
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def matrix(place=(0, 0, 0), x=(1, 0, 0), y=(0, 1, 0), z=(0, 0, 1)):
    """Local to world, column vectors: the images of the axes and of the origin."""
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = x, y, z, place
    return m


def looking(place, direction, up=(0, 1, 0)):
    """The matrix of a camera or lamp: local -Z goes along `direction`."""
    z = -np.asarray(direction, float) / np.linalg.norm(direction)
    x = np.cross(up, z) if np.linalg.norm(np.cross(up, z)) > 1e-6 else np.array([1.0, 0, 0])
    x /= np.linalg.norm(x)
    return matrix(place, x, np.cross(z, x), z)


# --- materials: a name, and nodes -----------------------------------------------------------------------------------------------------


def shader(kind, color, **numbers):
    inputs = [{"name": "Color", "value": [*color, 1.0]}] + [{"name": name, "value": [value] * 4} for name, value in numbers.items()]
    return {"kind": kind, "name": kind, "inputs": inputs, "options": {"distribution": "GGX"} if kind in ("BsdfGlass", "BsdfGlossy") else {}}


def grey(value):
    return (value, value, value) if np.isscalar(value) else tuple(value)


def diffuse(albedo):
    return [shader("BsdfDiffuse", grey(albedo), Roughness=0.0)]


def mirror(color=1.0):
    return [shader("BsdfGlossy", grey(color), Roughness=0.0)]


def glass(ior=1.5, color=1.0):
    return [shader("BsdfGlass", grey(color), Roughness=0.0, IOR=ior)]


def emission(color, strength=1.0):
    return [shader("Emission", grey(color), Strength=strength)]


def both(first, second):
    """The sum of two one-node shaders."""
    slots = [{"name": "Shader", "node": 1, "output": ""}, {"name": "Shader_001", "node": 2, "output": ""}]
    return [{"kind": "AddShader", "name": "Add", "inputs": slots, "options": {}}, *first, *second]


# --- edits ----------------------------------------------------------------------------------------------------------------------------


def quad(place, x=(1, 0, 0), y=(0, 1, 0), z=(0, 0, 1), **more):
    """A quad whose half edges are x and y; its arrow is on the side of z."""
    return {"matrix": matrix(place, x, y, z), "half_size": 1.0, **more}


def exit_at(place, x=(1, 0, 0), y=(0, 1, 0), z=(0, 0, 1), **settings):
    return {"quad": quad(place, x, y, z), **settings}


class Scene:
    """Collects a description. By default an orthographic camera looks down on the square (±view, ±view, 0), a pixel per column and row
    of the same size, with a box filter: each pixel is the mean over its own square."""

    def __init__(self, size=32, view=1.0, height=5.0):
        self.description = {"meshes": [], "instances": [], "lights": [], "materials": [], "images": [], "edits": []}
        self.description["frame"] = {"width": size, "height": size, "filter_width": 1.0, "filter_box": True}
        self.size, self.view, self.orders = size, view, 0
        self.camera(matrix((0, 0, height)), view)

    def camera(self, place, view):
        self.description["camera"] = {
            "name": "Camera", "kind": "Orthographic", "matrix": place, "ortho_scale": 2.0 * view,
            "sensor_fit": "Horizontal", "clip_start": 0.0, "clip_end": 1e6}  # fmt: skip

    def perspective(self, place, angle, clip_start=1e-3):
        self.description["camera"] = {
            "name": "Camera", "kind": "Perspective", "matrix": place, "lens": 18 / math.tan(angle / 2), "sensor_width": 36.0,
            "sensor_fit": "Horizontal", "clip_start": clip_start, "clip_end": 1e6}  # fmt: skip

    def material(self, nodes):
        self.description["materials"].append({"name": f"Material {len(self.description['materials'])}", "nodes": nodes, "surface": 0, "surface_output": ""})
        return len(self.description["materials"]) - 1

    def mesh(self, name, positions, triangles, nodes, **more):
        d = self.description
        d["meshes"].append({"name": name, "positions": np.array(positions, np.float32), "triangles": np.array(triangles, np.uint32), **more})
        names = [name] if isinstance(name, str) else name
        d["instances"].append({"names": names, "mesh": len(d["meshes"]) - 1, "matrix": np.eye(4), "materials": [self.material(nodes)]})

    def plane(self, name, corners, nodes):
        self.mesh(name, corners, [[0, 1, 2], [0, 2, 3]], nodes)

    def floor(self, nodes, half=2.0, z=0.0, name="Floor"):
        self.plane(name, [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)], nodes)

    def box(self, name, low, high, nodes):
        corners = [[(low, high)[(i >> axis) & 1][axis] for axis in range(3)] for i in range(8)]
        sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]  # seen from outside, counter-clockwise
        self.mesh(name, corners, [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))], nodes)

    def sphere(self, name, centre, radius, nodes, rings=64):
        theta, phi = np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
        t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
        normals = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1)
        i, j = (a.ravel() for a in np.meshgrid(np.arange(rings), np.arange(2 * rings), indexing="ij"))
        a, b = i * 2 * rings + j, i * 2 * rings + (j + 1) % (2 * rings)
        upper, lower = np.stack([a, a + 2 * rings, b], -1)[i > 0], np.stack([b, a + 2 * rings, b + 2 * rings], -1)[i < rings - 1]
        self.mesh(name, normals * radius + np.array(centre), np.concatenate([upper, lower]), nodes)

    def light(self, name, kind, place, power, **more):
        self.description["lights"].append({"names": [name], "kind": kind, "matrix": place, "power": float(power), **more})

    def point(self, place, power, name="Lamp", **more):
        self.light(name, "Point", matrix(place), power, **more)

    def sun(self, direction=(0, 0, -1), power=1.0, name="Sun", **more):
        self.light(name, "Sun", looking((0, 0, 0), direction), power, **more)

    def area(self, place, direction, power, name="Lamp", **more):
        self.light(name, "Area", looking(place, direction), power, **more)

    def edit(self, expression, entry, exits=(), name="Edit", **more):
        """Names and orders of the quads are given here."""
        exits = [{**e, "quad": {**e["quad"], "name": f"{name} exit {i}", "order": self.orders + 1 + i}} for i, e in enumerate(exits)]
        self.description["edits"].append({"entry": {**entry, "name": name, "order": self.orders}, "expression": expression, "exits": exits, **more})
        self.orders += 1 + len(exits)


    def layer(self, name, expression):
        self.description.setdefault("layers", []).append({"name": name, "expression": expression})


# --- rendering ------------------------------------------------------------------------------------------------------------------------


class Render:
    """What one session left: pictures in double (row 0 at the bottom), statistics, warnings."""

    def __init__(self, session):
        self.progress, self.warnings = session.progress(), session.warnings()
        self.statistics, self.hash = session.statistics(), session.film_hash()
        pictures = session.snapshot(["Combined", *PARTS, *(layer["name"] for layer in self.statistics["layers"])])
        self.pictures = {name: picture[..., :3].astype(float) for name, picture in pictures.items()}

    def __getitem__(self, name):
        return self.pictures[name]

    def ran(self, effect):
        return next(runs for name, runs, _ in self.statistics["effects"] if name == effect)

    def edit(self, name="Edit"):
        return next(e for e in self.statistics["edits"] if e["name"] == name)


ALIKE = {"use_adaptive_sampling": False, "caustic_radius_range": 1}  # pictures that are compared differ in neither samples nor radii
AS_SHIPPED = {}
in_use = ALIKE


@pytest.fixture(params=["alike", "as shipped"], autouse=True)
def defaults(request):
    """In a module that imports it each test runs twice: with even samples and widths, and with those that the product has by default."""
    global in_use
    in_use = AS_SHIPPED if request.param == "as shipped" else ALIKE
    yield request.param
    in_use = ALIKE


def most_range():
    """How many times wider or narrower than the common one the photons' kernels may be."""
    return in_use.get("caustic_radius_range", 2.5)


def start(scene, **settings):
    session = sluice_core.Session()
    session.start(getattr(scene, "description", scene), {"passes": 4, "photons": 8192, "seed": 0, "threads": 1, **in_use, **settings})
    return session


def render(scene, **settings):
    """Renders to the end and checks what holds of every render: it finished, the energy ledger closes, every number is finite, and the
    parts sum to Combined."""
    session = start(scene, **settings)
    while not session.wait(10.0):
        pass
    done = Render(session) if session.progress()["state"] == "finished" else None
    assert done, session.progress()
    assert done.statistics["ledger"]["worst_residual"] <= 1e-6
    assert done.statistics["dropped"]["non_finite"] == 0
    total = sum(done[name] for name in PARTS)
    assert np.isfinite(total).all()
    np.testing.assert_allclose(total, done["Combined"], rtol=1e-5, atol=1e-6 * max(total.max(), 1e-30))
    return done


class Seeds:
    """Independent renders of one scene."""

    def __init__(self, renders):
        self.renders = renders

    def stack(self, name="Combined"):
        return np.stack([r[name] for r in self.renders])

    def mean(self, name="Combined"):
        return self.stack(name).mean(0)

    def ledger(self, name):
        """Per pass, of each render."""
        return np.array([r.statistics["ledger"][name] / r.progress["pass"] for r in self.renders])


def seeds(scene, count=6, **settings):
    first = settings.pop("seed", 0)
    return Seeds([render(scene, seed=first + i, **settings) for i in range(count)])
