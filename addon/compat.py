# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between Blender 3.4 and 5.2, by feature tests (never by version numbers), in one place.

Functions take the Blender objects they ask, so tests run both branches with fakes. `bpy` is imported only where a name must be
looked up in it."""
from __future__ import annotations

import functools
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    import bpy
    import gpu.types as gpu_types

T = TypeVar("T")


def set_pass_rect(render_pass: bpy.types.RenderPass, pixels: np.ndarray) -> None:
    """Copies `pixels` (rows, columns, channels; row 0 at the bottom) into a render pass. Up to Blender 4.0 the setter wants
    (N, channels), from 4.1 a flat array; the wrong one raises TypeError. One channel is flat everywhere. An array whose channel
    count is not the pass's would be taken silently by some versions, so it is refused here."""
    pixels = np.ascontiguousarray(pixels, dtype=np.float32)
    channels = pixels.shape[2] if pixels.ndim == 3 else 1
    if channels != render_pass.channels:
        raise ValueError(f"pass {render_pass.name} has {render_pass.channels} channels, not {channels}")
    if channels == 1:
        render_pass.rect.foreach_set(pixels.ravel())
        return
    try:
        render_pass.rect.foreach_set(pixels.reshape(-1))
    except TypeError:
        render_pass.rect.foreach_set(pixels.reshape(-1, channels))


def builds_on_racing_normals(mesh: bpy.types.Mesh) -> bool:
    """Does this Blender add up the normals at vertices on threads that race, so that their last bits differ from one time to the next?
    Those before 4.1 do."""
    return not hasattr(mesh, "corner_normals")


def shades_by_racing_normals(mesh: bpy.types.Mesh) -> bool:
    """Is the mesh shaded by such normals? Auto Smooth makes normals of its own, fan by fan, each of them on one thread."""
    return builds_on_racing_normals(mesh) and not mesh.use_auto_smooth


def split_normals(mesh: bpy.types.Mesh, loop_count: int) -> np.ndarray | None:
    """Blender's own normals, one per loop, or None if every face is flat. Blender 4.1 has no calc_normals_split any more."""
    normals = np.empty(loop_count * 3, np.float32)
    if hasattr(mesh, "corner_normals"):  # since 4.1
        if mesh.normals_domain == 'FACE':  # type: ignore[attr-defined]
            return None
        mesh.corner_normals.foreach_get("vector", normals)
        return normals.reshape(-1, 3)
    if not (mesh.use_auto_smooth and mesh.has_custom_normals) and not smooth_polygons(mesh).any():
        return None
    mesh.calc_normals_split()
    mesh.loops.foreach_get("normal", normals)
    mesh.free_normals_split()
    return normals.reshape(-1, 3)


def smooth_polygons(mesh: bpy.types.Mesh) -> np.ndarray:
    """Which polygons are smooth: one bool each."""
    smooth = np.empty(len(mesh.polygons), bool)
    mesh.polygons.foreach_get("use_smooth", smooth)
    return smooth


def matrix(blender_matrix: Any) -> np.ndarray:
    """A matrix as an array (4, 4) of float64, its rows together; Blender 5's come out with their columns together."""
    return np.array(blender_matrix, np.float64, order='C')


def vertex_positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """Positions of the vertices, (n, 3) float32. The attribute (since 3.5) is read several times faster than the vertices."""
    positions = np.empty(len(mesh.vertices) * 3, np.float32)
    attribute = mesh.attributes.get("position")
    if attribute is not None and len(attribute.data) == len(mesh.vertices):
        attribute.data.foreach_get("vector", positions)
    else:
        mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)


def uv_corners(layer: bpy.types.MeshUVLoopLayer, loop_count: int) -> np.ndarray:
    """The coordinates of one UV map, (loops, 2) float32; `.uv` replaced `.data` in 3.5."""
    uv = np.empty(loop_count * 2, np.float32)
    if hasattr(layer, "uv"):
        layer.uv.foreach_get("vector", uv)
    else:
        layer.data.foreach_get("uv", uv)
    return uv.reshape(-1, 2)


def linear_color_names() -> set[str]:
    """Names of scene-linear colour spaces in Blender's own configurations (3.x, 4.x, 5.x)."""
    return {"Linear", "Linear Rec.709", "scene_linear", "Scene Linear"}


def builtin_shader(gpu: ModuleType, name: str) -> gpu_types.GPUShader:
    """A built-in 3D shader by its 4.0 name; before that the 3D ones carried a prefix. Never call it under -b (SystemError)."""
    for candidate in (name, "3D_" + name):
        try:
            shader = gpu.shader.from_builtin(candidate)
        except (ValueError, SystemError):
            continue
        return shader
    raise ValueError(f"no built-in shader {name}")


def text_size(blf: ModuleType, size: float) -> None:
    """Sets the size of drawn text. The call lost its dots per inch in 3.6 or so; from 4.0 it warns or fails with them."""
    try:
        blf.size(0, size)
    except TypeError:
        blf.size(0, round(size), 72)


def compositor(scene: bpy.types.Scene) -> Any:
    """The node tree of a scene's compositor, if it has one; from 5.0 it is a node group of the file."""
    return scene.compositing_node_group if hasattr(scene, "compositing_node_group") else scene.node_tree


def make_compositor(bpy: ModuleType, scene: bpy.types.Scene) -> Any:
    """The node tree of a scene's compositor, switched on, and made if there is none."""
    scene.render.use_compositing = True
    if not hasattr(scene, "compositing_node_group"):
        scene.use_nodes = True
        return scene.node_tree
    if scene.compositing_node_group is None:
        scene.compositing_node_group = bpy.data.node_groups.new("Compositor", 'CompositorNodeTree')
    interface = scene.compositing_node_group.interface
    if not any(getattr(item, "in_out", "") == 'OUTPUT' for item in interface.items_tree):
        interface.new_socket("Image", in_out='OUTPUT', socket_type='NodeSocketColor')
    return scene.compositing_node_group


def compositor_output(scene: bpy.types.Scene) -> str:
    """The kind of node whose first input is what the compositor makes: since 5.0 that of any node group."""
    return 'NodeGroupOutput' if hasattr(scene, "compositing_node_group") else 'CompositorNodeComposite'


def has_denoise_node() -> bool:
    """Was this Blender built with Open Image Denoise? Without it the compositor's Denoise node is there and does nothing. Cycles gets
    it by the same switch of the build, and tells."""
    try:
        import _cycles  # type: ignore[import-not-found]
    except ImportError:
        return False
    return bool(getattr(_cycles, "with_openimagedenoise", False))


def icon(name: str, instead: str) -> str:
    """An icon's name, or another one where this Blender lacks it (LIGHTPROBE_* changed in 4.1)."""
    import bpy
    return name if name in bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items else instead


def color_attribute_layers(mesh: bpy.types.Mesh) -> list[Any]:
    """Colour attributes, the one for rendering first."""
    layers = getattr(mesh, "color_attributes", None)
    if not layers:
        return []
    index = getattr(layers, "render_color_index", 0)
    return active_first(list(layers), index)


def active_first(items: list[T], index: int) -> list[T]:
    """The list with item `index` moved to the front; the list itself if there is no such item."""
    if 0 <= index < len(items):
        return [items[index]] + items[:index] + items[index + 1:]
    return items


def is_bpy_module(bpy: ModuleType) -> bool:
    """True where Blender is a Python module rather than a program: its engine classes must be gone before exit."""
    return not getattr(bpy.app, "binary_path", "") or getattr(bpy.app, "module", False)


def modifier_inputs(modifier: Any) -> list[Any]:
    """The values that a geometry nodes modifier gives its group, where this Blender tells them."""
    try:
        return list(modifier.values())
    except TypeError:
        return []


@functools.cache
def has_session_ids(bpy: ModuleType) -> bool:
    """Do datablocks bear a number that stays theirs while Blender runs (4.1)?"""
    return "session_uid" in bpy.types.ID.bl_rna.properties
