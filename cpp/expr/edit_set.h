// SPDX-License-Identifier: GPL-3.0-or-later
// Sets of edits, each a bit at its number. is_empty() is about bits. As the `members` of a query a set
// without words means all edits, so callers ask is_empty() first.
#pragma once
#include <cstdint>
#include <span>

namespace sluice {

using EditSet = std::span<const std::uint64_t>;

[[nodiscard]] inline bool is_empty(EditSet set) noexcept {
  for (const std::uint64_t word : set)
    if (word != 0) return false;
  return true;
}

[[nodiscard]] inline bool contains(EditSet set, int edit) noexcept {
  const auto e = static_cast<std::size_t>(edit);
  return e / 64 < set.size() && ((set[e / 64] >> (e % 64)) & 1) != 0;
}

}  // namespace sluice
