// SPDX-License-Identifier: GPL-3.0-or-later
// Sets of numbers as bits.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

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

}  // namespace sluice
