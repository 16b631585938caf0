// SPDX-License-Identifier: GPL-3.0-or-later
// Event classes of a scene for a set of rules: which events no symbol of any rule can tell apart. Only the
// compiler of automata needs this; paths use the Alphabet.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/cancel.h"
#include "expr/alphabet.h"
#include "expr/bits.h"
#include "expr/rule.h"

namespace sluice {

struct ClassedRules {
  Alphabet alphabet;
  std::vector<Bits> matchers;  // distinct meanings of atoms: the event classes that match
  std::vector<std::vector<std::uint32_t>> meaning;  // [rule][atom] -> matchers
};

[[nodiscard]] ClassedRules classify(std::span<const Rule> rules, std::span<const Entity> entities,
                                    std::span<const Entity> gates, const CancelPoint& cancel);

}  // namespace sluice
