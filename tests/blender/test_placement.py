# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads fitted to faces, and the operators that make and link edits."""
import bmesh
import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector


def _same_points(found, expected):
    """Equal as sets, to the precision of Blender's float32 matrices."""
    distances = np.linalg.norm(np.asarray(found)[:, None] - np.asarray(expected)[None], axis=2)
    return len(found) == len(expected) and (distances.min(axis=0) < 3e-6).all() and (distances.min(axis=1) < 3e-6).all()


@pytest.mark.parametrize("seed", range(20))
def test_the_fitted_quad_is_the_rectangle(seed):
    """Points of a turned rectangle with points inside: the quad has its corners, its normal, and all points behind it."""
    from sluice import quad_geometry
    random = np.random.default_rng(seed)
    turn = np.array(Matrix.Rotation(random.random() * 6, 3, Vector(random.normal(size=3))))
    half, centre = random.random(2) + (0.2, 1.2), random.normal(size=3)
    local = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), *((2 * random.random((30, 3)) - 1) * (1, 1, 0))]) * (*half, 1)
    matrix = quad_geometry.fit_quad(local @ turn.T + centre, turn[:, 2])
    corners = np.array([(matrix @ (x, y, 0, 1))[:3] for x in (-1, 1) for y in (-1, 1)])
    assert _same_points(corners, local[:4] @ turn.T + centre)
    np.testing.assert_allclose(matrix[:3, 2] / np.linalg.norm(matrix[:3, 2]), turn[:, 2], atol=1e-6)
    assert np.linalg.det(matrix[:3, :3]) > 0


def test_bumpy_faces_lie_behind_the_quad():
    from sluice import quad_geometry
    points = np.array([(0, 0, 0.1), (1, 0, 0), (1, 1, 0.3), (0, 1, 0)])
    matrix = quad_geometry.fit_quad(points, (0, 0, 1))
    assert matrix[2, 3] == pytest.approx(0.3)


@pytest.mark.parametrize("points", [[(0, 0, 0)], [(0, 0, 0), (1, 0, 0)], [(1, 2, 3)] * 4])
def test_degenerate_faces_still_give_a_quad_with_an_area(points):
    from sluice import quad_geometry
    matrix = quad_geometry.fit_quad(points, (0, 0, 0))
    assert np.isfinite(matrix).all() and np.linalg.det(matrix[:3, :3]) > 0


def test_at_the_cursor():
    scene = bpy.context.scene
    scene.cursor.location = (1, 2, 3)
    bpy.ops.sluice.add_edit(expression="L", size=4)
    entry, exit_ = bpy.data.objects["Light Edit"], bpy.data.objects["Light Edit Exit"]
    bpy.context.view_layer.update()
    assert tuple(entry.matrix_world.translation) == (1, 2, 3) and entry.scale[0] * entry.empty_display_size == 2
    assert (entry.sluice.role, entry.sluice.expression, exit_.sluice.role, exit_.sluice.entry) == ('ENTRY', "L", 'EXIT', entry)
    assert exit_.select_get() and bpy.context.object == exit_
    # beside each other, not overlapping
    assert abs((exit_.matrix_world.translation - entry.matrix_world.translation).length) > 4


@pytest.mark.parametrize("expression, title", [("LS+", "Caustic"), ("L'World'", "Light from World"), ("L'Lamp'D*S'Egg'+", "Light by Egg"),
                                               ("L.*D'Wall,Red \\'A\\''", "Light by Red 'A'"), ("L.*D.S", "Light Edit"), ("L.*!D'Wall'", "Light Edit"), ("L'\u043b\u0430\u043c\u043f\u0430'", "Light from \u043b\u0430\u043c\u043f\u0430")])  # fmt: skip
def test_called_by_what_it_takes(expression, title):
    from sluice import light_kinds
    assert light_kinds.title(expression) == title
    bpy.ops.sluice.add_edit(expression=expression, name=title)
    assert (bpy.context.object.name, bpy.context.object.sluice.entry.name) == (f"{title} Exit", title)


def test_on_selected_faces(new_object, cube_mesh):
    item = new_object("Cube", cube_mesh(), Matrix.Translation((5, 0, 0)) @ Matrix.Diagonal((1, 2, 3, 1)))
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    bpy.ops.object.mode_set(mode='EDIT')
    mesh = bmesh.from_edit_mesh(item.data)
    for face in mesh.faces:
        face.select_set(face.normal.x > 0.9)
    bmesh.update_edit_mesh(item.data)
    bpy.ops.sluice.add_edit()
    assert bpy.context.mode == 'OBJECT'
    entry = bpy.data.objects["Light Edit"]
    bpy.context.view_layer.update()
    np.testing.assert_allclose(entry.matrix_world.translation, (6, 0, 0), atol=1e-6)
    np.testing.assert_allclose(np.array(entry.matrix_world.to_3x3().normalized())[:, 2], (1, 0, 0), atol=1e-6)
    assert sorted(np.round(entry.scale, 5))[1:] == [2.5, 3] or sorted(np.round(entry.scale[:2], 5)) == [2, 3]


def test_exits_are_added_selected_and_linked(new_object):
    bpy.ops.sluice.add_edit()
    entry, first = bpy.data.objects["Light Edit"], bpy.data.objects["Light Edit Exit"]
    first.sluice.intensity = 3
    bpy.ops.sluice.add_exit()  # the active exit is copied
    second = bpy.context.object
    assert second.sluice.entry == entry and second.sluice.intensity == 3 and second != first
    bpy.ops.sluice.select_one(name=entry.name)
    assert bpy.context.selected_objects == [entry]
    bpy.ops.sluice.select_exits()
    assert set(bpy.context.selected_objects) == {first, second}
    third = new_object("Third")
    for item in (third, entry):
        item.select_set(True)
    bpy.context.view_layer.objects.active = entry
    bpy.ops.sluice.link_exits()
    assert third.sluice.role == 'EXIT' and third.sluice.entry == entry and entry.sluice.role == 'ENTRY'
    orders = [item.sluice.order for item in (entry, first, second, third)]
    assert len(set(orders)) == 4


def test_overlay_shapes(new_object):
    """What the view draws, without a view: the quad's corners, the arrow to the side of local +Z, the link."""
    from sluice import overlay
    bpy.ops.sluice.add_edit(size=2)
    entry, exit_ = bpy.data.objects["Light Edit"], bpy.data.objects["Light Edit Exit"]
    entry.matrix_world = Matrix.Diagonal((-1, 2, 1, 1))  # mirrored: the arrow stays on local +Z's side
    bpy.context.view_layer.update()
    corners, centre, tip = overlay.quad_corners(entry)
    assert _same_points(corners, [(x, y, 0) for x in (-1, 1) for y in (-2, 2)])
    assert tip[2] > centre[2]
    exit_.empty_display_type = 'PLAIN_AXES'  # has no arrow of its own
    found = overlay.shapes([entry, exit_], bpy.context.scene)
    assert len(found.fills) == 2 and len(found.lines) == 4
    np.testing.assert_allclose(found.lines[-1][0], [centre, np.array(exit_.matrix_world)[:3, 3]])
    assert found.fills[1][1][:3] == overlay.EXIT_COLOR
    exit_.sluice.tint = (0.1, 0.05, 0)  # fills the exit at full brightness; its border stays mauve
    found = overlay.shapes([entry, exit_], bpy.context.scene)
    assert found.fills[1][1][:3] == pytest.approx((1, 0.735, 0), abs=1e-3) and found.lines[2][1][:3] == overlay.EXIT_COLOR


def test_a_further_exit_takes_over_every_setting():
    """All that an exit has but what an entry has alone, its role, its order and its entry."""
    from sluice.properties import EXIT_PROPERTIES
    bpy.ops.sluice.add_edit()
    first, image = bpy.context.object, bpy.data.images.new("Image", 4, 4)
    rna = first.sluice.bl_rna.properties
    of_entries = {"expression", "enabled", "repeat", "amount", "feather"}
    assert set(EXIT_PROPERTIES) == set(rna.keys()) - of_entries - {"rna_type", "name", "role", "order", "entry"}
    for name in EXIT_PROPERTIES:
        value = {'FLOAT': 0.25, 'BOOLEAN': not getattr(first.sluice, name), 'POINTER': image}[rna[name].type]
        setattr(first.sluice, name, (0.25, 0.5, 0.75) if name == "tint" else value)
    bpy.ops.sluice.add_exit()
    second = bpy.context.object
    assert second != first
    for name in EXIT_PROPERTIES:
        old, new = getattr(first.sluice, name), getattr(second.sluice, name)
        assert tuple(new) == tuple(old) if name == "tint" else new == old, name
