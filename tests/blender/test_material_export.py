# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees as the core is told of them: every node type, groups, reroutes, muting, tables, and versions that differ."""
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from sluice.export import material as exporter


class Images:
    """Counts the images it is asked for."""

    def __init__(self):
        self.images = []

    def index(self, image, color_space=None):
        self.images.append(image.name)
        return len(self.images) - 1


@pytest.fixture
def tree():
    """A material's empty tree with an output."""
    material = bpy.data.materials.new("Material")
    material.use_nodes = True
    material.node_tree.nodes.clear()
    material.node_tree.nodes.new('ShaderNodeOutputMaterial')
    return material.node_tree


def add(tree, kind, **inputs):
    node = tree.nodes.new("ShaderNode" + kind)
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    return node


def surface(tree, output):
    tree.links.new(output, next(node for node in tree.nodes if node.bl_idname == 'ShaderNodeOutputMaterial').inputs["Surface"])


def export(tree, warnings=None):
    material = next(material for material in bpy.data.materials if material.node_tree == tree)
    found = [] if warnings is None else warnings
    return exporter.export_material(material, Images(), lambda *warning: found.append(warning))


def inputs(node):
    return {item["name"]: item for item in node["inputs"]}


def emission_of(tree, output):
    """The exported node that feeds an Emission's colour, and the name of its output."""
    emission = add(tree, "Emission")
    tree.links.new(output, emission.inputs["Color"])
    surface(tree, emission.outputs[0])
    description = export(tree)
    link = inputs(description["nodes"][description["surface"]])["Color"]
    return description["nodes"][link["node"]], link["output"], description


def check_layout(description):
    """What the binding relies on: types, lengths, indices in range."""
    count = len(description["nodes"])
    assert -1 <= description["surface"] < count and isinstance(description["surface_output"], str)
    for node in description["nodes"]:
        assert set(node) == {"kind", "name", "inputs", "options", "table", "image"}
        assert node["table"].dtype == np.float32 and node["table"].ndim == 1 and len(node["table"]) % 4 == 0
        assert all(isinstance(key, str) and isinstance(value, str) for key, value in node["options"].items())
        for item in node["inputs"]:
            assert len(item["value"]) == 4 and all(isinstance(number, float) for number in item["value"])
            assert -1 <= item["node"] < count


def test_every_node_type_passes(tree):
    kinds = [name for name in dir(bpy.types) if name.startswith("ShaderNode")]
    seen = 0
    for kind in kinds:
        try:
            node = tree.nodes.new(kind)
        except RuntimeError:  # abstract types
            continue
        for output in (output for output in node.outputs if output.enabled):
            surface(tree, output)
            description = export(tree)
            check_layout(description)
            if kind != 'ShaderNodeGroup':
                assert description["nodes"][description["surface"]]["kind"].startswith(kind.removeprefix("ShaderNode"))
                seen += 1
    assert seen > 80


def test_principled_tells_its_shape(tree):
    node = add(tree, "BsdfPrincipled", Roughness=0.25)
    surface(tree, node.outputs[0])
    description = export(tree)
    found = description["nodes"][0]
    is_new = "Specular IOR Level" in node.inputs
    assert found["kind"] == ("BsdfPrincipled" if is_new else "BsdfPrincipledV1")
    sockets = inputs(found)
    assert sockets["Roughness"]["value"] == [0.25] * 4
    assert "Normal" not in sockets and "Tangent" not in sockets  # implicit
    assert {"Base Color", "Metallic", "IOR", "Alpha", "Emission Strength"} <= set(sockets)
    assert ("Coat Weight" in sockets) == is_new and ("Clearcoat" in sockets) != is_new


def test_mix_and_map_range_have_one_set_of_names(tree):
    mix = tree.nodes.new('ShaderNodeMix')
    for data_type in ('FLOAT', 'VECTOR', 'RGBA'):
        mix.data_type = data_type
        output = next(output for output in mix.outputs if output.enabled)
        found, name, _ = emission_of(tree, output)
        assert name == "Result" and [item["name"] for item in found["inputs"]] == ["Factor", "A", "B"]
        assert found["options"]["data_type"] == data_type
    vector = tree.nodes.new('ShaderNodeMapRange')
    vector.data_type = 'FLOAT_VECTOR'
    found, name, _ = emission_of(tree, next(output for output in vector.outputs if output.enabled))
    assert name == "Vector" and {"From Min", "From Max", "To Min", "To Max"} <= set(inputs(found))


def test_math_sockets_are_numbered(tree):
    math = tree.nodes.new('ShaderNodeMath')
    math.operation, math.use_clamp = 'MULTIPLY_ADD', True
    for socket, value in zip(math.inputs, (1, 2, 3)):
        socket.default_value = value
    found, name, _ = emission_of(tree, math.outputs[0])
    assert {key: item["value"][0] for key, item in inputs(found).items()} == {"Value": 1, "Value_001": 2, "Value_002": 3}
    assert found["options"]["operation"] == 'MULTIPLY_ADD' and found["options"]["use_clamp"] == "1"


def test_values_colours_and_tables(tree):
    rgb, ramp, curve = tree.nodes.new('ShaderNodeRGB'), tree.nodes.new('ShaderNodeValToRGB'), tree.nodes.new('ShaderNodeRGBCurve')
    rgb.outputs[0].default_value = (0.1, 0.2, 0.3, 1)
    ramp.color_ramp.elements[0].color = (1, 0, 0, 1)
    ramp.color_ramp.interpolation = 'CONSTANT'
    curve.mapping.curves[3].points[1].location = (1, 0.5)
    curve.mapping.curves[0].points[0].location = (0, 0.25)
    curve.mapping.update()
    found, _, _ = emission_of(tree, rgb.outputs[0])
    assert inputs(found)["Color"]["value"] == pytest.approx([0.1, 0.2, 0.3, 1])
    found, _, _ = emission_of(tree, ramp.outputs[0])
    table = found["table"].reshape(-1, 4)
    assert len(table) == 256 and table[0] == pytest.approx([1, 0, 0, 1]) and table[-1] == pytest.approx([1, 1, 1, 1])
    assert found["options"]["interpolation"] == 'CONSTANT'
    found, _, _ = emission_of(tree, curve.outputs[0])
    table = found["table"].reshape(-1, 4)
    assert table[0][0] == pytest.approx(0.25, abs=1e-3) and table[-1][1] == pytest.approx(0.5, abs=1e-3)
    assert (found["options"]["min"], found["options"]["max"]) == ("0.0", "1.0")


def new_group(name, kinds, result):
    """A group with inputs of the kinds given and one output; result(tree, group input, group output) links it."""
    group = bpy.data.node_groups.new(name, 'ShaderNodeTree')
    for kind in kinds:
        if hasattr(group, "interface"):
            group.interface.new_socket("In", in_out='INPUT', socket_type=kind)
        else:
            group.inputs.new(kind, "In")
    if hasattr(group, "interface"):
        group.interface.new_socket("Out", in_out='OUTPUT', socket_type='NodeSocketColor')
    else:
        group.outputs.new('NodeSocketColor', "Out")
    result(group, group.nodes.new('NodeGroupInput'), group.nodes.new('NodeGroupOutput'))
    return group


def test_groups_reroutes_and_muted_nodes_disappear(tree):
    def inner(group, source, sink):
        gamma, reroute = group.nodes.new('ShaderNodeGamma'), group.nodes.new('NodeReroute')
        group.links.new(source.outputs[0], reroute.inputs[0])
        group.links.new(reroute.outputs[0], gamma.inputs["Color"])
        group.links.new(source.outputs[1], gamma.inputs["Gamma"])
        group.links.new(gamma.outputs[0], sink.inputs[0])
    small = new_group("Small", ['NodeSocketColor', 'NodeSocketFloat'], inner)

    def outer(group, source, sink):
        node, muted = group.nodes.new('ShaderNodeGroup'), group.nodes.new('ShaderNodeInvert')
        node.node_tree, muted.mute = small, True
        group.links.new(source.outputs[0], muted.inputs["Color"])
        group.links.new(muted.outputs[0], node.inputs[0])
        node.inputs[1].default_value = 2.5
        group.links.new(node.outputs[0], sink.inputs[0])
    large = new_group("Large", ['NodeSocketColor'], outer)
    first, second, noise = tree.nodes.new('ShaderNodeGroup'), tree.nodes.new('ShaderNodeGroup'), tree.nodes.new('ShaderNodeTexNoise')
    first.node_tree = second.node_tree = large
    tree.links.new(noise.outputs["Color"], first.inputs[0])
    second.inputs[0].default_value = (0.25, 0.5, 0.75, 1)
    mix = tree.nodes.new('ShaderNodeMixRGB')
    tree.links.new(first.outputs[0], mix.inputs["Color1"])
    tree.links.new(second.outputs[0], mix.inputs["Color2"])
    found, _, description = emission_of(tree, mix.outputs[0])
    check_layout(description)
    kinds = [node["kind"] for node in description["nodes"]]
    assert sorted(kinds) == ["Emission", "Gamma", "Gamma", "MixRGB", "TexNoise"]
    gammas = [description["nodes"][inputs(found)[name]["node"]] for name in ("Color1", "Color2")]
    assert gammas[0] is not gammas[1] and all(inputs(node)["Gamma"]["value"][0] == 2.5 for node in gammas)
    assert description["nodes"][inputs(gammas[0])["Color"]["node"]]["kind"] == "TexNoise"
    assert inputs(gammas[1])["Color"]["value"] == pytest.approx([0.25, 0.5, 0.75, 1]) and inputs(gammas[1])["Color"]["node"] == -1


def test_a_groups_colour_on_a_number_is_converted_by_the_core(tree):
    def inner(group, source, sink):
        math = group.nodes.new('ShaderNodeMath')
        group.links.new(source.outputs[0], math.inputs[0])
        group.links.new(math.outputs[0], sink.inputs[0])
    node = tree.nodes.new('ShaderNodeGroup')
    node.node_tree = new_group("Number", ['NodeSocketColor'], inner)
    node.inputs[0].default_value = (1, 0, 0, 1)
    found, _, description = emission_of(tree, node.outputs[0])
    source = description["nodes"][inputs(found)["Value"]["node"]]
    assert source["kind"] == "RGB" and source["inputs"][0]["value"] == [1, 0, 0, 1]


def test_muted_links_and_shared_nodes(tree):
    noise, add_shader = tree.nodes.new('ShaderNodeTexNoise'), tree.nodes.new('ShaderNodeAddShader')
    for socket in add_shader.inputs:
        diffuse = add(tree, "BsdfDiffuse")
        tree.links.new(noise.outputs["Color"], diffuse.inputs["Color"])
        tree.links.new(diffuse.outputs[0], socket)
    surface(tree, add_shader.outputs[0])
    description = export(tree)
    assert [node["kind"] for node in description["nodes"]].count("TexNoise") == 1
    link = noise.outputs["Color"].links[0]
    link.is_muted = True
    muted = [node for node in export(tree)["nodes"] if node["kind"] == "BsdfDiffuse" and inputs(node)["Color"]["node"] == -1]
    assert len(muted) == 1


def test_images_and_their_options(tree):
    image = bpy.data.images.new("Pixels", 4, 4)
    node = tree.nodes.new('ShaderNodeTexImage')
    node.image, node.interpolation, node.extension = image, 'Closest', 'CLIP'
    found, _, _ = emission_of(tree, node.outputs["Color"])
    assert found["image"] == 0 and found["options"]["interpolation"] == "Closest" and found["options"]["extension"] == 'CLIP'
    assert "Vector" not in inputs(found)
    node.image = None
    found, _, _ = emission_of(tree, node.outputs["Color"])
    assert found["image"] == -1


def test_the_active_output_counts(tree):
    first = next(iter(tree.nodes))
    red, green = add(tree, "Emission"), add(tree, "BsdfDiffuse")
    tree.links.new(red.outputs[0], first.inputs["Surface"])
    second = tree.nodes.new('ShaderNodeOutputMaterial')
    tree.links.new(green.outputs[0], second.inputs["Surface"])
    first.is_active_output = second.is_active_output = False
    second.is_active_output = True
    assert export(tree)["nodes"][0]["kind"] == "BsdfDiffuse"
    second.is_active_output, first.is_active_output = False, True
    assert export(tree)["nodes"][0]["kind"] == "Emission"


def test_without_nodes_or_links(tree):
    assert export(tree) == {"name": "Material", "nodes": [], "surface": -1, "surface_output": ""}
    plain = bpy.data.materials.new("Plain")
    if not plain.use_nodes:  # Blender 5 has nodes always
        plain.diffuse_color = (0.5, 0.25, 0.125, 1)
        description = exporter.export_material(plain, Images(), None)
        check_layout(description)
        assert description["nodes"][0]["kind"] == "BsdfDiffuse" and inputs(description["nodes"][0])["Color"]["value"] == [0.5, 0.25, 0.125, 1]


def test_volumes_and_displacement_are_named(tree):
    output = next(iter(tree.nodes))
    tree.links.new(add(tree, "VolumeScatter").outputs[0], output.inputs["Volume"])
    warnings = []
    export(tree, warnings)
    assert warnings == [("Material", "volume is not supported and is left out")]


def test_worlds():
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    background = next(node for node in world.node_tree.nodes if node.bl_idname == 'ShaderNodeBackground')
    background.inputs["Strength"].default_value = 2
    description = exporter.export_world(world, Images(), None)
    check_layout(description)
    assert description["nodes"][description["surface"]]["kind"] == "Background" and inputs(description["nodes"][0])["Strength"]["value"][0] == 2


def test_lamps_fold_to_colour_and_strength(core):
    lamp = bpy.data.lights.new("Lamp", 'POINT')
    assert exporter.light_emission(lamp, None) == ((1, 1, 1), 1)
    lamp.use_nodes = True
    tree = lamp.node_tree
    emission = next(node for node in tree.nodes if node.bl_idname == 'ShaderNodeEmission')
    emission.inputs["Strength"].default_value = 3
    blackbody = add(tree, "Blackbody", Temperature=3000)
    tree.links.new(blackbody.outputs[0], emission.inputs["Color"])
    color, strength = exporter.light_emission(lamp, None)
    assert strength == 3 and color == pytest.approx((1.77084, 0.844284, 0.272223), abs=3e-3)  # as Cycles 3.4.1 renders it
    assert color == core.blackbody(3000)
    falloff, warnings = tree.nodes.new('ShaderNodeLightFalloff'), []
    tree.links.new(falloff.outputs[0], emission.inputs["Strength"])
    assert exporter.light_emission(lamp, lambda *warning: warnings.append(warning)) == ((1, 1, 1), 1)
    assert warnings[0][0] == "Lamp"


def test_a_long_chain_needs_no_deep_stack(tree):
    source = tree.nodes.new('ShaderNodeRGB').outputs[0]
    for _ in range(600):
        node = tree.nodes.new('ShaderNodeGamma')
        tree.links.new(source, node.inputs["Color"])
        source = node.outputs[0]
    _, _, description = emission_of(tree, source)
    assert len(description["nodes"]) == 602


def test_other_versions_by_their_features():
    def socket(name):
        return SimpleNamespace(identifier=name, name=name)
    new = SimpleNamespace(bl_idname='ShaderNodeBsdfPrincipled', inputs={"Specular IOR Level": socket("Specular IOR Level")})
    old = SimpleNamespace(bl_idname='ShaderNodeBsdfPrincipled', inputs={"Specular": socket("Specular")})
    assert (exporter._kind(new), exporter._kind(old)) == ("BsdfPrincipled", "BsdfPrincipledV1")
