# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered mode without a window: what an update copies anew, and when the picture starts over. With the stand-in core."""
from types import SimpleNamespace

import bpy
import pytest
from mathutils import Matrix
from windowless import Window


@pytest.fixture
def window(camera, new_object, cube_mesh, fake_core, monkeypatch):
    """A view of a cube with an edit that has settled."""
    from sluice import viewport
    scene = bpy.context.scene
    new_object("Cube", cube_mesh())
    bpy.ops.sluice.add_edit(expression="LS+")
    scene.sluice.passes, scene.sluice.photons = 4, 100000
    found = Window(160, 80, scene.camera, monkeypatch.setattr)
    found.update()
    found.draw()
    found.settle()
    yield found
    viewport.free(found.view)


def test_levels(window):
    """Coarse ones first, of little work; all of one compilation."""
    first, second, last = window.sessions
    assert window.copies == 1 and first.base is None and second.base is first and last.base is first
    assert [s._frame["width"] for s in window.sessions] == [20, 80, 160]
    assert [s._settings["passes"] for s in window.sessions] == [1, 1, 4]
    photons, pilots = ([s._settings.get(name) for s in window.sessions] for name in ("photons", "pilot_paths"))
    assert photons[0] < photons[1] < photons[2] == 100000 and pilots[0] < pilots[1] and pilots[2] is None
    assert window.view.texture.shape == (80, 160, 4)


def restarted(window, datablocks, copies):
    """Whether an update starts the picture over; asks how often the scene was copied for it."""
    before, known = window.copies, len(window.sessions)
    window.update(*datablocks)
    window.draw()
    assert window.copies - before == copies, datablocks
    found = len(window.sessions) > known
    assert found == (window.view.level == 0)
    window.settle()
    return found


def test_an_edit_keeps_the_things(window):
    base = window.view.base
    exit_ = next(item for item in bpy.data.objects if item.sluice.role == 'EXIT')
    exit_.location.x += 1
    assert restarted(window, [exit_], copies=0) and window.view.base is base
    assert window.sessions[-1]._description["edits"][0]["exits"][0]["quad"]["matrix"][0, 3] == exit_.matrix_world[0][3]
    exit_.sluice.intensity = 3
    assert restarted(window, [exit_], copies=0) and window.sessions[-1]._description["edits"][0]["exits"][0]["intensity"] == 3
    bpy.context.scene.sluice.photons = 90000
    assert restarted(window, [bpy.context.scene], copies=0) and window.sessions[-1]._settings["photons"] == 90000
    bpy.context.scene.sluice.max_gates = 3
    assert restarted(window, [bpy.context.scene], copies=0) and window.sessions[-1]._description["max_gates"] == 3
    assert all(session.base is base for session in window.sessions[1:])


def test_what_changes_nothing_starts_nothing(window):
    scene, cube = bpy.context.scene, bpy.data.objects["Cube"]
    cube.select_set(not cube.select_get())
    assert not restarted(window, [scene], copies=0)
    assert not restarted(window, [next(item for item in bpy.data.objects if item.sluice.role == 'ENTRY')], copies=0)
    assert not restarted(window, [scene.camera, scene.camera.data], copies=0)  # the view is another
    assert not restarted(window, [], copies=0)


def test_things_are_copied_anew(window, new_object, cube_mesh):
    scene, cube = bpy.context.scene, bpy.data.objects["Cube"]
    cube.location.x += 1
    assert restarted(window, [cube], copies=1) and window.sessions[-1].base is window.view.base is window.sessions[3]
    cube.data.vertices[0].co.x += 1
    assert restarted(window, [next(item for item in bpy.data.objects if item.sluice.role == 'EXIT'), cube], copies=1)
    scene.sluice.specular_threshold = 0.3
    assert restarted(window, [scene], copies=1) and window.sessions[-1]._description["specular_threshold"] == pytest.approx(0.3)
    cube.hide_set(True)
    assert restarted(window, [scene], copies=1) and not window.sessions[-1]._description["instances"]
    cube.hide_set(False)
    assert restarted(window, [scene], copies=1) and window.sessions[-1]._description["instances"]
    scene.world = bpy.data.worlds.new("Other")
    assert restarted(window, [scene], copies=1)
    if scene.world.use_nodes:  # always, from Blender 5 on
        next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND").inputs["Color"].default_value = (0, 1, 0, 1)
    else:
        scene.world.color = (0, 1, 0)
    assert restarted(window, [scene.world], copies=1)


def test_an_undo_compiles_only_what_it_changes(window):
    """Blender lists everything then."""
    exit_, cube, base = next(item for item in bpy.data.objects if item.sluice.role == 'EXIT'), bpy.data.objects["Cube"], window.view.base
    assert not restarted(window, [exit_, cube, cube.data], copies=1) and window.view.base is base
    exit_.location.x += 1
    assert restarted(window, [exit_, cube, cube.data], copies=1) and window.view.base is base is window.sessions[-1].base
    assert window.sessions[-1]._description["edits"][0]["exits"][0]["quad"]["matrix"][0, 3] == exit_.matrix_world[0][3]
    cube.data.vertices[0].co.x += 1
    assert restarted(window, [exit_, cube, cube.data], copies=1) and window.view.base is not base


def test_frames_of_an_exit_that_is_keyframed(window):
    """Playback keeps the things, and where nothing moves the picture."""
    scene, base = bpy.context.scene, window.view.base
    exit_ = next(item for item in bpy.data.objects if item.sluice.role == 'EXIT')
    for frame, place in ((1, 0), (10, 2), (20, 2)):
        exit_.location.x = place
        exit_.keyframe_insert("location", frame=frame)
    for frame, moves in ((5, True), (10, True), (15, False)):
        scene.frame_set(frame)
        assert restarted(window, [scene, exit_, exit_.animation_data.action], copies=0) == moves
        assert window.sessions[-1]._description["edits"][0]["exits"][0]["quad"]["matrix"][0, 3] == exit_.matrix_world[0][3]
    scene.sluice.use_animated_seed = True
    assert restarted(window, [scene], copies=0)
    scene.frame_set(16)
    assert restarted(window, [scene], copies=0) and window.view.base is base


def test_a_new_texture_of_an_exit(window):
    """It is not among what was compiled; the scene need not be copied for it."""
    exit_ = next(item for item in bpy.data.objects if item.sluice.role == 'EXIT')
    exit_.sluice.intensity_texture = bpy.data.images.new("Stripes", 4, 4)
    base = window.view.base
    assert restarted(window, [exit_], copies=0) and window.view.base is not base
    found = window.sessions[-1]._description
    assert found["images"][found["edits"][0]["exits"][0]["intensity_texture"]]["name"] == "Stripes"
    exit_.location.x += 1
    base = window.view.base
    assert restarted(window, [exit_], copies=0) and window.view.base is base


def test_orbiting_keeps_the_scene(window):
    base, known = window.view.base, len(window.sessions)
    window.region_3d.view_matrix = Matrix.Translation((0, 1, -5))
    window.draw()
    assert window.copies == 1 and len(window.sessions) == known + 1 and window.sessions[-1].base is base
    assert window.sessions[-1]._frame["width"] == 20


def test_a_hand_that_does_not_stop_sees_pictures(window, fake_core):
    """Changes come faster than coarse images: each image is seen before the next one starts, and the last one is of the end."""
    exit_ = next(item for item in bpy.data.objects if item.sluice.role == 'EXIT')
    known = len(window.sessions)
    fake_core.seconds_per_photon = 1  # no image before the hand moves on
    for _ in range(10):
        exit_.location.x += 0.1
        window.update(exit_)
        window.draw()
    assert len(window.sessions) == known + 1 and window.view.stale and window.sessions[-1]._state == 'rendering'
    fake_core.seconds_per_photon = 1e-8
    window.view.session.wait(60)
    window.draw()
    assert len(window.sessions) == known + 2 and not window.view.stale and window.view.level == 0
    assert window.sessions[-1]._description["edits"][0]["exits"][0]["quad"]["matrix"][0, 3] == exit_.matrix_world[0][3]


def test_an_error_stands_until_it_is_mended(window):
    entry = next(item for item in bpy.data.objects if item.sluice.role == 'ENTRY')
    picture = window.view.texture
    entry.sluice.expression = "LS+("
    window.update(entry)
    window.draw(), window.draw()
    assert "a parenthesis is open" in window.engine.said[-1] and window.view.texture is picture
    entry.sluice.expression = "LS+"
    assert restarted(window, [entry], copies=1)


def test_its_figures_are_told(window, fake_core, monkeypatch):
    from sluice import edit_statistics
    row = {"name": "Light Edit", "matched": 7, "moved": 7, "capped": 0, "acted": True, "energy_in": 8.0, "energy_out": 4.0, "share": 0.1, "seconds": 0.2}
    monkeypatch.setattr(fake_core.Session, "statistics", lambda session: {"edits": [row], "ledger": {"emitted": 9.0}, "view_paths": 9})
    exit_ = next(item for item in bpy.data.objects if item.sluice.role == 'EXIT')
    exit_.location.x += 1
    assert restarted(window, [exit_], copies=0)
    assert edit_statistics.of("Light Edit").matched == 7 and edit_statistics.of("Light Edit").power_in == 2
    edit_statistics.forget()


@pytest.mark.parametrize("case, asks", [
    ((0, 1, 0.01, 0.5, False), True),  # the first image of a session: at once
    ((1, 2, 0.01, 0.0005, False), True),  # quick redraws: whenever there is news
    ((1, 2, 5, 0.5, False), False),  # slow ones: a twentieth of the time
    ((1, 2, 11, 0.5, False), True),
    ((1, 1, 11, 0.5, False), False),  # no news
    ((0, 0, 0.05, 0.001, False), False),  # before the first image for the status line
    ((0, 0, 0.15, 0.001, False), True),
    ((0, 0, 5, 0.5, False), False),
    ((1, 1, 0.01, 0.5, True), True),
])
def test_when_it_asks_for_a_redraw(monkeypatch, case, asks):
    from sluice import viewport
    shown, passes, since, redraw, finished = case
    asked, view = [], viewport.View()
    view.session = SimpleNamespace(wait=lambda _: finished, progress=lambda: {"pass": passes})
    view.shown_pass, view.drawn, view.redraw = shown, 100.0, redraw
    monkeypatch.setattr(viewport, "time", SimpleNamespace(monotonic=lambda: 100.0 + since))
    again = viewport._look(lambda: SimpleNamespace(tag_redraw=lambda: asked.append(True)), view)
    assert bool(asked) == asks and (again is None) == finished


def test_what_was_retired_is_kept_until_it_is_over(fake_core, monkeypatch):
    """Its last reference would wait for its threads."""
    from sluice import core as door
    over = False
    monkeypatch.setattr(fake_core.Session, "wait", lambda session, seconds: over)
    session = door.new_session()
    door.retire(session)
    door.new_session()
    assert door._ending == [session]
    over = True
    door.new_session()
    assert not door._ending


def test_pictures_of_a_moment_are_as_of_a_scene_copied_anew(room, core, monkeypatch):
    """With the real core: an exit is dragged and the view turns; bit by bit what a view shows that opens now."""
    from sluice import viewport
    monkeypatch.setattr(viewport, "_AT_ONCE", 60)  # on a slow machine the coarse image under way as the view turns would be one more
    window = Window(160, 80, room.camera, monkeypatch.setattr)
    window.update()
    window.draw()
    window.settle()
    bpy.data.objects["Exit"].location.x += 0.2
    window.update(bpy.data.objects["Exit"])
    window.region_3d.view_matrix = window.region_3d.view_matrix @ Matrix.Translation((0.1, 0, 0))
    window.draw()
    window.settle()
    assert window.copies == 1
    fresh = Window(160, 80, room.camera, monkeypatch.setattr)
    fresh.region_3d.view_matrix = window.region_3d.view_matrix
    fresh.update()
    fresh.draw()
    fresh.settle()
    hashes = [[session.film_hash() for session in view.sessions] for view in (window, fresh)]
    assert len(hashes[0]) == 6 and len(hashes[1]) == 3
    assert hashes[0][3:] == hashes[1] and not set(hashes[0][:3]) & set(hashes[1])
    viewport.free(window.view), viewport.free(fresh.view)


def test_a_property_of_the_scene_lists_all_its_objects(window):
    """Blender 5.2: with the scene every object comes as changed in its shading alone. Nothing is copied for that, but for what moves."""
    from types import SimpleNamespace

    from sluice import changes

    def listed(item, **changed):
        flags = {f"is_updated_{what}": changed.get(what, False) for what in ("geometry", "transform", "shading")}
        return SimpleNamespace(id=item, **flags)

    scene, cube, light = bpy.context.scene, bpy.data.objects["Cube"], bpy.data.lights.new("Lamp", 'POINT')
    whole = listed(scene, geometry=True, transform=True, shading=True)
    for updates, kind in (([whole, listed(cube, shading=True)], changes.EDITS),
                          ([listed(scene), listed(cube, shading=True)], changes.THINGS),
                          ([whole, listed(cube, transform=True, shading=True)], changes.THINGS),
                          ([whole, listed(cube, geometry=True)], changes.THINGS),
                          ([whole, listed(cube, shading=True), listed(light, shading=True)], changes.THINGS)):  # fmt: skip
        assert changes.of(SimpleNamespace(updates=updates)) == kind
