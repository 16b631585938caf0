# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of lobes and kinds of lights are closed sets: one that forgets a case must not compile. Each test lays a changed copy of a header
before the core's own and asks the compiler to read, without making code, the files that ask every alternative."""
import shutil
import subprocess
from pathlib import Path

import pytest

CPP = Path(__file__).resolve().parents[2] / "cpp"
COMPILER = shutil.which("c++")
IMATH = "/usr/include/Imath"
pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C++ compiler")

# A shape that is sampled by the cosine, and one that is not: what each must say, line by line
COSINE = {
    "sampling": "static constexpr auto sampling = Sampling::Cosine;",
    "side": "static constexpr auto side = LeavesOn::NearSide;",
    "response": "static constexpr auto response = Response::Broad;",
    "eval_shape": "Color eval_shape(const Extra&, const V3f&, const V3f&) noexcept;",
    "albedo_shape": "Color albedo_shape(const Extra&, float) noexcept;",
}
PEAKED = {
    **COSINE,
    "sampling": "static constexpr auto sampling = Sampling::Own;",
    "response": "static constexpr auto response = Response::Peaked;",
    "pdf_shape": "float pdf_shape(const Extra&, const V3f&, const V3f&) noexcept;",
    "sample_shape": "bool sample_shape(const Extra&, const V3f&, const V2f&, ShapeSample&) noexcept;",
    "is_delta": "bool is_delta(const Extra&) noexcept;",
}
LIGHT = {
    "infinite": "static constexpr bool infinite = false;",
    "crossable": "static constexpr bool crossable = true;",
    "kinds::is_delta": "bool is_delta(const Extra&) noexcept;",
    "kinds::sample_direct": "std::optional<DirectSample> sample_direct(const Parts&, const Extra&, const V3d&, float, const V2f&) noexcept;",
    "kinds::pdf_direct": "float pdf_direct(const Parts&, const Extra&, const V3d&, const V3f&, const Hit*) noexcept;",
    "kinds::crossing": "std::optional<LampCrossing> crossing(const Extra&, const V3d&, const V3f&) noexcept;",
    "kinds::sample_position": "std::optional<EmissionPoint> sample_position(const Parts&, const Extra&, float, const V2f&) noexcept;",
    "kinds::sample_direction": "std::optional<EmissionDirection> sample_direction(const Parts&, const Extra&, const EmissionPoint&, float, const V2f&) noexcept;",
    "kinds::pdf_direction": "float pdf_direction(const Parts&, const Extra&, const EmissionPoint&, const V3f&) noexcept;",
    "kinds::eval_emission": "Color eval_emission(const Parts&, const Extra&, const EmissionPoint&, const V3f&) noexcept;",
    "kinds::is_dark": "bool is_dark(const Extra&, const V3d&) noexcept;",
    "kinds::emission_cone": "DirectionCone emission_cone(const Extra&) noexcept;",
}
INFINITE_LIGHT = {
    "infinite": "static constexpr bool infinite = true;",
    "crossable": "static constexpr bool crossable = false;",
    "kinds::is_delta": LIGHT["kinds::is_delta"],
    "kinds::common_direction": "std::optional<V3f> common_direction(const Extra&) noexcept;",
    "kinds::sample_towards": "std::optional<EmissionDirection> sample_towards(const Extra&, const V2f&) noexcept;",
    "kinds::pdf_towards": "float pdf_towards(const Extra&, const V3f&) noexcept;",
    "kinds::radiance": "Color radiance(const Parts&, const Extra&, const V3f&, bool) noexcept;",
    "kinds::irradiance_bound": "float irradiance_bound(const Extra&, float, const V3f&) noexcept;",
    "kinds::directions_to": "DirectionBall directions_to(const Extra&) noexcept;",
}
# The file that asks for an overload, where it is not light.cpp
ASKED_BY = {"kinds::is_dark": "light_choice", "kinds::irradiance_bound": "light_choice", "kinds::emission_cone": "light_tree_build",
            "kinds::directions_to": "light_tree_build"}  # fmt: skip
# A value of LightKind: what must name it, as {the line before which it stands: what is put there}
LAMP = {
    "name_of": ('case LightKind::Point: return "Point";', 'case LightKind::Extra: return "Extra";'),
    "has_direction": ("case LightKind::Point: return false;", "case LightKind::Extra: return false;"),
    "make_lamp": ("case LightKind::Sun: return make_sun(d);", "case LightKind::Extra: return make_sphere_lamp(d, centre);"),
}


def put(text, before, added):
    assert text.count(before) == 1, before
    return text.replace(before, added + before)


def lobes_with(facts):
    """lobes.h with one more shape that says so much of itself."""
    text = (CPP / "shading/lobes.h").read_text()
    members = " ".join(fact for fact in facts.values() if fact.startswith("static"))
    overloads = "\n".join(fact for fact in facts.values() if not fact.startswith("static"))
    text = put(text, "using LobeShape =", f"struct Extra {{ {members} }};\n").replace("std::variant<Lambert,", "std::variant<Extra, Lambert,")
    return put(text, "[[nodiscard]] Color eval_shape(const Lambert&,", overloads + "\n")


def lights_with(facts):
    """light.h and light_kinds.h with one more kind."""
    light, kinds = (CPP / "scene/light.h").read_text(), (CPP / "scene/light_kinds.h").read_text()
    members = " ".join(fact for name, fact in facts.items() if "::" not in name)
    overloads = "\n".join(fact for name, fact in facts.items() if "::" in name)
    light = put(light, "struct Light {", f"struct Extra {{ {members} }};\n").replace("std::variant<SphereLamp,", "std::variant<Extra, SphereLamp,")
    return light, put(kinds, "// sphere lamps:", overloads + "\n")


def reads(tmp_path, headers, source):
    """What the compiler says of a core's file before which `headers` (path: text) are found; empty: it compiles."""
    for path, text in headers.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    shutil.copy(CPP / source, tmp_path / source)  # includes of its own folder are found beside it first
    command = [COMPILER, "-std=c++20", "-fsyntax-only", "-Werror=switch", "-I", tmp_path, "-I", CPP, "-isystem", IMATH, tmp_path / source]
    return subprocess.run(command, capture_output=True, text=True).stderr


def test_a_complete_shape_compiles(tmp_path):
    assert reads(tmp_path, {"shading/lobes.h": lobes_with(COSINE)}, "shading/bsdf.cpp") == ""


@pytest.mark.parametrize("facts, forgotten", [*((COSINE, name) for name in COSINE), *((PEAKED, name) for name in PEAKED if name not in COSINE)])
def test_a_shape_that_forgets_something_does_not(tmp_path, facts, forgotten):
    left = {name: fact for name, fact in facts.items() if name != forgotten}
    found = reads(tmp_path, {"shading/lobes.h": lobes_with(left)}, "shading/material.cpp" if forgotten == "response" else "shading/bsdf.cpp")
    assert "error" in found and forgotten in found, found


def light_files(facts):
    light, kinds = lights_with(facts)
    return {"scene/light.h": light, "scene/light_kinds.h": kinds}


@pytest.mark.parametrize("facts", [LIGHT, INFINITE_LIGHT], ids=["finite", "infinite"])
@pytest.mark.parametrize("source", ["light", *sorted(set(ASKED_BY.values()))])
def test_a_complete_light_compiles(tmp_path, facts, source):
    assert reads(tmp_path, light_files(facts), f"scene/{source}.cpp") == ""


@pytest.mark.parametrize("facts, forgotten", [*((LIGHT, name) for name in LIGHT), *((INFINITE_LIGHT, name) for name in INFINITE_LIGHT)])
def test_a_light_that_forgets_something_does_not(tmp_path, facts, forgotten):
    left = {name: fact for name, fact in facts.items() if name != forgotten}
    found = reads(tmp_path, light_files(left), f"scene/{ASKED_BY.get(forgotten, 'light')}.cpp")
    assert "error" in found and forgotten.split("::")[-1] in found, found


def lamp_files(named_by):
    """description.h and light_kinds.h with one more value of LightKind, which so many of those in LAMP name."""
    description, kinds = (CPP / "scene/description.h").read_text(), (CPP / "scene/light_kinds.h").read_text()
    description = put(description, "Sun, Area };", "Extra, ")
    for place in named_by:
        if place == "make_lamp":
            kinds = put(kinds, *LAMP[place])
        else:
            description = put(description, *LAMP[place])
    return {"scene/description.h": description, "scene/light_kinds.h": kinds}


def test_a_lamp_that_is_named_everywhere_compiles(tmp_path):
    assert reads(tmp_path, lamp_files(LAMP), "scene/compile_lights.cpp") == ""


@pytest.mark.parametrize("forgotten", LAMP)
def test_a_lamp_that_is_forgotten_somewhere_does_not(tmp_path, forgotten):
    found = reads(tmp_path, lamp_files([place for place in LAMP if place != forgotten]), "scene/compile_lights.cpp")
    assert "error" in found and "Extra" in found and forgotten in found, found
