# SPDX-License-Identifier: GPL-3.0-or-later
"""What things answer to in expressions: instances of instances, whatever makes them, and things of libraries."""
import bpy
import pytest


@pytest.fixture
def eggs(cube_mesh, export_now):
    """eggs(): {x: names} of the exported instances that are called Egg."""
    mesh = cube_mesh("Egg")

    def told():
        description, _warnings = export_now()
        return {round(float(item["matrix"][0, 3]), 3): item["names"] for item in description["instances"] if item["names"][0] == "Egg"}

    told.mesh = mesh
    return told


def _collection(name, parent=None):
    made = bpy.data.collections.new(name)
    if parent is not None:
        parent.children.link(made)
    return made


@pytest.fixture
def instance(new_object):
    """instance("A", collection, x, into): an Empty that instances a collection."""
    def make(name, collection, x=0.0, into=None):
        item = new_object(name, None, collection=into)
        item.instance_type, item.instance_collection, item.location.x = 'COLLECTION', collection, x
        return item

    return make


@pytest.fixture
def row(eggs, new_object, instance):
    """Two instances, A at 0 and B at 3, of a collection Box that holds the egg in its collection Nest, beside things that are not seen."""
    box, pair = _collection("Box"), _collection("Pair")
    hidden = new_object("Hidden", eggs.mesh, collection=box)
    hidden.hide_render = hidden.hide_viewport = True
    new_object("Egg", eggs.mesh, collection=_collection("Nest", box))
    new_object("Ball", eggs.mesh, collection=box)
    instance("A", box, 0, pair)
    instance("B", box, 3, pair)
    return pair


def test_an_instance_answers_to_all_that_make_it(eggs, row, instance):
    """Three instancers above each other; which ones is told by the place."""
    shelf = _collection("Shelf")
    instance("M", row, 0, shelf)
    instance("N", row, 10, shelf)
    instance("Top", shelf)
    instance("Aside", row, 100)
    inner = ["Egg", "Nest", "Box"]
    assert eggs() == {
        0: [*inner, "A", "Pair", "M", "Shelf", "Top"], 3: [*inner, "B", "Pair", "M", "Shelf", "Top"],
        10: [*inner, "A", "Pair", "N", "Shelf", "Top"], 13: [*inner, "B", "Pair", "N", "Shelf", "Top"],
        100: [*inner, "A", "Pair", "Aside"], 103: [*inner, "B", "Pair", "Aside"]}  # fmt: skip


@pytest.mark.parametrize("kind", ('VERTS', 'FACES'))
def test_instances_on_a_mesh(row, instance, new_object, export_now, kind):
    carrier = new_object("Carrier", bpy.data.meshes.new("Carrier"))
    carrier.data.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2), (0, 2, 3)])
    carrier.instance_type = kind
    instance("Kid", row).parent = carrier
    found = sorted(item["names"] for item in export_now()[0]["instances"] if "Carrier" in item["names"] and "Egg" in item["names"])
    count = len(carrier.data.vertices if kind == 'VERTS' else carrier.data.polygons)
    assert found == [["Egg", "Nest", "Box", name, "Pair", "Kid", "Carrier"] for name in "A" * count + "B" * count]


def _nodes(item, kind, thing, is_separate=False):
    tree = bpy.data.node_groups.new("Instances", 'GeometryNodeTree')
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out='OUTPUT', socket_type='NodeSocketGeometry')
    else:
        tree.outputs.new('NodeSocketGeometry', "Geometry")
    info, out = tree.nodes.new(kind), tree.nodes.new('NodeGroupOutput')
    inputs = {socket.name: socket for socket in info.inputs}
    inputs["Object" if "Object" in inputs else "Collection"].default_value = thing
    if is_separate:
        inputs["Separate Children"].default_value = True
    tree.links.new(next(socket for socket in info.outputs if socket.type == 'GEOMETRY'), out.inputs[0])
    item.modifiers.new("Instances", 'NODES').node_group = tree


@pytest.mark.parametrize("is_separate", (False, True))
def test_geometry_nodes(eggs, row, new_object, is_separate):
    geometry = new_object("Geometry", eggs.mesh)
    _nodes(geometry, 'GeometryNodeCollectionInfo', row, is_separate)
    inner = ["Egg", "Nest", "Box"]
    assert eggs() == {0: [*inner, "A", "Pair", "Geometry"], 3: [*inner, "B", "Pair", "Geometry"]}


def test_particles(eggs, row, new_object):
    carrier = new_object("Carrier", eggs.mesh)
    carrier.modifiers.new("Particles", 'PARTICLE_SYSTEM')
    settings = carrier.particle_systems[0].settings
    settings.count, settings.frame_start, settings.frame_end, settings.physics_type = 2, 1, 1, 'NO'
    settings.render_type, settings.instance_collection, settings.use_whole_collection = 'COLLECTION', bpy.data.collections["Box"], True
    bpy.context.scene.frame_set(1)
    found = list(eggs().values())
    assert found and all(names == ["Egg", "Nest", "Box", "Carrier"] for names in found)


def test_lamps_in_instances_and_collections_renamed(row, new_object, instance, export_now):
    new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT'), collection=bpy.data.collections["Nest"])
    instance("Top", row)
    bpy.data.collections["Box"].name = "Case"
    lights = export_now()[0]["lights"]
    assert [light["names"] for light in lights] == [["Lamp", "Nest", "Case", name, "Pair", "Top"] for name in "AB"]


@pytest.fixture
def lit(new_object, camera):
    """lit(): the light that the entry took in a small render of the open scene, W. A mirror throws the lamp's light onto it."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.sluice.passes, scene.sluice.photons = 16, 16, 2, 4000
    new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT')).location.z = 2
    bpy.data.lights["Lamp"].energy = 100
    ceiling = new_object("Ceiling", bpy.data.meshes.new("Ceiling"))
    ceiling.data.from_pydata([(-20, -20, 12), (20, -20, 12), (20, 20, 12), (-20, 20, 12)], [], [(0, 1, 2, 3)])
    entry, out = new_object("Entry"), new_object("Exit")
    entry.location, entry.empty_display_size, out.location = (0, 0, 1), 4, (0, 0, 9)
    entry.sluice.role, out.sluice.role, out.sluice.entry = 'ENTRY', 'EXIT', entry

    def render(scene, expression=None):
        from sluice import edit_statistics
        entry, = (item for item in scene.objects if item.sluice.role == 'ENTRY')
        entry.sluice.expression = expression or entry.sluice.expression
        bpy.ops.render.render(scene=scene.name)
        return edit_statistics.of(entry.name_full).power_in

    return render


def _mirror(mesh):
    material = bpy.data.materials.new("Mirror")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, out = nodes.new('ShaderNodeBsdfGlossy'), nodes.new('ShaderNodeOutputMaterial')
    shader.inputs["Roughness"].default_value = 0
    material.node_tree.links.new(shader.outputs[0], out.inputs[0])
    mesh.materials.append(material)


def test_light_is_taken_by_every_name(lit, eggs, row, instance):
    """The same light, to the last bit, whichever of its names the expression says."""
    _mirror(eggs.mesh)
    bpy.data.objects["Ball"].hide_render = True
    instance("Top", row)
    scene = bpy.context.scene
    whole = lit(scene, "LS+")
    assert whole > 0
    for name in ("Egg", "Nest", "Box", "Pair", "Top", "A,B"):
        assert lit(scene, f"LS'{name}'+") == whole, name
    assert 0 < lit(scene, "LS'A'+") < whole


def test_a_full_copy_takes_the_same_light(lit, new_object, eggs):
    _mirror(eggs.mesh)
    new_object("Egg", eggs.mesh)
    bpy.context.view_layer.update()
    first = bpy.context.scene
    taken = lit(first, "L'Lamp'S'Egg'+")
    bpy.ops.scene.new(type='FULL_COPY')
    assert bpy.context.scene != first and taken > 0
    assert lit(bpy.context.scene) == taken


def _library(path, make):
    """Saves what `make` makes as a library, and opens an empty file."""
    make()
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True)


def _link(path, **names):
    with bpy.data.libraries.load(str(path), link=True) as (_there, here):
        for kind, wanted in names.items():
            setattr(here, kind, wanted)
    for item in names.get("objects", ()):  # names no more: Blender puts in what it loaded
        bpy.context.scene.collection.objects.link(item)
    for item in names.get("collections", ()):
        bpy.context.scene.collection.children.link(item)


@pytest.fixture
def entry_of_shelf(tmp_path, new_object, cube_mesh):
    """The path of a library with an entry that takes what its egg sends on."""
    def make():
        new_object("Egg", cube_mesh())
        new_object("Entry").sluice.role = 'ENTRY'
        bpy.data.objects["Entry"].sluice.expression = "L'Sky'S'Egg'+"
        bpy.data.worlds.new("Sky").use_fake_user = True

    _library(tmp_path / "shelf.blend", make)
    return tmp_path / "shelf.blend"


def _expression(exported):
    edit, = exported[0]["edits"]
    return edit["expression"]


def test_a_linked_edit_means_its_own_library(entry_of_shelf, new_object, cube_mesh, export_now):
    _link(entry_of_shelf, objects=["Entry", "Egg"], worlds=["Sky"])
    bpy.context.scene.world = bpy.data.worlds["Sky"]
    assert _expression(export_now()) == "L'Sky'S'Egg'+"
    new_object("Egg", cube_mesh())
    assert _expression(export_now()) == "L'Sky'S'Egg [shelf.blend]'+"
    bpy.data.worlds.new("Sky")
    description = export_now()[0]
    assert description["edits"][0]["expression"] == "L'Sky [shelf.blend]'S'Egg [shelf.blend]'+"
    assert description["world"]["name"] == "Sky [shelf.blend]"
    assert sorted(item["names"] for item in description["instances"]) == [["Egg"], ["Egg [shelf.blend]"]]


def test_a_local_edit_means_local_things(entry_of_shelf, new_object, cube_mesh, export_now):
    _link(entry_of_shelf, objects=["Egg"])
    entry = new_object("Entry")
    entry.sluice.role, entry.sluice.expression = 'ENTRY', "LS'Egg'+"
    new_object("Egg", cube_mesh())
    assert _expression(export_now()) == "LS'Egg'+"
    assert sorted(item["names"] for item in export_now()[0]["instances"]) == [["Egg"], ["Egg [shelf.blend]"]]


def test_a_name_may_lie_in_a_library_of_the_library(tmp_path, entry_of_shelf, new_object, cube_mesh, export_now):
    """The edit was written in a file that links the egg: that one it means, whatever this file has."""
    def make():
        _link(entry_of_shelf, objects=["Egg"])
        new_object("Entry").sluice.role = 'ENTRY'
        bpy.data.objects["Entry"].sluice.expression = "LS'Egg'+"
        room = bpy.data.collections.new("Room")
        bpy.context.scene.collection.children.link(room)
        room.objects.link(bpy.data.objects["Entry"])
        room.objects.link(bpy.data.objects["Egg"])

    _library(tmp_path / "room.blend", make)
    _link(tmp_path / "room.blend", collections=["Room"])
    new_object("Egg", cube_mesh())
    assert _expression(export_now()) == "LS'Egg [shelf.blend]'+"


def test_two_libraries_have_edits_and_eggs_of_one_name(tmp_path, new_object, cube_mesh, export_now):
    def make():
        new_object("Egg", cube_mesh())
        new_object("Entry").sluice.role = 'ENTRY'
        bpy.data.objects["Entry"].sluice.expression = "LS'Egg'F'Entry'*"

    for name in ("one", "two"):
        _library(tmp_path / f"{name}.blend", make)
    for name in ("one", "two"):
        _link(tmp_path / f"{name}.blend", objects=["Egg", "Entry"])
    found = {edit["entry"]["name"]: edit["expression"] for edit in export_now()[0]["edits"]}
    assert found == {f"Entry [{name}.blend]": f"LS'Egg [{name}.blend]'F'Entry [{name}.blend]'*" for name in ("one", "two")}


class _Layout:
    """Remembers what a panel draws."""

    def __init__(self):
        self.alert, self.use_property_split, self.scale_y = False, True, 1
        self.inside, self.fields, self.sentence = [], [], ""

    def row(self, **_more):
        self.inside.append(_Layout())
        return self.inside[-1]

    column = row

    def prop(self, _owner, name, **_more):
        self.fields.append(name)

    def label(self, text="", **_more):
        self.sentence += text + " "

    def all(self):
        return [self] + [part for layout in self.inside for part in layout.all()]


@pytest.fixture
def drawn(monkeypatch):
    """drawn(entry): (is the field red, what is said in red) of its expression in its panel."""
    from sluice import interface
    monkeypatch.setattr(interface, "sentence", lambda layout, _region, text, _icon: layout.label(text))

    def draw(entry):
        layout = _Layout()
        bpy.context.view_layer.update()
        interface.draw_expression(layout, None, entry.sluice)
        field, = (part for part in layout.all() if "expression" in part.fields)
        return field.alert, "".join(part.sentence for part in layout.all() if part.alert)

    return draw


def test_a_name_that_is_not_in_the_scene_is_red(drawn, row, instance, new_object, cube_mesh):
    instance("Top", row)
    geometry = new_object("Geometry", cube_mesh())
    lonely = bpy.data.objects.new("Lonely", cube_mesh())
    _nodes(geometry, 'GeometryNodeObjectInfo', lonely)
    bpy.context.scene.world, bpy.data.worlds.new("Night").use_fake_user = bpy.data.worlds.new("Sky"), True
    bpy.data.scenes.new("Other").collection.objects.link(bpy.data.objects.new("Away", cube_mesh()))
    entry = new_object("Entry")
    entry.sluice.role = 'ENTRY'
    for name in ("Egg", "Nest", "Box", "A", "Pair", "Top", "Geometry", "Lonely", "Sky", "Entry"):
        entry.sluice.expression = f"L.*X'{name}'"
        assert drawn(entry) == (False, ""), name
    for name in ("Away", "Night"):
        entry.sluice.expression = f"L.*X'{name}'"
        red, said = drawn(entry)
        assert red and f"'{name}' is in this file, but not in this scene" in said
    entry.sluice.expression = "L.*X'Egk'"
    red, said = drawn(entry)
    assert red and "'Egg'" in said
    bpy.data.scenes["Other"].collection.objects.link(bpy.data.objects["Egg"])  # stays in the file, leaves the scene
    for collection in bpy.data.objects["Egg"].users_collection:
        if collection.name == "Nest":
            collection.objects.unlink(bpy.data.objects["Egg"])
    entry.sluice.expression = "L.*X'Egg'"
    assert drawn(entry)[0]
