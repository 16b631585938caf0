# SPDX-License-Identifier: GPL-3.0-or-later
"""Registering leaves nothing behind, whatever happens between; the package says who it is."""
import resource
from pathlib import Path

import bpy
import sluice

ADDON = Path(sluice.__file__).parent


def _traces():
    """Everything of ours that Blender knows."""
    kinds = (bpy.types.Panel, bpy.types.Operator, bpy.types.PropertyGroup, bpy.types.Menu, bpy.types.RenderEngine)
    classes = sorted(cls.__name__ for kind in kinds for cls in kind.__subclasses__()
                     if cls.__module__.startswith("sluice.") and cls.is_registered)
    adopted = sorted(cls.__name__ for cls in bpy.types.Panel.__subclasses__()
                     if not cls.__module__.startswith("sluice.") and 'SLUICE' in getattr(cls, "COMPAT_ENGINES", ()))
    owners = [owner.__name__ for owner in (bpy.types.Object, bpy.types.Scene, bpy.types.ViewLayer) if hasattr(owner, "sluice")]
    menus = sum(draw.__module__.startswith("sluice.") for name in ("VIEW3D_MT_add", "VIEW3D_MT_mesh_add", "NODE_MT_add")
                for draw in getattr(bpy.types, name)._dyn_ui_initialize())
    handlers = sum(handler.__module__.startswith("sluice") for handler in bpy.app.handlers.load_pre)
    return classes, adopted, owners, menus, handlers


def test_fifty_times():
    before = _traces()
    assert before[0] and len(before[1]) > 30 and len(before[2]) == 3 and before[3] == 3 and before[4] == 1
    memory = None
    for turn in range(50):
        sluice.unregister()
        assert _traces() == ([], [], [], 0, 0)
        sluice.register()
        if turn == 9:  # Blender's own pools have grown to their size by now
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert _traces() == before
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 4096  # kB


def test_panels_whose_options_we_ignore_stay_hidden():
    for panel in bpy.types.Panel.__subclasses__():
        if 'SLUICE' in getattr(panel, "COMPAT_ENGINES", ()) and not panel.__module__.startswith("sluice."):
            assert not any(word in panel.__name__.lower() for word in ("freestyle", "shadow_cascaded", "bloom", "volume_render", "sss"))


def test_native_panels_for_nodes_and_cameras_show():
    adopted = _traces()[1]
    for name in ("EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface", "DATA_PT_lens",
                 "DATA_PT_camera_dof", "RENDER_PT_output", "RENDER_PT_color_management"):
        assert name in adopted


def test_manifest_and_bl_info_agree():
    import tomllib
    from sluice import core
    manifest = tomllib.loads((ADDON / "blender_manifest.toml").read_text())
    needed = {"schema_version", "id", "version", "name", "tagline", "maintainer", "type", "license", "blender_version_min"}
    assert needed <= manifest.keys()
    assert manifest["version"] == ".".join(map(str, sluice.bl_info["version"])) == ".".join(map(str, core.VERSION))
    assert manifest["id"] == "sluice" and manifest["type"] == "add-on" and len(manifest["tagline"]) <= 64
    assert not manifest["tagline"].endswith(".")


def test_imports_are_relative():
    """As an extension the package has another name."""
    for path in ADDON.rglob("*.py"):
        for line in path.read_text().splitlines():
            assert not line.strip().startswith(("import sluice", "from sluice")), f"{path}: {line}"


def test_labels_have_their_french():
    """Every label of ours but those that Blender has itself, and no word that nothing uses."""
    from sluice import light_kinds, translations
    source = "\n".join(path.read_text() for path in ADDON.glob("*.py") if path.name != "translations.py")
    assert [word for word in translations.FRENCH if f'"{word}"' not in source] == []
    blenders = {"Film", "Light", "Performance", "Simplify", "Visibility", "Select", "Solo", "Sluice Shader", "Light Layer"}
    kinds = (bpy.types.Panel, bpy.types.Operator, bpy.types.Menu)
    labels = {cls.bl_label for kind in kinds for cls in kind.__subclasses__() if cls.__module__.startswith("sluice.") and cls.is_registered}
    assert labels - blenders - translations.FRENCH.keys() == set()
    for group in (bpy.context.scene.sluice, bpy.data.objects.new("Empty", None).sluice, bpy.context.view_layer.sluice):
        names = {item.name for item in group.bl_rna.properties if item.identifier not in {"rna_type", "name"}}
        assert names - translations.FRENCH.keys() == set()
    assert {label for _name, label, _description, _icon in light_kinds.ACTIONS} <= translations.FRENCH.keys()


def test_french_is_shown():
    view = bpy.context.preferences.view
    if "fr_FR" not in bpy.app.translations.locales:
        import pytest
        pytest.skip("this Blender has no languages")
    view.language, view.use_translate_interface = 'fr_FR', True
    try:
        shown = bpy.app.translations.pgettext_iface
        assert (shown("Light Edit"), shown("Exit", "Sluice"), shown("Tint", "Sluice"), shown("Add Exit", "Operator")) == ("Édition de lumière", "Sortie", "Coloration", "Ajouter une sortie")
    finally:
        view.language = 'en_US'
