// SPDX-License-Identifier: GPL-3.0-or-later
// Where view samples go: how many of a pass each block of pixels takes, and how many lights and gather
// segments each, as a pilot found noise there. It is fixed before the first view samples are taken (its pilot
// needs the photons of the first pass) and made of samples of its own, so the picture's mean stays what it
// is: no sample decides about itself.
#pragma once
#include <vector>

#include "base/random.h"

namespace sluice {

struct SampleCount {
  // one gather segment in every second pass: bundles share them (view/shared_gather.h)
  static constexpr std::uint8_t by_turns = 0;

  std::uint8_t samples = 1;  // of a pixel
  // of each of those by next-event estimation at v, where that is most of the noise
  std::uint8_t light_samples = 1;
  std::uint8_t gather_segments = by_turns;  // of each of those, where indirect light is
  std::uint8_t emission_samples = 0;  // of a pixel, of emission alone; 0: the samples above see emission too

  [[nodiscard]] float mean_segments() const noexcept {
    return gather_segments == by_turns ? 0.5f : static_cast<float>(gather_segments);
  }
  [[nodiscard]] std::uint64_t hash() const noexcept {
    return mix(mix(mix(samples, light_samples), gather_segments), emission_samples);
  }
};

class SampleMap {
 public:
  static constexpr int max_samples = 16, max_emission_samples = 64;  // of a pixel

  SampleMap() = default;  // one sample everywhere
  // `side`: of a block, in pixels.
  SampleMap(int side, std::size_t blocks_x, std::vector<SampleCount> counts)
      : side_(side), blocks_x_(blocks_x), counts_(std::move(counts)) {}

  // What pixel (x, y) of the full frame takes in each pass.
  [[nodiscard]] SampleCount at(int x, int y) const noexcept {
    return counts_.empty() ? SampleCount{}
                           : counts_[static_cast<std::size_t>(y / side_) * blocks_x_ +
                                     static_cast<std::size_t>(x / side_)];
  }
  [[nodiscard]] std::uint64_t hash() const noexcept {
    std::uint64_t h = 0;
    for (const SampleCount& count : counts_) h = mix(h, count.hash());
    return h;
  }

 private:
  int side_ = 1;
  std::size_t blocks_x_ = 0;
  std::vector<SampleCount> counts_;
};

}  // namespace sluice
