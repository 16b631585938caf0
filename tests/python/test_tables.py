# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists that stand on both sides of the binding are equal: the core's tables (transport/pixel_sample.h, edit/description.h, scene/description.h) decide, the add-on
follows. Its files are read, not imported, as they need Blender."""
import ast
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

import sluice_core

ROOT = Path(__file__).resolve().parents[2]
COMPILER = shutil.which("c++")


def _syntax_of(file):
    return ast.parse((ROOT / file).read_text())


def _assigned(tree, name):
    """The value of a module's NAME = value."""
    return next(node.value for node in tree.body if isinstance(node, ast.Assign) and [t.id for t in node.targets if isinstance(t, ast.Name)] == [name])


def test_the_stand_in_core_has_only_passes_of_the_core():
    """The add-on takes its passes from the core that it finds, so those of the stand-in may be fewer."""
    passes = ast.literal_eval(_assigned(_syntax_of("tests/blender/fakes/sluice_core.py"), "passes"))
    assert passes[0] == sluice_core.passes[0] == ("Combined", "RGBA")
    assert set(passes) <= set(sluice_core.passes)


def test_every_pass_has_a_switch():
    """The add-on registers switches without a core; the three lists that it makes them of hold the core's passes, and each once."""
    tables = [ast.literal_eval(_assigned(_syntax_of(f"addon/{file}.py"), name))
              for file, name in (("passes", "SHOWS"), ("passes", "_BLENDERS_SWITCHES"), ("pass_panels", "_GROUPS"))]
    names = sorted(name for name, _channels in sluice_core.passes if name != "Combined")
    assert sorted([*tables[0], *tables[1]]) == names == sorted(name for group in tables[2].values() for name in group)


def test_the_design_names_every_pass():
    section = re.search(r"^## 8\. .*?(?=^## |\Z)", (ROOT / "docs/design.md").read_text(), re.MULTILINE | re.DOTALL).group()
    assert {name for name, _channels in sluice_core.passes} <= set(re.findall(r"\w+", section))


def test_the_exporter_writes_every_property_of_an_exit():
    function = next(node for node in ast.walk(_syntax_of("addon/export/edit.py")) if isinstance(node, ast.FunctionDef) and node.name == "_export_exit")
    written = [key.value for node in ast.walk(function) if isinstance(node, ast.Dict) for key in node.keys]
    assert sorted(written) == sorted(("quad", *sluice_core.exit_properties))


# --- a member without its row does not compile, and with it nothing else is asked for ------------------------------------------------


class Addition(NamedTuple):
    """A new member of a header and its row in the table there, each as {a line's beginning: what is put before it}; a source that lives by both."""

    header: str
    source: str
    member: dict
    row: dict


ADDITIONS = {
    "counter of work": Addition(
        "transport/counts.h", "render/report.cpp", {"void operator+=(const Counters& o) noexcept;": "std::uint64_t added = 0;"},
        {'{"edit_queries", ': '{"added", &Counters::added},'}),
    "counter of drops": Addition(
        "transport/counts.h", "render/report.cpp", {"void operator+=(const Counters& o) noexcept;": "std::uint64_t added = 0;"},
        {'{"grazing_dropped", ': '{"added", &Counters::added, "capped", " by another bound"},'}),
    "term of the ledger": Addition(
        "transport/counts.h", "render/report.cpp", {"void operator+=(const Ledger& o) noexcept;": "double sunk = 0;"},
        {'{"absorbed", ': '{"sunk", &Ledger::sunk, -1},'}),
    "render pass": Addition(
        "transport/pixel_sample.h", "transport/film.cpp", {"PixelSample() noexcept {": "V3f added{0};"},
        {'{.name = "Albedo"': '{.name = "Added", .channels = "XYZ", .vector = &PixelSample::added},'}),
    "part of the picture": Addition(
        "transport/pixel_sample.h", "transport/film.cpp", {"Emission };": "Added,"}, {"case Part::Emission:": 'case Part::Added: return "Added";', "5;": "1 +"}),
    "property of exits": Addition(
        "edit/description.h", "edit/compile_edits.cpp", {"bool keep_brightness = true;": "float added = 0;"},
        {"keep_brightness, intensity_texture,": "added,", 'visit("keep_brightness"': 'visit("added", added, NumberRule{0, 1, 0});'}),
    "member of lamps": Addition(
        "scene/description.h", "scene/compile_lights.cpp", {"bool spot_cosine = true;": "float added = 0;"},
        {"spot_cosine, shape,": "added,", 'visit("spot_cosine"': 'visit("added", added);'}),
    "kind of camera": Addition(
        "scene/description.h", "scene/normals.cpp", {"Orthographic };": "Added,"}, {"case CameraKind::Orthographic:": 'case CameraKind::Added: return "Added";'}),
}  # fmt: skip


def _with(text, additions):
    for before, added in additions.items():
        assert text.count(before) == 1, before
        text = text.replace(before, f"{added} {before}")
    return text


def _complaints(tmp_path, addition, text):
    """What the compiler says of the source if this is the header; empty: it compiles."""
    place = tmp_path / addition.header
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(text)
    command = [COMPILER, "-std=c++20", "-fsyntax-only", "-Wall", "-Werror", "-I", tmp_path, "-I", ROOT / "cpp", "-isystem", "/usr/include/Imath",
               ROOT / "cpp" / addition.source]  # fmt: skip
    return subprocess.run(command, capture_output=True, text=True).stderr


@pytest.mark.skipif(COMPILER is None, reason="no C++ compiler")
@pytest.mark.parametrize("name", ADDITIONS)
def test_a_member_needs_its_row_and_nothing_else(tmp_path, name):
    addition = ADDITIONS[name]
    text = (ROOT / "cpp" / addition.header).read_text()
    assert "error" in _complaints(tmp_path, addition, _with(text, addition.member))
    assert _complaints(tmp_path, addition, _with(_with(text, addition.member), addition.row)) == ""
