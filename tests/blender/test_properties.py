# SPDX-License-Identifier: GPL-3.0-or-later
"""The public names (design §8), and that an edit is its Empty: keyframes, copies, overrides, deletion."""
import bpy
import pytest

NAMES = {
    "scene": {"passes": 'INT', "photons": 'INT', "seed": 'INT', "use_animated_seed": 'BOOLEAN', "use_adaptive_sampling": 'BOOLEAN', "use_preview_denoise": 'BOOLEAN', "max_depth": 'INT', "max_gates": 'INT',
              "specular_threshold": 'FLOAT', "time_limit": 'FLOAT', "error_target": 'FLOAT', "use_direct": 'BOOLEAN',
              "use_caustics": 'BOOLEAN', "use_edited": 'BOOLEAN', "use_indirect": 'BOOLEAN', "use_edits": 'BOOLEAN',
              "solo": 'POINTER'},
    "object": {"role": 'ENUM', "order": 'INT', "offset": 'FLOAT', "expression": 'STRING', "enabled": 'BOOLEAN', "repeat": 'BOOLEAN',
               "amount": 'FLOAT', "feather": 'FLOAT', "entry": 'POINTER', "intensity": 'FLOAT', "hue_shift": 'FLOAT', "tint": 'FLOAT',
               "keep_brightness": 'BOOLEAN', "intensity_texture": 'POINTER', "hue_shift_texture": 'POINTER', "normal_map": 'POINTER'},
    "view_layer": {"layers": 'COLLECTION', "active_layer": 'INT', "use_denoise": 'BOOLEAN',
                   **{f"use_pass_{name}": 'BOOLEAN' for name in ("albedo", "direct", "caustics", "edited", "indirect", "emission", "noise", "bias")}},
}


def _groups(new_object):
    return {"scene": bpy.context.scene.sluice, "object": new_object("Empty").sluice, "view_layer": bpy.context.view_layer.sluice}


def _own(group):
    return [item for item in group.bl_rna.properties if item.identifier not in {"rna_type", "name"}]


def test_names_and_types(new_object):
    for owner, group in _groups(new_object).items():
        assert {item.identifier: item.type for item in _own(group)} == NAMES[owner]


def test_every_property_explains_itself(new_object):
    bpy.context.view_layer.sluice.layers.add()
    for group in (*_groups(new_object).values(), bpy.context.view_layer.sluice.layers[0]):
        for item in _own(group):
            assert len(item.description) > 8 and not item.description.endswith("."), item.identifier
            if item.type in {'INT', 'FLOAT'} and item.identifier not in {"seed", "order"}:
                assert item.soft_max < 1e8, f"{item.identifier} has no soft limit"
            if item.type != 'COLLECTION':
                assert item.is_overridable, item.identifier


def test_units(new_object):
    groups = _groups(new_object)
    units = {"hue_shift": 'ROTATION', "offset": 'LENGTH'}
    for name, unit in units.items():
        assert groups["object"].bl_rna.properties[name].unit == unit
    assert groups["scene"].bl_rna.properties["time_limit"].unit.startswith('TIME')
    assert groups["scene"].bl_rna.properties["error_target"].subtype == 'PERCENTAGE'


def test_defaults(new_object):
    scene, item = bpy.context.scene.sluice, new_object("Empty").sluice
    assert (scene.max_depth, scene.max_gates, scene.time_limit, scene.error_target) == (12, 8, 0, 0)
    assert scene.specular_threshold == pytest.approx(0.1)
    assert (item.role, item.amount, item.feather, item.offset, item.enabled, item.repeat) == ('NONE', 1, 0, 0, True, False)
    assert (item.intensity, item.hue_shift, tuple(item.tint), item.keep_brightness, item.entry) == (1, 0, (1, 1, 1), True, None)
    item.tint = (-1, 0.5, 2)  # of a colour brighter than white only the colour counts
    assert tuple(item.tint) == (0, 0.5, 2) and item.bl_rna.properties["tint"].subtype == 'COLOR'


def test_order_is_given_at_creation_and_unique(new_object):
    items = [new_object(f"Empty{number}") for number in range(5)]
    for item in items:
        item.sluice.role = 'ENTRY'
    assert [item.sluice.order for item in items] == [1, 2, 3, 4, 5]
    items[0].sluice.role = 'EXIT'  # keeps its place
    assert items[0].sluice.order == 1
    copy = items[2].copy()
    copy.sluice.role = 'EXIT'
    assert copy.sluice.order == 6


def test_only_entries_can_be_chosen(new_object):
    from sluice.properties import _is_entry
    entry, other = new_object("Entry"), new_object("Other")
    entry.sluice.role = 'ENTRY'
    assert _is_entry(None, entry) and not _is_entry(None, other)


def test_deleting_the_entry_clears_the_exit(new_object):
    entry, exit_ = new_object("Entry"), new_object("Exit")
    entry.sluice.role, exit_.sluice.role = 'ENTRY', 'EXIT'
    exit_.sluice.entry = entry
    bpy.data.objects.remove(entry)
    assert exit_.sluice.entry is None


def test_keyframes_reach_the_export_at_subframes(new_object, export_now):
    entry, exit_ = new_object("Entry"), new_object("Exit")
    entry.sluice.role, exit_.sluice.role = 'ENTRY', 'EXIT'
    exit_.sluice.entry = entry
    for frame, value in ((1, 0.0), (11, 1.0)):
        entry.sluice.amount, exit_.sluice.intensity, exit_.sluice.hue_shift = value, 2 * value, 3 * value
        exit_.sluice.tint = (1, 1 - value, 0.5)
        entry.keyframe_insert("sluice.amount", frame=frame)
        exit_.keyframe_insert("sluice.intensity", frame=frame)
        exit_.keyframe_insert("sluice.hue_shift", frame=frame)
        exit_.keyframe_insert("sluice.tint", frame=frame)
    entry.sluice.enabled = False
    entry.keyframe_insert("sluice.enabled", frame=20)
    bpy.context.scene.frame_set(6, subframe=0.0)
    edit, = export_now()[0]["edits"]
    assert edit["amount"] == pytest.approx(0.5, abs=1e-6)
    assert edit["exits"][0]["intensity"] == pytest.approx(1, abs=1e-6)
    bpy.context.scene.frame_set(8, subframe=0.5)
    between = export_now()[0]["edits"][0]
    assert 0.75 < between["amount"] < 0.95  # eased
    assert between["exits"][0]["hue_shift"] == pytest.approx(3 * between["amount"], rel=1e-5)
    assert between["exits"][0]["tint"] == pytest.approx((1, 1 - between["amount"], 0.5), abs=1e-5)


def test_quads_follow_parents_and_drivers(new_object, export_now):
    """The parent moves by keyframes; the exit's own height and intensity follow the parent's place."""
    entry, exit_, carrier = new_object("Entry"), new_object("Exit"), new_object("Carrier")
    entry.sluice.role, exit_.sluice.role = 'ENTRY', 'EXIT'
    exit_.sluice.entry, exit_.parent, entry.parent = entry, carrier, carrier
    for frame, x in ((1, 0.0), (11, 4.0)):
        carrier.location.x = x
        carrier.keyframe_insert("location", index=0, frame=frame)
    for curve in (exit_.driver_add("location", 2), exit_.driver_add("sluice.intensity")):
        curve.driver.type = 'SUM'
        variable = curve.driver.variables.new()
        variable.type = 'TRANSFORMS'
        variable.targets[0].id, variable.targets[0].transform_type = carrier, 'LOC_X'
    for frame, x in ((1, 0.0), (6, 2.0), (11, 4.0)):
        bpy.context.scene.frame_set(frame)
        edit, = export_now()[0]["edits"]
        out, = edit["exits"]
        assert tuple(edit["entry"]["matrix"][:3, 3]) == pytest.approx((x, 0, 0), abs=1e-5)
        assert tuple(out["quad"]["matrix"][:3, 3]) == pytest.approx((x, 0, x), abs=1e-5)
        assert out["intensity"] == pytest.approx(x, abs=1e-5)


def test_an_exit_that_grows_from_nothing(new_object, export_now):
    """By its own scale and by its parent's: numbers throughout, so that the core sees no area and not no place."""
    entry, parent, exits = new_object("Entry"), new_object("Parent"), [new_object(name) for name in ("One", "Two")]
    entry.sluice.role = 'ENTRY'
    for item in exits:
        item.sluice.role, item.sluice.entry = 'EXIT', entry
    exits[1].parent = parent
    for frame, size in ((1, 0.0), (11, 1.0)):
        for item in (exits[0], parent):
            item.location, item.scale = (1, 2, 3), (size,) * 3
            item.keyframe_insert("location", frame=frame)
            item.keyframe_insert("scale", frame=frame)
    for frame, size in ((1, 0), (11, 1)):
        bpy.context.scene.frame_set(frame)
        edit, = export_now()[0]["edits"]
        for out in edit["exits"]:
            assert out["quad"]["matrix"][:3, :3].tolist() == [[size, 0, 0], [0, size, 0], [0, 0, size]]
            assert out["quad"]["matrix"][:3, 3].tolist() == [1, 2, 3]


def test_scene_settings_can_be_animated(export_now):
    from sluice.export.settings import export_settings
    scene = bpy.context.scene
    for frame, value in ((1, 10), (11, 110)):
        scene.sluice.passes = value
        scene.keyframe_insert("sluice.passes", frame=frame)
    scene.frame_set(11)
    assert export_settings(bpy.context.evaluated_depsgraph_get().scene_eval)["passes"] == 110


def test_library_override(tmp_path, new_object):
    """A linked edit, overridden: its numbers can be changed, and the overridden exit names the overridden entry."""
    collection = bpy.data.collections.new("Edits")
    bpy.context.scene.collection.children.link(collection)
    entry, exit_ = new_object("Entry", collection=collection), new_object("Exit", collection=collection)
    entry.sluice.role, exit_.sluice.role = 'ENTRY', 'EXIT'
    exit_.sluice.entry = entry
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_there, here):
        here.collections = ["Edits"]
    linked = bpy.data.collections["Edits"]
    scene = bpy.context.scene
    scene.collection.children.link(linked)
    local = linked.override_hierarchy_create(scene, bpy.context.view_layer)
    entry, exit_ = local.objects["Entry"], local.objects["Exit"]
    assert exit_.override_library and exit_.sluice.entry == entry
    exit_.sluice.intensity, entry.sluice.expression = 3, "L.*D"
    assert (exit_.sluice.intensity, entry.sluice.expression) == (3, "L.*D")
    assert any(item.rna_path == "sluice.intensity" for item in _operations(exit_))


def _operations(item):
    bpy.context.view_layer.update()
    item.override_library.operations_update() if hasattr(item.override_library, "operations_update") else None
    return item.override_library.properties
