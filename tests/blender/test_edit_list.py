# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of edits, what becomes of light, and what a render found at each edit."""

import math

import bpy
import pytest
from mathutils import Vector


@pytest.fixture
def entries(new_object):
    """Three entries, each with an exit."""
    found = []
    for name in ("First", "Second", "Third"):
        entry, exit_ = new_object(name), new_object(f"{name} Exit")
        entry.sluice.role, exit_.sluice.role = 'ENTRY', 'EXIT'
        exit_.sluice.entry = entry
        found.append(entry)
    return found


def _enabled(entries):
    return [item.sluice.enabled for item in entries]


def test_enable_all_or_selected(entries):
    bpy.context.view_layer.objects.active = entries[0]
    assert bpy.ops.sluice.enable_edits(action='DISABLE') == {'FINISHED'} and _enabled(entries) == [False] * 3
    bpy.data.objects["Second Exit"].select_set(True)
    assert bpy.ops.sluice.enable_edits(action='TOGGLE', which='SELECTED') == {'FINISHED'}
    assert _enabled(entries) == [False, True, False]


def test_solo_keeps_what_was_enabled(entries, export_now):
    entries[2].sluice.enabled = False
    bpy.ops.sluice.solo_edit(name="Second")
    assert [edit["enabled"] for edit in export_now()[0]["edits"]] == [False, True, False]
    assert _enabled(entries) == [True, True, False]
    bpy.ops.sluice.solo_edit(name="Second")
    assert [edit["enabled"] for edit in export_now()[0]["edits"]] == [True, True, False]
    bpy.ops.sluice.solo_edit(name="Second")
    bpy.context.scene.collection.objects.unlink(entries[1])  # deleted as Blender deletes what is still pointed at
    assert [edit["enabled"] for edit in export_now()[0]["edits"]] == [True, False]


def test_the_row_follows_the_selection(entries):
    from sluice import model
    manager = bpy.context.window_manager
    assert [item.name for item in model.entries_of(bpy.context.scene)] == ["First", "Second", "Third"]
    manager.sluice_edit_row = bpy.data.objects.find("Second")
    assert bpy.context.object == entries[1] and entries[1].select_get()
    bpy.context.view_layer.objects.active = bpy.data.objects["Third Exit"]
    assert manager.sluice_edit_row == bpy.data.objects.find("Third")


def _exits(name):
    from sluice import model
    return model.exits_of(bpy.data.objects[name])


@pytest.mark.parametrize("action", ['MOVE', 'COPY', 'RECOLOUR', 'DIM', 'REMOVE'])
def test_add_and_change_do_the_same(action, export_now):
    """An edit made with an action, and an empty one to which the action is done."""
    cursor = bpy.context.scene.cursor
    cursor.location = (1, 2, 3)
    bpy.ops.sluice.add_edit(expression="L", size=0.5, action=action)
    bpy.ops.sluice.add_edit(expression="L", size=0.5, action='REMOVE')
    assert bpy.context.object.name == "Light Edit.001"
    if action != 'COPY':
        bpy.ops.sluice.change_light(action=action)
    else:
        cursor.location = (9, 2, 3)
        bpy.ops.sluice.change_light(action=action)
        assert tuple(bpy.context.object.location) == (9, 2, 3)
    counts = {'MOVE': 1, 'COPY': 2, 'RECOLOUR': 1, 'DIM': 1, 'REMOVE': 0}
    for name in ("Light Edit", "Light Edit.001"):
        exits = _exits(name)
        assert len(exits) == counts[action]
        stays = [item for item in exits if item.parent == bpy.data.objects[name]]
        assert len(stays) == (1 if action in {'COPY', 'RECOLOUR', 'DIM'} else 0)
        assert [item.sluice.hue_shift for item in stays] == [0] * len(stays)
        assert all((max(item.sluice.tint) > 2 * min(item.sluice.tint)) == (action == 'RECOLOUR') for item in stays)  # white light is seen to change
        assert [item.sluice.intensity for item in stays] == [0.5 if action == 'DIM' else 1] * len(stays)
        bpy.data.objects[name].location.z += 1  # the exit that stays goes with its entry
        bpy.context.view_layer.update()
        assert all(item.matrix_world == bpy.data.objects[name].matrix_world for item in stays)
    assert [len(edit["exits"]) for edit in export_now()[0]["edits"]] == [counts[action]] * 2


@pytest.mark.parametrize("exits", [0, 1, 2])
def test_move_to_cursor(exits):
    """The exit that is active, else the first; one that is made if there is none. It keeps its size."""
    bpy.ops.sluice.add_edit(expression="L", size=0.5, action='REMOVE')
    entry = bpy.context.object
    for _ in range(exits):
        bpy.ops.sluice.add_exit()
    moved = bpy.context.object if exits else None
    bpy.context.scene.cursor.location = (9, 2, 3)
    bpy.ops.sluice.change_light(action='MOVE', to_cursor=True)
    bpy.context.view_layer.update()
    assert bpy.context.object == (moved or _exits(entry.name)[0]) and len(_exits(entry.name)) == max(1, exits)
    assert tuple(bpy.context.object.matrix_world.translation) == (9, 2, 3) and bpy.context.object.parent is None
    assert bpy.context.object.matrix_world.to_scale() == entry.matrix_world.to_scale()


def test_move_to_cursor_keeps_what_an_exit_follows(entries, new_object):
    """Its parent, unless that is the entry it lay upon; its mirror image, and its arrow away from the surface."""
    screen, exit_ = new_object("Screen"), _exits("First")[0]
    exit_.parent, exit_.scale = screen, (1, 2, -3)
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = exit_
    bpy.context.scene.cursor.location = (9, 2, 3)
    bpy.ops.sluice.change_light(action='MOVE', to_cursor=True)
    bpy.context.view_layer.update()
    assert exit_.parent == screen and tuple(exit_.matrix_world.translation) == (9, 2, 3)
    assert exit_.matrix_world.is_negative and exit_.matrix_world.col[2][2] > 0


def test_change_keeps_exits_that_are_there(entries):
    bpy.context.view_layer.objects.active = entries[0]
    bpy.ops.sluice.change_light(action='DIM', intensity=0.25)
    bpy.ops.sluice.change_light(action='RECOLOUR', hue_shift=1, tint=(0, 0.5, 1))
    exit_, = _exits("First")
    assert (exit_.sluice.intensity, exit_.sluice.hue_shift, tuple(exit_.sluice.tint)) == (0.25, 1, (0, 0.5, 1))
    bpy.context.view_layer.objects.active = exit_
    bpy.ops.sluice.add_exit()
    added = bpy.context.object
    assert tuple(added.sluice.tint) == (0, 0.5, 1)
    bpy.data.objects.remove(added)
    bpy.context.view_layer.objects.active = entries[0]
    bpy.ops.sluice.change_light(action='REMOVE')
    assert _exits("First") == [] and bpy.context.object == entries[0] and len(_exits("Second")) == 1


class _Session:
    """What statistics ask of a session."""

    def __init__(self, **row):
        self.row = {"name": "First", "matched": 0, "moved": 0, "capped": 0, "acted": bool(row.get("matched")), "energy_in": 0.0, "energy_out": 0.0, "share": 0.0, "seconds": 0.0, **row}

    def progress(self):
        return {"pass": 4}

    def statistics(self):
        return {"edits": [self.row], "ledger": {"emitted": 40.0}, "view_paths": 100}


def _told(**row):
    from sluice import edit_statistics
    edit_statistics.remember(_Session(**row))
    return " / ".join(text for text, _icon in edit_statistics.lines(edit_statistics.of("First"))), edit_statistics


def test_figures_in_words():
    told, statistics = _told(matched=12345, moved=24690, energy_in=8.0, energy_out=0.002, share=0.0312, seconds=0.4)
    assert told == "Took 12.3 k paths, sent on 24.7 k / In 2 W, 20 % of the lamps' light; out 500 µW / 3.1 % of the picture; about 0.4 s"
    assert statistics.icon(statistics.of("First")) == 'CHECKMARK'
    assert _told(matched=5, capped=2)[0] == "Took 5 paths, sent on 0 / 5 % of the paths from the eye / Absorbed 2 paths at Max Edits per Path"
    told, statistics = _told(acted=True, share=0.2, seconds=0.1, crossed=800, probed=4096)  # light that no photon carries
    assert told == "Took light on its way to the eye / 20 % of the picture; about 0.1 s"
    assert statistics.icon(statistics.of("First")) == 'CHECKMARK'
    assert _told(acted=True, crossed=800, probed=4096)[0] == "Took light on its way to the eye"
    floats = " / Floats 24 cm in front of its plane"  # in a scene of a thousand kilometres
    assert _told(matched=5, floats=0.24, side=0.5)[0].endswith(floats) and _told(probed=4096, floats=0.24, side=0.5)[0].endswith(floats)
    assert "Floats" not in _told(matched=5, floats=1e-5, side=0.5)[0]
    lost = "The picture has nothing of it: is an exit behind a surface, or out of sight?"
    assert _told(matched=5, moved=5, energy_in=1.0, energy_out=1.0)[0].endswith(lost) and lost not in _told(matched=5, moved=5, energy_in=1.0)[0]
    assert _told()[0] == "Nothing that matches crossed the entry"  # of what the eye sees
    assert "No light crosses it at all" in _told(probed=4096)[0]
    told, statistics = _told(crossed=800, probed=4096)
    assert "800 of 4,096 test paths crossed it" in told
    assert statistics.icon(statistics.of("First")) == 'ERROR' and statistics.of("Second") is None
    assert statistics.stamps() == {"First": "matched 0, moved 0, capped 0, in 0 W, out 0 W, makes 0 % of the picture, "
                                            "about 0 s, crossed 800 of 4096 test paths"}
    assert _told(crossed=8, probed=4096, taken=900, taker="Second")[0] == "Second takes the light before it comes here"
    assert [statistics.percent(share) for share in (0, 1e-6, 1e-4, 0.031, 0.0999, 0.12, 1)] == ["0 %", "under 0.01 %", "0.01 %", "3.1 %", "10 %", "12 %", "100 %"]
    bpy.ops.wm.read_homefile(use_empty=True)
    assert statistics.of("First") is None


def test_drawn_dashed_where_no_light_was_found_and_dim_where_it_does_not_act(entries):
    from sluice import overlay
    statistics = _told(crossed=3)[1]
    scene = bpy.context.scene
    fills, lines = overlay.shapes(entries, scene)
    assert [len(points) for points, _color in fills] == [6, 6, 6]
    borders = [points for points, _color in lines if len(points) != 10]  # ten: an arrow
    assert [len(points) for points in borders] == [4 * 2 * overlay._DASHES, 8, 8]  # the first one alone was rendered
    assert (borders[0].min(axis=0) == borders[1].min(axis=0)).all() and (borders[0].max(axis=0) == borders[1].max(axis=0)).all()
    scene.sluice.solo = entries[1]
    strengths = [color[3] for _points, color in overlay.shapes(entries, scene).fills]
    assert strengths[0] == strengths[2] < 0.5 * strengths[1]
    statistics.forget()


def test_light_that_arrived_becomes_the_expression(entries):
    bpy.context.view_layer.objects.active = bpy.data.objects["First Exit"]
    assert bpy.ops.sluice.take_arrival(expression="L'Sun'S'Egg'+") == {'FINISHED'}
    assert entries[0].sluice.expression == "L'Sun'S'Egg'+" and entries[1].sluice.expression == "LS+"


def test_a_render_leaves_its_figures(entries, camera, cube_mesh, new_object, tmp_path):
    """F12 with the real core: an entry in the light of a lamp, one that finds nothing, in panel and file header."""
    from mathutils import Matrix
    from sluice import edit_statistics
    new_object("Floor", cube_mesh(), Matrix.Translation((0, 0, -1)))
    new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT'), Matrix.Translation((0, 0, 2)))
    entries[1].sluice.expression, entries[0].sluice.expression = "LS'Floor'S+", "L"
    entries[1].location.z = 0.5  # above the first, whose light crosses it
    bpy.data.objects["First Exit"].location.x = 5
    entries[2].sluice.enabled = False
    scene = bpy.context.scene
    scene.sluice.passes, scene.sluice.photons = 4, 20000
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.image_settings.file_format, scene.render.filepath = 'OPEN_EXR', str(tmp_path / "out.exr")
    bpy.ops.render.render(write_still=True)
    first, second, third = (edit_statistics.of(item.name) for item in entries)
    assert 0 < first.taken <= 1 and 0 <= first.share < 1 and first.seconds > 0
    assert first.matched > 100 and first.power_in > 0 and first.arrivals[0][0] == "L'Lamp'"
    assert third is None  # it did not act
    assert second.matched == 0 and 0 < second.crossed < second.probed and second.arrivals[0][0].startswith("L'Lamp'")
    header = (tmp_path / "out.exr").read_bytes()
    entries[1].sluice.enabled = False
    bpy.ops.render.render()
    assert edit_statistics.of("First") is not None and edit_statistics.of("Second") is None  # of a render before
    assert b"Sluice edit First" in header and edit_statistics.stamp(second).encode() in header


def test_what_arrives_at_a_place(cube_mesh, new_object):
    """Edit Light Here with the real core: straight light on a floor, in plain words; nothing is left behind in the scene."""
    from mathutils import Matrix
    from sluice import arrivals
    new_object("Floor", cube_mesh(), Matrix.Translation((0, 0, -1)))
    new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT'), Matrix.Translation((0, 0, 2)))
    before = len(bpy.data.objects)
    session = arrivals.ask(bpy.context.evaluated_depsgraph_get(), bpy.data, Matrix.Scale(0.5, 4))
    assert session.wait(60)
    (expression, share), = arrivals.answer(session)[0]
    assert arrivals.answer(session)[1] == ""
    assert expression == "L'Lamp'" and share > 0.9
    assert arrivals.told(expression, share).endswith("%   light straight from Lamp")
    assert bpy.ops.sluice.edit_light_here() == {'FINISHED'} and len(bpy.data.objects) == before


def test_light_that_is_taken_before_is_told(cube_mesh, new_object):
    """Nothing arrives below an entry that takes all: its name is told."""
    from mathutils import Matrix
    from sluice import arrivals
    new_object("Floor", cube_mesh(), Matrix.Translation((0, 0, -1)))
    new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT'), Matrix.Translation((0, 0, 2)))
    bpy.ops.sluice.add_edit(expression="L", size=1.9, action='REMOVE')
    thief = bpy.context.object
    for name, height in (("Above", 0.5), ("In the plane", 0.0)):
        thief.name, thief.location.z = name, height
        session = arrivals.ask(bpy.context.evaluated_depsgraph_get(), bpy.data, Matrix.Scale(0.5, 4))
        assert session.wait(60) and arrivals.answer(session) == ([], name)


def test_the_question_comes_after_all_edits_and_costs_little(entries, fake_core):
    """Whatever orders there are: in one plane, what others take is gone before. Nobody looks at the picture."""
    from mathutils import Matrix
    from sluice import arrivals
    bpy.data.objects["First Exit"].sluice.order = 1000
    arrivals.ask(bpy.context.evaluated_depsgraph_get(), bpy.data, Matrix.Scale(0.5, 4))
    assert fake_core.last_description["edits"][-1]["entry"]["order"] == 1001
    settings = fake_core.last_settings
    assert settings["pilot_paths"] <= 1024 and not settings["use_adaptive_sampling"]


def test_move_lays_the_exit_that_is_there(entries):
    bpy.context.view_layer.objects.active = entries[0]
    exit_, = _exits("First")
    assert bpy.ops.sluice.change_light(action='MOVE') == {'FINISHED'} and bpy.context.object == exit_ and _exits("First") == [exit_]
    bpy.context.view_layer.objects.active = entries[0]
    bpy.ops.sluice.change_light(action='REMOVE')
    bpy.ops.sluice.change_light(action='DIM')
    upon, = _exits("First")
    bpy.ops.sluice.change_light(action='MOVE')
    bpy.context.view_layer.update()
    assert _exits("First") == [upon] and upon.parent is None and upon.sluice.intensity == 0.5
    assert (upon.matrix_world.translation - entries[0].matrix_world.translation).length > 0.5


def test_a_deleted_entry_leaves_no_line(entries):
    from sluice import overlay
    scene, exit_ = bpy.context.scene, bpy.data.objects["First Exit"]
    assert [len(points) for points, _color in overlay.shapes([exit_], scene).lines] == [8, 10, 2]  # border, arrow, link
    scene.collection.objects.unlink(entries[0])
    assert [len(points) for points, _color in overlay.shapes([exit_], scene).lines] == [8, 10]


def test_a_wrong_edit_is_told_where_light_is_asked_for(entries):
    entries[0].sluice.expression = "L("
    bpy.data.objects["First Exit"].location.x = 5
    with pytest.raises(RuntimeError, match="First: column 2"):
        bpy.ops.sluice.edit_light_here()


def test_an_arrow_that_points_at_the_eye_leans():
    """As little as it takes to see it, up if it points straight there; others stay as they are."""
    from sluice import gizmos
    eye, up = Vector((0, 0, 1)), Vector((0, 1, 0))
    for axis, seen in (((0, 0, 1), (0, math.sin(gizmos._LEAN), math.cos(gizmos._LEAN))), ((0, 0, -1), (0, math.sin(gizmos._LEAN), -math.cos(gizmos._LEAN))),
                       ((math.sin(0.1), 0, math.cos(0.1)), (math.sin(gizmos._LEAN), 0, math.cos(gizmos._LEAN))), ((0, 0.6, 0.8), (0, 0.6, 0.8))):
        assert (gizmos._leaning(Vector(axis), eye, up) - Vector(seen)).length < 1e-6
