# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists that stand on both sides of the binding are equal: the core's tables (transport/pixel_sample.h, edit/description.h) decide, the add-on
follows. Its files are read, not imported, as they need Blender."""
import ast
from pathlib import Path

import sluice_core

ROOT = Path(__file__).resolve().parents[2]


def _syntax_of(file):
    return ast.parse((ROOT / file).read_text())


def _assigned(tree, name):
    """The value of a module's NAME = value."""
    return next(node.value for node in tree.body if isinstance(node, ast.Assign) and [t.id for t in node.targets if isinstance(t, ast.Name)] == [name])


def test_the_hosts_passes_are_the_films():
    rows = _assigned(_syntax_of("addon/passes.py"), "PASSES").elts
    told = {row.args[0].value: row.args[1].value for row in rows}
    assert told == dict(sluice_core.passes)
    assert len(rows) == len(sluice_core.passes)


def test_the_stand_in_core_paints_the_films_passes():
    painted = ast.literal_eval(_assigned(_syntax_of("tests/blender/fakes/sluice_core.py"), "_CHANNELS"))
    assert painted == {name: len(channels) for name, channels in sluice_core.passes}


def test_the_exporter_writes_every_property_of_an_exit():
    function = next(node for node in ast.walk(_syntax_of("addon/export/edit.py")) if isinstance(node, ast.FunctionDef) and node.name == "_export_exit")
    written = [key.value for node in ast.walk(function) if isinstance(node, ast.Dict) for key in node.keys]
    assert sorted(written) == sorted(("quad", *sluice_core.exit_properties))
