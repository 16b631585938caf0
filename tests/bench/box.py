# SPDX-License-Identifier: GPL-3.0-or-later
"""The yardstick: a Cornell box with a glass and a mirror sphere at 256 × 256, and what its image must be.

box_large.npy and box_small.npy hold linear RGB (float32, row 0 at the bottom) of an independent photon mapper with final gathering and
no depth limit: 5,600 view samples per pixel from two seeds, which agree to a relMSE of 2e-5; path tracers agree to 0.1 % in the mean."""

import math
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
# blend_scenes/cornell.blend without edits at 240 × 135, by Sluice itself (./run bench --make-reference): it shows noise and the speed of
# convergence, not a bias of its own. 2,048 passes of 65,536 photons; its noise is 1.3 % by the render's own estimate, a relMSE of about
# 5e-5 (1/128 of what 16 passes have): errors near that are the reference's
CORNELL = HERE / "cornell.npy"
LAMPS = {"large": (0.25, 15.0), "small": (0.02, 2343.75)}  # half edge (m) and radiance: the same power

# The floor to beat: passes, seconds and relMSE of a prototype on two threads, large lamp
FLOOR = ((1, 0.08, 0.156), (4, 0.30, 0.028), (16, 1.04, 0.0056), (64, 4.0, 0.0013), (256, 15.7, 0.00041))


def build(lamp="large"):
    """Makes the scene in the open file (inside Blender). Here Y is up, as in the reference, and the camera looks along -Z."""
    sys.path.insert(0, str(HERE.parents[1] / "blend_scenes"))
    import modelling as m

    scene = m.start(256, 256)
    scene.render.filter_size = 1.0
    white, red, green = (m.matte(*paint) for paint in (("White", (0.75, 0.75, 0.75)), ("Red", (0.75, 0.25, 0.25)), ("Green", (0.25, 0.75, 0.25))))
    corner = {name: (x, y, z) for name, x, y, z in (
        ("lbf", -1, -1, 1), ("rbf", 1, -1, 1), ("ltf", -1, 1, 1), ("rtf", 1, 1, 1),
        ("lbb", -1, -1, -1), ("rbb", 1, -1, -1), ("ltb", -1, 1, -1), ("rtb", 1, 1, -1))}  # fmt: skip  # left/right, bottom/top, front/back
    for name, corners, paint in (("Floor", "lbb lbf rbf rbb", white), ("Ceiling", "ltb rtb rtf ltf", white), ("Back", "lbb rbb rtb ltb", white),
                                 ("Left", "lbf lbb ltb ltf", red), ("Right", "rbb rbf rtf rtb", green)):  # fmt: skip
        m.quad(name, [corner[c] for c in corners.split()], paint)
    half, radiance = LAMPS[lamp]
    square = ((-half, -half), (half, -half), (half, half), (-half, half))
    m.quad("Lamp", [(x, 0.999, z) for x, z in square], one_sided(m.lamp("Light", (1, 1, 1), radiance)))
    ball("Glass", (0.4, -0.6, 0.25), m.glass("Clear glass"))
    ball("Mirror", (-0.42, -0.6, -0.3), m.mirror("Mirror"))
    camera = m.camera((0, 0, 4), (0, 0, 0))
    camera.rotation_euler = (0, 0, 0)
    camera.data.sensor_fit, camera.data.angle = "HORIZONTAL", math.radians(39)
    return scene


def one_sided(lamp):
    """Meshes emit on both sides; this lamp's back is black, as the reference's."""
    tree = lamp.node_tree
    emission = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeEmission")
    geometry, front = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeMath")
    front.operation, front.inputs[0].default_value = "MULTIPLY_ADD", -emission.inputs["Strength"].default_value
    front.inputs[2].default_value = emission.inputs["Strength"].default_value  # strength · (1 - backfacing)
    tree.links.new(geometry.outputs["Backfacing"], front.inputs[1])
    tree.links.new(front.outputs[0], emission.inputs["Strength"])
    return lamp


def ball(name, centre, material):
    import bpy

    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128, radius=0.4, location=centre)
    bpy.ops.object.shade_smooth()
    bpy.context.object.name = name
    bpy.context.object.data.materials.append(material)


def reference(lamp="large"):
    return np.load(HERE / f"box_{lamp}.npy").astype(np.float64)


def relmse(image, truth):
    """Mean of d²/(ref² + 0.01); the same without the worst 0.1 % of the pixels; mean over reference mean."""
    error = np.sort(((image - truth) ** 2 / (truth**2 + 0.01)).mean(-1).ravel())
    return float(error.mean()), float(error[: int(error.size * 0.999)].mean()), float(image.mean() / truth.mean())


def seconds_to(curve, target):
    """Seconds at which a curve [(seconds, error), …] reaches a target, by lines in log-log; None if it never does."""
    for (s0, e0), (s1, e1) in zip(curve, curve[1:], strict=False):
        if e1 <= target < e0:
            return math.exp(math.log(s0) + (math.log(s1) - math.log(s0)) * (math.log(e0) - math.log(target)) / (math.log(e0) - math.log(e1)))
    return curve[0][0] if curve and curve[0][1] <= target else None
