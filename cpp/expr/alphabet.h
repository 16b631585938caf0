// SPDX-License-Identifier: GPL-3.0-or-later
// Event classes of a scene for a set of rules: which events no symbol of any rule can tell apart. Only the
// compiler of automata needs this; paths use the Alphabet.
#pragma once
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "expr/automaton.h"

namespace sluice {

using Bits = std::vector<std::uint64_t>;
[[nodiscard]] inline bool has_bit(const Bits& bits, std::size_t i) noexcept {
  return (bits[i / 64] >> (i % 64)) & 1;
}
inline void set_bit(Bits& bits, std::size_t i) noexcept { bits[i / 64] |= 1ull << (i % 64); }
template <class F>
void for_each_bit(const Bits& bits, const F& f) {
  for (std::size_t i = 0; i < bits.size(); ++i)
    for (std::uint64_t w = bits[i]; w; w &= w - 1) f(i * 64 + static_cast<std::size_t>(std::countr_zero(w)));
}

struct ClassedRules {
  Alphabet alphabet;
  std::vector<Bits> matchers;  // distinct meanings of atoms: the event classes that match
  std::vector<std::vector<std::uint32_t>> meaning;  // [rule][atom] -> matchers
};

[[nodiscard]] ClassedRules classify(std::span<const Rule> rules, std::span<const Entity> entities,
                                    std::span<const Entity> gates, const CancelPoint& cancel);

}  // namespace sluice
