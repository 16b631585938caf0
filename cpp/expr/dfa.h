// SPDX-License-Identifier: GPL-3.0-or-later
// Deterministic automata, and the steps of compiling them: determinise one expression, minimise, join two.
// None returns more than max_dfa_states states.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/cancel.h"
#include "base/event.h"
#include "expr/bits.h"

namespace sluice {

struct Positions;

inline constexpr int max_dfa_states = 4096;

// Complete: every state has a successor for every class. State 0 is the start.
struct Dfa {
  int states = 0, columns = 0;
  std::vector<std::uint16_t> column;  // [event class]
  std::vector<std::uint16_t> next;    // [state * columns + column]
  std::vector<std::uint16_t> label;   // [state] -> accepting
  // [label] -> numbers of the expressions that accept, ascending
  std::vector<std::vector<std::uint16_t>> accepting;

  [[nodiscard]] std::uint16_t step(std::uint16_t state, EventClass event) const noexcept {
    return next[static_cast<std::size_t>(state) * static_cast<std::size_t>(columns) + column[event]];
  }
  [[nodiscard]] std::span<const std::uint16_t> accepts(std::uint16_t state) const noexcept {
    return accepting[label[state]];
  }
};

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
