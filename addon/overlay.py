# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits drawn in the 3D view: entries blue, exits mauve (the paper's colours) and filled with their tint, arrow, link line and name;
dimmed where they do not act, dashed where the last render found no light for them. Hidden by the overlay switch.

Shaders are made in the draw callback, never at registration: without a window they raise, or crash Blender."""
from __future__ import annotations

from collections.abc import Iterable
from types import ModuleType
from typing import Any, NamedTuple

import bpy
import numpy as np
from mathutils import Color

from . import compat, edit_statistics, model
from .interface import ENTRY_COLOR, EXIT_COLOR

# Quads lie on surfaces: they are drawn nearer by this fraction of the distance, so that they do not flicker.
_TOWARDS_EYE = 0.004
_DASHES = 9  # Each side of a quad is cut into so many.
_handles: list[Any] = []


class Shape(NamedTuple):
    """What is drawn of edits, as lists of (points, colour or colours)."""

    fills: list[tuple[Any, Any]]  # three points for each triangle
    lines: list[tuple[Any, Any]]  # two points for each line


def quad_corners(item: bpy.types.Object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The four corners of an edit's quad in world space, counter-clockwise seen from the arrow's side, then the centre and the tip
    of the arrow."""
    s = item.empty_display_size
    matrix = np.array(item.matrix_world)
    local = np.array(((-s, -s, 0, 1), (s, -s, 0, 1), (s, s, 0, 1), (-s, s, 0, 1)))
    corners = (local @ matrix.T)[:, :3]
    x, y = corners[1] - corners[0], corners[3] - corners[0]
    normal = np.cross(x, y)
    length = np.linalg.norm(normal)
    if length > 0:
        normal *= np.sign(np.dot(normal, matrix[:3, 2]) or 1) / length
    reach = 0.35 * min(np.linalg.norm(x), np.linalg.norm(y))
    centre = matrix[:3, 3]
    return corners, centre, centre + normal * reach


def _looks(item: bpy.types.Object, scene: bpy.types.Scene) -> tuple[tuple[float, ...], float, bool]:
    """How an edit's Empty is drawn: (colour, opacity, whether its border is dashed)."""
    entry = model.entry_of(item)
    alive = entry is not None and model.acts(scene, entry) and entry.name in scene.objects
    found = edit_statistics.of(entry.name_full) if alive else None
    strength = (1.0 if item.select_get() else 0.65) * (1.0 if alive else 0.35)
    return ENTRY_COLOR if item.sluice.role == 'ENTRY' else EXIT_COLOR, strength, found is not None and not found.acted


def _fill(edit: Any, color: tuple[float, ...]) -> tuple[float, ...]:
    """The colour within a quad's border: its tint at full brightness, if it has one."""
    high = max(edit.tint)
    if edit.role == 'ENTRY' or min(edit.tint) == high:
        return color
    return tuple(Color([part / high for part in edit.tint]).from_scene_linear_to_srgb()[:])


def _dashes(points: np.ndarray) -> np.ndarray:
    """Lines, given as pairs of points, cut into dashes."""
    steps = np.linspace(0, 1, 2 * _DASHES)[:, None]
    return np.concatenate([a + steps * (b - a) for a, b in points.reshape(-1, 2, 3)])


def shapes(items: Iterable[bpy.types.Object], scene: bpy.types.Scene) -> Shape:
    """What to draw for the Empties of edits: (points, colours) of triangles and of lines."""
    fills, lines = [], []
    for item in items:
        edit = item.sluice
        color, strength, dashed = _looks(item, scene)
        corners, centre, tip = quad_corners(item)
        border = corners[[0, 1, 1, 2, 2, 3, 3, 0]]
        fills.append((corners[[0, 1, 2, 0, 2, 3]], (*_fill(edit, color), 0.22 * strength)))
        lines.append((_dashes(border) if dashed else border, (*color, 0.95 * strength)))
        if item.empty_display_type != 'SINGLE_ARROW':  # That display type shows the arrow itself.
            lines.append((_arrow(corners, centre, tip), (*color, 0.95 * strength)))
        # An exit still points at an entry that was deleted.
        if edit.role == 'EXIT' and edit.entry is not None and edit.entry.name in scene.objects:
            link = np.array((np.array(edit.entry.matrix_world)[:3, 3], centre))
            lines.append((link, np.array(((*ENTRY_COLOR, 0.7 * strength), (*EXIT_COLOR, 0.7 * strength)))))
    return Shape(fills, lines)


def _arrow(corners: np.ndarray, centre: np.ndarray, tip: np.ndarray) -> np.ndarray:
    """Shaft and four barbs of an arrow, as pairs of points."""
    back = centre + 0.7 * (tip - centre)
    reach = 0.12 * np.linalg.norm(tip - centre)
    points = [centre, tip]
    for side in (corners[1] - corners[0], corners[3] - corners[0]):
        length = np.linalg.norm(side)
        if length > 0:
            points += [tip, back + side / length * reach, tip, back - side / length * reach]
    return np.array(points)


def _draw() -> None:
    context = bpy.context
    items = model.visible_parts(context)
    if items:
        # In a rendered view the light below the quads must be seen.
        opacity = 0.2 if context.space_data.shading.type == 'RENDERED' else 1.0
        _draw_shapes(shapes(items, context.scene), context.region, context.region_data, opacity)


def _draw_names() -> None:
    """The name of each edit in a pale form of its colour: an entry's above it, an exit's below, as one may lie on the other. Names that
    would lie on each other are stacked."""
    import blf
    from bpy_extras.view3d_utils import location_3d_to_region_2d
    context = bpy.context
    size = 11 * context.preferences.system.ui_scale
    taken: list[tuple[float, float, float]] = []  # The place (x, y) and the width of each name that is drawn.
    for item in model.visible_parts(context):
        color, strength, _dashed = _looks(item, context.scene)
        corners = [location_3d_to_region_2d(context.region, context.region_data, corner) for corner in quad_corners(item)[0]]
        if None in corners:
            continue
        above = item.sluice.role == 'ENTRY'
        place = (max if above else min)(corners, key=lambda corner: corner.y)
        compat.text_size(blf, size)
        width, line = blf.dimensions(0, item.name)[0], (1.3 if above else -1.3) * size  # type: ignore[index]
        x, y = place.x + 4, place.y + (4 if above else -4 - size)
        while any(abs(y - other_y) < size and x < other_x + other_width and other_x < x + width for other_x, other_y, other_width in taken):
            y += line
        taken.append((x, y, width))
        blf.color(0, *(0.5 + 0.5 * part for part in color), min(1.0, 0.3 + strength))  # type: ignore[call-arg]
        blf.enable(0, blf.SHADOW)
        blf.shadow(0, 3, 0, 0, 0, 0.8)
        blf.position(0, x, y, 0)
        blf.draw(0, item.name)
        blf.disable(0, blf.SHADOW)


def _draw_shapes(found: Shape, region: bpy.types.Region, region_3d: bpy.types.RegionView3D, opacity: float) -> None:
    import gpu
    gpu.state.blend_set('ALPHA')
    gpu.state.depth_mask_set(False)
    # All is drawn twice: solid where it is in front, faint where something hides it.
    for depth_test, strength in (('LESS_EQUAL', 1.0), ('GREATER', 0.25)):
        gpu.state.depth_test_set(depth_test)
        _draw_batch(gpu, found.fills, region_3d, strength * opacity)
        _draw_batch(gpu, found.lines, region_3d, strength, region)
    gpu.state.depth_test_set('NONE')
    gpu.state.depth_mask_set(True)
    gpu.state.blend_set('NONE')


def _draw_batch(gpu: ModuleType, parts: list[tuple[Any, Any]], region_3d: bpy.types.RegionView3D,
                strength: float, region: bpy.types.Region | None = None) -> None:
    """Draws triangles; or lines, of one width in pixels in every region, if a region is given."""
    from gpu_extras.batch import batch_for_shader
    kind, shader_name = ('TRIS', "SMOOTH_COLOR") if region is None else ('LINES', "POLYLINE_SMOOTH_COLOR")
    shader = compat.builtin_shader(gpu, shader_name)
    points = np.concatenate([points for points, _color in parts])
    colors = np.concatenate([np.broadcast_to(color, (len(points), 4)) for points, color in parts]) * (1, 1, 1, strength)
    # Concatenated broadcast arrays have their columns together; the buffer wants rows.
    batch: Any = batch_for_shader(shader, kind, {"pos": np.ascontiguousarray(_nearer(points, region_3d), np.float32),
                                            "color": np.ascontiguousarray(colors, np.float32)})
    shader.bind()
    if region is not None:
        shader.uniform_float("viewportSize", (region.width, region.height))
        shader.uniform_float("lineWidth", 1.6 * bpy.context.preferences.system.pixel_size)
    batch.draw(shader)


def _nearer(points: np.ndarray, region_3d: bpy.types.RegionView3D) -> np.ndarray:
    """The points, moved a little towards the eye."""
    inverse = np.array(region_3d.view_matrix.inverted())
    if region_3d.is_perspective:
        return points + _TOWARDS_EYE * (inverse[:3, 3] - points)
    return points + _TOWARDS_EYE * region_3d.view_distance * inverse[:3, 2]


def register() -> None:
    if not bpy.app.background:
        for draw, kind in ((_draw, 'POST_VIEW'), (_draw_names, 'POST_PIXEL')):
            _handles.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), 'WINDOW', kind))


def unregister() -> None:
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), 'WINDOW')
