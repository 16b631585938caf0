# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps. Power is what the lamp's panel shows (W; sun W/m²); the core knows Cycles' conventions."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from .. import compat
from .description import Description, Rows, Warn
from .material import light_emission

if TYPE_CHECKING:
    import bpy

_KINDS = {'POINT': 'Point', 'SPOT': 'Spot', 'SUN': 'Sun', 'AREA': 'Area'}
_SHAPES = {'SQUARE': 'Square', 'RECTANGLE': 'Rectangle', 'DISK': 'Disk', 'ELLIPSE': 'Ellipse'}


def export_light(item: bpy.types.Object, matrix_world: Rows, names: list[str], warn: Warn) -> Description:
    """A LightDescription of a lamp object at `matrix_world`."""
    lamp = item.data
    tint, factor = light_emission(lamp, warn)
    color = [a * b for a, b in zip(_color(lamp), tint)]
    description = {
        "names": names,
        "kind": _KINDS[lamp.type],
        "matrix": compat.matrix(matrix_world),
        "color": tuple(color),
        "power": lamp.energy * factor * 2.0 ** getattr(lamp, "exposure", 0.0) * _newer_area(lamp),
        "radius": getattr(lamp, "shadow_soft_size", 0.0),
        "casts_shadow": bool(getattr(lamp, "use_shadow", True)),
        "visible_to_camera": False,
    }
    if lamp.type == 'SUN':
        description["angle"] = lamp.angle
    elif lamp.type == 'SPOT':
        description["spot_angle"], description["spot_blend"] = lamp.spot_size, lamp.spot_blend
        # Older spots of Cycles fall off with the cosine (measured in 3.4 and 4.3).
        description["spot_cosine"] = not _is_newer(lamp)
    elif lamp.type == 'AREA':
        description["shape"] = _SHAPES[lamp.shape]
        description["size_x"] = lamp.size
        description["size_y"] = lamp.size_y if lamp.shape in {'RECTANGLE', 'ELLIPSE'} else lamp.size
        description["spread"] = getattr(lamp, "spread", math.pi)
    if not getattr(lamp, "normalize", True):  # Since 4.5 the power may be one per area.
        warn(item.original.name, "Normalize off is not supported: the lamp's power is taken as the whole lamp's")
    return description


def _is_newer(lamp: bpy.types.Light) -> bool:
    """Does this Blender's Cycles measure lamps in the newer way? A property of lamps that came with 4.2 tells."""
    return hasattr(lamp, "shadow_filter_radius")


def _newer_area(lamp: bpy.types.Light) -> float:
    """The factor on the power of area lamps. Their radiance is power / (4 area) in the Cycles of Blender 3, as in the core, and
    power / (pi area) in newer ones (measured in 4.3 and 5.2)."""
    return 4 / math.pi if lamp.type == 'AREA' and _is_newer(lamp) else 1.0


def _color(lamp: Any) -> list[float]:
    """The lamp's colour times that of its temperature (4.5)."""
    color = list(lamp.color)
    if getattr(lamp, "use_temperature", False):
        color = [a * b for a, b in zip(color, lamp.temperature_color)]
    return color
