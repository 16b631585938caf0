// SPDX-License-Identifier: GPL-3.0-or-later
// Steps of compiling automata: determinise one expression, minimise, join two. None returns more than
// max_dfa_states states.
#pragma once
#include <optional>
#include <span>

#include "expr/alphabet.h"
#include "expr/automaton.h"
#include "expr/positions.h"

namespace sluice {

// `meaning`: [atom] -> matchers. States accept expression `number`. Empty when it does not fit.
[[nodiscard]] std::optional<Dfa> determinised(const Positions& positions,
                                              std::span<const std::uint32_t> meaning,
                                              std::span<const Bits> matchers, int classes,
                                              std::uint16_t number);

// Equivalent, with the fewest states, numbered in the order in which they are met from the start.
[[nodiscard]] Dfa minimised(const Dfa& dfa, const CancelPoint& cancel = {});

// Runs both at once; accepts what either accepts. Empty when it does not fit.
[[nodiscard]] std::optional<Dfa> product(const Dfa& a, const Dfa& b);

}  // namespace sluice
