# SPDX-License-Identifier: GPL-3.0-or-later
"""The render passes, and how their pixels get into a render result."""
from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from . import compat, core

if TYPE_CHECKING:
    import bpy
    import numpy as np

    from .export.description import Description

Kind: TypeAlias = Literal['COLOR', 'VECTOR', 'VALUE']


@dataclass(frozen=True)
class Pass:
    """A render pass: its name, its channels as the EXR file names them."""

    name: str
    channels: str

    @property
    def kind(self) -> Kind:
        """What the compositor makes of it."""
        if len(self.channels) == 1:
            return 'VALUE'
        return 'VECTOR' if self.channels == "XYZ" else 'COLOR'


COMBINED = Pass("Combined", "RGBA")
_BLENDERS_OWN = {"Image", "Alpha"}  # Sockets that the compositor has beside those of passes.
_LONGEST = 40  # A layer's name has at most so many bytes: a channel's name in a file has room for 64, with the view layer's name.


def fixed_passes() -> tuple[Pass, ...]:
    """The passes that every picture of the core has, Combined first. Without a core Combined is there alone: panels and the render itself
    tell what is wrong then, and the interface goes on."""
    try:
        told = core.load().passes
    except core.CoreMissing:
        return (COMBINED,)
    return tuple(Pass(name, channels) for name, channels in told)


def clean_name(name: str, taken: Container[str] = ()) -> str:
    """The name, changed so far that the compositor and a file can hold it: it is printable, has no dot (files split their channels' names
    there), is not too long, and no other pass has it."""
    name = " ".join("".join(letter if letter.isprintable() and letter != "." else " " for letter in name).split())
    base = _cut(name, _LONGEST) or "Layer"
    unique, number = base, 1
    of_passes = _BLENDERS_OWN | {item.name for item in fixed_passes()}
    while unique in of_passes or unique in taken:
        number += 1
        unique = f"{_cut(base, _LONGEST - 4)} {number}"
    return unique


def _cut(text: str, size: int) -> str:
    return text.encode()[:size].decode(errors="ignore").strip()


def export_layers(view_layer: bpy.types.ViewLayer) -> list[Description]:
    """The LayerDescriptions of a view layer. Scripts may leave names empty or give one twice, so each gets one of its own here."""
    found: list[Description] = []
    for layer in view_layer.sluice.layers:
        found.append({"name": clean_name(layer.name, [item["name"] for item in found]), "expression": layer.expression})
    return found


def all_passes(layers: Iterable[Description]) -> tuple[Pass, ...]:
    """The core's render passes, and one for each of the LayerDescriptions."""
    return fixed_passes() + tuple(Pass(layer["name"], "RGB") for layer in layers)


def register_passes(engine: bpy.types.RenderEngine, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> None:
    """Gives the compositor its sockets."""
    for item in all_passes(export_layers(view_layer)):
        engine.register_pass(scene, view_layer, item.name, len(item.channels), item.channels, item.kind)


def add_passes(engine: bpy.types.RenderEngine, layer: str, passes: Sequence[Pass]) -> None:
    """Gives the render result its buffers; Combined is always there."""
    for item in passes[1:]:
        engine.add_pass(item.name, len(item.channels), item.channels, layer=layer)


def begin(engine: bpy.types.RenderEngine, layer: str) -> bpy.types.RenderResult:
    """Begins a result of the size that Blender wants: that of the render border if there is one, else of the whole frame."""
    return engine.begin_result(0, 0, engine.resolution_x, engine.resolution_y, layer=layer)


def write(result: bpy.types.RenderResult, images: Mapping[str, np.ndarray]) -> list[str]:
    """Fills every pass of a result from {name: (height, width, channels)}. A pass that the result has and we do not make (Blender
    adds some of its own to previews) stays black. Returns the names of passes written."""
    written = []
    for render_pass in result.layers[0].passes:
        pixels = images.get(render_pass.name)
        if pixels is not None and pixels.shape[:2] == (result.resolution_y, result.resolution_x):
            compat.set_pass_rect(render_pass, pixels)
            written.append(render_pass.name)
    return written
