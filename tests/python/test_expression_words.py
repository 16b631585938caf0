# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions told back in words (addon/expression_words.py), from the trees of sluice_core.parse: no Blender here."""
import pytest
from addon_modules import load

import sluice_core

words = load("expression_words")

TOLD = {
    "L": ("light straight from any lamp", "la lumière directe de toute lampe"),
    "L'Sun,Sky'": ("light straight from Sun or Sky", "la lumière directe de Sun ou Sky"),
    "LS+": ("light from any lamp, then one or more mirrors or glass", "la lumière de toute lampe, puis un ou plusieurs miroirs ou verres"),
    "LS'Egg'+": ("light from any lamp, then one or more reflections or refractions by Egg",
                 "la lumière de toute lampe, puis un ou plusieurs reflets ou réfractions par Egg"),
    "L.*": ("all light from any lamp, whatever it met", "toute la lumière de toute lampe, quoi qu'elle ait rencontré"),
    "L.+": ("light from any lamp, then one or more bounces of any kind", "la lumière de toute lampe, puis un ou plusieurs rebonds quelconques"),
    "L.*D'Red wall'": ("light from any lamp, last by a diffuse bounce off Red wall",
                       "la lumière de toute lampe, en dernier par un rebond diffus sur Red wall"),
    "L'Sun'.*!SS'Egg'+": ("scattered light from Sun, last by one or more reflections or refractions by Egg",
                          "la lumière diffusée de Sun, en dernier par un ou plusieurs reflets ou réfractions par Egg"),
    "L(SD)*": ("light from any lamp, then any number of times (a mirror or glass, then a diffuse bounce)",
               "la lumière de toute lampe, puis un nombre quelconque de fois (un miroir ou verre, puis un rebond diffus)"),
    "L[DS]{2}": ("light from any lamp, then 2 diffuse bounces or mirrors or glass", "la lumière de toute lampe, puis 2 rebonds diffus ou miroirs ou verres"),
    "L!D?G{2,}": ("light from any lamp, then perhaps a bounce that is not a diffuse bounce, then at least 2 glossy bounces",
                  "la lumière de toute lampe, puis peut-être un rebond qui n'est pas un rebond diffus, puis au moins 2 rebonds brillants"),
    "LX'Egg'F'Move'": ("light from any lamp, then Egg, in whatever way, then the edit Move",
                       "la lumière de toute lampe, puis Egg, de quelque façon que ce soit, puis l'édition Move"),
    "L(D|S+)": ("light from any lamp, then (either a diffuse bounce, or one or more mirrors or glass)",
                "la lumière de toute lampe, puis (soit un rebond diffus, soit un ou plusieurs miroirs ou verres)"),
    "L|LS": ("either light straight from any lamp, or light from any lamp, then a mirror or glass",
             "soit la lumière directe de toute lampe, soit la lumière de toute lampe, puis un miroir ou verre"),
    "LF{1,3}": ("light from any lamp, then 1 to 3 edits", "la lumière de toute lampe, puis 1 à 3 éditions"),
    "S+E": ("what reaches the eye by one or more mirrors or glass", "ce qui atteint l'œil par un ou plusieurs miroirs ou verres"),
    "E": ("what the eye sees directly", "ce que l'œil voit directement"),
    "L.*E": ("all light from any lamp, whatever it met, and on to the eye", "toute la lumière de toute lampe, quoi qu'elle ait rencontré, et jusqu'à l'œil"),
    "LE|LDE": ("either light straight from any lamp, and on to the eye, or light from any lamp, then a diffuse bounce, and on to the eye",
               "soit la lumière directe de toute lampe, et jusqu'à l'œil, soit la lumière de toute lampe, puis un rebond diffus, et jusqu'à l'œil"),
    ".*E": ("all that reaches the eye", "tout ce qui atteint l'œil"),
}


@pytest.mark.parametrize("text", TOLD)
def test_told(text):
    tree = sluice_core.parse(text)
    assert (words.tell(tree), words.tell(tree, "fr")) == TOLD[text]
    assert words.tell(tree, "eo") == TOLD[text][0]


def test_tree():
    assert sluice_core.parse("L(D'Floor\\'s'|S)+C") == (
        "sequence", ("atom", False, (("L", ()),)),
        ("repeat", ("choice", ("atom", False, (("D", ("Floor's",)),)), ("atom", False, (("S", ()),))), 1, None),
        ("atom", False, (("E", ()),)))
    assert sluice_core.parse("[^XG]{0,2}") == ("repeat", ("atom", True, (("X", ()), ("G", ()))), 0, 2)
    with pytest.raises(sluice_core.ExpressionError) as error:
        sluice_core.parse("L(")
    assert error.value.column == 2


def test_any_expression_can_be_told():
    """Words for whatever the grammar makes, in both languages, with each name in it."""
    from itertools import product
    atoms, postfixes = ("L", "D'A'", "!(S|F'B')", "[^XG]", ".", "(D|S'A')", "(LG)", "E"), ("", "*", "+", "?", "{0}", "{3}", "{2,}", "{1,4}")
    for first, postfix, second in product(atoms, postfixes, atoms):
        for text in (first + postfix + second, f"({first}|{second}){postfix}"):
            for language in words.LANGUAGES:
                told = words.tell(sluice_core.parse(text), language)
                assert "{" not in told and "  " not in told and all(name in told for name in "AB" if f"'{name}'" in text), (text, told)
