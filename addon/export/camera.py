# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera, and the part of its frame that is rendered."""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import compat
from .description import Description, Rows, Warn

if TYPE_CHECKING:
    import bpy

_FITS = {'AUTO': 'Auto', 'HORIZONTAL': 'Horizontal', 'VERTICAL': 'Vertical'}


def export_camera(item: bpy.types.Object, matrix_world: Rows, warn: Warn) -> Description:
    """A CameraDescription. Cameras ignore their scale, as everywhere in Blender."""
    lens = item.data
    kind = 'Orthographic' if lens.type == 'ORTHO' else 'Perspective'
    if lens.type not in {'PERSP', 'ORTHO'}:
        warn(item.original.name, "panoramic cameras are not supported: rendered as a perspective one")
    matrix = _without_scale(compat.matrix(matrix_world))
    return {
        "name": item.original.name, "kind": kind, "matrix": matrix,
        "lens": lens.lens, "sensor_width": lens.sensor_width, "sensor_height": lens.sensor_height,
        "sensor_fit": _FITS[lens.sensor_fit], "ortho_scale": lens.ortho_scale,
        "shift_x": lens.shift_x, "shift_y": lens.shift_y, "clip_start": lens.clip_start, "clip_end": lens.clip_end,
        **_depth_of_field(lens, kind, matrix),
    }


def _without_scale(matrix: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    matrix[:3, :3] /= np.where(lengths > 0, lengths, 1)
    return matrix


def _depth_of_field(lens: bpy.types.Camera, kind: str, matrix: np.ndarray) -> Description:
    focus = lens.dof
    if not focus.use_dof:
        return {"aperture_radius": 0.0}
    distance = focus.focus_distance
    if focus.focus_object is not None:  # The distance is the depth along the view axis, as Cycles measures it.
        target = np.array(focus.focus_object.matrix_world, np.float64)[:3, 3]
        distance = abs(float(np.dot(matrix[:3, 2], matrix[:3, 3] - target)))
    # The f-number is the focal length over the diameter of the aperture. Orthographic cameras have no focal length: 1 m stands for it.
    length = lens.lens * 1e-3 if kind == 'Perspective' else 1.0
    return {
        "aperture_radius": length / (2 * max(focus.aperture_fstop, 1e-5)), "focus_distance": distance,
        "aperture_blades": focus.aperture_blades, "aperture_rotation": focus.aperture_rotation,
        "aperture_ratio": focus.aperture_ratio,
    }


def export_frame(width: int, height: int, render: bpy.types.RenderSettings) -> Description:
    """A FrameDescription of the full frame, cut to the render border as Blender's pipeline cuts it (float32, truncated)."""
    x0, y0, x1, y1 = 0, 0, width, height
    if render.use_border:
        edges = np.array([render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y], np.float32)
        x0, x1 = (int(edge) for edge in edges[:2] * np.float32(width))
        y0, y1 = (int(edge) for edge in edges[2:] * np.float32(height))
    return {
        "width": width, "height": height, "x0": x0, "y0": y0, "x1": x1, "y1": y1,
        "pixel_aspect_x": render.pixel_aspect_x, "pixel_aspect_y": render.pixel_aspect_y,
        "filter_width": render.filter_size, "filter_box": False,
    }


def export_view(view_matrix: Rows, window_matrix: Rows, is_perspective: bool, size: tuple[int, int]) -> tuple[Description, Description]:
    """The camera and the frame of a 3D view, from its matrices alone: free views and camera views with any zoom and offset."""
    width, height = size
    window = compat.matrix(window_matrix)
    matrix = np.linalg.inv(compat.matrix(view_matrix))
    # The window matrix holds the view plane's offset in column 2 (perspective, negative) or 3.
    side = -1 if is_perspective else 1
    column = 2 if is_perspective else 3
    camera = {
        "name": "View", "kind": 'Perspective' if is_perspective else 'Orthographic', "sensor_fit": 'Horizontal',
        "sensor_width": 36.0, "sensor_height": 36.0 * height / width, "aperture_radius": 0.0,
        "shift_x": -side * window[0, column] / 2, "shift_y": -side * window[1, column] / 2 * height / width,
    }
    if is_perspective:
        camera["lens"] = 18.0 * window[0, 0]
        camera["clip_start"] = window[2, 3] / (window[2, 2] - 1)
        camera["clip_end"] = window[2, 3] / (window[2, 2] + 1)
    else:
        near, far = (window[2, 3] + 1) / window[2, 2], (window[2, 3] - 1) / window[2, 2]
        # Blender's orthographic views begin behind the eye, so the camera is moved back to where they begin.
        matrix[:3, 3] -= matrix[:3, 2] * near
        camera["ortho_scale"] = 2 / window[0, 0]
        camera["clip_start"], camera["clip_end"] = 0.0, far - near
    camera["matrix"] = matrix
    frame = {"width": width, "height": height, "x0": 0, "y0": 0, "x1": width, "y1": height,
             "pixel_aspect_x": 1.0, "pixel_aspect_y": 1.0, "filter_width": 1.5, "filter_box": False}
    return camera, frame
