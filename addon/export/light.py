# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps. Power is what the lamp's panel shows (W; sun W/m²); the core knows Cycles' conventions."""
import math

import numpy as np

_KINDS = {'POINT': 'Point', 'SPOT': 'Spot', 'SUN': 'Sun', 'AREA': 'Area'}
_SHAPES = {'SQUARE': 'Square', 'RECTANGLE': 'Rectangle', 'DISK': 'Disk', 'ELLIPSE': 'Ellipse'}


def export_light(item, matrix_world, names, warn):
    """A LightDescription of a lamp object at `matrix_world`."""
    lamp = item.data
    factor, tint = _node_emission(lamp, item.original.name, warn)
    color = [a * b for a, b in zip(_color(lamp), tint)]
    description = {
        "names": names,
        "kind": _KINDS[lamp.type],
        "matrix": np.array(matrix_world, np.float64),
        "color": tuple(color),
        "power": lamp.energy * factor * 2.0 ** getattr(lamp, "exposure", 0.0),
        "radius": getattr(lamp, "shadow_soft_size", 0.0),
        "casts_shadow": bool(getattr(lamp, "use_shadow", True)),
        "visible_to_camera": False,
    }
    if lamp.type == 'SUN':
        description["angle"] = lamp.angle
    elif lamp.type == 'SPOT':
        description["spot_angle"], description["spot_blend"] = lamp.spot_size, lamp.spot_blend
    elif lamp.type == 'AREA':
        description["shape"] = _SHAPES[lamp.shape]
        description["size_x"] = lamp.size
        description["size_y"] = lamp.size_y if lamp.shape in {'RECTANGLE', 'ELLIPSE'} else lamp.size
        description["spread"] = getattr(lamp, "spread", math.pi)
    if not getattr(lamp, "normalize", True):  # 4.5: power per area instead of power
        warn(item.original.name, "Normalize off is not supported: the lamp's power is taken as the whole lamp's")
    return description


def _color(lamp):
    """The lamp's colour times that of its temperature (4.5)."""
    color = list(lamp.color)
    if getattr(lamp, "use_temperature", False):
        color = [a * b for a, b in zip(color, lamp.temperature_color)]
    return color


def _node_emission(lamp, name, warn):
    """(strength, colour) of a lamp's node tree: one Emission node with plain numbers, as Blender makes it. Else a warning."""
    plain = 1.0, (1.0, 1.0, 1.0)
    if not lamp.use_nodes or lamp.node_tree is None:
        return plain
    emissions = [node for node in lamp.node_tree.nodes if node.bl_idname == 'ShaderNodeEmission']
    extra = [node for node in lamp.node_tree.nodes
             if node.bl_idname not in {'ShaderNodeEmission', 'ShaderNodeOutputLight', 'NodeReroute', 'NodeFrame'}]
    if len(emissions) != 1 or extra:
        warn(name, "the lamp's shader nodes are ignored; its colour and power are used")
        return plain
    strength, color = emissions[0].inputs["Strength"], emissions[0].inputs["Color"]
    return strength.default_value, tuple(color.default_value[:3])
