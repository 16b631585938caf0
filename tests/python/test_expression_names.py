# SPDX-License-Identifier: GPL-3.0-or-later
"""Names in the text of expressions (addon/expression_names.py), against the core's own parser."""
import pytest
from addon_modules import load

import sluice_core

names = load("expression_names")


def _names_of(tree):
    """Every name in a syntax tree."""
    if tree[0] == "atom":
        return {name for _letter, named in tree[2] for name in named}
    return {name for part in tree[1:] if isinstance(part, tuple) for name in _names_of(part)}


TEXTS = ("LS+", "L'Sun'.*D'Red wall'", "L (S'Egg' | D'Floor,Wall')+", "L[S'A'D'B']", "L!(S'it\\'s'|D'a\\,b\\\\')", "LX 'spaced' F'SED'", "S'L'+E")


@pytest.mark.parametrize("text", TEXTS)
def test_names_are_the_parsers(text):
    assert names.names_in(text) == _names_of(sluice_core.parse(text))


@pytest.mark.parametrize("name", ("Egg", "it's", "a,b", "back\\slash", "S'x'", "été", "(", "|"))
def test_renaming_changes_names_alone(name):
    for text in TEXTS:
        used = names.names_in(text)
        changed = names.renamed(text, {old: [name] for old in used})
        assert _names_of(sluice_core.parse(changed)) == ({name} if used else set())
        assert names.renamed(text, {"nobody": [name]}) == text
        back = names.renamed(changed, {name: ["Q"]})
        assert sluice_core.parse(back) == sluice_core.parse(names.renamed(text, {old: ["Q"] for old in used}))


def test_renamed():
    assert names.renamed("LS'Egg,Ball'D'Egg'", {"Egg": ["Ball"]}) == "LS'Ball'D'Ball'"
    assert names.renamed("LS'Egg'+", {"Egg": ["Ball", "Egg"]}) == "LS'Ball,Egg'+"
    assert names.renamed("LS'Egg", {"Egg": ["Ball"]}) == "LS'Egg"  # never closed: an error stays what it was


@pytest.mark.parametrize(("text", "kind", "name", "wanted"), [
    ("LS+", "S", "Egg", "LS'Egg'+"), ("LS+", "L", "Sun", "L'Sun'S+"), ("LS'Egg'+", "S", "Ball", "LS'Egg'+S'Ball'"),
    ("L", "D", "it's", "LD'it\\'s'"), ("S+E", "D", "Floor", "S+D'Floor'E"), ("E ", "S", "Egg", "S'Egg'E "), ("L.*", "X", "Set", "L.*X'Set'")])
def test_a_name_put_in(text, kind, name, wanted):
    assert names.with_name(text, kind, name) == wanted
