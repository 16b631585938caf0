# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad scenes by name, and what comes of rendering one: run as a program, so that a crash is a result like any other.

    python bad_input.py NAME…   renders each scene and prints a line of JSON for it"""

import json
import math
import resource
import sys
import time

import numpy as np
import sluice_core
from scenes import Scene, diffuse, emission, exit_at, glass, matrix, quad, shader

NAN, INF = math.nan, math.inf


def good():
    """A floor, a ball, a lamp, an edit that acts."""
    scene = Scene(size=8)
    scene.floor(diffuse(0.8))
    scene.sphere("Ball", (0.5, 0.5, 0.5), 0.3, glass(), rings=8)
    scene.point((0.2, 0.1, 2), 50)
    scene.edit("L", quad((-0.4, 0, 0), (0.3, 0, 0), (0, 0.3, 0)), [exit_at((0.4, -0.4, 0), (0.3, 0, 0), (0, 0.3, 0))])
    return scene.description


CASES = {}


def case(name, how="finished", says=(), item=None, **settings):
    """Registers a function that spoils a good description. how: what must come of it: 'finished' (says: a word for each warning that must
    be given), 'refused' or 'fails' (says: words of the message; at once, or after start)."""

    def register(spoil):
        CASES[name] = {"spoil": spoil, "how": how, "says": (says,) if isinstance(says, str) else says, "item": item, "settings": settings}
        return spoil

    return register


def spoil(name, path, value, **expected):
    """A case that sets one value: path is keys and indices, value may be a function of the old one."""

    def change(d):
        at = d
        for key in path[:-1]:
            at = at[key]
        old = at.get(path[-1]) if isinstance(at, dict) else at[path[-1]]
        at[path[-1]] = value(old) if callable(value) else value

    case(name, **expected)(change)


def with_nan(place, value=NAN):
    def change(array):
        array = np.array(array, copy=True)
        array[place] = value
        return array

    return change


# --- types and shapes: refused before anything starts ---------------------------------------------------------------------------------

POSITIONS, TRIANGLES, MATRIX = ("meshes", 0, "positions"), ("meshes", 0, "triangles"), ("instances", 0, "matrix")
spoil("positions in double", POSITIONS, lambda a: a.astype(np.float64), how="refused", says=("positions", "float32"), item="Floor")
spoil("positions in big endian", POSITIONS, lambda a: a.astype(">f4"), how="refused", says="positions", item="Floor")
spoil("positions with two columns", POSITIONS, lambda a: np.ascontiguousarray(a[:, :2]), how="refused", says=("positions", "3 columns"), item="Floor")
spoil("positions flat", POSITIONS, lambda a: a.ravel(), how="refused", says="positions", item="Floor")
spoil("positions with holes", POSITIONS, lambda a: np.repeat(a, 2, 0)[::2], how="refused", says=("positions", "contiguous"), item="Floor")
spoil("positions a list", POSITIONS, [[0.0, 0, 0]], how="refused", says="positions", item="Floor")
spoil("triangles signed", TRIANGLES, lambda a: a.astype(np.int32), how="refused", says=("triangles", "uint32"), item="Floor")
spoil("triangles of four", TRIANGLES, np.zeros((2, 4), np.uint32), how="refused", says="triangles", item="Floor")
spoil("triangles without dimensions", TRIANGLES, np.uint32(3), how="refused", says="triangles", item="Floor")
spoil("matrix of 3 rows", MATRIX, np.eye(4)[:3].copy(), how="refused", says="matrix", item="Floor")
spoil("matrix in float32", MATRIX, np.eye(4, dtype=np.float32), how="refused", says="matrix", item="Floor")
spoil("matrix None", MATRIX, None, how="refused", says="matrix", item="Floor")
spoil("meshes a number", ("meshes",), 5, how="refused", says="meshes")
spoil("meshes a text", ("meshes",), "abc", how="refused", says="dict")
spoil("an instance is None", ("instances", 0), None, how="refused", says="dict")
spoil("names a text", ("instances", 0, "names"), "Floor", how="refused", says="names")
spoil("names of bytes that are no text", ("instances", 0, "names"), ["\udcff"], how="refused", says="names")
spoil("a mesh index that is no number", ("instances", 0, "mesh"), "0", how="refused", says="mesh")
spoil("a width beyond integers", ("frame", "width"), 2**40, how="refused", says="width")
spoil("a light of unknown kind", ("lights", 0, "kind"), "Torch", how="refused", says=("kind", "Torch"), item="Lamp")
spoil("a camera of unknown kind", ("camera", "kind"), "Panoramic", how="refused", says="kind")
spoil("a colour of two numbers", ("lights", 0, "color"), (1, 1), how="refused", says="color", item="Lamp")
spoil("an expression that is no text", ("edits", 0, "expression"), 7, how="refused", says="expression", item="Edit")
spoil("exits a dict", ("edits", 0, "exits"), {"quad": 1}, how="refused", says="exits")
case("passes a text", how="refused", says="passes", passes="many")(lambda d: None)
case("photons beyond integers", how="refused", says="photons", photons=2**33)(lambda d: None)

# --- indices and counts: named, with what was expected ------------------------------------------------------------------------------------

spoil("vertex out of range", TRIANGLES, with_nan((1, 2), 4), how="fails", says=("vertex 4", "4"), item="Floor")
spoil("vertex far out of range", TRIANGLES, with_nan((0, 0), 0xFFFFFFFF), how="fails", says="4294967295", item="Floor")
spoil("normals too few", ("meshes", 0, "normals"), np.zeros((5, 3), np.float32), how="fails", says=("normals", "5", "6"), item="Floor")
spoil("polygons of no sizes", ("meshes", 0, "polygons"), {"starts": np.zeros(2, np.uint32)}, how="fails", says=("sizes", "0", "2"), item="Floor")
spoil("polygons a list", ("meshes", 0, "polygons"), [1], how="refused", says="dict", item="Floor")
spoil("slots too many", ("meshes", 0, "material_slots"), np.zeros(3, np.uint16), how="fails", says=("slots", "3", "2"), item="Floor")
spoil("UV map too short", ("meshes", 0, "uv_maps"), [{"name": "UV", "corners": np.zeros((1, 2), np.float32)}], how="fails", says="UV", item="Floor")
spoil("colours too short", ("meshes", 0, "colors"), [{"name": "Col", "corners": np.zeros((1, 3), np.float32)}], how="fails", says="Col", item="Floor")
spoil("mesh out of range", ("instances", 0, "mesh"), 9, how="fails", says=("mesh", "9"), item="Floor")
spoil("mesh below range", ("instances", 0, "mesh"), -2, how="fails", says="mesh", item="Floor")
spoil("material out of range", ("instances", 0, "materials"), [7], how="fails", says=("material", "7"), item="Floor")
spoil("texture of an exit out of range", ("edits", 0, "exits", 0, "normal_map"), 3, how="fails", says="texture", item="Edit exit 0")
spoil("world material out of range", ("world",), {"name": "World", "material": 12}, how="fails", says="material", item="world")
spoil("frame of no pixels", ("frame", "width"), 0, how="fails", says="size", item="frame")
spoil("frame of negative height", ("frame", "height"), -5, how="fails", says="size", item="frame")
spoil("frame too wide", ("frame", "width"), 65537, how="fails", says="65537", item="frame")
spoil("border outside the frame", ("frame", "x1"), 9, how="fails", says="border", item="frame")
spoil("border inside out", ("frame", "x0"), 8, how="fails", says="border", item="frame")
spoil("pixel aspect 0", ("frame", "pixel_aspect_x"), 0.0, how="fails", says="aspect", item="frame")
spoil("camera not finite", ("camera", "matrix"), with_nan((0, 3)), how="fails", says="finite", item="Camera")
spoil("camera flat", ("camera", "matrix"), lambda m: m * [1, 1, 0, 1], how="fails", says="scale", item="Camera")
spoil("orthographic scale 0", ("camera", "ortho_scale"), 0.0, how="fails", says="scale", item="Camera")
spoil("clip range empty", ("camera", "clip_end"), 0.0, how="fails", says="clip", item="Camera")
spoil("specular threshold NaN", ("specular_threshold",), NAN, how="fails", says="threshold")
spoil("max_gates negative", ("max_gates",), -1, how="fails", says="max_gates")
spoil("max_gates 0", ("max_gates",), 0)
spoil("max_gates of a billion", ("max_gates",), 10**9)
spoil("image of negative size", ("images",), [{"name": "Wood", "width": -1, "height": -4, "rgba": np.zeros(16, np.float32)}], how="fails", says="negative", item="Wood")
case("a picture for which there is no memory", how="fails", says="memory")(lambda d: d["frame"].update(width=65536, height=65536))


@case("a border of a picture for which there is no memory")
def small_border(d):
    d["frame"].update(width=65536, height=65536, x0=30000, y0=30000, x1=30008, y1=30008)


# --- geometry that is left out, with a warning --------------------------------------------------------------------------------------------

for value in (NAN, INF, -INF, 1e38):
    spoil(f"vertex {value}", POSITIONS, with_nan((1, 0), value), says="1 of 2 triangles left out")
    spoil(f"quad placed at {value}", ("edits", 0, "entry", "matrix"), with_nan((0, 3), value), says="this quad")
    spoil(f"exit turned by {value}", ("edits", 0, "exits", 0, "quad", "matrix"), with_nan((2, 2), value), **({} if value == 1e38 else {"says": "this quad"}))
    spoil(f"instance matrix {value}", MATRIX, with_nan((1, 1), value), says="left out")
    spoil(f"lamp power {value}", ("lights", 0, "power"), value, **({} if value == 1e38 else {"says": "light is off"}))
    spoil(f"lamp matrix {value}", ("lights", 0, "matrix"), with_nan((1, 3), value), says="light is off")
    spoil(f"normals {value}", ("meshes", 0, "normals"), np.full((6, 3), value, np.float32), **({} if value == 1e38 else {"says": "not finite"}))
    spoil(f"albedo {value}", ("materials", 0, "nodes", 0, "inputs", 0, "value"), [value, 0.5, 0.5, 1])
    spoil(f"roughness of glass {value}", ("materials", 1, "nodes", 0, "inputs", 1, "value"), [value] * 4)
    spoil(f"IOR {value}", ("materials", 1, "nodes", 0, "inputs", 2, "value"), [value] * 4)
    case(f"time limit {value}", time_limit=value)(lambda d: None)
    case(f"error target {value}", error_target=value)(lambda d: None)
    case(f"radius factor {value}", caustic_radius_factor=value)(lambda d: None)
    spoil(f"exit intensity {value}", ("edits", 0, "exits", 0, "intensity"), value, says="intensity")
    spoil(f"hue shift {value}", ("edits", 0, "exits", 0, "hue_shift"), value, **({} if value == 1e38 else {"says": "hue_shift"}))
    spoil(f"tint {value}", ("edits", 0, "exits", 0, "tint"), [value, 0.5, 0.5], **({} if value == 1e38 else {"says": "tint"}))
    spoil(f"amount {value}", ("edits", 0, "amount"), value, says="amount")
    spoil(f"feather {value}", ("edits", 0, "feather"), value, says="feather")
    spoil(f"offset {value}", ("edits", 0, "entry", "offset"), value, **({} if value == 1e38 else {"says": "this quad"}))
    spoil(f"half size {value}", ("edits", 0, "entry", "half_size"), value, says="this quad")

spoil("triangles without area", TRIANGLES, np.zeros((2, 3), np.uint32), says="without area")
spoil("an instance without volume", MATRIX, np.diag([1.0, 1, 0, 1]), says="scale is 0")
spoil("quad without size", ("edits", 0, "entry", "half_size"), 0.0, says="this quad")
spoil("quad collapsed to a line", ("edits", 0, "entry", "matrix"), matrix((0, 0, 0), (1, 0, 0), (1, 0, 0)), says="this quad")
spoil("exit collapsed to a point", ("edits", 0, "exits", 0, "quad", "matrix"), np.zeros((4, 4)), says="this quad")
spoil("quad of negative size", ("edits", 0, "entry", "half_size"), -1.0)
spoil("a tint that is no colour", ("edits", 0, "exits", 0, "tint"), 0.5, how="refused", says="three numbers")
spoil("a negative tint", ("edits", 0, "exits", 0, "tint"), [-1.0, 0.5, 0.5], says="tint")
spoil("entry without exits", ("edits", 0, "exits"), [], says="no exit")
spoil("lamp of negative power", ("lights", 0, "power"), -3.0, says="light is off")
spoil("lamp of negative radius", ("lights", 0, "radius"), -3.0)
spoil("area lamp without area", ("lights", 0), {"names": ["Lamp"], "kind": "Area", "matrix": np.eye(4), "size_x": 0.0}, says="no area")
spoil("spot of all angles", ("lights", 0), {"names": ["Lamp"], "kind": "Spot", "matrix": np.eye(4), "spot_angle": 100.0, "spot_blend": -3.0})
spoil("sun of all angles", ("lights", 0), {"names": ["Lamp"], "kind": "Sun", "matrix": np.eye(4), "angle": 100.0, "power": 1.0})
spoil("no names", ("instances", 0, "names"), [])
spoil("no material", ("instances", 0, "materials"), [], says="no material")
spoil("no light", ("lights",), [], says="no light")
spoil("nothing", ("instances",), [], says="nothing to see")
spoil("unknown name in an expression", ("edits", 0, "expression"), "L'Lmap'", says="Lamp")


@case("an empty description", says=("nothing to see", "no light"))
def empty(d):
    for key in list(d):
        if key not in ("frame", "camera"):
            del d[key]


# --- materials and images -----------------------------------------------------------------------------------------------------------------


def nodes(*list_of_nodes, surface=0):
    return {"name": "Odd", "nodes": list(list_of_nodes), "surface": surface, "surface_output": ""}


def link(name, node, output="Color"):
    return {"name": name, "node": node, "output": output}


def node(kind, *inputs, **more):
    return {"kind": kind, "name": kind, "inputs": list(inputs), "options": {}, **more}


MATERIAL = ("materials", 0)
spoil("unknown node", MATERIAL, nodes(node("BsdfHairPrincipled")), says="BsdfHairPrincipled")
spoil("surface out of range", MATERIAL, nodes(shader("BsdfDiffuse", (1, 1, 1)), surface=5))
spoil("link to a node out of range", MATERIAL, nodes(node("BsdfDiffuse", link("Color", 9))))
spoil("link to itself", MATERIAL, nodes(node("MixShader", link("Shader", 0), link("Shader_001", 0))))
spoil("links in a ring", MATERIAL, nodes(node("BsdfDiffuse", link("Color", 1)), node("Math", link("Value", 2)), node("Math", link("Value", 1))))
spoil("a ladder of 60 mixes", MATERIAL, nodes(*[node("AddShader", link("Shader", i + 1), link("Shader_001", i + 1)) for i in range(60)], shader("BsdfDiffuse", (0.1, 0.1, 0.1))))
spoil("a chain of 20000 nodes", MATERIAL, nodes(node("BsdfDiffuse", link("Color", 1)), *[node("Gamma", link("Color", i + 2)) for i in range(20000)]))
spoil("a missing texture", MATERIAL, nodes(node("BsdfDiffuse", link("Color", 1)), node("TexImage", image=-1)), says="image")
spoil("a texture out of range", MATERIAL, nodes(node("BsdfDiffuse", link("Color", 1)), node("TexImage", image=44)))
spoil("a material without nodes", MATERIAL, {"name": "Odd", "nodes": [], "surface": 0, "surface_output": ""})
spoil("options that are no texts", MATERIAL, nodes({**shader("BsdfDiffuse", (1, 1, 1)), "options": {"distribution": 3}}), how="refused", says="options")
for strength in (NAN, INF, 1e38, -1.0):
    spoil(f"emission {strength}", MATERIAL, {"name": "Odd", "nodes": emission(1.0, strength), "surface": 0, "surface_output": ""})
    spoil(f"world {strength}", ("world",), {"name": "World", "material": 2})
    CASES[f"world {strength}"]["spoil"] = lambda d, s=strength: (
        d["materials"].append({"name": "Sky", "nodes": [shader("Background", (1, 1, 1), Strength=s)], "surface": 0, "surface_output": ""}), d.update(world={"material": 2}))  # fmt: skip


def broken_image(width, height, floats):
    """Read, but by no one: an exit and a material ask for it."""

    def change(d):
        d["images"] = [{"name": "Lost", "width": width, "height": height, "rgba": np.zeros(floats, np.float32)}]
        d["edits"][0]["exits"][0]["intensity_texture"] = 0
        d["materials"][0] = nodes(node("BsdfDiffuse", link("Color", 1)), node("TexImage", image=0))

    return change


for name, width, height, floats in (("empty", 0, 0, 0), ("too short", 1000, 1000, 4), ("too long", 1, 1, 400), ("too large", 20000, 2, 4), ("absurd", 2**31 - 1, 2**31 - 1, 4)):
    case(f"an image {name}", says=("'Lost'", "cannot be read", "Odd"))(broken_image(width, height, floats))


@case("an exit's texture of NaN and Inf")
def odd_texels(d):
    d["images"] = [{"name": "Odd", "width": 2, "height": 1, "color_space": "Linear", "rgba": np.array([NAN, 1, 1, 1, INF, -INF, 1e38, 1], np.float32)}]
    d["edits"][0]["exits"][0].update(intensity_texture=0, hue_shift_texture=0, hue_shift=1.0, normal_map=0)


# --- scale --------------------------------------------------------------------------------------------------------------------------------


def scaled(factor):
    def change(d):
        s = np.diag([factor] * 3 + [1.0])
        for item in (*d["instances"], *d["lights"], d["camera"], d["edits"][0]["entry"], d["edits"][0]["exits"][0]["quad"]):
            item["matrix"] = s @ item["matrix"]
        d["camera"]["ortho_scale"] *= factor
        d["lights"][0]["power"] *= factor**2

    return change


for factor, says in ((1e-7, "inexact"), (1e-4, ()), (1e5, ()), (1e8, "inexact"), (1e14, "inexact"), (1e17, "left out")):
    case(f"scale {factor}", says=says)(scaled(factor))

# --- settings -----------------------------------------------------------------------------------------------------------------------------

for settings in ({"passes": 0}, {"passes": -7}, {"photons": 0}, {"photons": -9}, {"max_depth": 0}, {"max_depth": -3}, {"max_depth": 10**9},
                 {"seed": -1}, {"seed": 2**63 - 1}, {"threads": 64}, {"threads": 10**6}, {"threads": -4}, {"frame": -3, "use_animated_seed": True},
                 {"caustic_radius_factor": 0.0}, {"caustic_radius_factor": -1.0}, {"time_limit": -1.0}, {"time_limit": 1e-9}, {"error_target": -1.0}):  # fmt: skip
    case(f"settings {settings}", **settings)(lambda d: None)
case("settings {'seed': 2**64}", how="refused", says="seed", seed=2**64)(lambda d: None)


def limit_memory(gigabytes=6):
    """So that a picture of terabytes fails here as it would on any machine."""
    resource.setrlimit(resource.RLIMIT_AS, (gigabytes << 30, gigabytes << 30))


def outcome(description, settings):
    session = sluice_core.Session()
    try:
        session.start(description, {"passes": 2, "photons": 1024, "threads": 2, **settings})
    except ValueError as error:
        return {"how": "refused", "message": str(error), "item": getattr(error, "item", None), "warnings": []}
    begin = time.monotonic()
    while not session.wait(0.2):
        if time.monotonic() - begin > 60:
            return {"how": "hangs", "message": str(session.progress()), "item": None, "warnings": []}
    progress = session.progress()
    result = {"how": {"failed": "fails"}.get(progress["state"], progress["state"]), "message": progress["message"], "warnings": [" ".join(w) for w in session.warnings()]}
    result["item"] = progress["error"]["item"] if progress["error"] else None
    result["column"] = progress["error"]["column"] if progress["error"] else None
    if progress["state"] == "finished":
        picture = session.snapshot(["Combined", "Direct", "Edited", "Indirect", "Noise", "Depth", "Normal", "Albedo"])
        result["finite"] = all(bool(np.isfinite(p).all()) for p in picture.values())
        result["least"], result["most"] = (float(f(picture["Combined"][..., :3])) for f in (np.min, np.max))
        result["ledger"] = session.statistics()["ledger"]["worst_residual"]
    return result


def run(name):
    chosen, d = CASES[name], good()
    chosen["spoil"](d)
    return outcome(d, chosen["settings"])


if __name__ == "__main__":
    limit_memory()
    for name in sys.argv[1:]:
        print(json.dumps(run(name)), flush=True)
