# SPDX-License-Identifier: GPL-3.0-or-later
"""Names in the text of expressions: which there are, how to put one in, how to exchange one for another. No bpy; text that is no
expression is left alone where it cannot be understood."""
from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

_SYMBOL = re.compile(r"(?P<kind>[LEDSGFXC])(?P<gap>\s*)(?P<names>'(?:\\.|[^'\\])*')?", re.DOTALL)


def quoted(names: Iterable[str]) -> str:
    """'Egg,Ball', each name with its \\ ' and , escaped."""
    return "'" + ",".join(re.sub(r"([\\',])", r"\\\1", name) for name in names) + "'"


def _split(text: str) -> list[str]:
    """The names between two quotes, as they are."""
    return [re.sub(r"\\(.)", r"\1", name, flags=re.DOTALL) for name in re.findall(r"(?:\\.|[^,\\])+", text[1:-1], re.DOTALL)]


def _named(text: str) -> list[tuple[str, str]]:
    """(event, name) of each name that an expression uses, in its order."""
    return [(symbol["kind"], name) for symbol in _SYMBOL.finditer(text) if symbol["names"] for name in _split(symbol["names"])]


def names_in(text: str) -> set[str]:
    """Every name that an expression uses."""
    return {name for _event, name in _named(text)}


def last_in(text: str) -> tuple[str, str]:
    """(event, name) of the last name that an expression uses; ("", "") if it uses none."""
    return (_named(text) or [("", "")])[-1]


def renamed(text: str, changes: Mapping[str, list[str]]) -> str:
    """The expression with each name that `changes` holds exchanged for those it says: {'Egg': ['Ball']}. Others stay as written."""
    def exchange(symbol: re.Match[str]) -> str:
        names = _split(symbol["names"]) if symbol["names"] else []
        if not any(name in changes for name in names):
            return symbol[0]
        new = [other for name in names for other in changes.get(name, [name])]
        return symbol["kind"] + symbol["gap"] + quoted(dict.fromkeys(new))

    return _SYMBOL.sub(exchange, text)


def with_name(text: str, kind: str, name: str) -> str:
    """The expression with one more name: on the last symbol of this kind that has none (LS+ becomes LS'Egg'+), else as one more
    event of the path, before the eye if it ends there."""
    bare = [symbol for symbol in _SYMBOL.finditer(text)
            if symbol["kind"] == kind and not symbol["names"] and not text[:symbol.start()].rstrip().endswith("!")]
    if bare:
        at = bare[-1].end("kind")
        return text[:at] + quoted([name]) + text[at:]
    end = len(text.rstrip())
    if text[:end].endswith(("E", "C")) and kind != "E":
        end -= 1
    return text[:end] + kind + quoted([name]) + text[end:]
