# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the artist wants a quad to lie: on the selected faces, or at the 3D cursor."""
from __future__ import annotations

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import quad_geometry

# The side of a new quad, as a fraction of its distance from the eye: so it fits the view, whatever the scene's scale.
_SHARE_OF_DISTANCE = 0.12
_TOUCHES = 0.02  # A surface that is nearer to the cursor than this fraction of the distance is the one that it was set on.


def _selected_faces(context: bpy.types.Context) -> tuple[np.ndarray, np.ndarray] | None:
    """Corners and mean normal, in world space, of the faces that are selected in edit mode; of the active face if none is; else None."""
    points, normal = [], Vector()
    for item in context.objects_in_mode_unique_data if context.mode == 'EDIT_MESH' else ():
        mesh = bmesh.from_edit_mesh(item.data)
        faces = [face for face in mesh.faces if face.select] or [face for face in (mesh.faces.active,) if face]
        turn = item.matrix_world.to_3x3().inverted_safe().transposed()
        for face in faces:
            points += [item.matrix_world @ vertex.co for vertex in face.verts]
            normal += (turn @ face.normal).normalized() * face.calc_area()
    return (np.array(points), np.array(normal)) if points else None


def find(context: bpy.types.Context, size: float) -> tuple[Matrix, bool]:
    """Where an edit would be made: on the selected faces, else at the 3D cursor. Returns the matrix, and whether faces are selected."""
    faces = _selected_faces(context)
    if faces is not None:
        return Matrix(quad_geometry.fit_quad(*faces)), True
    matrix, distance = at_cursor(context)
    return matrix @ Matrix.Scale((size or _SHARE_OF_DISTANCE * distance) / 2, 4), False


def _view(context: bpy.types.Context) -> bpy.types.RegionView3D | None:
    """The 3D view that the artist looks into, also from a panel in it or beside it; None without a window."""
    if context.region_data is not None or context.window is None or bpy.app.background:
        return context.region_data
    if context.area is not None and context.area.type == 'VIEW_3D':
        return context.space_data.region_3d
    views = [area for area in context.window.screen.areas if area.type == 'VIEW_3D']
    return max(views, key=lambda area: area.width * area.height).spaces.active.region_3d if views else None


def at_cursor(context: bpy.types.Context) -> tuple[Matrix, float]:
    """The matrix of a quad at the 3D cursor, and the distance from the eye. It lies on the surface that the view shows there, if it shows
    one; else it is turned as the cursor is. Without a view it counts as 8 m away."""
    cursor, view = context.scene.cursor.matrix, _view(context)
    if view is None:
        return cursor, 1 / _SHARE_OF_DISTANCE
    place, back = cursor.translation, view.view_matrix.inverted()
    forward = -back.col[2].to_3d()
    distance = (place - back.translation).length if view.is_perspective else view.view_distance
    direction = (place - back.translation).normalized() if view.is_perspective else forward
    start = back.translation if view.is_perspective else place - forward * (10 * distance)
    hit, found, normal = context.scene.ray_cast(context.evaluated_depsgraph_get(), start, direction)[:3]  # type: ignore[index]
    if not hit or (found - place).length > _TOUCHES * distance:
        return cursor, distance
    x, y, z = quad_geometry.frame_from_normal(normal if normal.dot(direction) < 0 else -normal)
    turn = Matrix((x, y, z)).transposed().to_4x4()
    return Matrix.Translation(found) @ turn, distance
