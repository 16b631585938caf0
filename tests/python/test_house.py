# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of the house: which room may use which, who may include what, how long files and functions may be.

Every rule is a function from a source tree to a list of complaints. It runs on the repository, where there must be none, and on a
small bad example, where there must be one: a rule that cannot fail is no rule."""

import ast
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MAX_FILE_LINES = 450  # at 110 columns in C++
MAX_COLUMNS = 110
MAX_FUNCTION_LINES = 60
MAX_PARAMETERS = 6
SIGNED_BY_BLENDER = {"draw_item"}  # callbacks whose parameters are not ours to choose

# base <- {expr <- edit, shading} <- scene <- transport <- render <- bindings
MAY_USE = {
    "base": set(),
    "expr": {"base"},
    "edit": {"base", "expr"},
    "shading": {"base"},
    "scene": {"base", "expr", "edit", "shading"},
    "transport": {"base", "expr", "edit", "shading", "scene"},
    "render": {"base", "expr", "edit", "shading", "scene", "transport"},
    "bindings": {"base", "expr", "edit", "shading", "scene", "transport", "render"},
}


# The same within transport: what both sides share <- photons <- view <- guide
TRANSPORT = {"": {""}, "photons": {"", "photons"}, "view": {"", "photons", "view"}, "guide": {"", "photons", "view", "guide"}}


# --- reading ------------------------------------------------------------------------------------------------------------------------


def cpp_files(root, *folders):
    """C++ files below the folders (all of ours when none is named), in a fixed order."""
    places = folders or ("cpp", "bindings", "tests/cpp")
    return sorted(p for folder in places for ext in ("*.h", "*.cpp") for p in (root / folder).rglob(ext))


def python_files(root, *folders):
    places = folders or ("addon", "tools", "blend_scenes", "tests")
    return sorted(p for folder in places for p in (root / folder).rglob("*.py"))


def code_of(path):
    """A C++ file without comments and the insides of its strings; line numbers stay."""
    pattern = r'//[^\n]*|/\*.*?\*/|R"\((?:.*?)\)"|"(?:\\.|[^"\\\n])*"' + r"|'(?:\\.|[^'\\\n])'"
    keep_lines = lambda match: '""' + "\n" * match.group().count("\n")  # noqa: E731
    return re.sub(pattern, keep_lines, path.read_text(), flags=re.DOTALL)


def includes(path):
    return [(line, a or b) for line, text in enumerate(path.read_text().splitlines(), 1)
            for a, b in re.findall(r'^\s*#\s*include\s*(?:<([^>]+)>|"([^"]+)")', text)]  # fmt: skip


def found(root, files, pattern):
    """file:line: match for each place where the code matches."""
    places = []
    for path in files:
        for number, line in enumerate(code_of(path).splitlines(), 1):
            places += [f"{path.relative_to(root)}:{number}: {m.group()}" for m in re.finditer(pattern, line)]
    return places


def who_includes(root, pattern):
    return sorted({str(p.relative_to(root)) for p in cpp_files(root) for _, name in includes(p) if re.search(pattern, name)})


# --- rules --------------------------------------------------------------------------------------------------------------------------


def wrong_arrows(root):
    complaints = []
    for room, used in MAY_USE.items():
        for path in cpp_files(root, room if room == "bindings" else f"cpp/{room}"):
            for line, name in includes(path):
                target = name.split("/")[0]
                where = f"{path.relative_to(root)}:{line}: {name}"
                if target in MAY_USE and target != room and target not in used:
                    complaints.append(where)
                elif target in MAY_USE and not (root / "cpp" / name).exists() and not (root / name).exists():
                    complaints.append(where + " does not exist")
    return complaints


def wrong_folders(root):
    """Folders of transport that use what is not theirs to use."""
    complaints = []
    for path in cpp_files(root, "cpp/transport"):
        folder = "/".join(path.relative_to(root / "cpp/transport").parts[:-1])
        for line, name in includes(path):
            if name.startswith("transport/") and "/".join(name.split("/")[1:-1]) not in TRANSPORT[folder]:
                complaints.append(f"{path.relative_to(root)}:{line}: {name}")
    return complaints


def wide_comments(root):
    """Lines of C++ beyond the limit of .clang-format, which wraps code and leaves comments alone."""
    return [f"{p.relative_to(root)}:{number}: {len(line)} columns" for p in cpp_files(root)
            for number, line in enumerate(p.read_text().splitlines(), 1) if len(line) > MAX_COLUMNS]


def wrong_targets(dot):
    """Complaints about the targets' own links, read from the graph that CMake writes."""
    names = dict(re.findall(r'"(node\d+)" \[ label = "([^"\\]+)', dot))
    complaints = []
    for a, b in re.findall(r'"(node\d+)" -> "(node\d+)"', dot):
        user, used = names[a], names[b]
        room, target = user.removeprefix("sluice_"), used.removeprefix("sluice_")
        room, target = ({"core": "bindings"}.get(name, name) for name in (room, target))
        if room in MAY_USE and target in MAY_USE and target != room and target not in MAY_USE[room]:
            complaints.append(f"{user} links {used}")
        if user.startswith("sluice_") and ("embree" in used and room != "scene" or "OpenImageIO" in used and room != "base"):
            complaints.append(f"{user} links {used}")
    return complaints


def embree_elsewhere(root):
    return [p for p in who_includes(root, "embree[34]") if p != "cpp/scene/embree.cpp"]


def image_library_elsewhere(root):
    return [p for p in who_includes(root, "OpenImageIO") if p != "cpp/base/image.cpp"]


def python_in_core(root):
    return [p for p in who_includes(root, r"pybind11|^Python\.h$") if not p.startswith("bindings/")]


def blender_in_exporters(root):
    """Exporters run without Blender: they may import it for mypy alone."""
    complaints = []
    for path in python_files(root, "addon/export"):
        tree = ast.parse(path.read_text())
        tree.body = [node for node in tree.body if not (isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING")]
        for node in ast.walk(tree):
            modules = [a.name for a in node.names] if isinstance(node, ast.Import) else [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            complaints += [f"{path.relative_to(root)}:{node.lineno}: {m}" for m in modules if m.split(".")[0] in {"bpy", "bpy_extras", "gpu"}]
    return complaints


def interface_among_itself(root):
    """Modules of the add-on that give Blender classes (SLUICE_…) are imported by its __init__ alone, which registers them: what two
    of them need stands in model.py, checking.py or interface.py."""
    trees = {path: ast.parse(path.read_text()) for path in python_files(root, "addon")}
    shown = {path.stem for path, tree in trees.items() if any(isinstance(node, ast.ClassDef) and node.name.startswith("SLUICE_") for node in tree.body)}
    complaints = []
    for path, tree in trees.items():
        if path == root / "addon" / "__init__.py":
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.level:
                names = [alias.name for alias in node.names] if node.module is None else [node.module]
                complaints += [f"{path.relative_to(root)}:{node.lineno}: {name}" for name in names if name in shown]
    return complaints


def untold_functions(root):
    """The add-on's public functions and methods tell the types of what they take and return (mypy checks them), and functions what they do."""
    complaints = []
    for path in python_files(root, "addon"):
        tree = ast.parse(path.read_text())
        methods = [node for cls in tree.body if isinstance(cls, ast.ClassDef) for node in cls.body]
        for node in [*tree.body, *methods]:
            if not isinstance(node, ast.FunctionDef) or node.name.startswith("_") and node.name != "__init__":
                continue
            arguments = node.args.posonlyargs + node.args.args + node.args.kwonlyargs + [a for a in (node.args.vararg, node.args.kwarg) if a]
            typed = node.returns is not None and all(a.annotation is not None for a in arguments if a.arg not in {"self", "cls"})
            told = node in methods or node.name in {"register", "unregister"} or ast.get_docstring(node)
            if not typed or not told:
                complaints.append(f"{path.relative_to(root)}:{node.lineno}: {node.name}")
    return complaints


def imports_of_tests(root):
    """What several tests need stands in a module of helpers or in conftest.py: whoever changes a test changes no other one."""
    complaints = []
    for path in python_files(root, "tests"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and not node.level and (node.module or "").startswith("test_"):
                complaints.append(f"{path.relative_to(root)}:{node.lineno}: {node.module}")
    return complaints


def printing(root):
    return found(root, cpp_files(root, "cpp"), r"\bstd::(cout|cerr|clog|exit|quick_exit|abort|terminate)\b|\bv?f?printf\b|\b(exit|abort|puts|_Exit)\s*\(")


def threads_elsewhere(root):
    files = [p for p in cpp_files(root, "cpp", "bindings") if p.relative_to(root / "cpp" if "cpp" in p.parts else root).with_suffix("") != Path("base/threads")]
    return found(root, files, r"\bstd::(jthread|thread|async)\b|\btbb::|#\s*pragma\s+omp|\bpthread_create\b")


def indirect_calls(root):
    """Per-path code decides by std::variant or a switch, never through a pointer (style: closed sets)."""
    return (found(root, cpp_files(root, "cpp"), r"\bvirtual\b")
            + found(root, cpp_files(root, "cpp/transport", "cpp/shading", "cpp/edit", "cpp/expr"), r"\bstd::(function|any)\b"))  # fmt: skip


def long_files(root):
    return [f"{p.relative_to(root)}: {n} lines" for p in cpp_files(root) + python_files(root) if (n := len(p.read_text().splitlines())) > MAX_FILE_LINES]


def long_functions(root):
    complaints = []
    for path in cpp_files(root, "cpp", "bindings"):  # definitions at the left margin: from "…) {" to the "}" below it
        start = None
        for number, line in enumerate(code_of(path).splitlines(), 1):
            if re.match(r"[A-Za-z}].*\).*\{\s*$", line) and not line.startswith("namespace"):
                start = number
            elif line.rstrip() == "}" and start is not None:
                if number - start + 1 > MAX_FUNCTION_LINES:
                    complaints.append(f"{path.relative_to(root)}:{start}: {number - start + 1} lines")
                start = None
    for path in python_files(root):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                names = [a.arg for a in node.args.posonlyargs + node.args.args + node.args.kwonlyargs]
                length, parameters = node.end_lineno - node.lineno + 1, len([name for name in names if name not in {"self", "cls"}])
                if length > MAX_FUNCTION_LINES or (parameters > MAX_PARAMETERS and node.name not in SIGNED_BY_BLENDER):
                    complaints.append(f"{path.relative_to(root)}:{node.lineno}: {node.name}: {length} lines, {parameters} parameters")
    return complaints


def without_licence(root):
    return [str(p.relative_to(root)) for p in cpp_files(root) + python_files(root) if p.read_text().strip() and "SPDX-License-Identifier: GPL-3.0-or-later" not in p.read_text().split("\n", 1)[0]]


def without_docstring(root):
    return [str(p.relative_to(root)) for p in python_files(root) if p.read_text().strip() and not ast.get_docstring(ast.parse(p.read_text()))]


def left_over_marks(root):
    marks = re.compile("|".join(["TO" + "DO", "FIX" + "ME", r"/wo" + r"rk/", r"/tm" + r"p/[a-z]"]))
    return [f"{p.relative_to(root)}:{n}: {line.strip()[:80]}" for p in cpp_files(root) + python_files(root) for n, line in enumerate(p.read_text().splitlines(), 1) if marks.search(line)]


# --- the repository, and for each rule an example that breaks it -------------------------------------------------------------------

SPDX = "// SPDX-License-Identifier: GPL-3.0-or-later\n"
BAD = {
    wrong_arrows: ("cpp/edit/a.cpp", '#include "scene/scene.h"\n'),
    wrong_folders: ("cpp/transport/photons/a.cpp", '#include "transport/view/sample.h"\n'),
    wide_comments: ("cpp/base/a.h", "// " + "a " * MAX_COLUMNS + "\n"),
    embree_elsewhere: ("cpp/transport/a.cpp", "#include <embree4/rtcore.h>\n"),
    image_library_elsewhere: ("cpp/shading/a.cpp", "#include <OpenImageIO/imageio.h>\n"),
    python_in_core: ("cpp/render/a.cpp", "#include <pybind11/pybind11.h>\n"),
    blender_in_exporters: ("addon/export/a.py", "def f():\n    from bpy.types import Object\n"),
    interface_among_itself: ("addon/a.py", "from .a import f\n\n\nclass SLUICE_OT_a:\n    pass\n"),
    untold_functions: ("addon/a.py", 'def f(x) -> None:\n    """Does it."""\n'),
    imports_of_tests: ("tests/python/test_a.py", "def test_it():\n    from test_b import helper\n"),
    printing: ("cpp/base/a.cpp", 'void f() { std::printf("x"); }\n'),
    threads_elsewhere: ("cpp/render/a.cpp", "std::jthread worker;\n"),
    indirect_calls: ("cpp/transport/a.h", "std::function<void()> next;\n"),
    long_files: ("cpp/base/a.h", "\n" * (MAX_FILE_LINES + 1)),
    long_functions: ("cpp/base/a.cpp", "void f(int a) {\n" + "  g();\n" * MAX_FUNCTION_LINES + "}\n"),
    without_licence: ("tools/a.py", "x = 1\n"),
    without_docstring: ("tools/a.py", "x = 1\n"),
    left_over_marks: ("tools/a.py", "# TO" + "DO: later\n"),
}
NOT_BAD = {  # what a careless rule would take for a breach
    wrong_arrows: ("cpp/scene/a.cpp", '#include <vector>\n// #include "render/session.h"\n'),
    interface_among_itself: ("addon/a.py", "from . import core\nfrom .interface import Panel\n\n\nclass SLUICE_PT_a(Panel):\n    pass\n"),
    untold_functions: ("addon/a.py", 'def f(x: int) -> None:\n    """Does it."""\n\n\ndef _g(x):\n    pass\n\n\nclass A:\n    def h(self) -> None:\n        pass\n'),
    blender_in_exporters: ("addon/export/a.py", "if TYPE_CHECKING:\n    import bpy\n"),
    printing: ("cpp/base/a.cpp", '// std::cout is for others\nauto text = "exit(1)"; std::snprintf(b, n, "%d", 1);\n'),
    threads_elsewhere: ("cpp/base/threads.cpp", "std::jthread worker; std::this_thread::yield();\n"),
    long_functions: ("cpp/base/a.cpp", ("void f(int a) {\n" + "  g();\n" * 40 + "}\n") * 2),
}


@pytest.mark.parametrize("rule", BAD, ids=lambda rule: rule.__name__)
def test_repository(rule):
    assert rule(ROOT) == []


@pytest.mark.parametrize("rule", BAD, ids=lambda rule: rule.__name__)
def test_rule_can_fail(rule, tmp_path):
    name, text = BAD[rule]
    (tmp_path / name).parent.mkdir(parents=True)
    (tmp_path / name).write_text(text)
    assert len(rule(tmp_path)) == 1


@pytest.mark.parametrize("rule", NOT_BAD, ids=lambda rule: rule.__name__)
def test_rule_spares_the_innocent(rule, tmp_path):
    name, text = NOT_BAD[rule]
    (tmp_path / name).parent.mkdir(parents=True)
    (tmp_path / name).write_text(text)
    assert rule(tmp_path) == []


def test_each_room_has_code():
    """The rules above look at something: every room is there, and so are the two files that wrap a library."""
    assert [room for room in MAY_USE if not cpp_files(ROOT, room if room == "bindings" else f"cpp/{room}")] == []
    assert who_includes(ROOT, "embree[34]") == ["cpp/scene/embree.cpp"]
    assert who_includes(ROOT, "OpenImageIO") == ["cpp/base/image.cpp"]


def test_cmake_targets_follow_the_arrows(tmp_path):
    """CMake's own graph of targets, from a configuration made here: what is linked, not what a list says."""
    graph = tmp_path / "graph.dot"
    command = ["cmake", "-G", "Ninja", "-S", ROOT, "-B", tmp_path / "build", f"--graphviz={graph}", "-DSLUICE_TESTS=OFF"]
    subprocess.run(command, check=True, capture_output=True)
    assert "sluice_base" in graph.read_text()
    assert wrong_targets(graph.read_text()) == []


def test_cmake_rule_can_fail():
    bad = '"node0" [ label = "sluice_edit", shape = octagon ];\n"node1" [ label = "sluice_scene", shape = octagon ];\n"node0" -> "node1" // x\n'
    assert wrong_targets(bad) == ["sluice_edit links sluice_scene"]


def test_lint():
    """ruff, with the rules of pyproject.toml (./run setup puts it into .venv)."""
    ruff = ROOT / ".venv/bin/ruff"
    if not ruff.exists():
        pytest.skip("no ruff in .venv")
    result = subprocess.run([ruff, "check", "--no-cache", ROOT], capture_output=True, text=True)
    assert result.returncode == 0, result.stdout


def test_types():
    """mypy, with the settings of pyproject.toml and types of Blender 3.4 (./run setup puts both into .venv)."""
    mypy = ROOT / ".venv/bin/mypy"
    if not mypy.exists():
        pytest.skip("no mypy in .venv")
    result = subprocess.run([mypy], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout


@pytest.mark.skipif(not os.environ.get("SLUICE_FULL"), reason="in the full form alone: it takes minutes")
def test_tidy():
    """clang-tidy, with the settings of .clang-tidy, on every source file of the core and the bindings."""
    program, build = ROOT / ".venv/bin/clang-tidy", Path(os.environ.get("SLUICE_CORE", ROOT / "build"))
    if not program.exists():
        pytest.skip("no clang-tidy in .venv")
    sources = sorted([*(ROOT / "cpp").rglob("*.cpp"), *(ROOT / "bindings").glob("*.cpp")])
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = pool.map(lambda source: subprocess.run([program, "-p", build, "--quiet", source], capture_output=True, text=True), sources)
    assert not (found := "".join(result.stdout for result in results if result.returncode)), found


def test_format():
    """clang-format, with the settings of .clang-format (./run setup puts it into .venv, always the same version)."""
    program = ROOT / ".venv/bin/clang-format"
    if not program.exists():
        pytest.skip("no clang-format in .venv")
    result = subprocess.run([program, "--dry-run", "--Werror", *cpp_files(ROOT), *ROOT.glob("tests/bench/*.cpp")], capture_output=True, text=True)
    assert result.returncode == 0, f"run {program.relative_to(ROOT)} -i on\n" + "\n".join(sorted(set(re.findall(r"^(\S+?):\d+", result.stderr, re.MULTILINE))))


def test_summary_counts_and_refuses_empty_suites(tmp_path):
    """tools/test_summary.py, which decides whether ./run test has passed."""
    def summary(*suites):
        return subprocess.run([sys.executable, ROOT / "tools/test_summary.py", tmp_path, *suites], capture_output=True, text=True)

    (tmp_path / "good.xml").write_text('<testsuites><testsuite><testcase name="a" time="1"/><testcase name="b"><skipped message="why"/></testcase></testsuite></testsuites>')
    (tmp_path / "bad.xml").write_text('<testsuite><testcase name="a"><failure/></testcase></testsuite>')
    (tmp_path / "empty.xml").write_text("<testsuite/>")
    assert summary("good").returncode == 0
    assert summary("good").stdout.endswith("1 passed, 0 failed, 1 skipped\n")
    assert [summary("good", other).returncode for other in ("bad", "empty", "absent")] == [1, 1, 1]
