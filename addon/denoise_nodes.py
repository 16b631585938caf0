# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts a Denoise node into a scene's compositor, behind the picture of a view layer, and keeps what is linked there."""
from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy

from . import compat, passes

_DENOISE, _RENDER_LAYERS = 'CompositorNodeDenoise', 'CompositorNodeRLayers'
_GAP = 40  # between nodes, in the units of their locations


def set_up(scene: Any, view_layer: Any) -> bool:
    """Lets the picture of the view layer go through a Denoise node, guided by Albedo and Normal, on its way to the compositor's output.
    False: the output is made of other things; the nodes are there, and what they give is linked to nothing.

    What is done already is left alone, so that a second time changes nothing."""
    view_layer.use_pass_normal = view_layer.sluice.use_pass_albedo = True
    view_layer.sluice.use_denoise = False  # Twice would be once too often.
    tree = compat.make_compositor(bpy, scene)
    view_layer.update_render_passes()
    output = _output(tree, compat.compositor_output(scene))
    sources = [node for node in tree.nodes if node.bl_idname == _RENDER_LAYERS and node.scene == scene and node.layer == view_layer.name]
    sources = sources or [_new_source(tree, scene, view_layer, output)]
    feeding = _feeding(tree, output)
    shown = [node for node in sources if _ways(node, feeding)]
    is_free = not output.inputs[0].is_linked
    for node in shown or sources[:1]:
        denoise = _behind(tree, node, _ways(node, feeding))
        for name in passes.GUIDES:
            if not denoise.inputs[name].is_linked:
                tree.links.new(_socket(node.outputs, name), denoise.inputs[name])
        if is_free:
            tree.links.new(denoise.outputs[0], output.inputs[0])
    return bool(shown) or is_free


def _output(tree: Any, kind: str) -> Any:
    """The compositor's output; it is made if there is none."""
    found = [node for node in tree.nodes if node.bl_idname == kind]
    return next((node for node in found if getattr(node, "is_active_output", True)), None) or (found or [tree.nodes.new(kind)])[0]


def _new_source(tree: Any, scene: Any, view_layer: Any, output: Any) -> Any:
    node = tree.nodes.new(_RENDER_LAYERS)
    node.scene, node.layer = scene, view_layer.name
    node.location = output.location.x - node.width - _GAP, output.location.y
    return node


def _feeding(tree: Any, output: Any) -> set[str]:
    """The names of the nodes from which links lead to the output, its own among them."""
    names: set[str] = set()
    more = {output.name}
    while more:
        names |= more
        more = {link.from_node.name for link in tree.links if link.to_node.name in names} - names
    return names


def _ways(source: Any, feeding: set[str]) -> list[Any]:
    """The sockets that get the picture of a Render Layers node and bring it to the output."""
    return [link.to_socket for link in _socket(source.outputs, "Image").links if link.to_node.name in feeding]


def _behind(tree: Any, source: Any, ways: list[Any]) -> Any:
    """The Denoise node behind a Render Layers node: the one that is there, or a new one, through which the ways lead then."""
    image = _socket(source.outputs, "Image")
    there = [link.to_node for link in image.links if link.to_node.bl_idname == _DENOISE]
    if there and (not ways or any(way.node in there for way in ways)):
        return next((node for node in there if any(way.node == node for way in ways)), there[0])
    denoise = tree.nodes.new(_DENOISE)
    for node in tree.nodes:
        if node not in (source, denoise) and node.parent is None and node.location.x > source.location.x:
            node.location.x += denoise.width + _GAP
    denoise.location = source.location.x + source.width + _GAP, source.location.y
    tree.links.new(image, denoise.inputs["Image"])
    for way in ways:
        tree.links.new(denoise.outputs[0], way)
    return denoise


def _socket(sockets: Iterable[Any], name: str) -> Any:
    """The socket of a name; Blender keeps some that it does not show."""
    return next(socket for socket in sockets if socket.name == name and socket.enabled)
