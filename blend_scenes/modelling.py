# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scene scripts share: a clean file, meshes, materials, painted textures, lights, a camera, quads of light edits, saving.

Lengths are metres, colours linear, Z is up. Only nodes that Sluice reads are used. A script runs as
./run blender -b --python blend_scenes/NAME.py and writes NAME.blend beside itself."""

import math
import os
import sys
import tempfile

import bpy
import numpy as np
from mathutils import Matrix, Vector

HERE = os.path.dirname(os.path.abspath(__file__))


# --- file ---------------------------------------------------------------------------------------------------------------------------


def start(width=960, height=540):
    """An empty file with Sluice as its engine and a black world; returns the scene."""
    for collection in (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.lights, bpy.data.cameras, bpy.data.worlds,
                       bpy.data.collections):
        for item in list(collection):
            collection.remove(item)
    scene = bpy.context.scene
    if not hasattr(scene, "sluice"):
        sys.exit("the Sluice add-on is not enabled: start this script with ./run blender -b --python ...")
    scene.render.engine = "SLUICE"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.frame_start = scene.frame_end = 1
    scene.view_settings.view_transform = "Filmic"
    scene.view_settings.look = "Medium High Contrast"
    world((0, 0, 0))
    return scene


def save(script):
    """Writes the .blend beside the script, with everything it uses inside."""
    path = os.path.splitext(os.path.abspath(script))[0] + ".blend"
    _set_the_stage()
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=path, compress=True, check_existing=False)
    print(f"{path}: {os.path.getsize(path) / 1024:.0f} KiB")


def _set_the_stage():
    """The file opens at its first edit, seen through the camera in the colours of the materials. (Rendered mode is never saved.)"""
    edits = sorted((item for item in bpy.context.scene.objects if item.sluice.role == "ENTRY"), key=lambda item: item.sluice.order)
    for item in bpy.context.scene.objects:
        item.select_set(item in edits[:1])
    bpy.context.view_layer.objects.active = edits[0]
    for space in (area.spaces.active for screen in bpy.data.screens for area in screen.areas):
        if space.type == "VIEW_3D":
            space.region_3d.view_perspective, space.region_3d.view_camera_zoom = "CAMERA", 20
            space.shading.color_type = "MATERIAL"
        elif space.type == "PROPERTIES":
            space.context = "DATA"


def _add(name, data, parent=None):
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    item.parent = parent
    return item


# --- meshes -------------------------------------------------------------------------------------------------------------------------


def mesh(name, vertices, faces, material, smooth=False):
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(v) for v in vertices], [], faces)
    data.materials.append(material)
    data.polygons.foreach_set("use_smooth", [smooth] * len(faces))
    data.update()
    return _add(name, data)


def quad(name, corners, material, uv_scale=1.0):
    """A rectangle a, b, c, d with UVs in metres along ab and ad, divided by uv_scale; None: one image over all of it."""
    item = mesh(name, corners, [(0, 1, 2, 3)], material)
    a, b, _, d = (Vector(c) for c in corners)
    width, height = ((b - a).length / uv_scale, (d - a).length / uv_scale) if uv_scale else (1, 1)
    layer = item.data.uv_layers.new(name="UVMap")
    for loop, uv in zip(layer.data, ((0, 0), (width, 0), (width, height), (0, height)), strict=True):
        loop.uv = uv
    return item


def box(name, size, location, material, bevel=0.0, turn=0.0):
    """A box of the full size, turned about Z by degrees; its UVs are metres in each face's plane."""
    x, y, z = (s / 2 for s in size)
    corners = [(i * x, j * y, k * z) for k in (-1, 1) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    item = mesh(name, corners, faces, material)
    layer = item.data.uv_layers.new(name="UVMap")
    for polygon in item.data.polygons:
        along = [axis for axis in range(3) if abs(polygon.normal[axis]) < 0.5]
        for loop in polygon.loop_indices:
            position = item.data.vertices[item.data.loops[loop].vertex_index].co
            layer.data[loop].uv = (position[along[0]], position[along[1]])
    item.location, item.rotation_euler = location, (0, 0, math.radians(turn))
    if bevel:
        modifier = item.modifiers.new("Bevel", "BEVEL")
        modifier.width, modifier.segments = bevel, 3
        round_off(item)
    return item


def lathe(name, profile, location, material, segments=48, levels=2):
    """A profile [(radius, z), …] turned about Z and subdivided; a radius of 0 closes an end."""
    rings = [i for i, (r, _) in enumerate(profile) if r > 0]
    vertices = [(r * math.cos(2 * math.pi * s / segments), r * math.sin(2 * math.pi * s / segments), z)
                for r, z in (profile[i] for i in rings) for s in range(segments)]  # fmt: skip
    faces = [(i * segments + s, i * segments + (s + 1) % segments, (i + 1) * segments + (s + 1) % segments, (i + 1) * segments + s)
             for i in range(len(rings) - 1) for s in range(segments)]  # fmt: skip
    for end, first, turn in ((0, 0, -1), (len(profile) - 1, (len(rings) - 1) * segments, 1)):
        if profile[end][0] == 0:
            vertices.append((0, 0, profile[end][1]))
            faces += [(first + s, first + (s + 1) % segments, len(vertices) - 1)[::turn] for s in range(segments)]
    item = mesh(name, vertices, faces, material, smooth=True)
    item.location = location
    subdivide(item, levels)
    return item


def sphere(name, radius, location, material):
    """A sphere by subdivision of a cube cast to a ball: even quads, no poles."""
    bpy.ops.mesh.primitive_cube_add(size=2 * radius, location=location)
    item = bpy.context.object
    item.name = item.data.name = name
    item.data.materials.append(material)
    subdivide(item, 5)
    cast = item.modifiers.new("Cast", "CAST")
    cast.factor, cast.radius, cast.use_radius_as_size, cast.size = 1, 0, False, radius
    item.data.polygons.foreach_set("use_smooth", [True] * len(item.data.polygons))
    return item


def subdivide(item, levels):
    modifier = item.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = min(levels, 2), levels


def round_off(item):
    """Smooth shading that keeps flat faces flat (before and after Blender 4.1, which made it a modifier)."""
    item.data.polygons.foreach_set("use_smooth", [True] * len(item.data.polygons))
    if hasattr(item.data, "use_auto_smooth"):
        item.data.use_auto_smooth, item.data.auto_smooth_angle = True, math.radians(40)
        item.modifiers.new("Weighted normals", "WEIGHTED_NORMAL")


# --- materials ----------------------------------------------------------------------------------------------------------------------


def material(name, node, **inputs):
    """A material of one shader node; inputs are numbers, colours (3) or image textures."""
    item = bpy.data.materials.new(name)
    item.use_nodes = True
    tree = item.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new(node), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    for key, value in inputs.items():
        if "Color" in key:
            item.diffuse_color = _solid(value)
        socket = shader.inputs[key.replace("_", " ")]
        if isinstance(value, bpy.types.Image):
            texture = tree.nodes.new("ShaderNodeTexImage")
            texture.image = value
            tree.links.new(texture.outputs["Color"], socket)
        else:
            socket.default_value = (*value, 1) if isinstance(value, tuple) else value
    return item


def _solid(value):
    """What the viewport's solid mode shows of a colour or of an image."""
    if isinstance(value, bpy.types.Image):
        pixels = np.empty(len(value.pixels), np.float32)
        value.pixels.foreach_get(pixels)
        return (*(pixels.reshape(-1, 4)[:, :3].mean(0) ** 2.2).tolist(), 1)
    return (*value, 1)


def matte(name, color):
    return material(name, "ShaderNodeBsdfDiffuse", Color=color)


def glossy(name, color, roughness):
    """A coloured base under a clear gloss. Of nodes that mean the same in every Blender; the base of Principled gets darker in 4.0."""
    item = material(name, "ShaderNodeBsdfDiffuse", Color=color)
    tree = item.node_tree
    base, output = (next(n for n in tree.nodes if n.bl_idname == kind) for kind in ("ShaderNodeBsdfDiffuse", "ShaderNodeOutputMaterial"))
    gloss, fresnel, mix = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfGlossy", "Fresnel", "MixShader"))
    gloss.inputs["Color"].default_value, gloss.inputs["Roughness"].default_value, fresnel.inputs["IOR"].default_value = (1, 1, 1, 1), roughness, 1.45
    for source, socket in ((fresnel, 0), (base, 1), (gloss, 2)):
        tree.links.new(source.outputs[0], mix.inputs[socket])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    return item


def glass(name, color=(1, 1, 1), ior=1.5):
    return material(name, "ShaderNodeBsdfGlass", Color=color, Roughness=0.0, IOR=ior)


def mirror(name, color=(0.9, 0.9, 0.9), roughness=0.0):
    return material(name, "ShaderNodeBsdfGlossy", Color=color, Roughness=roughness)


def lamp(name, color, strength):
    return material(name, "ShaderNodeEmission", Color=color, Strength=strength)


def world(color, strength=1.0):
    item = bpy.context.scene.world or bpy.data.worlds.new("World")
    bpy.context.scene.world = item
    item.use_nodes = True
    background = item.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1)
    background.inputs["Strength"].default_value = strength


def bump(item, image, strength, distance=0.001):
    """Roughens a material by a grey image over its first UV map."""
    tree = item.node_tree
    texture, node = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeBump")
    texture.image = image
    image.colorspace_settings.name = "Non-Color"
    node.inputs["Strength"].default_value, node.inputs["Distance"].default_value = strength, distance
    tree.links.new(texture.outputs["Color"], node.inputs["Height"])
    for other in (n for n in tree.nodes if "Normal" in n.inputs and n != node):
        tree.links.new(node.outputs["Normal"], other.inputs["Normal"])
    return item


# --- painted textures ---------------------------------------------------------------------------------------------------------------


def image(name, pixels, colorspace="sRGB"):
    """A texture from an array (rows, columns, 3) of stored values in [0, 1], row 0 at the bottom; packed as JPEG."""
    rows, columns, _ = pixels.shape
    drawn = bpy.data.images.new(name, columns, rows)
    drawn.pixels.foreach_set(np.dstack([pixels, np.ones((rows, columns))]).clip(0, 1).astype(np.float32).ravel())
    with tempfile.TemporaryDirectory() as folder:
        drawn.filepath_raw, drawn.file_format = os.path.join(folder, "texture.jpg"), "JPEG"
        drawn.save()
        packed = bpy.data.images.load(drawn.filepath_raw)
        packed.pack()
    bpy.data.images.remove(drawn)
    packed.name, packed.filepath_raw, packed.colorspace_settings.name = name, "", colorspace
    return packed


def noise(rng, rows, columns, across, along, octaves=4):
    """Smooth noise that repeats, mean 0, with `across` and `along` features per side in its first octave."""
    total = np.zeros((rows, columns))
    y, x = (np.arange(n) / n for n in (rows, columns))
    for octave in range(octaves):
        ny, nx = across << octave, along << octave
        grid = rng.standard_normal((ny, nx))

        def weights(t, n):
            i = np.floor(t * n).astype(int)
            f = t * n - i
            return i % n, (i + 1) % n, f * f * (3 - 2 * f)

        (y0, y1, fy), (x0, x1, fx) = weights(y, ny), weights(x, nx)
        low, high = (grid[r][:, x0] * (1 - fx) + grid[r][:, x1] * fx for r in (y0, y1))
        total += (low * (1 - fy)[:, None] + high * fy[:, None]) / 2**octave
    return total


def wood(name, light, dark, planks, seed, size=512):
    """Boards along U with grain, each with its own tone; light and dark are display colours."""
    rng = np.random.default_rng(seed)
    board = size // planks
    rows = []
    for _ in range(planks):
        shift = rng.integers(size)
        warp = noise(rng, board, size, 2, 2, 3)
        v = np.linspace(0, 1, board)[:, None]
        rings = np.sin(2 * math.pi * (rng.uniform(3, 6) * v + 0.35 * warp + rng.uniform()))
        fibre = noise(rng, board, size, max(board // 4, 1), 3, 3)
        tone = 0.5 + 0.16 * rings + 0.10 * fibre + 0.10 * rng.standard_normal()
        groove = np.minimum(1, np.minimum(np.arange(board), np.arange(board)[::-1]) / 1.6)[:, None]
        if planks > 1:
            tone = np.roll(tone, shift, axis=1).clip(0, 1) * (0.35 + 0.65 * groove**0.7)
        rows.append(tone.clip(0, 1)[..., None])
    mix = np.concatenate(rows)
    mix = np.concatenate([mix, mix[-1:].repeat(size - mix.shape[0], axis=0)])
    return image(name, np.array(dark) * (1 - mix) + np.array(light) * mix)


# --- lights and camera --------------------------------------------------------------------------------------------------------------


def light(name, kind, location, power, color=(1, 1, 1), target=None, **settings):
    """A lamp looking at target; power is W, for a sun W/m²; settings are the datablock's own (shadow_soft_size, size, angle, …)."""
    data = bpy.data.lights.new(name, kind)
    data.energy, data.color = power, color
    for key, value in settings.items():
        setattr(data, key, value)
    item = _add(name, data)
    item.location = location
    if target is not None:
        item.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    return item


def camera(location, target, lens=50.0, focus=None, f_stop=8.0):
    data = bpy.data.cameras.new("Camera")
    data.lens, data.clip_start = lens, 0.01
    item = _add("Camera", data)
    item.location = location
    item.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    if focus is not None:
        data.dof.use_dof, data.dof.aperture_fstop = True, f_stop
        data.dof.focus_distance = (Vector(focus) - Vector(location)).length
    bpy.context.scene.camera = item
    return item


# --- light edits --------------------------------------------------------------------------------------------------------------------


def collect(name, items):
    """The items in a collection of their own, by whose name expressions can mean them all."""
    collection = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(collection)
    for item in items:
        collection.objects.link(item)


def aim(turn, rise):
    """The unit vector that points to -Y turned about Z by degrees, then raised by degrees."""
    a, b = math.radians(turn), math.radians(rise)
    return Vector((math.sin(a) * math.cos(b), -math.cos(a) * math.cos(b), math.sin(b)))


def _quad_empty(name, location, arrow, along, size):
    """An Empty whose square (size: full width along `along`, full height) lies at the location and whose arrow (+Z) points as told."""
    item = _add(name, None)
    item.empty_display_type, item.empty_display_size = "SINGLE_ARROW", size[0] / 2
    z = Vector(arrow).normalized()
    x = (Vector(along) - Vector(along).dot(z) * z).normalized()
    frame = Matrix((x, z.cross(x), z)).transposed().to_4x4()
    item.matrix_world = Matrix.Translation(location) @ frame @ Matrix.Diagonal((1, size[1] / size[0], 1, 1))
    return item


def entry(name, expression, location, arrow, along, size, **settings):
    """Captures the light whose path so far matches the expression. The arrow points away from the receiver behind it."""
    item = _quad_empty(name, location, arrow, along, size)
    item.sluice.role, item.sluice.expression = "ENTRY", expression  # the role gives it its order
    for key, value in settings.items():
        setattr(item.sluice, key, value)
    return item


def exit_of(edit, name, location, arrow, along, size, **settings):
    """Re-emits what the entry captures."""
    item = _quad_empty(name, location, arrow, along, size)
    item.sluice.role, item.sluice.entry = "EXIT", edit
    for key, value in settings.items():
        setattr(item.sluice, key, value)
    return item
