// SPDX-License-Identifier: GPL-3.0-or-later
// From expressions to tables (design §3): the events of a scene fall into classes that no expression can tell
// apart, and expressions of one side share a deterministic automaton while it has at most 4,096 states. Knows
// no geometry and no path.
#pragma once
#include <span>
#include <vector>

#include "base/cancel.h"
#include "expr/alphabet.h"
#include "expr/dfa.h"
#include "expr/rule.h"

namespace sluice {

struct Automata {
  Alphabet alphabet;
  // for light edits, view edits and layers; accepting lists hold indices of rules
  std::vector<Dfa> forward, backward, layers;
};

// Throws ExpressionError naming the rule that does not fit into max_dfa_states alone.
[[nodiscard]] Automata compile_automata(std::span<const Rule> rules, std::span<const Entity> entities,
                                        std::span<const Entity> gates, const CancelPoint& cancel = {});

}  // namespace sluice
