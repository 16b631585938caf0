// SPDX-License-Identifier: GPL-3.0-or-later
// An expression and how it is to be read.
#pragma once
#include <string>

#include "expr/expression.h"

namespace sluice {

// One edit, layer or test expression on its way into an automaton.
struct Rule {
  std::string name;  // said in errors and warnings
  const Expression* expression = nullptr;
  // an edit that acts once: its own F cannot occur before it acts, so it need not be told apart
  int own_gate = -1;
  bool reversed = false;  // view edits are read from E backward
  bool is_layer = false;  // layers are read from L to E, by automata of their own
};

}  // namespace sluice
