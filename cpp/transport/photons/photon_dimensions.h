// SPDX-License-Identifier: GPL-3.0-or-later
// What each pair of numbers of a light path's sampler is drawn for. Two uses of one pair would be correlated,
// so no other file may name a pair of its own for photons.
#pragma once
#include <cstdint>

#include "base/random.h"

namespace sluice {

//   pair      first number                    second number
//   0         which light                     which way of its mixture, and the cell of its histogram
//   1         position on the light; of light from infinity, of the line across its direction
//   2         direction from the light
//   3 + 2d    which lobe of the vertex        roulette                         (d: events before the vertex)
//   4 + 2d    direction by that lobe
enum class PhotonDimension : std::uint32_t {
  LightAndWay,
  Position,
  Direction,
  LobeAndRoulette,
  LobeDirection
};

[[nodiscard]] inline V2f pair_of(const Sampler& sampler, PhotonDimension dimension, int depth = 0) noexcept {
  return sampler.pair(static_cast<std::uint32_t>(dimension) + 2 * static_cast<std::uint32_t>(depth));
}

}  // namespace sluice
