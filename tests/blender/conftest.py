# SPDX-License-Identifier: GPL-3.0-or-later
"""Inside Blender (run.py): fixtures for a fresh file and the stand-in core. Outside: only the test that launches Blender."""
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
INSIDE = os.environ.get("SLUICE_INSIDE_BLENDER") == "1" and "bpy" in sys.modules

collect_ignore = ["run.py", "gui", "fakes"] + (["test_outside.py"] if INSIDE else [])
if not INSIDE:
    collect_ignore_glob = ["test_[!o]*.py", "test_o[!u]*.py"]


@pytest.fixture(autouse=INSIDE)
def empty_file():
    """Each test starts in an empty file with the add-on's engine."""
    import bpy
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.context.scene.render.engine = 'SLUICE'


@pytest.fixture(scope="module")
def core():
    """The real core's module."""
    from sluice import core as door
    try:
        return door.load()
    except door.CoreMissing as missing:
        pytest.skip(str(missing))


@pytest.fixture
def fake_core(monkeypatch):
    """The stand-in core, as the add-on's core module for one test."""
    import sluice.core
    spec = importlib.util.spec_from_file_location("sluice.sluice_core", HERE / "fakes" / "sluice_core.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setitem(sys.modules, "sluice.sluice_core", module)
    return module


@pytest.fixture
def new_object():
    """new_object('Cube', data, matrix): an object linked to the scene."""
    import bpy

    def make(name, data=None, matrix=None, collection=None):
        item = bpy.data.objects.new(name, data)
        (collection or bpy.context.scene.collection).objects.link(item)
        if matrix is not None:
            item.matrix_world = matrix
        return item

    return make


@pytest.fixture
def cube_mesh():
    """A cube of side 2 round the origin, with a UV map."""
    import bmesh
    import bpy

    def make(name="Cube"):
        mesh = bpy.data.meshes.new(name)
        shape = bmesh.new()
        shape.loops.layers.uv.new("UVMap")
        bmesh.ops.create_cube(shape, size=2, calc_uvs=True)
        shape.to_mesh(mesh)
        shape.free()
        return mesh

    return make


@pytest.fixture
def camera(new_object):
    """An active camera that looks down on the origin."""
    import bpy
    from mathutils import Matrix
    item = new_object("Camera", bpy.data.cameras.new("Camera"), Matrix.Translation((0, 0, 5)))
    bpy.context.scene.camera = item
    return item


@pytest.fixture
def export_now():
    """export_now(): (description, warnings) of the open file as the final render copies it."""
    import bpy
    from sluice import export
    from sluice.export.camera import export_frame
    from sluice.export.scene_names import Names

    def run():
        depsgraph = bpy.context.evaluated_depsgraph_get()
        context = export.Context(Names(bpy.data.collections, bpy.data.objects, bpy.data.worlds))
        frame = export_frame(64, 48, bpy.context.scene.render)
        return export.export_scene(depsgraph, {}, frame, context), context.warnings

    return run


@pytest.fixture
def launch(tmp_path):
    """launch(args): another Blender with the add-on and the stand-in core, in background."""
    import bpy

    def run(*args, core=HERE / "fakes"):
        environment = dict(os.environ, SLUICE_CORE=str(core))
        command = [bpy.app.binary_path, "--factory-startup", "-Y", "-b", "--addons", "sluice", *map(str, args)]
        return subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=120)

    return run


@pytest.fixture
def edited_scene(camera, new_object, cube_mesh):
    """A small scene with one edit, and quick settings."""
    import bpy
    scene = bpy.context.scene
    new_object("Cube", cube_mesh())
    bpy.ops.sluice.add_edit(expression="LS+")
    scene.sluice.passes, scene.sluice.photons = 3, 1000
    scene.render.resolution_x, scene.render.resolution_y = 40, 30
    scene.frame_end = 2
    return scene


@pytest.fixture
def room(core, camera, new_object, cube_mesh):
    """A floor under a lamp with a glass ball, an edit that moves direct light aside; small and quick."""
    import bpy
    from blender_scenes import ask_for_all_passes
    from mathutils import Matrix
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.object.name = "Floor"
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.4, location=(-0.8, 0, 0.6))
    ball = bpy.context.object
    ball.name = "Ball"
    ball.data.polygons.foreach_set("use_smooth", [True] * len(ball.data.polygons))
    glass = bpy.data.materials.new("Glass")
    glass.use_nodes = True
    glass.node_tree.nodes.clear()
    shader, out = glass.node_tree.nodes.new('ShaderNodeBsdfGlass'), glass.node_tree.nodes.new('ShaderNodeOutputMaterial')
    shader.inputs["Roughness"].default_value = 0
    glass.node_tree.links.new(shader.outputs[0], out.inputs["Surface"])
    ball.data.materials.append(glass)
    lamp = bpy.data.lights.new("Lamp", 'POINT')
    lamp.energy, lamp.shadow_soft_size = 100, 0.05
    new_object("Lamp", lamp, Matrix.Translation((0, 0, 3)))
    entry, exit_ = new_object("Entry"), new_object("Exit")
    entry.sluice.role, exit_.sluice.role = 'ENTRY', 'EXIT'
    entry.sluice.expression, exit_.sluice.entry = "L", entry
    entry.matrix_world = Matrix.Translation((0.5, -0.8, 0)) @ Matrix.Scale(0.3, 4)
    exit_.matrix_world = Matrix.Translation((0.5, 0.8, 0)) @ Matrix.Scale(0.3, 4)
    scene.sluice.passes, scene.sluice.photons = 4, 20000
    scene.render.resolution_x, scene.render.resolution_y = 48, 36
    scene.view_settings.view_transform = 'Standard'
    ask_for_all_passes(scene)
    return scene


@pytest.fixture
def picture(room, tmp_path):
    """picture(): {pass.channel: (h, w)} of an F12, and the film's hash from the file's header."""
    import bpy
    from blender_scenes import channels, oiiotool, write_layers

    def run(name="image"):
        path = tmp_path / f"{name}.exr"
        write_layers(room)
        room.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        header = oiiotool("--info", "-v", path)
        found = {key.split(".", 1)[1]: pixels for key, pixels in channels(path).items()}
        found["hash"] = header.split('Sluice film hash: "')[1].split('"')[0]
        return found

    return run
