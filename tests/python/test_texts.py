# SPDX-License-Identifier: GPL-3.0-or-later
"""The texts that developers read: whatever code cites in them is there, and whatever they name is there.

Each rule is a function from a source tree to a list of complaints. It runs on the repository, where there must be none, and on small bad
examples, where there must be one."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CITING = ("cpp", "bindings", "addon", "tests", "tools")  # folders whose comments cite the texts
TEXTS = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md")
HOW_TO = ("lobe", "light", "effect", "render pass", "exit property", "node")

BREAK = r"(?:\s|//|#)+"  # between words of a comment that runs on in the next line
NUMBER = r"(?:§\s?\d+(?:\.\d+)?|[PRD]\d+)"
CITATION = re.compile(rf"\b([Dd]esign|[Nn]umerics|[Pp]erformance|[Pp]aper){BREAK}({NUMBER}(?:,?(?:{BREAK}and)?{BREAK}{NUMBER})*)")
OF_NUMERICS = re.compile(rf"\b([PRD]\d+){BREAK}of{BREAK}numerics")
WITHOUT_NUMBER = re.compile(r"(?://|#|\().*\b(numerics|performance)\s*:")
FILE_NAME = re.compile(r"[\w-][\w.-]*\.(?:h|cpp|py|md|txt|json|toml|csv)")


# --- reading ------------------------------------------------------------------------------------------------------------------------


def texts(root):
    return sorted(path for pattern in TEXTS for path in root.glob(pattern))


def sources(root):
    found = (path for folder in CITING for ending in ("*.h", "*.cpp", "*.py") for path in (root / folder).rglob(ending))
    return sorted(path for path in found if path.name != Path(__file__).name)  # its examples are bad on purpose


def line_of(text, place):
    return text.count("\n", 0, place) + 1


def read(path):
    return path.read_text() if path.exists() else ""


def headings(text):
    return re.findall(r"^#+ (.+)$", without_code(text), re.MULTILINE)


def without_code(text):
    """The text without its blocks of code; line numbers stay."""
    return re.sub(r"^```.*?^```", lambda block: "\n" * block.group().count("\n"), text, flags=re.MULTILINE | re.DOTALL)


def sections(text):
    return {f"§{number}" for number in re.findall(r"^## (\d+)\. ", text, re.MULTILINE)}


def citable(root):
    """Per text: what may be cited of it."""
    design, numerics, performance = (read(root / f"docs/{name}.md") for name in ("design", "numerics", "performance"))
    return {
        "design": sections(design),
        "numerics": sections(numerics) | set(re.findall(r"^- \*\*([PRD]\d+)\*\* ", numerics, re.MULTILINE)),
        "performance": sections(performance),
        "paper": set(re.findall(r"^- (§\d+(?:\.\d+)?) ", design, re.MULTILINE)),
    }


def citations(text):
    """(place, text, number) of each."""
    for match in CITATION.finditer(text):
        for number in re.findall(NUMBER, match[2]):
            yield match.start(), match[1].lower(), number.replace(" ", "")
    for match in OF_NUMERICS.finditer(text):
        yield match.start(), "numerics", match[1]


def named(text):
    """(place, what) of all that stands between backticks on one line."""
    for match in re.finditer(r"`([^`\n]+)`", without_code(text)):
        yield match.start(), match[1]


def slug(heading):
    """The anchor that a heading gets where Markdown is shown."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


# --- rules --------------------------------------------------------------------------------------------------------------------------


def lost_citations(root):
    known = citable(root)
    complaints = []
    for path in sources(root) + texts(root):
        text = path.read_text()
        complaints += [f"{path.relative_to(root)}:{line_of(text, place)}: {name} {number}" for place, name, number in citations(text) if number not in known[name]]
    return complaints


def citations_without_number(root):
    complaints = []
    for path in sources(root):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if WITHOUT_NUMBER.search(line):
                complaints.append(f"{path.relative_to(root)}:{number}: {line.strip()[:90]}")
    return complaints


def lost_paths(root):
    """Paths between backticks, and names of files without a folder. What is made by builds and runs need not be there."""
    names = {path.name for folder in (*CITING, "blend_scenes") for path in (root / folder).rglob("*")} | {path.name for path in root.iterdir()}
    complaints = []
    for path in texts(root):
        text = path.read_text()
        for place, what in named(text):
            is_path = re.fullmatch(r"\.?\w[\w.-]*(?:/[\w.-]+)*/?", what) and "/" in what and not what.startswith(("out/", "build"))
            if is_path and not (root / what).exists() or FILE_NAME.fullmatch(what) and what not in names:
                complaints.append(f"{path.relative_to(root)}:{line_of(text, place)}: {what}")
    return complaints


def lost_tests(root):
    """Tests that a text names, as Suite.Test or test_name."""
    code = {path: path.read_text() for path in (root / "tests").rglob("*.*") if path.suffix in {".cpp", ".py"}}
    known = {f"{suite}.{test}" for text in code.values() for suite, test in re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", text, re.MULTILINE)}
    suites = {name.split(".")[0] for name in known}
    known |= {name for text in code.values() for name in re.findall(r"^\s*def (test_\w+)", text, re.MULTILINE)}
    complaints = []
    for path in texts(root):
        text = path.read_text()
        for place, what in named(text):
            is_test = re.fullmatch(r"test_\w+", what) or re.fullmatch(r"([A-Z]\w+)\.[A-Za-z]\w+", what) and what.split(".")[0] in suites
            if is_test and what not in known:
                complaints.append(f"{path.relative_to(root)}:{line_of(text, place)}: {what}")
    return complaints


def lost_names(root):
    """Classes and functions that a text names, as `Film` or `compile()`."""
    words = {word for path in sources(root) for word in re.findall(r"\w+", path.read_text())}
    complaints = []
    for path in texts(root):
        text = path.read_text()
        for place, what in named(text):
            name = re.fullmatch(r"([A-Z][a-z]\w*|[a-z]\w*(?=\(\)$))(?:\(\))?", what)
            if name and name[1] not in words:
                complaints.append(f"{path.relative_to(root)}:{line_of(text, place)}: {what}")
    return complaints


def lost_links(root):
    complaints = []
    for path in texts(root):
        text = path.read_text()
        for match in re.finditer(r"\]\(([^)\s]+)\)", without_code(text)):
            target, _, anchor = match[1].partition("#")
            if re.match(r"\w+:", target):
                continue
            other = path.parent / target if target else path
            if not other.exists() or anchor and anchor not in map(slug, headings(other.read_text())):
                complaints.append(f"{path.relative_to(root)}:{line_of(text, match.start())}: {match[1]}")
    return complaints


def unnamed_properties(root):
    """Public names of properties that section 8 of the design does not tell (tests/python/test_tables.py asks the core for those of passes)."""
    design = read(root / "docs/design.md")
    section = re.search(r"^## 8\. .*?(?=^## |\Z)", design, re.MULTILINE | re.DOTALL)
    told = set(re.findall(r"\w+", section.group())) if section else set()
    properties = re.findall(r"^    (\w+): \w+Property\(", read(root / "addon/properties.py"), re.MULTILINE)
    return [name for name in properties if name not in told | {"active_layer"}]  # the panel's own


def unplaced_steps(root):
    """"Adding a …" in CONTRIBUTING.md: numbered steps in order, each beginning with the path that it is about."""
    complaints = []
    parts = re.split(r"^## ", read(root / "CONTRIBUTING.md"), flags=re.MULTILINE)
    for part in (part for part in parts if part.startswith("Adding ")):
        title, steps = part.split("\n", 1)[0], re.findall(r"^(\d+)\. (.*)$", part, re.MULTILINE)
        if not steps:
            complaints.append(f"{title}: no step")
        complaints += [f"{title}: {number}. {step[:50]}" for count, (number, step) in enumerate(steps, 1) if int(number) != count or not re.match(r"`[\w./-]+/?`", step)]
    return complaints


# --- the repository, and for each rule examples that break it and that only look so --------------------------------------------------

DESIGN = "# Design\n\n## 2. Geometry\n\n- §4 Une édition\n- §4.1 Une expression\n"
NUMERICS = "## 1. Quads\n\n- **P8** *Overflow.* A case.\n"
CITED = {"docs/design.md": DESIGN, "docs/numerics.md": NUMERICS}
BAD = {
    lost_citations: [
        {**CITED, "cpp/edit/a.h": "// Quads (design §3).\n"},
        {**CITED, "cpp/edit/a.h": "// Overflow (numerics P8,\n// P9).\n"},
        {**CITED, "cpp/edit/a.h": "// Both, numerics P8 and\n  // §2.\n"},
        {**CITED, "tests/a.py": '"""P9 of numerics §1."""\n'},
        {**CITED, "addon/a.py": "# paper §4.2\n"},
        {**CITED, "docs/architecture.md": "See performance §1.\n"},
        {"cpp/edit/a.h": "// Design §2\n"},
    ],
    citations_without_number: [{"cpp/edit/a.h": "// numerics: gains must not overflow\n"}, {"tools/a.py": "x = 1  # (performance: fast)\n"}],
    lost_paths: [
        {"CONTRIBUTING.md": "1. `cpp/edit/gone.h`: a member\n"},
        {"docs/architecture.md": "the folder `cpp/gone/`\n"},
        {"docs/numerics.md": "in `gone.cpp`\n"},
    ],
    lost_tests: [
        {"tests/cpp/a_test.cpp": "TEST(Quad, IsFlat) {}\n", "docs/numerics.md": "`Quad.IsRound`\n"},
        {"docs/numerics.md": "`test_that_is_gone`\n"},
    ],
    lost_names: [
        {"cpp/a.h": "class Film;\n", "docs/architecture.md": "a `Film` of a `Camera`\n"},
        {"cpp/a.h": "int made();\n", "docs/architecture.md": "`made()` by `compile()`\n"},
    ],
    lost_links: [
        {"README.md": "[design](docs/gone.md)\n"},
        {"docs/design.md": "## Words\n", "README.md": "[words](docs/design.md#geometry)\n"},
        {"README.md": "# One\n[two](#two)\n"},
    ],
    unnamed_properties: [
        {"docs/design.md": "## 8. Names\n`seed`\n", "addon/properties.py": "class A:\n    seed: IntProperty(\n    solo: BoolProperty(name='x')\n"},
        {"docs/design.md": "## 8. Names\n`solo`\n\n## 9. Later\n`seed`\n", "addon/properties.py": "class A:\n    seed: IntProperty(\n"},
    ],
    unplaced_steps: [
        {"CONTRIBUTING.md": "## Adding a lobe\n\n1. Write the shape.\n"},
        {"CONTRIBUTING.md": "## Adding a lobe\n\n1. `cpp/a.h`: shape\n3. `cpp/b.h`: list\n"},
        {"CONTRIBUTING.md": "## Adding a lobe\n\nSoon.\n"},
    ],
}
NOT_BAD = {
    lost_citations: {
        **CITED,
        "cpp/edit/a.h": "// Design §2 and paper §4.1: quads (numerics P8, §1).\n// As Ureña et al. 2013, §9, have it. The design of 3 parts.\n",
        "tests/a.py": '"""P8 of numerics §1; numerics\n§1 too."""\n',
    },
    citations_without_number: {**CITED, "cpp/edit/a.h": "// numerics P8: gains must not overflow\nint performance;\n", "addon/a.py": "SLUICE_PT_performance\n"},
    lost_paths: {"CONTRIBUTING.md": "`cpp/edit/a.h`, `a.h`, `out/test/`, `L/D*`, `./run test`, `ctest -R a/b`\n```\n`cpp/gone.h`\n```\n", "cpp/edit/a.h": ""},
    lost_tests: {"tests/cpp/a_test.cpp": "TEST(Quad, IsFlat) {}\n", "docs/numerics.md": "`Quad.IsFlat`, `Film.width`, `test_there`\n", "tests/python/test_a.py": "def test_there():\n"},
    lost_names: {"cpp/a.h": "class Film;\nint made();\n", "docs/design.md": "`Film`, `made()`, `LS+`, `D'Wall'`, `ENTRY`, `hue_shift`\n"},
    lost_links: {"docs/design.md": "## 2. Words, and more\n", "README.md": "[words](docs/design.md#2-words-and-more) [far](https://example.org/x)\n"},
    unnamed_properties: {"docs/design.md": "## 8. Names\n`seed`, Depth\n", "addon/properties.py": "class A:\n    seed: IntProperty(\n    kept: int = 3\n"},
    unplaced_steps: {"CONTRIBUTING.md": "## Style\n\n1. Short.\n\n## Adding a lobe\n\n1. `cpp/a.h`: shape\n2. `docs/`: word\n"},
}


def tree(root, files):
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


@pytest.mark.parametrize("rule", BAD, ids=lambda rule: rule.__name__)
def test_repository(rule):
    assert rule(ROOT) == []


@pytest.mark.parametrize("rule, files", [(rule, files) for rule, examples in BAD.items() for files in examples], ids=lambda value: getattr(value, "__name__", ""))
def test_rule_can_fail(rule, files, tmp_path):
    assert len(rule(tree(tmp_path, files))) == 1


@pytest.mark.parametrize("rule", NOT_BAD, ids=lambda rule: rule.__name__)
def test_rule_spares_the_innocent(rule, tmp_path):
    assert rule(tree(tmp_path, NOT_BAD[rule])) == []


def test_the_rules_look_at_something():
    """Each text can be cited and is, and each how-to is there."""
    known = citable(ROOT)
    assert all(known.values())
    cited = {name for path in sources(ROOT) for _, name, _ in citations(path.read_text())}
    assert cited == set(known)
    contributing = (ROOT / "CONTRIBUTING.md").read_text()
    assert [name for name in HOW_TO if not re.search(rf"^## Adding an? {name}$", contributing, re.MULTILINE)] == []


def test_texts_are_tracked():
    """A clone has them."""
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "docs", "*.md"], capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("no repository")
    assert {str(path.relative_to(ROOT)) for path in texts(ROOT)} <= set(listed.stdout.split())
