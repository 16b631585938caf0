# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported meshes and instances against Blender's own evaluated data, read the slow and plain way."""
import bpy
import numpy as np
import pytest
from blender_scenes import geometry_tree
from mathutils import Matrix


def _corner_normals(mesh):
    if hasattr(mesh, "corner_normals"):
        return [tuple(normal.vector) for normal in mesh.corner_normals]
    mesh.calc_normals_split()
    return [tuple(loop.normal) for loop in mesh.loops]


def _expected(mesh):
    """Positions and, per triangle corner, vertex, normal, UVs: one Python step per corner."""
    mesh.calc_loop_triangles()
    corners = [(vertex, loop) for triangle in mesh.loop_triangles for vertex, loop in zip(triangle.vertices, triangle.loops)]
    normals = _corner_normals(mesh)
    return ([tuple(vertex.co) for vertex in mesh.vertices], [vertex for vertex, _loop in corners],
            [normals[loop] for _vertex, loop in corners],
            {layer.name: [tuple(layer.data[loop].uv) for _vertex, loop in corners] for layer in mesh.uv_layers})


def _check_mesh(found, mesh):
    positions, vertices, normals, uvs = _expected(mesh)
    assert found["positions"].dtype == np.float32 and found["triangles"].dtype == np.uint32
    assert all(array.flags.c_contiguous for array in (found["positions"], found["triangles"], found["normals"], *found["polygons"].values()))
    np.testing.assert_array_equal(found["positions"], np.array(positions, np.float32))
    np.testing.assert_array_equal(found["triangles"].ravel(), vertices)
    if len(found["normals"]):
        np.testing.assert_array_equal(found["normals"], np.array(normals, np.float32))
    elif found["polygons"]:  # the core makes them: test_normals.py
        _check_polygons(found["polygons"], mesh)
    else:  # flat: each corner's normal is its triangle's
        p = np.array(positions)[np.array(vertices).reshape(-1, 3)]
        flat = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        flat /= np.linalg.norm(flat, axis=1)[:, None]
        np.testing.assert_allclose(np.repeat(flat, 3, axis=0), normals, atol=1e-4)
    assert [layer["name"] for layer in found["uv_maps"]] and {layer["name"] for layer in found["uv_maps"]} == set(uvs)
    for layer in found["uv_maps"]:
        np.testing.assert_array_equal(layer["corners"], np.array(uvs[layer["name"]], np.float32))


def _check_polygons(found, mesh):
    np.testing.assert_array_equal(found["corners"], [loop.vertex_index for loop in mesh.loops])
    np.testing.assert_array_equal(found["starts"], [polygon.loop_start for polygon in mesh.polygons])
    np.testing.assert_array_equal(found["sizes"], [polygon.loop_total for polygon in mesh.polygons])
    np.testing.assert_array_equal(found["smooth"], [polygon.use_smooth for polygon in mesh.polygons])
    np.testing.assert_array_equal(found["of_triangles"], [triangle.polygon_index for triangle in mesh.loop_triangles])


def _evaluated(item):
    return item.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


@pytest.mark.parametrize("shading", ["flat", "smooth", "mixed", "auto smooth", "custom"])
def test_mesh_equals_blenders_own(new_object, cube_mesh, export_now, shading):
    mesh = cube_mesh()
    mesh.uv_layers.new(name="Second")
    mesh.uv_layers["Second"].data.foreach_set("uv", np.linspace(0, 1, 48, dtype=np.float32))
    item = new_object("Cube", mesh)
    item.modifiers.new("Bevel", 'BEVEL')
    smooth = {"flat": False, "mixed": [number % 2 == 0 for number in range(6)]}.get(shading, True)
    mesh.polygons.foreach_set("use_smooth", np.broadcast_to(smooth, 6).copy())
    if shading == "auto smooth" and hasattr(mesh, "use_auto_smooth"):
        mesh.use_auto_smooth, mesh.auto_smooth_angle = True, 0.5
    if shading == "custom":
        if hasattr(mesh, "use_auto_smooth"):
            mesh.use_auto_smooth = True
        item.modifiers.clear()
        mesh.normals_split_custom_set([(0.6, 0, 0.8)] * len(mesh.loops))
    found, = export_now()[0]["meshes"]
    assert bool(len(found["normals"]) or found["polygons"]) == (shading != "flat")
    _check_mesh(found, _evaluated(item))


def test_the_uv_map_for_rendering_comes_first(new_object, cube_mesh, export_now):
    mesh = cube_mesh()
    mesh.uv_layers.new(name="Second").active_render = True
    new_object("Cube", mesh)
    assert [layer["name"] for layer in export_now()[0]["meshes"][0]["uv_maps"]] == ["Second", "UVMap"]


def test_materials_per_face_and_slot_links(new_object, cube_mesh, export_now):
    mesh = cube_mesh()
    names = ["Red", "Green", "Blue"]
    for name in names:
        mesh.materials.append(bpy.data.materials.new(name))
    mesh.polygons.foreach_set("material_index", [0, 1, 2, 0, 1, 2])
    item, other = new_object("Cube", mesh), new_object("Other", mesh)
    other.material_slots[1].link = 'OBJECT'
    other.material_slots[1].material = bpy.data.materials.new("Own")
    description = export_now()[0]
    found, = description["meshes"]
    by_name = [material["name"] for material in description["materials"]]
    slots = {instance["names"][0]: [by_name[index] for index in instance["materials"]] for instance in description["instances"]}
    assert slots == {"Cube": names, "Other": ["Red", "Own", "Blue"]}
    evaluated = _evaluated(item)
    evaluated.calc_loop_triangles()
    np.testing.assert_array_equal(found["material_slots"], [triangle.material_index for triangle in evaluated.loop_triangles])
    assert found["material_slots"].dtype == np.uint16


def test_materials_set_by_a_modifier(new_object, cube_mesh, export_now):
    """Geometry nodes may set materials that no slot of the object knows."""
    tree, first, last = geometry_tree()
    node = tree.nodes.new('GeometryNodeSetMaterial')
    node.inputs["Material"].default_value = bpy.data.materials.new("Made")
    tree.links.new(first.outputs[0], node.inputs["Geometry"])
    tree.links.new(node.outputs[0], last.inputs[0])
    item = new_object("Cube", cube_mesh())
    item.modifiers.new("Nodes", 'NODES').node_group = tree
    description = export_now()[0]
    instance, = description["instances"]
    used = set(description["meshes"][0]["material_slots"].tolist() or [0])
    assert {description["materials"][instance["materials"][slot]]["name"] for slot in used} == {"Made"}


@pytest.mark.parametrize("domain, kind", [('CORNER', 'BYTE_COLOR'), ('POINT', 'FLOAT_COLOR')])
def test_color_attributes(new_object, cube_mesh, export_now, domain, kind):
    mesh = cube_mesh()
    layer = mesh.color_attributes.new("Paint", kind, domain)
    values = np.random.default_rng(1).random((len(layer.data), 4), np.float32)
    layer.data.foreach_set("color", values.ravel())
    item = new_object("Cube", mesh)
    found = export_now()[0]["meshes"][0]["colors"][0]
    evaluated = _evaluated(item)
    evaluated.calc_loop_triangles()
    stored = evaluated.color_attributes["Paint"].data
    expected = [tuple(stored[index].color)[:3] for triangle in evaluated.loop_triangles
                for index in (triangle.loops if domain == 'CORNER' else triangle.vertices)]
    assert found["name"] == "Paint"
    np.testing.assert_array_equal(found["corners"], np.array(expected, np.float32))


@pytest.mark.parametrize("kind", ["curve", "text", "metaball", "surface"])
def test_other_kinds_come_as_meshes(export_now, kind):
    add = {"curve": bpy.ops.curve.primitive_bezier_circle_add, "text": bpy.ops.object.text_add,
           "metaball": bpy.ops.object.metaball_add, "surface": bpy.ops.surface.primitive_nurbs_surface_sphere_add}[kind]
    add()
    item = bpy.context.object
    if kind == "curve":
        item.data.bevel_depth = 0.1
    if kind == "text":
        item.data.extrude = 0.1
    description = export_now()[0]
    mesh = item.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    instance, = description["instances"]
    assert instance["names"][0] == item.name
    np.testing.assert_array_equal(description["meshes"][0]["positions"], [tuple(vertex.co) for vertex in mesh.vertices])


def test_instances_share_their_mesh(new_object, cube_mesh, export_now):
    mesh = cube_mesh()
    places = [Matrix.Translation((number, 0, 0)) @ Matrix.Scale(-1, 4, (1, 0, 0)) for number in range(3)]
    for number, matrix in enumerate(places):
        new_object(f"Cube{number}", mesh, matrix)
    inner, outer = bpy.data.collections.new("Inner"), bpy.data.collections.new("Outer")
    outer.children.link(inner)
    new_object("Original", mesh, Matrix.Translation((0, 0, 9)), collection=inner)
    maker = new_object("Maker", None, Matrix.Translation((0, 5, 0)))
    maker.instance_type, maker.instance_collection = 'COLLECTION', outer
    description = export_now()[0]
    assert len(description["meshes"]) == 1 and len(description["instances"]) == 4
    by_name = {instance["names"][0]: instance for instance in description["instances"]}
    for number, matrix in enumerate(places):
        np.testing.assert_allclose(by_name[f"Cube{number}"]["matrix"], np.array(matrix), atol=1e-6)
        assert np.linalg.det(by_name[f"Cube{number}"]["matrix"]) < 0
    assert by_name["Original"]["names"] == ["Original", "Inner", "Outer", "Maker"]
    np.testing.assert_array_equal(by_name["Original"]["matrix"][:3, 3], (0, 5, 9))
    assert by_name["Original"]["matrix"].dtype == np.float64


def test_a_modifier_gives_a_mesh_of_its_own(new_object, cube_mesh, export_now):
    mesh = cube_mesh()
    new_object("Plain", mesh)
    new_object("Smooth", mesh).modifiers.new("Subdivision", 'SUBSURF')
    description = export_now()[0]
    assert sorted(len(item["positions"]) for item in description["meshes"]) == [8, 26]


def test_generated_coordinates_span_the_texture_space(new_object, cube_mesh, export_now):
    mesh = cube_mesh()
    mesh.transform(Matrix.Diagonal((1, 2, 3, 1)))
    new_object("Box", mesh)
    found, = export_now()[0]["meshes"]
    generated = (found["positions"] - found["texture_origin"]) / found["texture_size"]
    np.testing.assert_allclose(generated.min(axis=0), 0, atol=1e-6)
    np.testing.assert_allclose(generated.max(axis=0), 1, atol=1e-6)


def test_visibility(new_object, cube_mesh, export_now):
    mesh = cube_mesh()
    new_object("Ghost", mesh).visible_camera = False
    new_object("Thin", mesh).visible_shadow = False
    found = {item["names"][0]: (item["visible_to_camera"], item["casts_shadow"]) for item in export_now()[0]["instances"]}
    assert found == {"Ghost": (False, True), "Thin": (True, False)}


def test_what_is_skipped_is_named(new_object, cube_mesh, export_now):
    new_object("Cloud", bpy.data.volumes.new("Cloud"))
    furry = new_object("Furry", cube_mesh())
    furry.modifiers.new("Fur", 'PARTICLE_SYSTEM')
    furry.particle_systems[0].settings.type = 'HAIR'
    warnings = export_now()[1]
    assert {item for item, _message in warnings} == {"Cloud", "Furry"}
    assert all("not rendered" in message for _item, message in warnings)


def test_object_info(new_object, cube_mesh, export_now):
    from sluice.export.geometry import name_hash
    item = new_object("Suzanne", cube_mesh())
    item.color, item.pass_index = (0.25, 0.5, 0.75, 1), 7
    found, = export_now()[0]["instances"]
    assert found["color"] == (0.25, 0.5, 0.75) and found["object_index"] == 7
    assert found["random"] == name_hash("Suzanne") / 2**32 and 0 <= found["random"] < 1


def test_empty_meshes_and_hidden_objects_are_left_out(new_object, cube_mesh, export_now):
    new_object("Nothing", bpy.data.meshes.new("Nothing"))
    new_object("Hidden", cube_mesh()).hide_viewport = True  # the depsgraph of a test is the view layer's
    description, warnings = export_now()
    assert not description["meshes"] and not description["instances"] and not warnings


def test_a_big_mesh_is_quick(new_object, export_now):
    """980 k triangles took 0.5 s by a plain script; nothing here may run per vertex in Python."""
    import time
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=500, y_subdivisions=500)
    bpy.context.object.data.polygons.foreach_set("use_smooth", [True] * 250000)
    begin = time.perf_counter()
    description = export_now()[0]
    assert len(description["meshes"][0]["triangles"]) == 500000
    assert time.perf_counter() - begin < 3
