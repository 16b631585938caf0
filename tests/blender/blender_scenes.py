# SPDX-License-Identifier: GPL-3.0-or-later
"""What several tests need to make and to read in Blender: meshes, node trees, files, the channels of images. Fixtures are in conftest.py."""
import re
import subprocess

import bpy
import numpy as np


def write_layers(scene):
    """Multilayer EXR of full floats. From 5.0 the kind of medium is chosen first, and layers are parts."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = 'MULTI_LAYER_IMAGE'
    settings.file_format, settings.color_depth = 'OPEN_EXR_MULTILAYER', '32'
    if hasattr(settings, "use_exr_interleave"):
        settings.use_exr_interleave = True  # all layers in one part, as it was before


def oiiotool(*args):
    """What OpenImageIO's own program prints."""
    return subprocess.run(["oiiotool", *map(str, args)], capture_output=True, text=True, check=True).stdout


def channels(path):
    """{'ViewLayer.Depth.Z': (h, w)} of an EXR file, row 0 at the bottom, read by OpenImageIO's own tool."""
    names = re.search(r"channel list: (.*)", oiiotool("--info", "-v", path)).group(1).split(", ")
    lines = oiiotool("--dumpdata", path).splitlines()
    found = [re.match(r"\s*Pixel \((\d+), (\d+)\): (.*)", line) for line in lines]
    cells = [(int(m[1]), int(m[2]), [float(number) for number in m[3].split()]) for m in found if m]
    x0, y0 = min(cell[0] for cell in cells), min(cell[1] for cell in cells)
    width, height = max(cell[0] for cell in cells) - x0 + 1, max(cell[1] for cell in cells) - y0 + 1
    pixels = np.zeros((height, width, len(names)))
    for x, y, values in cells:
        pixels[y - y0, x - x0] = values
    return {name: pixels[::-1, :, index] for index, name in enumerate(names)}


def save(tmp_path, name="scene"):
    """Saves the open file in a folder; returns its path."""
    path = tmp_path / f"{name}.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def compositor_of(scene):
    """The node tree of a scene's compositor, switched on."""
    if hasattr(scene, "compositing_node_group"):  # 5.0
        scene.compositing_node_group = bpy.data.node_groups.new("Compositor", 'CompositorNodeTree')
        return scene.compositing_node_group
    scene.use_nodes = True
    return scene.node_tree


def ask_for_all_passes(scene):
    """Switches on every render pass of every view layer."""
    for view_layer in scene.view_layers:
        view_layer.use_pass_z = view_layer.use_pass_normal = True
        for item in view_layer.sluice.bl_rna.properties:
            if item.identifier.startswith("use_pass_"):
                setattr(view_layer.sluice, item.identifier, True)


def made_by(operator, **settings):
    """The object that an operator makes."""
    operator(**settings)
    return bpy.context.object


def smooth(item, flags=True):
    """The object, its faces smooth where flags say so (repeated as often as needed)."""
    count = len(item.data.polygons)
    item.data.polygons.foreach_set("use_smooth", np.resize(flags, count))
    item.data.update()
    return item


def sphere(**settings):
    """A smooth sphere."""
    return smooth(made_by(bpy.ops.mesh.primitive_uv_sphere_add, **settings))


def auto_smooth(item, angle):
    """The object with Auto Smooth, in Blenders that have it."""
    if hasattr(item.data, "use_auto_smooth"):
        item.data.use_auto_smooth, item.data.auto_smooth_angle = True, angle
    return item


def modified(item, kind, **settings):
    """The object with one more modifier of these settings."""
    modifier = item.modifiers.new(kind, kind)
    for name, value in settings.items():
        setattr(modifier, name, value)
    return item


def geometry_tree():
    """(tree, its input node, its output node): geometry nodes that take a geometry and give one."""
    tree = bpy.data.node_groups.new("Tree", 'GeometryNodeTree')
    if hasattr(tree, "interface"):
        for side in ('INPUT', 'OUTPUT'):
            tree.interface.new_socket("Geometry", in_out=side, socket_type='NodeSocketGeometry')
    else:
        tree.inputs.new('NodeSocketGeometry', "Geometry")
        tree.outputs.new('NodeSocketGeometry', "Geometry")
    return tree, tree.nodes.new('NodeGroupInput'), tree.nodes.new('NodeGroupOutput')
