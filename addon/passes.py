# SPDX-License-Identifier: GPL-3.0-or-later
"""The render passes: which there are, which of them somebody asks for, and how their pixels get into a render result."""
from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import bpy

from . import compat, core

if TYPE_CHECKING:
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
NOISY_IMAGE = Pass("Noisy Image", "RGBA")  # Combined before it was denoised, under the name that Cycles gives it; no pass of the core
GUIDES = ("Albedo", "Normal")  # what a denoiser wants to know beside Combined
# The passes that have a switch among view_layer.sluice, by name, and what they show. The switch of Albedo is use_pass_albedo.
SHOWS = {
    "Albedo": "The share of light that the surface sends back that is seen first, in each colour: its paint without any light",
    "Direct": "Light that arrives straight from its source at what is seen",
    "Caustics": "Light that arrives from a mirror or through glass at what is seen",
    "Edited": "Light that arrives through the exit of an edit at what is seen",
    "Indirect": "Light that arrives from another lit surface at what is seen",
    "Emission": "Sources themselves, as they are seen straight, in mirrors and through exits",
    "Noise": "Standard error of each pixel by chance, relative to it: 0.1 is 10 %. It takes no memory of its own",
    "Bias": "By how much each pixel is expected to be off for the width of the kernels that blur photons, relative to it: above 0 too bright, "
    "below 0 too dark",
}
_BLENDERS_SWITCHES = {"Depth": "use_pass_z", "Normal": "use_pass_normal"}  # on the view layer itself
_TAKEN = {"Image", "Alpha", NOISY_IMAGE.name}  # Sockets that the compositor has beside those of the core's passes.
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
    of_passes = _TAKEN | {item.name for item in fixed_passes()}
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


def switch_of(name: str, view_layer: bpy.types.ViewLayer) -> tuple[bpy.types.bpy_struct, str] | None:
    """What switches a fixed pass: the owner of the property, and the property's name. None: it has no switch."""
    if name in _BLENDERS_SWITCHES:
        return view_layer, _BLENDERS_SWITCHES[name]
    return (view_layer.sluice, f"use_pass_{name.lower()}") if name in SHOWS else None


def linked(scene: bpy.types.Scene, layer: str) -> set[str]:
    """Names of the sockets that a compositor takes from Render Layers nodes of this scene and view layer. Any scene's may."""
    trees = (compat.compositor(other) for other in bpy.data.scenes)
    nodes = (node for tree in trees if tree is not None for node in _nodes_of(tree, 8))
    return {socket.name for node in nodes if node.bl_idname == 'CompositorNodeRLayers' and node.scene == scene and node.layer == layer
            for socket in node.outputs if socket.is_linked}


def _nodes_of(tree: bpy.types.NodeTree, deepest: int) -> Iterator[Any]:
    for node in tree.nodes:
        yield node
        inner = getattr(node, "node_tree", None)
        if inner is not None and deepest > 0:
            yield from _nodes_of(inner, deepest - 1)


def asked(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, layers: Iterable[Description]) -> dict[Pass, str]:
    """The passes that a picture of the view layer is to have, Combined first, and who asks for each: what nobody asks for takes memory
    and time. A pass without a switch is always there."""
    links, found = linked(scene, view_layer.name), {}
    for item in fixed_passes():
        switch = switch_of(item.name, view_layer)
        if switch is None:
            found[item] = "always there"
        elif getattr(*switch):
            found[item] = "switched on"
        elif item.name in links:
            found[item] = "linked in the compositor"
    if view_layer.sluice.use_denoise:  # Also where it cannot be done: files of one scene shall have the same passes everywhere.
        found[NOISY_IMAGE] = "for Denoise"
    return {**found, **{Pass(layer["name"], "RGB"): "a light layer" for layer in layers}}


def register_passes(engine: bpy.types.RenderEngine, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> None:
    """Gives the compositor its sockets."""
    for item in asked(scene, view_layer, export_layers(view_layer)):
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
