# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits stay alive when they are copied, appended, overridden, made local: their expressions name what was copied along with them.

The right names are those of the objects at the places where the copies lie, or what Blender's own pointers say."""
import bpy
import pytest


def _update():
    """Blender's own update, and the look that Sluice takes by a timer where there is a window."""
    from sluice import renaming
    bpy.context.view_layer.update()
    renaming.follow()


@pytest.fixture
def make_shelf(new_object, cube_mesh):
    """make_shelf(): a collection Shelf with an egg, a second egg, a lamp, an entry that names them all, and its exit; a world, a layer."""
    def make(is_told=True):
        scene = bpy.context.scene
        scene.world = bpy.data.worlds.new("Sky")
        shelf = bpy.data.collections.new("Shelf")
        scene.collection.children.link(shelf)
        for number, name in enumerate(("Egg", "Egg.001")):
            new_object(name, cube_mesh(), collection=shelf).location.x = 3 * number + 1
        new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT'), collection=shelf).location.z = 5
        entry, out = new_object("Entry", collection=shelf), new_object("Exit", collection=shelf)
        entry.sluice.role, out.sluice.role, out.sluice.entry = 'ENTRY', 'EXIT', entry
        entry.sluice.expression = "L'Lamp,Sky'(!F'Entry')*S'Egg'S'Egg.001'X'Shelf'"
        bpy.context.view_layer.sluice.layers.add().expression = "L'Sky'.*F'Entry'.*S'Egg'E"
        if is_told:
            _update()
        return shelf

    return make


def _at(scene, x):
    """The mesh that lies at a place."""
    item, = (item for item in scene.objects if item.type == 'MESH' and abs(item.location.x - x) < 1e-6)
    return item


def _one(scene, kind, role=None):
    item, = (item for item in scene.objects if item.type == kind and role in {None, item.sluice.role})
    return item


def _check(scene, world, collection):
    """What the scene's edit and layer say is what lies in the scene."""
    entry, out, lamp = _one(scene, 'EMPTY', 'ENTRY'), _one(scene, 'EMPTY', 'EXIT'), _one(scene, 'LIGHT')
    eggs = _at(scene, 1).name, _at(scene, 4).name
    assert out.sluice.entry == entry
    assert entry.sluice.expression == f"L'{lamp.name},{world}'(!F'{entry.name}')*S'{eggs[0]}'S'{eggs[1]}'X'{collection}'"
    for layer in scene.view_layers:
        assert [item.expression for item in layer.sluice.layers] in ([], [f"L'{world}'.*F'{entry.name}'.*S'{eggs[0]}'E"])


@pytest.mark.parametrize("is_told", (True, False))
def test_full_copy_of_a_scene(make_shelf, is_told, capfd):
    make_shelf(is_told)
    first = bpy.context.scene
    first.sluice.solo = bpy.data.objects["Entry"]
    bpy.ops.scene.new(type='FULL_COPY')
    second = bpy.context.scene
    _update()
    assert second.sluice.solo == _one(second, 'EMPTY', 'ENTRY')
    assert second != first and _at(second, 1).name not in {"Egg", "Egg.001"}
    _check(first, "Sky", "Shelf")
    _check(second, second.world.name, second.collection.children[0].name)
    assert second.view_layers[0].sluice.layers[0].expression != first.view_layers[0].sluice.layers[0].expression
    bpy.ops.scene.new(type='FULL_COPY')
    _update()
    _check(bpy.context.scene, bpy.context.scene.world.name, bpy.context.scene.collection.children[0].name)
    assert "is now" in capfd.readouterr().out


def test_a_script_that_saves_what_it_copied(make_shelf, tmp_path):
    make_shelf()
    bpy.ops.scene.new(type='FULL_COPY')
    second = bpy.context.scene.name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "two.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "two.blend"))
    scene = bpy.data.scenes[second]
    _check(scene, scene.world.name, scene.collection.children[0].name)


def test_a_linked_copy_names_what_it_did(make_shelf):
    make_shelf()
    bpy.ops.scene.new(type='LINK_COPY')
    _update()
    _check(bpy.context.scene, "Sky", "Shelf")


@pytest.mark.parametrize("is_shared", (True, False))
def test_make_single_user(make_shelf, is_shared):
    """A collection that scenes share stays shared, with the new objects in it; objects of the scenes' own part."""
    shelf = make_shelf()
    first = bpy.context.scene
    for item in list(shelf.objects) if not is_shared else ():
        first.collection.objects.link(item)
        shelf.objects.unlink(item)
    bpy.ops.scene.new(type='LINK_COPY')
    second = bpy.context.scene
    _update()
    bpy.ops.object.make_single_user(type='ALL', object=True, obdata=True)
    _update()
    assert is_shared == (_at(second, 1) == _at(first, 1)) and _at(second, 1).name not in {"Egg", "Egg.001"}
    _check(first, "Sky", "Shelf")
    _check(second, "Sky", "Shelf")


def test_what_is_duplicated_together_belongs_together(make_shelf):
    """As the pointer of the exit says."""
    make_shelf()
    for item in bpy.context.scene.objects:
        item.select_set(item.name in {"Entry", "Exit", "Egg"})
    bpy.ops.object.duplicate()
    _update()
    entry, egg = (item.name for item in sorted(bpy.context.selected_objects, key=lambda item: item.type) if item.sluice.role != 'EXIT')
    assert bpy.data.objects[entry].sluice.expression == f"L'Lamp,Sky'(!F'{entry}')*S'{egg}'S'Egg.001'X'Shelf'"
    assert bpy.data.objects["Entry"].sluice.expression == "L'Lamp,Sky'(!F'Entry')*S'Egg'S'Egg.001'X'Shelf'"


def test_what_comes_into_the_scene_takes_nobodys_place(new_object, cube_mesh):
    """The egg that the edit names is in the scene as an instance alone; another egg comes."""
    shelf, maker, entry = bpy.data.collections.new("Shelf"), new_object("Maker"), new_object("Entry")
    new_object("Egg", cube_mesh(), collection=shelf)
    maker.instance_type, maker.instance_collection = 'COLLECTION', shelf
    entry.sluice.role, entry.sluice.expression = 'ENTRY', "LS'Egg'+"
    _update()
    new_object("Egg", cube_mesh())
    _update()
    assert entry.sluice.expression == "LS'Egg'+"


def test_an_edit_duplicated_alone_names_what_it_did(make_shelf):
    make_shelf()
    for item in bpy.context.scene.objects:
        item.select_set(item.name == "Exit")
    bpy.ops.object.duplicate()
    _update()
    assert bpy.data.objects["Entry"].sluice.expression == "L'Lamp,Sky'(!F'Entry')*S'Egg'S'Egg.001'X'Shelf'"


@pytest.fixture
def shelf_file(make_shelf, tmp_path):
    """A library with the shelf; the open file is empty but for an egg and a lamp of its own."""
    make_shelf()
    path = tmp_path / "shelf.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True)
    return path


def _stranger(new_object, cube_mesh):
    item = new_object("Egg", cube_mesh())
    item.location.x = -7
    _update()
    return item


def _entry():
    return next(item for item in bpy.context.scene.objects if item.sluice.role == 'ENTRY')


@pytest.mark.parametrize("has_egg", (False, True))
def test_append(shelf_file, new_object, cube_mesh, has_egg):
    if has_egg:
        _stranger(new_object, cube_mesh)
        bpy.data.collections.new("Shelf").use_fake_user = True
    bpy.ops.wm.append(directory=f"{shelf_file}/Collection/", filename="Shelf")
    _update()
    entry, scene = _entry(), bpy.context.scene
    collection, = (item.name for item in entry.users_collection)
    assert has_egg == (_at(scene, 1).name != "Egg") == (collection != "Shelf")
    assert f"(!F'Entry')*S'{_at(scene, 1).name}'" in entry.sluice.expression and entry.sluice.expression.endswith(f"X'{collection}'")


def _link(path):
    with bpy.data.libraries.load(str(path), link=True) as (_there, here):
        here.collections = ["Shelf"]
    bpy.context.scene.collection.children.link(here.collections[0])
    _update()
    return here.collections[0]


def _link_objects(path):
    with bpy.data.libraries.load(str(path), link=True) as (_there, here):
        here.objects = ["Entry", "Exit", "Egg", "Egg.001", "Lamp"]
    for item in here.objects:
        bpy.context.scene.collection.objects.link(item)
    _update()
    return here.objects[0]


@pytest.mark.parametrize("has_egg", (False, True))
def test_override(shelf_file, new_object, cube_mesh, has_egg):
    if has_egg:
        _stranger(new_object, cube_mesh)
    linked = _link(shelf_file)
    linked.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)
    bpy.context.scene.collection.children.unlink(linked)
    _update()
    entry, scene = _entry(), bpy.context.scene
    egg = _at(scene, 1)
    assert entry.override_library is not None and has_egg == (egg.name != "Egg")
    assert f"(!F'{entry.name}')*S'{egg.name}'" in entry.sluice.expression


def test_an_override_of_the_edit_alone_means_the_linked_egg(shelf_file, new_object, cube_mesh):
    _stranger(new_object, cube_mesh)
    entry = _link_objects(shelf_file).override_create(remap_local_usages=True)
    _update()
    assert entry.library is None and "S'Egg [shelf.blend]'" in entry.sluice.expression


@pytest.mark.parametrize("has_egg", (False, True))
def test_make_the_edit_local(shelf_file, new_object, cube_mesh, has_egg):
    """The egg stays linked."""
    if has_egg:
        _stranger(new_object, cube_mesh)
    linked = _link_objects(shelf_file)
    linked.make_local()
    _update()
    entry, = (item for item in bpy.data.objects if item.sluice.role == 'ENTRY' and item.library is None)
    assert ("S'Egg [shelf.blend]'" if has_egg else "S'Egg'") in entry.sluice.expression


@pytest.mark.parametrize("has_egg", (False, True))
@pytest.mark.parametrize("link", (_link, _link_objects))
def test_make_all_local(shelf_file, new_object, cube_mesh, has_egg, link):
    if has_egg:
        _stranger(new_object, cube_mesh)
    link(shelf_file)
    for item in bpy.context.scene.objects:
        item.select_set(True)
    bpy.context.view_layer.objects.active = bpy.context.selected_objects[0]
    bpy.ops.object.make_local(type='ALL')
    _update()
    entry, egg = _entry(), _at(bpy.context.scene, 1)
    assert entry.library is None and egg.library is None and has_egg == (egg.name != "Egg")
    assert f"(!F'{entry.name}')*S'{egg.name}'" in entry.sluice.expression


def test_a_full_copy_renders_its_own(make_shelf, export_now):
    """The copied edit's names are borne by what is exported."""
    make_shelf()
    bpy.ops.scene.new(type='FULL_COPY')
    _update()
    from sluice import expression_names
    description, _warnings = export_now()
    borne = {name for item in (*description["instances"], *description["lights"]) for name in item["names"]}
    borne |= {description["world"]["name"]} | {edit["entry"]["name"] for edit in description["edits"]}
    edit, = description["edits"]
    assert expression_names.names_in(edit["expression"]) <= borne and len(edit["exits"]) == 1
