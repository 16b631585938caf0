# SPDX-License-Identifier: GPL-3.0-or-later
"""Shading normals as renders take them against Blender's own, on meshes of many kinds."""
import math

import bpy
import numpy as np
import pytest
from blender_scenes import auto_smooth, made_by, modified, smooth, sphere
from mathutils import Matrix


def _monkey():
    return smooth(made_by(bpy.ops.mesh.primitive_monkey_add))


def _moved(item, move):
    """The object after move(vertex number, position) of each vertex; positions come from a generator of a fixed seed where they are random."""
    for number, vertex in enumerate(item.data.vertices):
        vertex.co = move(number, vertex.co.copy())
    return item


def _bent():
    random = np.random.default_rng(3)
    grid = smooth(made_by(bpy.ops.mesh.primitive_grid_add, x_subdivisions=12, y_subdivisions=9))
    return _moved(grid, lambda _number, p: (p.x, p.y, 0.2 * random.random()))


def _from_faces(positions, faces):
    mesh = bpy.data.meshes.new("Faces")
    mesh.from_pydata(positions, [], faces)
    item = bpy.data.objects.new("Faces", mesh)
    bpy.context.scene.collection.objects.link(item)
    return smooth(item)


def _hollow_ngon():
    """Its first three corners turn the other way than the whole."""
    rim = [(0, 0, 0), (2, -1, 0), (1, 0, 0.3), (2, 1, 0), (0, 2, 0), (-2, 0, 0.1)]
    return _from_faces([*rim, (0, 0.5, 1)], [tuple(range(6)), (3, 6, 4)])


def _without_area():
    """A quad with two corners in one place, and a triangle on a line, with vertices that are its alone."""
    places = [(0, 0, 0), (1, 0, 0), (1, 1, 0.2), (0, 1, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (0.5, 0.5, 1)]
    return _from_faces(places, [(0, 1, 2, 3), (1, 4, 2, 7), (1, 5, 6), (3, 2, 7)])


def _three_at_an_edge():
    return _from_faces([(0, 0, 0), (0, 0, 1), (1, 0, 0.5), (0, 1, 0.4), (-1, -1, 0.3)], [(0, 1, 2), (1, 0, 3), (0, 1, 4)])


def _flipped():
    item = _monkey()  # not a sphere: the operator gives its faces another order each time
    for polygon in list(item.data.polygons)[::7]:
        polygon.flip()
    return item


def _loose():
    item = _monkey()
    item.data.vertices.add(3)
    item.data.edges.add(1)
    item.data.edges[-1].vertices = (len(item.data.vertices) - 1, 0)
    item.data.update()
    return item


def _sharp(auto=None):
    item = smooth(made_by(bpy.ops.mesh.primitive_cylinder_add, vertices=24))
    for edge in list(item.data.edges)[::3]:
        edge.use_edge_sharp = True
    return auto_smooth(item, auto) if auto is not None else item


def _custom():
    item = auto_smooth(_monkey(), math.pi)
    random = np.random.default_rng(5).normal(size=(len(item.data.vertices), 3))
    item.data.normals_split_custom_set_from_vertices((random / np.linalg.norm(random, axis=1)[:, None]).tolist())
    return item


def _scaled(scale):
    return _moved(_monkey(), lambda _number, p: p * scale)


def _text():
    item = made_by(bpy.ops.object.text_add)
    item.data.body, item.data.extrude, item.data.bevel_depth = "Sluice", 0.2, 0.02
    return item


def _tube():
    item = made_by(bpy.ops.curve.primitive_bezier_circle_add)
    item.data.bevel_depth = 0.2
    return item


KINDS = {
    "sphere": sphere, "monkey": _monkey, "flat": lambda: smooth(_monkey(), False), "mixed": lambda: smooth(_monkey(), [True, True, False]),
    "bent quads": _bent, "hollow n-gon": _hollow_ngon, "no area": _without_area, "three at an edge": _three_at_an_edge,
    "cylinder with n-gons": lambda: smooth(made_by(bpy.ops.mesh.primitive_cylinder_add, vertices=24)), "flipped": _flipped, "loose": _loose,
    "sharp edges": _sharp, "sharp edges and angle": lambda: _sharp(0.5), "auto smooth": lambda: auto_smooth(_monkey(), 0.5), "custom": _custom,
    "1e6 m": lambda: _scaled(1e6), "1 mm": lambda: _scaled(1e-3), "1 µm": lambda: _scaled(1e-6),
    "subdivision": lambda: modified(_monkey(), 'SUBSURF', levels=2, render_levels=2), "multiresolution": lambda: modified(_monkey(), 'MULTIRES'),
    "hard bevel": lambda: modified(auto_smooth(_monkey(), math.pi), 'BEVEL', harden_normals=True, width=0.01),
    "weighted": lambda: modified(auto_smooth(_monkey(), math.pi), 'WEIGHTED_NORMAL'), "solidify": lambda: modified(_monkey(), 'SOLIDIFY', thickness=0.05),
    "triangulate": lambda: modified(_monkey(), 'TRIANGULATE'), "mirror": lambda: modified(_monkey(), 'MIRROR'),
    "remesh": lambda: modified(_monkey(), 'REMESH', voxel_size=0.1, use_smooth_shade=True),
    "decimate": lambda: modified(_monkey(), 'DECIMATE', ratio=0.3),
    "text": _text, "tube": _tube, "metaball": lambda: made_by(bpy.ops.object.metaball_add),
    "nurbs": lambda: made_by(bpy.ops.surface.primitive_nurbs_surface_sphere_add),
}


# Blender adds up in floats: of faces that are small beside their distance from the mesh's origin it knows the normals less well
_ROUNDING = {"text": 1e-3, "decimate": 1e-4}


def _blenders_own(mesh):
    """(triangles, 3, 3)."""
    mesh.calc_loop_triangles()
    if hasattr(mesh, "corner_normals"):
        normals = np.array([normal.vector[:] for normal in mesh.corner_normals])
    else:
        mesh.calc_normals_split()
        normals = np.array([loop.normal[:] for loop in mesh.loops])
    return normals[np.array([triangle.loops[:] for triangle in mesh.loop_triangles])]


@pytest.mark.parametrize("kind", KINDS)
def test_normals_are_blenders(core, export_now, kind):
    item = KINDS[kind]()
    if kind != "metaball":  # of no influence: normals live in the mesh's own space; but a mirrored metaball is none
        item.matrix_world = Matrix.Translation((1, 2, 3)) @ Matrix.Diagonal((-1, 2, 1, 1))
    found, = export_now()[0]["meshes"]
    normals = (core.shading_normals(found) if found["polygons"] else found["normals"]).reshape(-1, 3, 3)
    instance, = [instance.object.data for instance in bpy.context.evaluated_depsgraph_get().object_instances if instance.object.type == 'MESH']
    own = _blenders_own(instance)
    assert (len(normals) == 0) == (kind == "flat")
    if len(normals):
        np.testing.assert_allclose(normals, own, atol=_ROUNDING.get(kind, 2e-5))


def test_the_core_makes_what_blender_makes_on_racing_threads(export_now):
    """Its own sums are not even read then."""
    sphere()
    auto_smooth(sphere(), 0.5)
    found = export_now()[0]["meshes"]
    if "corner_normals" in bpy.types.Mesh.bl_rna.properties:
        assert all(len(mesh["normals"]) and not mesh["polygons"] for mesh in found)
    else:
        assert sorted((len(mesh["normals"]) > 0, len(mesh["polygons"]) > 0) for mesh in found) == [(False, True), (True, False)]
