# SPDX-License-Identifier: GPL-3.0-or-later
"""Unedited scenes against Cycles: means of blocks of pixels agree within noise + 2 %.

Both renderers make several pictures with different seeds, so the noise of each block is measured, not guessed: Welch's interval, with
one false alarm in a thousand comparisons of a whole picture (Šidák). The 2 % (of the block, plus a tenth of a percent of the picture)
are for what differs by design: photon density near edges, Cycles' own approximations."""
import math
import os
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

sys.path.append(str(Path(__file__).resolve().parents[1] / "python"))
from statistics_of_renders import FALSE_ALARM, student_quantile

SIDE, BLOCKS = 48, 4
FULL = os.environ.get("SLUICE_FULL") == "1"
SEEDS = 24 if FULL else 12


def _node_material(name, build):
    """A material whose surface is what build(tree) returns."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    out = tree.nodes.new('ShaderNodeOutputMaterial')
    tree.links.new(build(tree), out.inputs["Surface"])
    return material


def _shader(tree, kind, **inputs):
    node = tree.nodes.new(kind)
    for name, value in inputs.items():
        socket = node.inputs[name.replace("_", " ")]
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node


def plain(kind, **inputs):
    return _node_material(kind, lambda tree: _shader(tree, kind, **inputs).outputs[0])


def diffuse(*color):
    return plain('ShaderNodeBsdfDiffuse', Color=(*color, 1))


def principled(**inputs):
    known = bpy.data.materials.new("probe")
    known.use_nodes = True
    names = {socket.name for socket in known.node_tree.nodes["Principled BSDF"].inputs}
    modern = {"Specular": "Specular IOR Level", "Transmission": "Transmission Weight", "Clearcoat": "Coat Weight",
              "Clearcoat_Roughness": "Coat Roughness", "Sheen": "Sheen Weight"}
    found = {(name if name.replace("_", " ") in names else modern[name].replace(" ", "_")): value for name, value in inputs.items()}
    return plain('ShaderNodeBsdfPrincipled', **found)


def _add(name, material, smooth=True):
    item = bpy.context.object
    item.name = name
    item.data.materials.append(material)
    # Cycles moves shadow rays off low-poly surfaces unless told not to
    item.cycles.shadow_terminator_offset = item.cycles.shadow_terminator_geometry_offset = 0
    item.data.polygons.foreach_set("use_smooth", [smooth] * len(item.data.polygons))
    return item


def ball(material, location=(0, 0, 0.5), radius=0.5, segments=48):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=segments, ring_count=segments // 2, radius=radius, location=location)
    return _add("Ball", material)


def box(material, location, scale=(0.5, 0.5, 0.5), turn=0.4):
    bpy.ops.mesh.primitive_cube_add(size=1, location=location, rotation=(0, 0, turn))
    bpy.context.object.scale = scale
    return _add("Box", material, smooth=False)


def lamp(kind, location, energy, toward=(0, 0, 0), **settings):
    data = bpy.data.lights.new(kind, kind)
    data.energy = energy
    for name, value in settings.items():
        setattr(data, name, value)
    item = bpy.data.objects.new(kind, data)
    item.matrix_world = Matrix.Translation(location) @ (Vector(toward) - Vector(location)).to_track_quat('-Z', 'Y').to_matrix().to_4x4()
    bpy.context.scene.collection.objects.link(item)


def world(build=None, color=(0, 0, 0), strength=0.0):
    scene_world = bpy.data.worlds.new("World")
    scene_world.use_nodes = True
    tree = scene_world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (*color, 1), strength
    if build:
        tree.links.new(build(tree), background.inputs["Color"])
    bpy.context.scene.world = scene_world


def picture(name, pixels):
    """A packed image of (h, w, 3) values, scene-linear."""
    image = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], float_buffer=True)
    rgba = np.ones((*pixels.shape[:2], 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    return image


def stage():
    """A floor and a back wall, and a camera that looks at them."""
    bpy.ops.mesh.primitive_plane_add(size=6)
    _add("Floor", diffuse(.6, .6, .6), smooth=False)
    bpy.ops.mesh.primitive_plane_add(size=6, location=(0, 1.5, 0), rotation=(math.pi / 2, 0, 0))
    _add("Wall", diffuse(.7, .35, .25), smooth=False)
    data = bpy.data.cameras.new("Camera")
    data.lens = 40
    camera = bpy.data.objects.new("Camera", data)
    camera.matrix_world = Matrix.Translation((0, -4, 1.6)) @ Euler((math.radians(75), 0, 0)).to_matrix().to_4x4()
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def lamps_small():
    lamp('POINT', (-1, -1, 2.2), 60, shadow_soft_size=0.01)  # Cycles 3.4 draws soft points as disks, we as spheres
    lamp('SPOT', (1.4, -1.2, 2), 120, spot_size=0.9, spot_blend=0.4, shadow_soft_size=0.01)
    ball(diffuse(.3, .5, .8)), box(diffuse(.8, .7, .2), (-1, 0, 0.25))


def spot():
    lamp('SPOT', (1.4, -1.2, 2), 120, spot_size=2.0, spot_blend=0.4, shadow_soft_size=0.1)
    ball(diffuse(.3, .5, .8)), box(diffuse(.8, .7, .2), (-1, 0, 0.25))


def lamps_large():
    lamp('AREA', (-1.5, -1, 2), 40, size=0.8, shape='DISK', spread=math.pi)
    lamp('AREA', (1.5, -0.5, 1.5), 25, size=0.6, size_y=0.3, shape='RECTANGLE', spread=1.2)
    lamp('SUN', (0, -2, 4), 1.0, toward=(0.5, 0.5, 0), angle=0.1)
    ball(diffuse(.8, .8, .8)), box(diffuse(.2, .7, .3), (-1, 0.2, 0.3))


def emissive_mesh():
    bpy.ops.mesh.primitive_plane_add(size=0.8, location=(0.2, -0.5, 2), rotation=(0.3, 0.2, 0))
    _add("Panel", plain('ShaderNodeEmission', Color=(1, .8, .6, 1), Strength=12), smooth=False)
    ball(diffuse(.6, .6, .8)), box(diffuse(.8, .3, .3), (-1, 0.2, 0.3))


def sky():
    rows, columns = np.mgrid[0:16, 0:32]
    pixels = np.stack([0.3 + rows / 20, 0.4 + columns / 60, 0.5 + 0 * rows], -1).astype(np.float32)
    pixels[10:12, 5:8] = 8

    def environment(tree):
        node = tree.nodes.new('ShaderNodeTexEnvironment')
        node.image = picture("Sky", pixels)
        return node.outputs["Color"]

    world(environment, strength=0.6)
    ball(principled(Base_Color=(.8, .6, .2, 1), Metallic=1, Roughness=.35)), box(diffuse(.5, .5, .5), (-1, 0, 0.25))


def glossy():
    lamp('AREA', (-1, -1.5, 2), 60, size=1.0)
    world(color=(.3, .4, .5), strength=0.5)
    ball(principled(Base_Color=(.7, .2, .2, 1), Roughness=.3, Specular=.5), (-0.8, 0, 0.5))
    ball(plain('ShaderNodeBsdfGlossy', Color=(.9, .9, .8, 1), Roughness=.25), (0.4, 0.3, 0.5))
    ball(principled(Base_Color=(.2, .3, .7, 1), Roughness=.6, Clearcoat=.5, Clearcoat_Roughness=.2), (1.2, -0.6, 0.3), 0.3)


def mirror_and_glass():
    lamp('AREA', (-1, -1, 2.2), 60, size=1.2)
    ball(plain('ShaderNodeBsdfGlass', Color=(1, 1, 1, 1), Roughness=0, IOR=1.45), (0.5, -0.3, 0.5))
    ball(plain('ShaderNodeBsdfGlossy', Color=(.9, .9, .9, 1), Roughness=0), (-0.7, 0.2, 0.5))


def rough_glass():
    lamp('AREA', (-1, -1, 2.2), 60, size=1.2)
    glass = plain('ShaderNodeBsdfGlass', Color=(1, 1, 1, 1), Roughness=.4, IOR=1.45)
    glass.node_tree.nodes["Glass BSDF"].distribution = 'GGX'
    ball(glass, (0, -0.2, 0.6), 0.6)


def textures():
    lamp('AREA', (-1, -1, 2.2), 60, size=1.2)
    rng = np.random.default_rng(1)

    def checker(tree):
        node = _shader(tree, 'ShaderNodeTexChecker', Color1=(.8, .2, .1, 1), Color2=(.1, .3, .8, 1), Scale=6)
        return _shader(tree, 'ShaderNodeBsdfDiffuse', Color=node.outputs["Color"]).outputs[0]

    def image(tree):
        node = tree.nodes.new('ShaderNodeTexImage')
        node.image = picture("Noise", rng.random((16, 16, 3), np.float32))
        bump = _shader(tree, 'ShaderNodeBump', Height=node.outputs["Color"], Strength=0.5, Distance=0.05)
        return _shader(tree, 'ShaderNodeBsdfDiffuse', Color=node.outputs["Color"], Normal=bump.outputs["Normal"]).outputs[0]

    ball(_node_material("Checker", checker), (-0.7, 0, 0.5)), box(_node_material("Image", image), (0.7, 0, 0.5), (0.9, 0.9, 0.9))


def see_through():
    lamp('AREA', (-1, -1, 2.2), 60, size=1.2)

    def leaf(tree):
        mix = tree.nodes.new('ShaderNodeMixShader')
        mix.inputs[0].default_value = 0.6
        tree.links.new(tree.nodes.new('ShaderNodeBsdfTransparent').outputs[0], mix.inputs[1])
        tree.links.new(_shader(tree, 'ShaderNodeBsdfTranslucent', Color=(.5, .5, .5, 1)).outputs[0], mix.inputs[2])  # Cycles 3.4 mixes colours of alpha cards wrongly
        return mix.outputs[0]

    bpy.ops.mesh.primitive_plane_add(size=1.4, location=(0, -0.3, 1), rotation=(1.2, 0.3, 0))
    _add("Leaf", _node_material("Leaf", leaf), smooth=False)


def low_poly():
    lamp('POINT', (-1.2, -1.2, 2), 80, shadow_soft_size=0.01)
    ball(diffuse(.8, .8, .8), (0, 0, 0.7), 0.7, segments=12)


def rendered(scene, path):
    scene.render.filepath = str(path)
    bpy.ops.render.render()
    bpy.data.images["Render Result"].save_render(str(path), scene=scene)
    loaded = bpy.data.images.load(str(path))
    pixels = np.empty(SIDE * SIDE * 4, np.float32)
    loaded.pixels.foreach_get(pixels)
    bpy.data.images.remove(loaded)
    return pixels.reshape(SIDE, SIDE, 4)[..., :3].astype(np.float64)


def block_means(pixels):
    side = SIDE // BLOCKS
    return pixels.reshape(BLOCKS, side, BLOCKS, side, 3).mean((1, 3))


def by_cycles(scene, path, samples):
    scene.render.engine = 'CYCLES'
    cycles = scene.cycles
    cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = samples, False, False
    cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = 0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 12
    cycles.caustics_reflective = cycles.caustics_refractive = True
    pictures = []
    for seed in range(SEEDS):
        cycles.seed = seed
        pictures.append(block_means(rendered(scene, path)))
    return np.array(pictures)


def by_sluice(scene, path, passes):
    scene.render.engine = 'SLUICE'
    scene.sluice.passes, scene.sluice.photons, scene.sluice.max_depth = passes, 40000, 13
    pictures = []
    for seed in range(SEEDS):
        scene.sluice.seed = seed
        pictures.append(block_means(rendered(scene, path)))
    return np.array(pictures)


def noise_bound(a, b, false_alarm):
    """What the means of two sets of independent samples (seeds first) may differ by, by chance alone (Welch)."""
    va, vb = a.var(0, ddof=1) / len(a), b.var(0, ddof=1) / len(b)
    freedom = (va + vb) ** 2 / (va ** 2 / (len(a) - 1) + vb ** 2 / (len(b) - 1))
    grid = np.arange(len(a) - 1, len(a) + len(b) - 1)  # at least the smaller set's, at most both together
    quantiles = np.array([student_quantile(false_alarm, at) for at in grid])
    return np.interp(freedom, grid, quantiles) * np.sqrt(va + vb)


@pytest.mark.parametrize("content", [lamps_small, spot, lamps_large, emissive_mesh, sky, glossy, mirror_and_glass, rough_glass, textures, see_through, low_poly],
                         ids=lambda content: content.__name__)
def test_like_cycles(content, tmp_path):
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = 'OPEN_EXR', '32'
    world()
    stage()
    content()
    cycles = by_cycles(scene, tmp_path / "cycles.exr", 512 if FULL else 128)
    ours = by_sluice(scene, tmp_path / "sluice.exr", 32 if FULL else 12)
    truth, difference = cycles.mean(0), ours.mean(0) - cycles.mean(0)
    noise = noise_bound(ours, cycles, FALSE_ALARM / truth.size)
    assert np.median(noise / truth) < 0.06, f"too noisy to tell: {np.median(noise / truth):.3f}"
    allowed = 0.02 * truth + 0.001 * truth.mean() + noise
    worst = np.unravel_index(np.argmax(np.abs(difference) - allowed), difference.shape)
    assert (np.abs(difference) <= allowed).all(), (
        f"block {worst}: ours {ours.mean(0)[worst]:.4f}, Cycles {truth[worst]:.4f}, noise {noise[worst]:.4f}; "
        f"all {ours.mean() / cycles.mean():.4f}; blocks beyond: {(np.abs(difference) > allowed).sum()} of {difference.size}")
    means = ours.mean((1, 2, 3)), cycles.mean((1, 2, 3))
    assert abs(means[0].mean() - means[1].mean()) <= 0.01 * truth.mean() + noise_bound(*means, FALSE_ALARM)
