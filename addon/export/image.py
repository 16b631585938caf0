# SPDX-License-Identifier: GPL-3.0-or-later
"""Images as pixels that Blender has decoded: packed, generated and file images alike, in whatever format."""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import compat
from .description import Description, Warn

if TYPE_CHECKING:
    import bpy

MAX_SIDE, MAX_PIXELS = 16384, 64_000_000  # Larger images are refused before anything is allocated.


class ImageTable:
    """The images of a description, each once per colour space. `warn(item, message)` is told what is wrong with one."""

    def __init__(self, warn: Warn) -> None:
        self.images: list[Description] = []
        self._indices: dict[tuple[str, str], int] = {}
        self._warn = warn

    def index(self, image: bpy.types.Image | None, color_space: str | None = None) -> int:
        """The index of a Blender image, -1 for None. A missing or unreadable one has no pixels: the core draws a placeholder."""
        if image is None:
            return -1
        space = color_space or self._space_of(image)
        key = (image.name_full, space)
        if key not in self._indices:
            self._indices[key] = len(self.images)
            self.images.append(self._export(image, space))
        return self._indices[key]

    def _space_of(self, image: bpy.types.Image) -> str:
        name = image.colorspace_settings.name
        if name in {"Non-Color", "Raw"} or getattr(image.colorspace_settings, "is_data", False):
            return 'NonColor'
        if image.is_float or name in compat.linear_color_names():
            return 'Linear'  # Blender makes float buffers scene-linear when it loads them.
        if name != "sRGB":
            self._warn(image.name, f"colour space {name} is not supported: read as sRGB")
        return 'SRGB'

    def _export(self, image: bpy.types.Image, space: str) -> Description:
        width, height = image.size
        empty = {"name": image.name, "width": 0, "height": 0, "color_space": space, "rgba": np.empty((0, 0, 4), np.float32)}
        if image.source in {'SEQUENCE', 'MOVIE', 'TILED'}:
            self._warn(image.name, f"{image.source.lower()} images are not supported: the one that is loaded is used")
        if max(width, height) > MAX_SIDE or width * height > MAX_PIXELS:
            self._warn(image.name, f"image of {width} × {height} pixels, more than {MAX_SIDE} a side or "
                                   f"{MAX_PIXELS // 1_000_000} million: a placeholder is used")
            return empty
        if width == 0 or height == 0 or image.channels == 0:
            self._warn(image.name, f"image not found ({image.filepath or 'no file'}): a placeholder is used")
            return empty
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        rgba = _as_rgba(pixels.reshape(height, width, image.channels))
        # Blender keeps float images multiplied by their alpha; the core wants them without.
        if image.is_float and image.channels in {2, 4}:
            alpha = rgba[..., 3:]
            np.divide(rgba[..., :3], alpha, out=rgba[..., :3], where=alpha > 0)
        return {**empty, "width": width, "height": height, "rgba": rgba}


def _as_rgba(pixels: np.ndarray) -> np.ndarray:
    """Pixels of grey, grey + alpha or RGB images as RGBA."""
    height, width, channels = pixels.shape
    if channels == 4:
        return pixels
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels[..., :3] if channels == 3 else pixels[..., :1]
    if channels == 2:
        rgba[..., 3] = pixels[..., 1]
    return rgba
