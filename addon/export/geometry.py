# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, and the instances that show them. Curves, text, surfaces and metaballs reach us from the depsgraph as meshes.

All arrays are read with foreach_get; nothing runs once per vertex in Python."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import compat
from . import light as light_export
from .description import Description
from .instancers import Instancers
from .racing import racing_modifier

if TYPE_CHECKING:
    import bpy

    from . import Context

# Kinds of objects that other engines render and this one does not.
_SKIPPED = {'VOLUME': "volumes are not rendered", 'CURVES': "hair curves are not rendered",
            'POINTCLOUD': "point clouds are not rendered", 'GPENCIL': "grease pencil is not rendered",
            'GREASEPENCIL': "grease pencil is not rendered"}


def export_objects(depsgraph: bpy.types.Depsgraph, context: Context) -> tuple[list[Description], list[Description], list[Description]]:
    """(meshes, instances, lights) of all that is visible. A mesh is exported once, however many instances share it."""
    meshes: list[Description] = []
    instances: list[Description] = []
    lights: list[Description] = []
    mesh_indices: dict[bpy.types.Mesh, int] = {}
    instancers = Instancers()
    # Blender frees an instance when the loop goes on: nothing may keep it.
    for count, instance in enumerate(depsgraph.object_instances):
        if count % 256 == 0:
            context.check_cancel()
        item = instance.object
        makers = instancers.of(instance) if instance.is_instance else ()
        if makers and item.type == 'EMPTY' and item.original.sluice.role != 'NONE':
            context.warn(item.original.name, "an edit inside a collection instance is ignored; put it in the scene itself")
        if not (instance.show_self or instance.is_instance):
            continue
        if not instance.is_instance:
            _warn_of_hair(item, context)
        if item.type == 'LIGHT':
            names = context.names.of_instance(item.original, *makers)
            lights.append(light_export.export_light(item, instance.matrix_world, names, context.warn))
        elif item.type == 'MESH' and item.data is not None:
            mesh = item.data
            index = mesh_indices.get(mesh)
            if index is None:
                context.check_cancel()
                index = mesh_indices[mesh] = _append_mesh(item, meshes)
                _warn_of_races(item, context)
            if index >= 0:
                names = context.names.of_instance(item.original, *makers)
                instances.append(_export_instance(instance, index, names, context))
        elif item.type in _SKIPPED:
            context.warn(item.original.name, _SKIPPED[item.type])
    return meshes, instances, lights


def _append_mesh(item: bpy.types.Object, meshes: list[Description]) -> int:
    """Exports the mesh of an object; returns its index, -1 if it has no faces."""
    description = export_mesh(item.data, is_metaball=item.original.type == 'META')
    if description is None:
        return -1
    meshes.append(description)
    return len(meshes) - 1


def export_mesh(mesh: bpy.types.Mesh, is_metaball: bool = False) -> Description | None:
    """A MeshDescription with all attributes per corner of a triangle, or None without faces. Shading normals are left out where all faces
    are flat, and where the core can make them of the polygons. Those of metaballs come from their field, so they are kept."""
    mesh.calc_loop_triangles()
    triangle_count, loop_count = len(mesh.loop_triangles), len(mesh.loops)
    if triangle_count == 0:
        return None
    loops = _integers(mesh.loop_triangles, "loops", triangle_count * 3)
    corners = _integers(mesh.loops, "vertex_index", loop_count)
    triangles = corners[loops]  # Asking the triangles for their vertices would take twice as long.
    slots = np.zeros(triangle_count, np.int32)
    if len(mesh.materials) > 1:
        mesh.loop_triangles.foreach_get("material_index", slots)
    from_polygons = compat.shades_by_racing_normals(mesh) and not is_metaball
    normals = None if from_polygons else compat.split_normals(mesh, loop_count)
    size = np.array(mesh.texspace_size, np.float32)
    return {
        "name": mesh.name,
        "positions": compat.vertex_positions(mesh),
        "triangles": triangles.reshape(-1, 3),
        "normals": np.empty((0, 3), np.float32) if normals is None else normals[loops],
        "polygons": _polygons(mesh, corners) if from_polygons else {},
        "material_slots": slots.astype(np.uint16) if slots.any() else np.empty(0, np.uint16),
        "uv_maps": _uv_maps(mesh, loops, loop_count),
        "colors": _colors(mesh, loops, triangles),
        # Generated coordinates are (p - location) / (2 size) + 1/2.
        "texture_origin": np.array(mesh.texspace_location, np.float32) - size,
        "texture_size": 2 * size,
    }


def _polygons(mesh: bpy.types.Mesh, corners: np.ndarray) -> Description:
    """A PolygonDescription, empty if every face is flat."""
    smooth = compat.smooth_polygons(mesh)
    if not smooth.any():
        return {}
    sizes = _integers(mesh.polygons, "loop_total", len(smooth))
    return {
        "corners": corners,
        "starts": _integers(mesh.polygons, "loop_start", len(smooth)),
        "sizes": sizes,
        "smooth": smooth.view(np.uint8),
        # A polygon of n corners makes n - 2 triangles, and triangles come in the order of their polygons.
        "of_triangles": np.repeat(np.arange(len(sizes), dtype=np.uint32), np.maximum(sizes, 2) - 2),
    }


def _integers(items: Any, name: str, count: int) -> np.ndarray:
    values = np.empty(count, np.int32)  # This is Blender's own type, so that it copies the array as a whole.
    items.foreach_get(name, values)
    return values.view(np.uint32)


def _uv_maps(mesh: bpy.types.Mesh, loops: np.ndarray, loop_count: int) -> list[Description]:
    layers = list(mesh.uv_layers)
    chosen = next((index for index, layer in enumerate(layers) if layer.active_render), 0)
    return [{"name": layer.name, "corners": compat.uv_corners(layer, loop_count)[loops]}
            for layer in compat.active_first(layers, chosen)]


def _colors(mesh: bpy.types.Mesh, loops: np.ndarray, vertices: np.ndarray) -> list[Description]:
    """Colour attributes, linear, without alpha. Each lives on corners or on vertices."""
    colors = []
    for layer in compat.color_attribute_layers(mesh):
        values = np.empty(len(layer.data) * 4, np.float32)
        layer.data.foreach_get("color", values)
        where = loops if layer.domain == 'CORNER' else vertices
        colors.append({"name": layer.name, "corners": np.ascontiguousarray(values.reshape(-1, 4)[where, :3])})
    return colors


def _export_instance(instance: bpy.types.DepsgraphObjectInstance, mesh_index: int, names: list[str], context: Context) -> Description:
    item = instance.object
    camera, shadow = item.visible_camera, item.visible_shadow
    if instance.is_instance and instance.parent:  # As in Cycles, the switches of an instancer hold for what it makes.
        camera, shadow = camera and instance.parent.visible_camera, shadow and instance.parent.visible_shadow
    random_id = instance.random_id if instance.is_instance else name_hash(item.original.name)
    return {
        "names": names,
        "mesh": mesh_index,
        "matrix": compat.matrix(instance.matrix_world),
        "materials": [context.material_index(found) for found in _materials(item)],
        "visible_to_camera": bool(camera),
        "casts_shadow": bool(shadow),
        "color": tuple(item.color[:3]),
        "random": (random_id & 0xffffffff) / 4294967296.0,
        "object_index": item.pass_index,
    }


def _materials(item: bpy.types.Object) -> list[bpy.types.Material | None]:
    """The materials by slot: the evaluated mesh's (modifiers may set them), unless the object's slot holds its own."""
    slots, of_mesh = item.material_slots, item.data.materials
    found = []
    for index in range(max(len(of_mesh), len(slots))):
        slot = slots[index] if index < len(slots) else None
        own = slot is not None and slot.link == 'OBJECT'
        found.append(slot.material if own or index >= len(of_mesh) else of_mesh[index])
    return found


def _warn_of_hair(item: bpy.types.Object, context: Context) -> None:
    for modifier in item.modifiers:
        system = getattr(modifier, "particle_system", None)
        if system is not None and system.settings.type == 'HAIR' and system.settings.render_type == 'PATH':
            context.warn(item.original.name, f"hair is not rendered (particle system {system.name})")


def _warn_of_races(item: bpy.types.Object, context: Context) -> None:
    modifier = racing_modifier(item)
    if modifier is not None:
        context.warn(item.original.name, f"two renders may differ in their last bits: modifier {modifier.name} builds along normals that this "
                                         "Blender adds up in no fixed order; Blender 4.1 and later do, or apply the modifier")


def name_hash(name: str) -> int:
    """Object Info's random number of an object that is no instance, as Cycles makes it: Jenkins' hash of a hash of the name."""
    value, mask = 0, 0xffffffff
    for byte in name.encode():
        value = (value * 37 + byte) & mask
    a = b = c = (0xdeadbeef + (2 << 2) + 13) & mask
    a = (a + value) & mask

    def rotate(x: int, bits: int) -> int:
        return ((x << bits) | (x >> (32 - bits))) & mask

    c = ((c ^ b) - rotate(b, 14)) & mask
    a = ((a ^ c) - rotate(c, 11)) & mask
    b = ((b ^ a) - rotate(a, 25)) & mask
    c = ((c ^ b) - rotate(b, 16)) & mask
    a = ((a ^ c) - rotate(c, 4)) & mask
    b = ((b ^ a) - rotate(a, 14)) & mask
    return ((c ^ b) - rotate(b, 24)) & mask
