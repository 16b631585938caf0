// SPDX-License-Identifier: GPL-3.0-or-later
// Python's dicts to the core's plain data. The keys are the members' names; a missing key keeps the member's
// default, a wrong type is a SceneError that names the thing and the key. Arrays must have the exact dtype
// and shape and are copied once.
#pragma once
#include <pybind11/pybind11.h>

#include "render/settings.h"
#include "scene/description.h"

namespace sluice {

[[nodiscard]] SceneDescription read_description(const pybind11::dict& scene);
[[nodiscard]] ShotDescription read_shot(const pybind11::dict& shot);  // the keys of a scene that a shot has
[[nodiscard]] RenderSettings read_settings(const pybind11::dict& settings);
[[nodiscard]] std::vector<std::string> exit_properties();  // keys of an exit beside its quad

}  // namespace sluice
