# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's evaluated scene to the plain tree of cpp/scene/description.h (with cpp/edit/description.h and cpp/shading/nodes.h): dicts
with the members' own names.

Arrays are C-contiguous NumPy (float32, uint32, uint16), matrices float64 4 × 4 as Blender's matrix_world (column vectors),
enumerations the names of their C++ values. "index" members point into the lists of the scene, -1 = none. One file per kind of
datablock. Nothing here imports bpy: exporters get objects, so fakes work in tests. Descriptions hold no Blender object; Names hold some as
keys, so a Context that is kept gets new ones before it exports again (viewport.py)."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from . import camera, edit, geometry, image, light, material, settings
from .description import Description
from .scene_names import Names

if TYPE_CHECKING:
    import bpy


class Cancelled(Exception):
    """The artist stopped the render while the scene was being copied."""


@dataclass
class Context:
    """What exporters share: the images met so far, the names of things, the way to warn and to learn of a cancel."""

    names: Names
    cancelled: Callable[[], bool] = lambda: False
    warnings: list[tuple[str, str]] = field(default_factory=list)  # pairs of the name of a thing and a sentence
    images: image.ImageTable = field(init=False)
    materials: list[Description] = field(default_factory=list)
    _material_indices: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.images = image.ImageTable(self.warn)

    def warn(self, item: str, message: str) -> None:
        """Notes a warning. However often it is met, it is told once for each item and sentence."""
        if (item, message) not in self.warnings:
            self.warnings.append((item, message))

    def check_cancel(self) -> None:
        if self.cancelled():
            raise Cancelled

    def material_index(self, blender_material: bpy.types.Material | None) -> int:
        """The index of a material, which is exported when it is first met. An empty slot has -1, the core's neutral material."""
        if blender_material is None:
            return -1
        key = blender_material.name_full
        if key not in self._material_indices:
            self._material_indices[key] = len(self.materials)
            self.materials.append(material.export_material(blender_material, self.images, self.warn))
        return self._material_indices[key]


def export_scene(depsgraph: bpy.types.Depsgraph, camera_description: Description | None, frame: Description | None, context: Context) -> Description:
    """The whole description of what the depsgraph shows, seen by a camera (see camera.py) in a frame."""
    scene = depsgraph.scene_eval
    meshes, instances, lights = geometry.export_objects(depsgraph, context)
    edits = export_edits(depsgraph, context)
    world = {"name": "", "material": -1}
    if scene.world is not None:
        context.materials.append(material.export_world(scene.world, context.images, context.warn))
        world = {"name": context.names.of_world(scene.world.original), "material": len(context.materials) - 1}
    return {
        "meshes": meshes, "instances": instances, "lights": lights, "materials": context.materials,
        "images": context.images.images, "world": world, "camera": camera_description, "frame": frame,
        "specular_threshold": scene.sluice.specular_threshold, **edits,
    }


def export_edits(depsgraph: bpy.types.Depsgraph, context: Context) -> Description:
    """The part of the description that tells of edits. Their textures are added to the context's images."""
    ours = depsgraph.scene_eval.sluice
    return {"edits": edit.export_edits(depsgraph.objects, context, ours.solo), "max_gates": ours.max_gates}
