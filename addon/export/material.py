# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees as flat lists of nodes (cpp/shading/nodes.h says what they mean). Groups, reroutes and muted nodes disappear here;
everything else passes under Blender's own names, and the core warns of what it does not know. `images` is an ImageTable,
`warn(item, message)` a place for warnings. Socket identifiers hardly change between Blender 3.4 and 5.x: `_canonical` holds the rest."""
from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from .. import core
from .description import Description, Warn

if TYPE_CHECKING:
    import bpy

    from .image import ImageTable

GroupPath: TypeAlias = tuple["bpy.types.Node", ...]  # The group nodes that a node lies in, outermost first.

_OPTIONS = (
    "interpolation", "extension", "projection", "projection_blend", "operation", "use_clamp", "data_type", "blend_type", "clamp_factor",
    "clamp_result", "factor_mode", "interpolation_type", "clamp", "clamp_type", "vector_type", "space", "uv_map", "invert",
    "attribute_name", "attribute_type", "layer_name", "mode", "distribution", "gradient_type", "convert_from", "convert_to",
    "direction_type", "axis", "noise_dimensions", "noise_type", "normalize", "wave_type", "bands_direction", "rings_direction",
    "wave_profile", "rotation_type")
_TABLE_ROWS = 256  # Cycles bakes ramps and curves into as many.
_MAX_NODES = 4097  # One more than the core takes, so that the core refuses the material and says why.


def export_material(material: bpy.types.Material, images: ImageTable, warn: Warn) -> Description:
    """A MaterialDescription of an (evaluated) material."""
    return _export(material, 'ShaderNodeOutputMaterial', images, warn) or _plain(
        material.name, "BsdfDiffuse", {"Color": _four(material.diffuse_color), "Roughness": [0.0] * 4})


def export_world(world: bpy.types.World, images: ImageTable, warn: Warn) -> Description:
    """A MaterialDescription whose surface is the world's background."""
    return _export(world, 'ShaderNodeOutputWorld', images, warn) or _plain(
        world.name, "Background", {"Color": _four(world.color), "Strength": [1.0] * 4})


def light_emission(light: bpy.types.Light, warn: Warn) -> tuple[tuple[float, ...], float]:
    """(colour, strength) that a lamp's node tree multiplies its own with: an Emission node fed by numbers, colours or a Blackbody.
    Anything else is said and left out."""
    found = _export(light, 'ShaderNodeOutputLight', None, warn)
    if not found:
        return (1.0, 1.0, 1.0), 1.0
    nodes, surface = found["nodes"], found["surface"]
    if surface < 0:
        return (0.0, 0.0, 0.0), 0.0
    color = strength = None
    if nodes[surface]["kind"] == "Emission":
        inputs = {item["name"]: item for item in nodes[surface]["inputs"]}
        color, strength = (_constant(inputs[name], nodes) for name in ("Color", "Strength"))
    if color is None or strength is None:
        warn(light.name, "only an Emission node with plain values is supported in a lamp; its nodes are left out")
        return (1.0, 1.0, 1.0), 1.0
    return tuple(color[:3]), strength[0]


def _constant(item: Description, nodes: list[Description]) -> list[float] | None:
    """The value of an input that is a number or comes from a Value, RGB or Blackbody node; else None."""
    if item["node"] < 0:
        return item["value"]
    source = nodes[item["node"]]
    if source["kind"] in {"Value", "RGB"}:
        return source["inputs"][0]["value"]
    if source["kind"] == "Blackbody" and source["inputs"][0]["node"] < 0:
        return [*core.load().blackbody(source["inputs"][0]["value"][0]), 1.0]
    return None


def _plain(name: str, kind: str, values: dict[str, list[float]]) -> Description:
    """A material of one node."""
    inputs = [{"name": key, "value": value, "node": -1, "output": ""} for key, value in values.items()]
    node = {"kind": kind, "name": kind, "inputs": inputs, "options": {}, "table": np.empty(0, np.float32), "image": -1}
    return {"name": name, "nodes": [node], "surface": 0, "surface_output": ""}


def _export(owner: Any, output_type: str, images: ImageTable | None, warn: Warn) -> Description | None:
    """The tree of a material, world or lamp; None if it has none."""
    tree = owner.node_tree
    if tree is None or not getattr(owner, "use_nodes", True):
        return None
    flat = _Flattener(owner.name, images, warn)
    description = {"name": owner.name, "nodes": flat.nodes, "surface": -1, "surface_output": ""}
    output = _active_output(tree, output_type)
    if output is None:
        return description
    for name in ("Volume", "Displacement"):
        socket = output.inputs.get(name)
        if socket is not None and socket.is_linked:
            warn(owner.name, f"{name.lower()} is not supported and is left out")
    source = flat.source_of(output.inputs["Surface"], ())
    if isinstance(source, _Link):
        description["surface"], description["surface_output"] = flat.node_index(source), source.output
        flat.finish()
    return description


def _active_output(tree: bpy.types.NodeTree, output_type: str) -> bpy.types.Node | None:
    """The output node that counts: active ones first, for every engine before those for one."""
    outputs = [node for node in tree.nodes if node.bl_idname == output_type and not node.mute]
    targets = ['ALL', 'CYCLES', 'EEVEE']
    outputs.sort(key=lambda node: (not node.is_active_output, targets.index(getattr(node, "target", 'ALL'))))
    return outputs[0] if outputs else None


class _Link:
    """The output of a real node, met inside the groups of `path` (a tuple of group nodes, outermost first)."""

    def __init__(self, node: bpy.types.Node, output: str, path: GroupPath) -> None:
        self.node, self.output, self.path = node, output, path


class _Flattener:
    def __init__(self, name: str, images: ImageTable | None, warn: Warn) -> None:
        self.nodes: list[Description] = []
        self._name, self._images, self._warn = name, images, warn
        self._indices: dict[tuple[str, ...], int] = {}
        self._waiting: list[tuple[int, _Link]] = []

    def finish(self) -> None:
        """Exports the inputs of the nodes met so far, and so on until no new ones turn up."""
        while self._waiting:
            index, link = self._waiting.pop()
            self.nodes[index]["inputs"] = self._inputs(link.node, link.path)

    def node_index(self, link: _Link) -> int:
        """Place of a real node in the list; it is added when first met."""
        key = (*(group.name for group in link.path), link.node.name)
        if key not in self._indices and len(self.nodes) < _MAX_NODES:
            self._indices[key] = len(self.nodes)
            self.nodes.append(self._describe(link.node))
            self._waiting.append((self._indices[key], link))
        return self._indices.get(key, 0)

    def source_of(self, socket: bpy.types.NodeSocket | None, path: GroupPath) -> _Link | bpy.types.NodeSocket | None:
        """What feeds an input: a _Link, or the socket that holds its value (the input itself, or one of a group further out)."""
        while True:
            link = next((link for link in socket.links if not link.is_muted and link.is_valid), None) if socket.is_linked else None
            if link is None:
                return socket
            node, output = link.from_node, link.from_socket
            if node.bl_idname == 'NodeReroute':
                socket = node.inputs[0]
            elif node.bl_idname == 'NodeGroupInput':
                if not path:
                    return socket
                socket, path = _by_identifier(path[-1].inputs, output.identifier), path[:-1]
            elif node.mute:
                socket = next((inner.from_socket for inner in node.internal_links if inner.to_socket == output), None)
            elif node.bl_idname == 'ShaderNodeGroup' and node.node_tree is not None:
                inside = _group_output(node.node_tree)
                socket = _by_identifier(inside.inputs, output.identifier) if inside is not None else None
                path = (*path, node)
            else:
                return _Link(node, _canonical(node, output), path)
            if socket is None:
                return None

    def _inputs(self, node: Any, path: GroupPath) -> list[Description]:
        """InputDescriptions. An unlinked socket that shows no value in Blender is left out: the node's implicit default."""
        if node.bl_idname in {'ShaderNodeValue', 'ShaderNodeRGB'}:
            name = "Value" if node.bl_idname == 'ShaderNodeValue' else "Color"
            value = _value_of(node.outputs[0])
            return [] if value is None else [_input(name, value)]
        inputs = []
        for socket in node.inputs:
            if not getattr(socket, "enabled", True) or getattr(socket, "is_unavailable", False):
                continue
            name, source = _canonical(node, socket), self.source_of(socket, path)
            if isinstance(source, _Link):
                inputs.append(_input(name, [0.0] * 4, self.node_index(source), source.output))
            elif source is None:  # It is fed by a muted node that passes nothing on.
                inputs.append(_input(name, [0.0] * 4))
            elif source is not socket and source.type != socket.type and source.type != 'SHADER':
                # A node of its own holds the value, and the core converts its type.
                inputs.append(_input(name, [0.0] * 4, *self._constant_node(source)))
            elif hasattr(source, "default_value") and not source.hide_value:
                value = _value_of(source)
                if value is not None:
                    inputs.append(_input(name, value))
        return inputs

    def _constant_node(self, socket: Any) -> tuple[int, str]:
        """(index, output) of a node made for the value of a group's socket of another type."""
        value = _value_of(socket) or [0.0] * 4
        if socket.type == 'VECTOR':
            kind, output, inputs = "CombineXYZ", "Vector", [_input(axis, [value[k]] * 4) for k, axis in enumerate("XYZ")]
        else:
            kind, output = ("RGB", "Color") if socket.type == 'RGBA' else ("Value", "Value")
            inputs = [_input(output, value)]
        self.nodes.append({"kind": kind, "name": socket.name, "inputs": inputs, "options": {}, "table": np.empty(0, np.float32), "image": -1})
        return len(self.nodes) - 1, output

    def _describe(self, node: Any) -> Description:
        """A NodeDescription but for its inputs."""
        described = {"kind": _kind(node), "name": node.name, "inputs": [], "options": _options(node), "table": np.empty(0, np.float32), "image": -1}
        if node.bl_idname == 'ShaderNodeValToRGB':
            ramp = node.color_ramp
            described["options"]["interpolation"] = ramp.interpolation
            described["table"] = _table([ramp.evaluate(k / (_TABLE_ROWS - 1)) for k in range(_TABLE_ROWS)])
        elif node.bl_idname in {'ShaderNodeRGBCurve', 'ShaderNodeVectorCurve', 'ShaderNodeFloatCurve'}:
            low, high, described["table"] = _curves(node.mapping)
            described["options"].update(min=repr(low), max=repr(high), interpolation='LINEAR')
        image = getattr(node, "image", None)
        if image is not None and self._images is not None:
            described["image"] = self._images.index(image)
            described["options"]["alpha_mode"] = getattr(image, "alpha_mode", 'STRAIGHT')
        return described


def _input(name: str, value: list[float], node: int = -1, output: str = "") -> Description:
    return {"name": name, "value": value, "node": node, "output": output}


def _kind(node: bpy.types.Node) -> str:
    """The core's name: Blender's without "ShaderNode"; Principled tells its two shapes apart by a socket that only one has."""
    if node.bl_idname == 'ShaderNodeBsdfPrincipled' and node.inputs.get("Specular IOR Level") is None:
        return "BsdfPrincipledV1"
    return node.bl_idname.removeprefix("ShaderNode")


def _canonical(node: bpy.types.Node, socket: bpy.types.NodeSocket) -> str:
    """The core's name of a socket. The Mix node has a set of sockets per data type, Map Range one whose names agree."""
    if node.bl_idname == 'ShaderNodeMix':
        return socket.identifier.split("_")[0]
    if node.bl_idname == 'ShaderNodeMapRange':
        return socket.name
    return socket.identifier


def _by_identifier(sockets: Iterable[bpy.types.NodeSocket], identifier: str) -> bpy.types.NodeSocket | None:
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def _group_output(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    outputs = [node for node in tree.nodes if node.bl_idname == 'NodeGroupOutput']
    return next((node for node in outputs if node.is_active_output), outputs[0] if outputs else None)


def _options(node: bpy.types.Node) -> dict[str, str]:
    """The node's settings as text."""
    options = {}
    for name in _OPTIONS:
        value = getattr(node, name, None)
        if isinstance(value, bool | str | int | float):
            options[name] = ("1" if value else "0") if isinstance(value, bool) else str(value)
    if getattr(node, "object", None) is not None:
        options["object"] = "1"
    return options


def _value_of(socket: Any) -> list[float] | None:
    """Four floats; None of what is no number (strings, menus, rotations)."""
    value = socket.default_value
    if isinstance(value, bool | int | float):
        return [float(value)] * 4
    if isinstance(value, str):
        return None
    try:
        return _four(value)
    except TypeError:
        return None


def _four(value: Iterable[float]) -> list[float]:
    numbers = [float(number) for number in value][:4]
    return numbers + [1.0] * (4 - len(numbers))


def _table(rows: Iterable[Iterable[float]]) -> np.ndarray:
    return np.ascontiguousarray([tuple(row)[:4] for row in rows], np.float32).reshape(-1)


def _curves(mapping: bpy.types.CurveMapping) -> tuple[float, float, np.ndarray]:
    """(lowest, highest, rows): colour curves go through the common curve first, as Blender evaluates them."""
    mapping.initialize()
    curves = list(mapping.curves)
    low = min(curve.points[0].location[0] for curve in curves)
    high = max(curve.points[-1].location[0] for curve in curves)
    if not low < high or not math.isfinite(high - low):
        low, high = 0.0, 1.0
    rows = []
    for x in np.linspace(low, high, _TABLE_ROWS):
        common = mapping.evaluate(curves[3], float(x)) if len(curves) > 3 else float(x)
        values = [mapping.evaluate(curve, common) for curve in curves[:3]]
        rows.append((values + values[:1] * 3)[:3] + [1.0])
    return low, high, _table(rows)
