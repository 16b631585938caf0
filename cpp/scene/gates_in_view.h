// SPDX-License-Identifier: GPL-3.0-or-later
// Where in the picture a ray from the camera may meet a gate that it would have to ask: all other such rays,
// nearly all of them, need no query, and most of these need to ask but a few quads. By blocks of pixels, on
// the side of asking.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "edit/edits.h"
#include "scene/camera.h"

namespace sluice {

class GatesInView {
 public:
  GatesInView() = default;
  GatesInView(const Edits& edits, const Camera& camera, const PixelFilter& filter,
              const FrameDescription& frame);

  // On a ray through pixel (x, y) of the full frame: exits of light edits, where light may come out; or
  // entries of view edits.
  [[nodiscard]] bool any(Side side, int x, int y) const noexcept {
    const auto& counts = blocks_[index(side)].counts;
    return !counts.empty() && counts[block(x, y)] > 0;
  }
  // All of them, where there are any; empty: too many to be listed.
  [[nodiscard]] std::optional<std::span<const QuadId>> listed(Side side, int x, int y) const noexcept {
    const Blocks& blocks = blocks_[index(side)];
    const std::size_t at = block(x, y), count = blocks.counts[at];
    if (count > max_listed) return std::nullopt;
    return std::span(blocks.gates).subspan(blocks.first[at], count);
  }

 private:
  static constexpr std::size_t max_listed = 16, max_blocks = 1 << 14;
  struct Blocks {
    std::vector<std::uint8_t> counts;  // of gates in each; max_listed + 1: more; empty: none anywhere
    std::vector<std::uint32_t> first;  // of each in `gates`
    std::vector<QuadId> gates;
  };
  [[nodiscard]] std::size_t block(int x, int y) const noexcept {
    return static_cast<std::size_t>(y >> shift_) * columns_ + static_cast<std::size_t>(x >> shift_);
  }

  int shift_ = 0;  // blocks are squares of 2^shift pixels
  std::size_t columns_ = 0;
  std::array<Blocks, 2> blocks_;  // [side]
};

}  // namespace sluice
