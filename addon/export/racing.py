# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that Blender itself does not make the same each time. Nothing here can mend that, so the artist is warned.

Before 4.1, Blender adds up the normals at vertices on threads that race. What modifiers build along them differs in its last bits from
one reading of a file to the next; which modifiers do that was measured in 3.4."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import compat

if TYPE_CHECKING:
    import bpy

_FACES_OF_A_THREAD = 1024  # Blender deals so many faces to a thread: the normals of fewer are added up by one thread, in order.


def racing_modifier(item: bpy.types.Object) -> bpy.types.Modifier | None:
    """The first modifier of an evaluated mesh object that builds along normals which race; None: its geometry is steady."""
    if not compat.builds_on_racing_normals(item.data) or len(item.data.polygons) <= _FACES_OF_A_THREAD:
        return None
    return next((modifier for modifier in item.modifiers if modifier.show_render and _follows_normals(modifier)), None)


def _follows_normals(modifier: Any) -> bool:
    kind = modifier.type
    if kind == 'DISPLACE':
        return modifier.direction in {'NORMAL', 'CUSTOM_NORMAL'}
    if kind == 'SOLIDIFY':
        return modifier.solidify_mode == 'EXTRUDE' and not modifier.use_quality_normals
    if kind == 'WAVE':
        return modifier.use_normal
    if kind == 'PARTICLE_SYSTEM':  # Particles start along the normal.
        return modifier.particle_system.settings.render_type in {'OBJECT', 'COLLECTION'}
    if kind == 'NODES':
        return modifier.node_group is not None and _reads_normals(modifier.node_group, set())
    return kind in {'SHRINKWRAP', 'WIREFRAME'}


def _reads_normals(tree: bpy.types.NodeTree, seen: set[str]) -> bool:
    """Whether geometry nodes, or groups in them, ask for normals; extruded vertices and edges go along them unasked."""
    if tree.name_full in seen:
        return False
    seen.add(tree.name_full)
    return any(node.bl_idname == 'GeometryNodeInputNormal' or node.bl_idname == 'GeometryNodeExtrudeMesh' and node.mode != 'FACES'
               or getattr(node, "node_tree", None) is not None and _reads_normals(node.node_tree, seen) for node in tree.nodes)
