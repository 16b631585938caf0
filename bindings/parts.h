// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the module sluice_core: each defines its functions and types in it.
#pragma once
#include <pybind11/pybind11.h>

namespace sluice {

void define_language(pybind11::module_& m);  // language.cpp
void define_session(pybind11::module_& m);   // session.cpp

}  // namespace sluice
