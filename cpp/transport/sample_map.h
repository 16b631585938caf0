// SPDX-License-Identifier: GPL-3.0-or-later
// Where view samples go: how many of a pass each block of pixels takes, and how many lights each asks at v, as a pilot pass found noise there. Fixed before the first pass
// like the rest of the guide and made of samples of its own, so the picture's mean stays what it is (no sample decides about itself).
#pragma once
#include <numeric>
#include <vector>

#include "base/random.h"

namespace sluice {

class SampleMap {
 public:
  static constexpr int most = 16;  // samples of a pixel

  SampleMap() = default;  // one sample everywhere
  // `side`: of a block, in pixels.
  SampleMap(int side, std::size_t blocks_x, std::vector<std::uint8_t> counts, std::uint32_t light_samples)
      : side_(side), blocks_x_(blocks_x), counts_(std::move(counts)), light_samples_(light_samples) {}

  // Samples that pixel (x, y) of the full frame takes in each pass.
  [[nodiscard]] std::uint32_t at(int x, int y) const noexcept { return counts_.empty() ? 1 : counts_[static_cast<std::size_t>(y / side_) * blocks_x_ + static_cast<std::size_t>(x / side_)]; }
  // Samples of lights at each v, where they cost less than what else a view path does.
  [[nodiscard]] std::uint32_t light_samples() const noexcept { return light_samples_; }
  [[nodiscard]] double mean() const noexcept {
    return counts_.empty() ? 1 : std::accumulate(counts_.begin(), counts_.end(), 0.0) / static_cast<double>(counts_.size());
  }
  [[nodiscard]] std::uint64_t hash() const noexcept {
    std::uint64_t h = light_samples_;
    for (const std::uint8_t n : counts_) h = mix(h, n);
    return h;
  }

 private:
  int side_ = 1;
  std::size_t blocks_x_ = 0;
  std::vector<std::uint8_t> counts_;
  std::uint32_t light_samples_ = 1;
};

}  // namespace sluice
