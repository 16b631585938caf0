// SPDX-License-Identifier: GPL-3.0-or-later
// Position automaton of an expression (Glushkov 1961): one position per symbol, {n,m} expanded, no empty
// moves. Both the side of a language and its deterministic automaton are read off it.
#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "expr/expression.h"

namespace sluice {

// A set of positions, at most max_expression_atoms.
struct PositionSet {
  std::array<std::uint64_t, max_expression_atoms / 64> words{};

  bool operator==(const PositionSet&) const = default;
  void insert(int p) noexcept { words[static_cast<std::size_t>(p) / 64] |= 1ull << (p % 64); }
  [[nodiscard]] bool contains(int p) const noexcept {
    return (words[static_cast<std::size_t>(p) / 64] >> (p % 64)) & 1;
  }
  [[nodiscard]] bool empty() const noexcept { return *this == PositionSet{}; }
  PositionSet& operator|=(const PositionSet& o) noexcept {
    for (std::size_t i = 0; i < words.size(); ++i) words[i] |= o.words[i];
    return *this;
  }
  PositionSet& operator&=(const PositionSet& o) noexcept {
    for (std::size_t i = 0; i < words.size(); ++i) words[i] &= o.words[i];
    return *this;
  }
  [[nodiscard]] friend PositionSet operator&(PositionSet a, const PositionSet& b) noexcept { return a &= b; }

  template <class F>
  void for_each(const F& f) const {
    for (std::size_t i = 0; i < words.size(); ++i)
      for (std::uint64_t w = words[i]; w; w &= w - 1) f(static_cast<int>(i) * 64 + std::countr_zero(w));
  }
};

struct Positions {
  std::vector<int> atoms;           // [position] -> Expression::atoms
  std::vector<PositionSet> follow;  // [position] -> what may come next
  PositionSet first, last;
  bool nullable = false;  // the empty word belongs to the language

  [[nodiscard]] int size() const noexcept { return static_cast<int>(atoms.size()); }
};

[[nodiscard]] Positions make_positions(const Expression& expression);
[[nodiscard]] Positions reversed(const Positions& positions);  // of the reversed language

}  // namespace sluice
