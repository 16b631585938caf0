// SPDX-License-Identifier: GPL-3.0-or-later
// One view sample while it is traced: what was asked for, and its random numbers.
#pragma once
#include "transport/view/view_sample.h"

namespace sluice {

// Pairs of dimensions of a view sample's low-discrepancy sequence. Each pair is used for one thing alone, as
// two uses of one would be correlated. The camera takes the first two, then each vertex of the path eight, at
// its depth; those of the gather segment come from the segment's own point of a sequence.
//
//   pair            first number                     second number
//   0               pixel filter                     pixel filter
//   1               lens                             lens
//   2 + 8·depth     which followed lobe              roulette
//   3 + 8·depth     direction of the followed lobe   direction
//   4 + 8·depth     which light v asks               -
//   5 + 8·depth     point on that light              point
//   6 + 8·depth     which lobe sends the segment     -
//   7 + 8·depth     direction of the segment         direction
//   8 + 8·depth     which light y asks               -
//   9 + 8·depth     point on that light              point
enum class Dimension : std::uint32_t {
  Filter,
  Lens,
  FollowedLobe,
  FollowedDirection,
  LightOfV,
  LightPointOfV,
  GatherLobe,
  GatherDirection,
  LightOfY,
  LightPointOfY
};
inline constexpr std::uint32_t pairs_per_vertex = 8;
static_assert(static_cast<std::uint32_t>(Dimension::LightPointOfY) ==
              static_cast<std::uint32_t>(Dimension::FollowedLobe) + pairs_per_vertex - 1);

// The number of a pair, for the vertex at some depth.
[[nodiscard]] constexpr std::uint32_t pair_of(Dimension dimension, int depth = 0) noexcept {
  return static_cast<std::uint32_t>(dimension) + pairs_per_vertex * static_cast<std::uint32_t>(depth);
}

class Sample {
 public:
  // `key`: of choices outside of the sampler's dimensions.
  Sample(const ViewSample& what, std::size_t number, std::uint64_t key) noexcept
      : asked(what), index(number), key_(key) {}

  const ViewSample& asked;
  const std::size_t index;   // in its bundle
  bool is_recorded = false;  // the first thing that it meets is known

  [[nodiscard]] V2f pair(Dimension dimension, int depth = 0) const noexcept {
    return asked.sampler.pair(pair_of(dimension, depth));
  }
  // A number of no dimension, for choices that few paths make.
  [[nodiscard]] float random() noexcept {
    return to_unit(static_cast<std::uint32_t>(mix(key_, ++draws_) >> 32));
  }
  [[nodiscard]] float light_samples() const noexcept { return static_cast<float>(asked.light_samples); }

 private:
  std::uint64_t key_, draws_ = 0;
};

}  // namespace sluice
