# SPDX-License-Identifier: GPL-3.0-or-later
"""The oracle of expressions (design section 3): Python's `re`. Events become letters and symbols become classes of letters, so that
an expression of ours and a pattern of `re` say the same. All words up to length 8 over three events, and random words over all kinds
and names."""

import itertools
import random
import re

import numpy as np
import pytest
import sluice_core

# Every event that words are made of: kind and names. One letter each.
EVENTS = [
    *((kind, names) for kind in "LEDSG" for names in ((), ("Egg",), ("Floor", "Room"), ("it's, a \\",), ("Стена",))),
    *(("F", names) for names in ((), ("Move",), ("Egg", "Room"))),
]
LETTERS = [chr(ord("A") + i) if i < 26 else chr(ord("a") + i - 26) for i in range(len(EVENTS))]
NAMES = ["Egg", "Floor", "Room", "it's, a \\", "Стена", "Move", "egg", "Nobody"]
KINDS = {"L": "L", "E": "E", "C": "E", "D": "DG", "S": "SG", "G": "G", "F": "F", "X": "DSG"}  # glossy is D|S
INTERACTIONS = "DSGF"


def quoted(names):
    return "'" + ",".join(re.sub(r"([\\',])", r"\\\1", name) for name in names) + "'" if names else ""


def letters_of(symbols, negated):
    """The letters of the events that a set of symbols matches (or, negated, of the interactions that it does not)."""
    found = {
        letter
        for letter, (kind, names) in zip(LETTERS, EVENTS, strict=True)
        if any(kind in KINDS[k] and (not wanted or set(wanted) & set(names)) for k, wanted in symbols)
    }
    if negated:
        found = {letter for letter, (kind, _) in zip(LETTERS, EVENTS, strict=True) if kind in INTERACTIONS} - found
    return "[" + "".join(sorted(found)) + "]" if found else "(?!)"


class Generator:
    """Random expressions, each as our text and as a pattern of `re`."""

    def __init__(self, seed):
        self.random = random.Random(seed)

    def space(self):
        return self.random.choice(["", "", "", " ", "\t "])

    def symbol(self):
        kind = self.random.choice("LECDSGFX" + "DSX" * 2)
        names = self.random.sample(NAMES, self.random.choice([0, 0, 0, 1, 1, 2]))
        return kind + self.space() + quoted(names), (kind, names)

    def symbols(self, fewest):
        texts, symbols = zip(*(self.symbol() for _ in range(self.random.randint(fewest, 3))), strict=True)
        return texts, symbols

    def atom(self):
        form = self.random.randrange(6)
        if form == 0:
            return ".", letters_of([], True)
        if form == 1:
            text, symbol = self.symbol()
            return "!" + self.space() + text, letters_of([symbol], True)
        if form == 2:
            texts, symbols = self.symbols(1)
            return "!(" + (self.space() + "|").join(texts) + ")", letters_of(symbols, True)
        if form == 3:
            texts, symbols = self.symbols(1)
            negated = self.random.random() < 0.5
            return "[" + "^" * negated + self.space().join(texts) + "]", letters_of(symbols, negated)
        text, symbol = self.symbol()
        return text, letters_of([symbol], False)

    def expression(self, depth, repeats=2):
        """`repeats`: how deep repetitions may be nested, as `re` takes exponential time for ((a*)*)*."""
        form = self.random.randrange(7 if repeats else 5) if depth else 0
        if form < 2:
            return self.atom()
        if form < 4:
            parts = [self.expression(depth - 1, repeats) for _ in range(self.random.randint(2, 3))]
            return self.space().join(f"({a})" if "|" in a else a for a, _ in parts), "".join(f"(?:{b})" for _, b in parts)
        if form == 4:
            parts = [self.expression(depth - 1, repeats) for _ in range(self.random.randint(2, 3))]
            return "|".join(a for a, _ in parts), "|".join(f"(?:{b})" for _, b in parts)
        text, pattern = self.expression(depth - 1, repeats - 1)
        low, more = self.random.randrange(3), self.random.randrange(3)
        ours = self.random.choice(["*", "+", "?", f"{{{low}}}", f"{{{low},}}", f"{{ {low} ,{low + more} }}"])
        return f"({text}){ours}", f"(?:{pattern}){ours.replace(' ', '')}"


class Words:
    """Words as rows for us, and as one text with a line each for `re`, which so runs once per expression."""

    def __init__(self, words):
        self.words = words
        self.rows = np.full((len(words), max(map(len, words))), 255, np.uint8)
        for row, word in zip(self.rows, words, strict=True):
            row[: len(word)] = word
        self.text = "".join("".join(LETTERS[e] for e in word) + "\n" for word in words)
        self.starts = np.cumsum([0] + [len(word) + 1 for word in words])

    def accepted_by_re(self, pattern):
        found = np.zeros(len(self.words) + 1, np.uint8)  # one more for the nothing behind the last line
        matches = re.finditer(f"^(?:{pattern})$", self.text, re.MULTILINE)
        found[np.searchsorted(self.starts, [match.start() for match in matches])] = 1
        return found[:-1]


EVENT_TEXTS = [kind + quoted(names) for kind, names in EVENTS]


@pytest.mark.parametrize("seed", range(8))
def test_agrees_with_re(seed):
    """250 expressions on every word up to length 8 over three events that may begin paths, meet the names and end paths, and on
    random words over everything."""
    generator = Generator(seed)
    three = [EVENT_TEXTS.index(text) for text in generator.random.sample(["L", "D'Floor,Room'", "S'Egg'", "G", "D", "F'Move'", "S"], 2) + ["G'Egg'"]]
    short = Words([word for length in range(9) for word in itertools.product(three, repeat=length)])
    accepted = refused = 0
    for _ in range(250):
        text, pattern = generator.expression(4)
        while len(text) > 1000:
            text, pattern = generator.expression(4)
        long = Words([generator.random.choices(range(len(EVENTS)), k=generator.random.randrange(12)) for _ in range(100)])
        for words in (short, long):
            theirs = words.accepted_by_re(pattern)
            ours = sluice_core.accepts_many(text, EVENT_TEXTS, words.rows)
            wrong = np.flatnonzero(np.asarray(ours) != theirs)
            assert not wrong.size, (text, pattern, [[EVENT_TEXTS[e] for e in words.words[i]] for i in wrong[:3]])
            accepted += int(theirs.sum())
            refused += int(len(theirs) - theirs.sum())
    assert accepted > 1000 and refused > 1000


def test_words_one_by_one():
    accepts = sluice_core.accepts
    assert accepts("L.*S'Egg'D", ["L", "D", "S'Egg'", "D'Floor'"])
    assert accepts("LS+DE", ["L", "S'Egg,Glass things'", "G'Egg'", "D", "E"])
    assert not accepts("L.*S'Egg'D", ["L", "S'egg'", "D'Floor'"])
    assert accepts("(!F'Move')*", [])
    assert accepts(r"D'it\'s'", [r"D'it\'s'"])


@pytest.mark.parametrize(("text", "column"), [("L(S", 2), ("", 1), ("LS**", 4), ("LD'Floor", 3), ("L D 'Floor' Ü", 13), ("L{3,2}", 5), ("L" + "." * 300, None)])
def test_errors_are_value_errors_with_a_column(text, column):
    with pytest.raises(ValueError) as caught:
        sluice_core.accepts(text, ["L"])
    assert isinstance(caught.value, sluice_core.ExpressionError)
    assert caught.value.column == column if column else caught.value.column >= 1


@pytest.mark.parametrize("event", ["", "X", "LD", "S'Egg", ".", "!D"])
def test_events_are_checked(event):
    with pytest.raises(ValueError):
        sluice_core.accepts("L", [event])
