// SPDX-License-Identifier: GPL-3.0-or-later
// Where in the picture a ray from the camera may meet a gate that it would have to ask: all other such rays, nearly all of them, need
// no query. By blocks of pixels, on the side of asking.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "edit/gates.h"
#include "scene/camera.h"

namespace sluice {

class GatesInView {
 public:
  GatesInView() = default;
  GatesInView(const Edits& edits, const Camera& camera, const PixelFilter& filter, const FrameDescription& frame);

  // On a ray through pixel (x, y) of the full frame: exits of light edits, where light may come out; or entries of view edits.
  [[nodiscard]] bool any(Side side, int x, int y) const noexcept {
    const auto& blocks = blocks_[index(side)];
    return !blocks.empty() && blocks[static_cast<std::size_t>(y / block_side) * columns_ + static_cast<std::size_t>(x / block_side)];
  }

 private:
  static constexpr int block_side = 8;
  std::size_t columns_ = 0;
  std::array<std::vector<std::uint8_t>, 2> blocks_;  // [side]; empty: none anywhere
};

}  // namespace sluice
