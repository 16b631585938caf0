# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps, cameras, edits, images, settings and names as the core is told of them."""
import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector


def test_lamps(new_object, export_now):
    for kind in ('POINT', 'SPOT', 'SUN', 'AREA'):
        lamp = bpy.data.lights.new(kind.title(), kind)
        lamp.energy, lamp.color = 12.5, (1, 0.5, 0.25)
        new_object(kind.title(), lamp, Matrix.Translation((1, 2, 3)))
    area = bpy.data.lights["Area"]
    area.shape, area.size, area.size_y, area.spread = 'RECTANGLE', 2, 3, 1
    bpy.data.lights["Spot"].spot_size, bpy.data.lights["Spot"].spot_blend = 1.25, 0.5
    bpy.data.lights["Sun"].angle = 0.125
    found = {item["kind"]: item for item in export_now()[0]["lights"]}
    assert set(found) == {'Point', 'Spot', 'Sun', 'Area'}
    for kind, item in found.items():
        power = 12.5 * (4 / math.pi if kind == 'Area' and hasattr(area, "shadow_filter_radius") else 1)  # Cycles' from 4.2 on
        assert item["names"] == [kind] and item["power"] == pytest.approx(power, rel=1e-12) and item["color"] == (1, 0.5, 0.25)
        np.testing.assert_array_equal(item["matrix"][:3, 3], (1, 2, 3))
    assert (found['Area']["shape"], found['Area']["size_x"], found['Area']["size_y"], found['Area']["spread"]) == ('Rectangle', 2, 3, 1)
    assert (found['Spot']["spot_angle"], found['Spot']["spot_blend"], found['Sun']["angle"]) == (1.25, 0.5, 0.125)
    assert found['Spot']["spot_cosine"] != hasattr(area, "shadow_filter_radius")


def test_a_lamps_nodes(new_object, export_now):
    lamp = bpy.data.lights.new("Lamp", 'POINT')
    lamp.use_nodes = True
    emission = next(node for node in lamp.node_tree.nodes if node.bl_idname == 'ShaderNodeEmission')
    emission.inputs["Strength"].default_value = 3
    new_object("Lamp", lamp)
    description, warnings = export_now()
    assert description["lights"][0]["power"] == pytest.approx(3 * lamp.energy) and not warnings
    noise = lamp.node_tree.nodes.new('ShaderNodeTexNoise')
    lamp.node_tree.links.new(noise.outputs[0], emission.inputs["Strength"])
    assert export_now()[1][0][0] == "Lamp"


def test_cameras():
    from sluice.export.camera import export_camera
    lens = bpy.data.cameras.new("Camera")
    item = bpy.data.objects.new("Camera", lens)
    target = bpy.data.objects.new("Target", None)
    target.location = (4, 3, -7)
    lens.lens, lens.shift_x, lens.sensor_fit = 35, 0.25, 'VERTICAL'
    lens.dof.use_dof, lens.dof.aperture_fstop, lens.dof.focus_object = True, 2.0, target
    warnings = []
    scaled = Matrix.Translation((1, 2, 3)) @ Matrix.Diagonal((2, 2, 2, 1))
    bpy.context.scene.collection.objects.link(target)
    bpy.context.view_layer.update()
    found = export_camera(item, scaled, lambda *warning: warnings.append(warning))
    np.testing.assert_allclose(found["matrix"][:3, :3], np.eye(3))
    assert found["aperture_radius"] == pytest.approx(0.035 / 4) and found["focus_distance"] == pytest.approx(10)
    assert (found["kind"], found["sensor_fit"], found["shift_x"]) == ('Perspective', 'Vertical', 0.25)
    lens.type = 'ORTHO'
    assert export_camera(item, scaled, None)["aperture_radius"] == pytest.approx(1 / 4)
    lens.type = 'PANO'
    assert export_camera(item, scaled, lambda *warning: warnings.append(warning))["kind"] == 'Perspective' and len(warnings) == 1


def _project(camera, frame, point):
    """Pixel of a point by the exported camera: Blender's lens, sensor fit horizontal."""
    local = np.linalg.inv(camera["matrix"]) @ (*point, 1)
    scale = camera["lens"] / camera["sensor_width"] / -local[2] if camera["kind"] == 'Perspective' else 1 / camera["ortho_scale"]
    x = local[0] * scale - camera["shift_x"] + 0.5
    y = local[1] * scale - camera["shift_y"] + 0.5 * frame["height"] / frame["width"]
    return x * frame["width"], y * frame["width"]


@pytest.mark.parametrize("perspective", [True, False])
def test_views_project_as_blender_does(perspective):
    """The camera made from a view's matrices sends points to the pixels that the matrices themselves send them to."""
    from sluice.export.camera import export_view
    view = Matrix.Rotation(0.3, 4, 'X') @ Matrix.Rotation(0.7, 4, 'Z') @ Matrix.Translation((0.5, -1, -9))
    near, far, left, right, bottom, top = 0.1, 100, -0.03, 0.05, -0.02, 0.04
    width, height = 800, 600
    if perspective:
        window = Matrix(((2 * near / (right - left), 0, (right + left) / (right - left), 0),
                         (0, 2 * near / (top - bottom), (top + bottom) / (top - bottom), 0),
                         (0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)), (0, 0, -1, 0)))
    else:
        left, right, bottom, top, near = -4, 4.8, -2.6, 4, -50
        window = Matrix(((2 / (right - left), 0, 0, -(right + left) / (right - left)),
                         (0, 2 / (top - bottom), 0, -(top + bottom) / (top - bottom)),
                         (0, 0, -2 / (far - near), -(far + near) / (far - near)), (0, 0, 0, 1)))
    camera, frame = export_view(view, window, perspective, (width, height))
    for point in ((0, 0, 0), (1, 2, -3), (-1, 0.5, 2)):
        clip = window @ view @ Vector((*point, 1))
        expected = [(clip[axis] / clip[3] + 1) / 2 * size for axis, size in ((0, width), (1, height))]
        np.testing.assert_allclose(_project(camera, frame, point), expected, rtol=1e-4)
        depth = -(np.linalg.inv(camera["matrix"]) @ (*point, 1))[2]
        assert camera["clip_start"] < depth < camera["clip_end"]
    assert camera["clip_start"] == pytest.approx(near if perspective else 0, rel=1e-4)


def test_frame_and_border():
    from sluice.export.camera import export_frame
    render = bpy.context.scene.render
    render.use_border, render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = True, 0.25, 0.75, 0.1, 0.5
    render.filter_size = 2
    found = export_frame(64, 48, render)
    assert [found[name] for name in ("x0", "x1", "y0", "y1")] == [16, 48, 4, 24] and found["filter_width"] == 2


def _edit(new_object, name, role, **properties):
    item = new_object(name)
    item.sluice.role = role
    for key, value in properties.items():
        setattr(item.sluice, key, value)
    return item


def test_edits(new_object, export_now):
    entry = _edit(new_object, "Entry", 'ENTRY', expression="LS+D", amount=0.5, feather=0.25, repeat=True, offset=0.01)
    entry.empty_display_size = 2
    entry.matrix_world = Matrix.Translation((1, 2, 3))
    _edit(new_object, "B", 'EXIT', entry=entry, intensity=2, hue_shift=math.pi / 3, tint=(1, 0.5, 0.25), keep_brightness=False)
    _edit(new_object, "A", 'EXIT', entry=entry)
    description, warnings = export_now()
    edit, = description["edits"]
    assert not warnings
    assert (edit["expression"], edit["amount"], edit["feather"], edit["repeat"], edit["enabled"]) == ("LS+D", 0.5, 0.25, True, True)
    quad = edit["entry"]
    assert (quad["name"], quad["half_size"], quad["offset"]) == ("Entry", 2, pytest.approx(0.01))
    np.testing.assert_array_equal(quad["matrix"][:3, 3], (1, 2, 3))
    assert [item["quad"]["name"] for item in edit["exits"]] == ["B", "A"]  # by order
    assert edit["exits"][0]["hue_shift"] == pytest.approx(math.pi / 3) and not edit["exits"][0]["keep_brightness"]
    assert [item["tint"] for item in edit["exits"]] == [(1, 0.5, 0.25), (1, 1, 1)]
    assert [edit["entry"]["order"], *(item["quad"]["order"] for item in edit["exits"])] == [1, 2, 3]


def test_copies_share_an_order_and_come_by_name(new_object, export_now):
    """The core lets the first of equals act first (cpp/edit/state_table.cpp, edits.cpp)."""
    entry = _edit(new_object, "Entry", 'ENTRY')
    for _number in range(3):
        bpy.context.scene.collection.objects.link(entry.copy())
    found = [(edit["entry"]["order"], edit["entry"]["name"]) for edit in export_now()[0]["edits"]]
    assert found == [(1, "Entry"), (1, "Entry.001"), (1, "Entry.002"), (1, "Entry.003")]


def test_loose_ends_are_warned_of(new_object, export_now):
    _edit(new_object, "Alone", 'ENTRY')  # the core warns of it
    _edit(new_object, "Lost", 'EXIT')
    _edit(new_object, "Wrong", 'EXIT', entry=new_object("Plain"))
    hidden = _edit(new_object, "Hidden", 'ENTRY')
    hidden.hide_viewport = True
    _edit(new_object, "Far", 'EXIT', entry=hidden)
    description, warnings = export_now()
    assert [edit["entry"]["name"] for edit in description["edits"]] == ["Alone"]
    assert {item for item, _message in warnings} == {"Lost", "Wrong", "Far"} and len(warnings) == 3


def test_excluded_collections_take_their_edits_along(new_object, export_now):
    collection = bpy.data.collections.new("Edits")
    bpy.context.scene.collection.children.link(collection)
    item = new_object("Entry", collection=collection)
    item.sluice.role = 'ENTRY'
    assert len(export_now()[0]["edits"]) == 1
    bpy.context.view_layer.layer_collection.children["Edits"].exclude = True
    assert not export_now()[0]["edits"]


def test_edits_bear_their_collections_names(new_object, export_now):
    inner, outer = bpy.data.collections.new("Inner"), bpy.data.collections.new("Outer")
    outer.children.link(inner)
    bpy.context.scene.collection.children.link(outer)
    new_object("Entry", collection=inner).sluice.role = 'ENTRY'
    assert export_now()[0]["edits"][0]["collections"] == ["Inner", "Outer"]


def test_exit_textures(new_object, export_now):
    image = bpy.data.images.new("Map", 3, 2)
    pixels = np.arange(24, dtype=np.float32) / 255
    image.pixels.foreach_set(pixels)
    entry = _edit(new_object, "Entry", 'ENTRY')
    _edit(new_object, "Exit", 'EXIT', entry=entry, intensity_texture=image, normal_map=image)
    description = export_now()[0]
    exit_ = description["edits"][0]["exits"][0]
    images = description["images"]
    assert exit_["hue_shift_texture"] == -1
    assert [images[exit_[name]]["color_space"] for name in ("intensity_texture", "normal_map")] == ['SRGB', 'NonColor']
    found = images[exit_["intensity_texture"]]
    assert found["rgba"].shape == (2, 3, 4) and (found["width"], found["height"]) == (3, 2)
    np.testing.assert_allclose(found["rgba"].ravel(), pixels, atol=1e-6)


def test_missing_and_oversized_images_get_a_placeholder(new_object, export_now, monkeypatch):
    from sluice.export import image as image_export
    monkeypatch.setattr(image_export, "MAX_SIDE", 16)
    lost = bpy.data.images.new("Lost", 4, 4)
    lost.source, lost.filepath = 'FILE', "//nowhere.png"
    huge = bpy.data.images.new("Huge", 17, 1)
    entry = _edit(new_object, "Entry", 'ENTRY')
    _edit(new_object, "Exit", 'EXIT', entry=entry, intensity_texture=lost, hue_shift_texture=huge)
    description, warnings = export_now()
    assert {item for item, _message in warnings} == {"Lost", "Huge"}
    assert all(image["rgba"].size == 0 for image in description["images"])


def test_settings():
    from sluice.export.settings import NAMES, export_settings, for_preview
    scene = bpy.context.scene
    scene.sluice.passes, scene.sluice.time_limit, scene.frame_current = 7, 2.5, 12
    scene.render.threads_mode, scene.render.threads = 'FIXED', 3
    found = export_settings(scene)
    assert set(NAMES) <= set(found) and (found["passes"], found["time_limit"], found["frame"], found["threads"]) == (7, 2.5, 12, 3)
    small = for_preview({**found, "passes": 1000})
    assert small["passes"] == 8 and small["pilot_paths"] <= small["photons"]


class _Collection:
    def __init__(self, name, objects=(), children=()):
        self.name, self.name_full, self.library = name, name, None
        self.objects, self.children = objects, children


class _Object:
    def __init__(self, name):
        self.name, self.name_full, self.library = name, name, None


def test_names_without_blender():
    from sluice.export.names import Names
    egg, floor, maker = _Object("Egg"), _Object("Floor"), _Object("Maker")
    glass = _Collection("Glass", [egg])
    table = _Collection("Table", [egg, floor], [glass])
    house = _Collection("House", [], [table, glass])
    names = Names([glass, table, house])
    assert names.of(egg) == ["Egg", "Glass", "Table", "House"]
    assert names.of(floor) == ["Floor", "Table", "House"]
    assert names.of(maker) == ["Maker"] and names.of_instance(egg, maker)[-1] == "Maker"


def test_two_of_one_name_are_told_apart(tmp_path, new_object, cube_mesh, export_now):
    """As Blender tells them: by the library. Alone, the linked one answers to its plain name too."""
    new_object("Egg", cube_mesh())
    path = str(tmp_path / "shelf.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_there, here):
        here.objects = ["Egg"]
    bpy.context.scene.collection.objects.link(bpy.data.objects["Egg"])
    assert _names_of_eggs(export_now()) == [["Egg", "Egg [shelf.blend]"]]
    new_object("Egg", cube_mesh())
    assert _names_of_eggs(export_now()) == [["Egg"], ["Egg [shelf.blend]"]]
    from sluice import names, presets
    labels = [item[0] for item in presets._nouns(None, bpy.context)]
    assert "S:Egg" in labels and "S:Egg [shelf.blend]" in labels
    assert names.names_in("S" + names.quoted(["Egg [shelf.blend]"])) == {"Egg [shelf.blend]"}


def _names_of_eggs(exported):
    description, _warnings = exported
    return sorted(instance["names"] for instance in description["instances"])


def test_a_cancel_stops_the_copy(new_object, cube_mesh):
    from sluice import export
    from sluice.export.names import Names
    new_object("Cube", cube_mesh())
    context = export.Context(Names(), cancelled=lambda: True)
    with pytest.raises(export.Cancelled):
        export.export_scene(bpy.context.evaluated_depsgraph_get(), {}, {}, context)
