# SPDX-License-Identifier: GPL-3.0-or-later
"""An expression told back in words, English or French, from the core's syntax tree (sluice_core.parse). No bpy.

A language is a table: for each event its noun (alone, several, one with a name, several with a name; {} is the name), and the
phrases that join them."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, TypeAlias

Tree: TypeAlias = tuple[Any, ...]  # ("atom", …), ("repeat", …), ("sequence", …) or ("choice", …), as sluice_core.parse makes it


class Noun(NamedTuple):
    """How an event is called: alone, several of it, one with a name, several with a name, and what "one or more" is before it."""

    one: str
    many: str
    named: str
    many_named: str
    some: str = "one or more"


Language: TypeAlias = dict[str, Any]  # event: its Noun; name of a phrase: the phrase


def _masculine(one: str, many: str, named: str, many_named: str) -> Noun:
    return Noun(one, many, named, many_named, "un ou plusieurs")


def _feminine(one: str, many: str, named: str, many_named: str) -> Noun:
    return Noun(one, many, named, many_named, "une ou plusieurs")


ENGLISH = {
    "L": Noun("light from any lamp", "lamps", "light from {}", "lamps called {}"),
    "E": Noun("the eye", "eyes", "the eye {}", "eyes called {}"),
    "D": Noun("a diffuse bounce", "diffuse bounces", "a diffuse bounce off {}", "diffuse bounces off {}"),
    "S": Noun("a mirror or glass", "mirrors or glass", "a reflection or refraction by {}", "reflections or refractions by {}"),
    "G": Noun("a glossy bounce", "glossy bounces", "a glossy bounce off {}", "glossy bounces off {}"),
    "X": Noun("a surface", "surfaces", "{}, in whatever way", "meetings with {}"),
    "F": Noun("an edit", "edits", "the edit {}", "passages through the edit {}"),
    ".": Noun("a bounce of any kind", "bounces of any kind", "", ""),
    "!": Noun("a bounce that is not {}", "bounces that are not {}", "", ""),
    "or": " or ", "then": ", then ", "either": "either {}", "else": ", or ",
    "some": "{} {}", "any": "any number of {}", "maybe": "perhaps {}", "none": "no {}", "exactly": "{} {}", "least": "at least {} {}",
    "between": "{} to {} {}",
    "some times": "one or more times ({})", "any times": "any number of times ({})", "exactly times": "{} times ({})",
    "least times": "at least {} times ({})", "between times": "{} to {} times ({})", "none times": "never ({})", "group": "({})",
    "straight": "light straight from {}", "any lamp": "any lamp", "all": "all light from {}, whatever it met",
    "last": "light from {}, last by {}", "scattered": "scattered light from {}, last by {}",
    "view": "what reaches the eye by {}", "view straight": "what the eye sees directly", "view all": "all that reaches the eye",
    "to eye": "{}, and on to the eye",
}
FRENCH = {
    "L": _feminine("la lumière de toute lampe", "lampes", "la lumière de {}", "lampes nommées {}"),
    "E": _masculine("l'œil", "yeux", "l'œil {}", "yeux nommés {}"),
    "D": _masculine("un rebond diffus", "rebonds diffus", "un rebond diffus sur {}", "rebonds diffus sur {}"),
    "S": _masculine("un miroir ou verre", "miroirs ou verres", "un reflet ou une réfraction par {}", "reflets ou réfractions par {}"),
    "G": _masculine("un rebond brillant", "rebonds brillants", "un rebond brillant sur {}", "rebonds brillants sur {}"),
    "X": _feminine("une surface", "surfaces", "{}, de quelque façon que ce soit", "rencontres avec {}"),
    "F": _feminine("une édition", "éditions", "l'édition {}", "traversées de l'édition {}"),
    ".": _masculine("un rebond quelconque", "rebonds quelconques", "", ""),
    "!": _masculine("un rebond qui n'est pas {}", "rebonds qui ne sont pas {}", "", ""),
    "or": " ou ", "then": ", puis ", "either": "soit {}", "else": ", soit ",
    "some": "{} {}", "any": "un nombre quelconque de {}", "maybe": "peut-être {}", "none": "aucun des {}", "exactly": "{} {}",
    "least": "au moins {} {}", "between": "{} à {} {}",
    "some times": "une ou plusieurs fois ({})", "any times": "un nombre quelconque de fois ({})", "exactly times": "{} fois ({})",
    "least times": "au moins {} fois ({})", "between times": "{} à {} fois ({})", "none times": "jamais ({})", "group": "({})",
    "straight": "la lumière directe de {}", "any lamp": "toute lampe", "all": "toute la lumière de {}, quoi qu'elle ait rencontré",
    "last": "la lumière de {}, en dernier par {}", "scattered": "la lumière diffusée de {}, en dernier par {}",
    "view": "ce qui atteint l'œil par {}", "view straight": "ce que l'œil voit directement", "view all": "tout ce qui atteint l'œil",
    "to eye": "{}, et jusqu'à l'œil",
}
LANGUAGES = {"en": ENGLISH, "fr": FRENCH}
_EYE = ("atom", False, (("E", ()),))
_ANYTHING = ("repeat", ("atom", True, ()), 0, None)
_NOT_MIRROR = ("atom", True, (("S", ()),))


def tell(tree: Tree, language: str = "en") -> str:
    """The sentence, its first letter small and without a full stop. An unknown language is told in English."""
    return _Teller(LANGUAGES.get(language, ENGLISH)).whole(tree)


class _Teller:
    def __init__(self, language: Language) -> None:
        self.say = language

    def whole(self, tree: Tree) -> str:
        """A branch of its own has phrases for what it commonly is: straight light, all light, what the eye sees."""
        if tree[0] == "choice":
            return self.say["either"].format(self.say["else"].join(map(self.whole, tree[1:])))
        parts = tree[1:] if tree[0] == "sequence" else (tree,)
        if len(parts) > 1 and _is(parts[0], "L") and parts[-1] == _EYE:  # This is the expression of a layer: a whole path.
            return self.say["to eye"].format(self.whole(("sequence", *parts[:-1])))
        if _is(parts[0], "L"):
            lamp = self._names(parts[0][2][0][1]) or self.say["any lamp"]
            phrase = {(): "straight", (_ANYTHING,): "all"}.get(parts[1:])
            if phrase:
                return self.say[phrase].format(lamp)
            if len(parts) == 4 and parts[1:3] == (_ANYTHING, _NOT_MIRROR):
                return self.say["scattered"].format(lamp, self.node(parts[3]))
            if len(parts) > 2 and parts[1] == _ANYTHING:
                return self.say["last"].format(lamp, self._join(parts[2:]))
        if _is(parts[-1], "E"):
            if len(parts) == 1:
                return self.say["view straight"]
            return self.say["view all"] if parts[:-1] == (_ANYTHING,) else self.say["view"].format(self._join(parts[:-1]))
        return self._join(parts)

    def _join(self, parts: Iterable[Tree]) -> str:
        return self.say["then"].join(map(self.node, parts))

    def node(self, tree: Tree) -> str:
        kind = tree[0]
        if kind == "atom":
            return self._atom(tree)
        if kind == "repeat":
            return self._repeat(*tree[1:])
        if kind == "sequence":
            return self.say["group"].format(self._join(tree[1:]))
        return self.say["group"].format(self.say["either"].format(self.say["else"].join(map(self.node, tree[1:]))))

    def _names(self, names: Iterable[str]) -> str:
        return self.say["or"].join(names)

    def _noun(self, letter: str, names: Sequence[str], many: bool) -> str:
        noun = self.say[letter]
        if names:
            return (noun.many_named if many else noun.named).format(self._names(names))
        return noun.many if many else noun.one

    def _atom(self, tree: Tree, many: bool = False) -> str:
        _kind, negated, symbols = tree
        if negated and not symbols:
            return self._noun(".", (), many)
        # Behind "bounces that are not" each thing is told in the singular: "a mirror or glass or a diffuse bounce".
        told = self.say["or"].join(self._noun(letter, names, many and not negated) for letter, names in symbols)
        return self._noun("!", (), many).format(told) if negated else told

    def _repeat(self, child: Tree, low: int, high: int | None) -> str:
        if child[0] != "atom":
            inner = self._join(child[1:]) if child[0] == "sequence" else self.node(child).removeprefix("(").removesuffix(")")
            return self._times(inner, low, high)
        if (low, high) == (0, 1):
            return self.say["maybe"].format(self._atom(child))
        if (low, high) == (1, 1):
            return self._atom(child)
        return self._count(child, low, high)

    def _count(self, child: Tree, low: int, high: int | None) -> str:
        many = self._atom(child, many=True)
        if high is None:
            if low == 0:
                return self.say["any"].format(many)
            if low == 1:
                return self.say["some"].format(self._some(child), many)
            return self.say["least"].format(low, many)
        if high == 0:
            return self.say["none"].format(many)
        if low == high:
            return self.say["exactly"].format(low, many)
        return self.say["between"].format(low, high, many)

    def _some(self, child: Tree) -> str:
        _kind, negated, symbols = child
        return self.say["!" if negated and symbols else symbols[0][0] if symbols else "."].some

    def _times(self, inner: str, low: int, high: int | None) -> str:
        if high is None:
            name = {0: "any times", 1: "some times"}.get(low)
            return self.say[name].format(inner) if name else self.say["least times"].format(low, inner)
        if (low, high) == (0, 1):
            return self.say["maybe"].format(self.say["group"].format(inner))
        if high == 0:
            return self.say["none times"].format(inner)
        if low == high:
            return self.say["exactly times"].format(low, inner)
        return self.say["between times"].format(low, high, inner)


def _is(node: Tree, letter: str) -> bool:
    """A plain atom of this kind alone."""
    return node[0] == "atom" and not node[1] and len(node[2]) == 1 and node[2][0][0] == letter
