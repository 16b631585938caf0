# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that Blender's threads make anew each time: those that it cannot make steadily are told, all others are the same in every bit."""
import math
import os

import bits
import bpy
import numpy as np
import pytest
from blender_scenes import auto_smooth, geometry_tree, modified, sphere

FULL = bool(os.environ.get("SLUICE_FULL"))
TIMES = 20 if FULL else 4
RACES = "corner_normals" not in bpy.types.Mesh.bl_rna.properties


def _dense():
    return sphere(segments=128, ring_count=64)


def _texture():
    return bpy.data.textures.new("Clouds", 'CLOUDS')


def _target():
    return bpy.data.objects.new("Target", _dense().data.copy())


def _nodes(item, kind, mode=None):
    """Geometry nodes: the mesh through one node, which takes its offset from a Normal node where it has one."""
    tree, first, last = geometry_tree()
    node = tree.nodes.new(kind)
    if mode:
        node.mode = mode
    else:
        tree.links.new(tree.nodes.new('GeometryNodeInputNormal').outputs[0], node.inputs["Offset"])
    tree.links.new(first.outputs[0], node.inputs[0])
    tree.links.new(node.outputs[0], last.inputs[0])
    return modified(item, 'NODES', node_group=tree)


def _particles():
    item = _dense()
    modified(item, 'PARTICLE_SYSTEM')
    settings = item.particle_systems[0].settings
    settings.count, settings.render_type, settings.instance_object = 10, 'OBJECT', sphere()
    return item


def _custom():
    item = auto_smooth(_dense(), math.pi)
    random = np.random.default_rng(5).normal(size=(len(item.data.vertices), 3))
    item.data.normals_split_custom_set_from_vertices((random / np.linalg.norm(random, axis=1)[:, None]).tolist())
    return item


def _hard_bevel():
    item = auto_smooth(_dense(), math.pi)
    item.data.uv_layers.remove(item.data.uv_layers[0])  # Blender 5.2 gives bevels other last bits of UVs each time
    return modified(item, 'BEVEL', harden_normals=True, width=0.003, limit_method='NONE')


RACING = {
    "displace": lambda: modified(_dense(), 'DISPLACE', texture=_texture()),
    "displace, custom normals": lambda: modified(auto_smooth(_dense(), 0.5), 'DISPLACE', texture=_texture(), direction='CUSTOM_NORMAL'),
    "solidify": lambda: modified(_dense(), 'SOLIDIFY'), "even solidify": lambda: modified(_dense(), 'SOLIDIFY', use_even_offset=True),
    "wave": lambda: modified(_dense(), 'WAVE', use_normal=True), "wireframe": lambda: modified(_dense(), 'WIREFRAME'),
    "shrinkwrap": lambda: modified(_dense(), 'SHRINKWRAP', target=_target(), wrap_method='PROJECT'), "particles": _particles,
    "push": lambda: _nodes(_dense(), 'GeometryNodeSetPosition'), "extruded edges": lambda: _nodes(_dense(), 'GeometryNodeExtrudeMesh', 'EDGES'),
}
STEADY = {
    "smooth": _dense, "auto smooth": lambda: auto_smooth(_dense(), 0.5), "custom": _custom,
    "weighted": lambda: modified(auto_smooth(_dense(), math.pi), 'WEIGHTED_NORMAL'),
    "normal edit": lambda: modified(auto_smooth(_dense(), math.pi), 'NORMAL_EDIT', mix_factor=0.5),
    "hard bevel": _hard_bevel,
    "displace along z": lambda: modified(_dense(), 'DISPLACE', texture=_texture(), direction='Z'),
    "quality solidify": lambda: modified(_dense(), 'SOLIDIFY', use_quality_normals=True),
    "complex solidify": lambda: modified(_dense(), 'SOLIDIFY', solidify_mode='NON_MANIFOLD'),
    "wave along z": lambda: modified(_dense(), 'WAVE'), "remesh": lambda: modified(_dense(), 'REMESH', voxel_size=0.05, use_smooth_shade=True),
    "corrective smooth": lambda: modified(_dense(), 'CORRECTIVE_SMOOTH'), "subdivision": lambda: modified(_dense(), 'SUBSURF'),
    "array": lambda: modified(_dense(), 'ARRAY', count=3), "decimate": lambda: modified(_dense(), 'DECIMATE', ratio=0.5),
    "cast": lambda: modified(_dense(), 'CAST'),
    "boolean": lambda: modified(sphere(), 'BOOLEAN', object=bpy.data.objects.new("Target", sphere().data.copy()), solver='EXACT'),
    "extruded faces": lambda: _nodes(_dense(), 'GeometryNodeExtrudeMesh', 'FACES'),
    "few faces": lambda: modified(sphere(), 'DISPLACE', texture=_texture()),
}

QUICK = ["smooth", "auto smooth", "custom", "weighted", "hard bevel", "quality solidify", "few faces"]


def _told(warnings):
    return {item for item, message in warnings if "last bits" in message}


@pytest.mark.parametrize("kind", RACING)
def test_what_races_is_told(export_now, kind):
    item = RACING[kind]()
    assert _told(export_now()[1]) == ({item.name} if RACES else set())


@pytest.mark.parametrize("kind", STEADY if FULL else QUICK)
def test_all_else_is_steady(export_now, kind):
    item = STEADY[kind]()
    found = set()
    for _time in range(TIMES):
        item.data.update()  # its normals are to be made anew
        item.update_tag(refresh={'DATA'})
        description, warnings = export_now()
        assert not _told(warnings)
        found.add(bits.fingerprint(description["meshes"]))
    assert len(found) == 1
