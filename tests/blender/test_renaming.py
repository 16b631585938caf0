# SPDX-License-Identifier: GPL-3.0-or-later
"""Names: expressions follow what is renamed, and take names and presets from menus."""
import bpy
import pytest


def _update():
    bpy.context.view_layer.update()


@pytest.fixture
def entry(new_object):
    item = new_object("Entry")
    item.sluice.role = 'ENTRY'
    return item


def _set(item, expression):
    item.sluice.expression = expression
    _update()


def test_objects_lights_collections_worlds_and_edits(new_object, entry, capfd):
    egg, lamp = new_object("Egg", bpy.data.meshes.new("Egg")), new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT'))
    glass, world = bpy.data.collections.new("Glass"), bpy.data.worlds.new("Sky")
    other = new_object("Other")
    other.sluice.role = 'ENTRY'
    bpy.context.scene.collection.children.link(glass)
    layer = bpy.context.view_layer.sluice.layers.add()
    layer.expression = "LS'Egg'E"
    _set(entry, "L'Lamp,Sky'(S'Egg'|X'Glass')F'Other'.*")
    egg.name = "it's"
    _update()
    assert entry.sluice.expression == "L'Lamp,Sky'(S'it\\'s'|X'Glass')F'Other'.*" and layer.expression == "LS'it\\'s'E"
    lamp.name, glass.name, world.name, other.name = "Sun", "Things", "Heaven", "Second"
    _update()
    assert entry.sluice.expression == "L'Sun,Heaven'(S'it\\'s'|X'Things')F'Second'.*"
    assert "sluice: Renamed in 2 expressions" in capfd.readouterr().out


def test_other_names_are_left_alone(new_object, entry):
    egg = new_object("Egg")
    _set(entry, "LS'Egg'D'Nobody'")
    bpy.data.objects.remove(egg)
    _update()
    new_object("Cube").name = "Ball"  # may lie where the egg lay
    _update()
    assert entry.sluice.expression == "LS'Egg'D'Nobody'"


def test_a_name_that_others_bear_too_stays_beside_the_new_one(new_object, entry):
    egg = new_object("Egg")
    bpy.context.scene.collection.children.link(bpy.data.collections.new("Egg"))
    _set(entry, "LS'Egg'")
    egg.name = "Ball"
    _update()
    assert entry.sluice.expression == "LS'Ball,Egg'"


def test_a_name_that_another_thing_is_given(new_object, entry):
    """Blender numbers the one that had it, which nobody renamed, so expressions go on to mean it; where it was renamed by hand and another
    took its name, they mean that."""
    egg, wall = new_object("Egg"), new_object("Wall")
    _set(entry, "LS'Egg'+")
    wall.name = "Egg"
    _update()
    if egg.name == "Egg":  # newer versions number the one that is renamed
        assert entry.sluice.expression == "LS'Egg'+"
        return
    assert entry.sluice.expression == f"LS'{egg.name}'+"
    egg.name = "Ball"
    _update()
    wall.name = "Ball.001"
    _update()
    assert entry.sluice.expression == "LS'Ball'+"
    egg.name, wall.name = "Yolk", "Ball"
    _update()
    assert entry.sluice.expression == "LS'Ball'+"


def test_an_expression_of_before_the_renaming_is_followed(new_object, entry):
    """As undo leaves it: the step that Blender made of the renaming was made before the expression followed."""
    egg = new_object("Egg")
    _set(entry, "LS'Egg'+")
    egg.name = "Ball"
    _update()
    _set(entry, "LS'Egg'+")
    assert entry.sluice.expression == "LS'Ball'+"
    new_object("Egg")
    _set(entry, "LS'Egg'+")  # now it is that one's name
    assert entry.sluice.expression == "LS'Egg'+"


def test_names_from_a_list(new_object, entry):
    new_object("Egg", bpy.data.meshes.new("Egg"))
    new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT'))
    bpy.context.view_layer.objects.active = entry
    entry.sluice.expression = "LS+"
    assert bpy.ops.sluice.insert_name(noun="S:Egg") == {'FINISHED'}
    assert bpy.ops.sluice.insert_name(noun="L:Lamp") == {'FINISHED'}
    assert entry.sluice.expression == "L'Lamp'S'Egg'+"
    with pytest.raises(TypeError):
        bpy.ops.sluice.insert_name(noun="S:Nobody")


def test_kinds_of_light_are_expressions(new_object, entry):
    from sluice import core, light_kinds
    egg = new_object("Egg's", bpy.data.meshes.new("Egg"))
    bpy.context.view_layer.objects.active = entry
    egg.select_set(True)
    for kind in (kind for group in light_kinds.GROUPS for kind in group):
        assert bpy.ops.sluice.set_expression(expression=kind.expression) == {'FINISHED'}
        found = core.load().check_expression(entry.sluice.expression, ["Egg's"])
        assert found["warnings"] == [] and found["side"] == ('view' if kind in light_kinds.SEEN else 'light')
        assert ("{}" in kind.expression) == ("Egg" in entry.sluice.expression)
    egg.select_set(False)
    assert bpy.ops.sluice.set_expression(expression="L.*S{}+", noun="D:Egg's") == {'FINISHED'}
    assert entry.sluice.expression == "L.*S'Egg\\'s'+"


def test_presets_are_kept_and_read_but_never_run(entry, tmp_path, monkeypatch):
    from sluice import presets
    monkeypatch.setattr(bpy.utils, "user_resource", lambda *_args, path="", **_more: str(_made(tmp_path / path)))
    bpy.context.view_layer.objects.active = entry
    entry.sluice.expression = "L.*S'it\\'s \"quoted\"'+"
    assert bpy.ops.sluice.save_expression(name="My glass") == {'FINISHED'}
    path, = (tmp_path / "presets" / "sluice" / "expression").iterdir()
    entry.sluice.expression = "L"
    assert bpy.ops.sluice.load_expression(filepath=str(path)) == {'FINISHED'}
    assert entry.sluice.expression == "L.*S'it\\'s \"quoted\"'+"
    for text in ("edit.expression = print('ran')", "not python(", "edit.expression = 3", "\0"):
        path.write_text(text)
        assert presets.read_preset(path) is None
    assert bpy.ops.sluice.load_expression(filepath=str(path)) == {'CANCELLED'}


def _made(path):
    path.mkdir(parents=True, exist_ok=True)
    return path


def test_one_that_takes_the_place_and_the_name_is_meant(new_object, entry):
    """As importers do: the old one goes, a new one comes under its name, others beside it, all in one step."""
    old = new_object("Egg", bpy.data.meshes.new("Egg"))
    _set(entry, "LS'Egg'")
    bpy.data.objects.remove(old)
    for name in ("Other", "Egg", "Third"):  # one of them may lie where the old one lay
        new_object(name, bpy.data.meshes.new(name))
    _update()
    assert entry.sluice.expression == "LS'Egg'"


def test_only_what_may_matter_walks_through_the_file(new_object, entry, monkeypatch):
    """Files of 10,000 objects: what comes under other names costs a look at names alone, and all is as after a walk."""
    from sluice import renaming
    walks, file = [], renaming._File
    monkeypatch.setattr(renaming, "_File", lambda: walks.append(None) or file())

    def walked():
        _update()
        found = bool(walks)
        walks.clear()
        return found

    egg = new_object("Egg")
    _set(entry, "LS'Egg'D'Nobody'")
    walks.clear()
    others = [new_object(name) for name in ("Cube", "Ball", "Sky")]
    bpy.data.collections.new("Glass")
    bpy.data.worlds.new("Sky")
    assert not walked()
    others[0].name = "Renamed"
    new_object("Cone")
    assert not walked()
    assert set(file().items) == renaming._known
    for name in ("Egg.001", "Nobody", "Entry.001"):
        new_object(name)
        assert walked()
    other = new_object("Other")
    other.sluice.role = 'ENTRY'
    assert walked()
    bpy.data.objects.remove(others[1])
    assert walked()
    bpy.data.objects.remove(others[2])
    new_object("First"), new_object("Second")  # one of them may lie where that one lay
    walked()
    assert set(file().items) == renaming._known
    egg.name = "Ei"
    assert walked() and entry.sluice.expression.startswith("LS'Ei'")
