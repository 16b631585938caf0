// SPDX-License-Identifier: GPL-3.0-or-later
// How wide the kernels of photons are to be, by places (disks.h).
#pragma once
#include <vector>

#include "transport/cells.h"

namespace sluice {

// Radius in the first pass that finds a few photons (m): of the smallest cell there that holds any photon of
// the pilot's: where those are sparse, larger cells answer.
struct RadiusCache {
  static constexpr double growth = 3;  // of the cells' edge
  std::vector<Cells> levels;           // the smallest first

  // `offset` is a random jitter in edges of a cell: drawn anew for each photon it hides the cells' borders.
  // If the jittered cell is empty, off the surface or out of the light, p's own cell answers. Null: the pilot
  // found no photon as far as the largest cells reach.
  [[nodiscard]] const float* find(const V3d& p, const V3d& offset) const noexcept {
    for (const Cells& level : levels)
      for (const V3d& at : {p + offset * level.edge(), p})
        if (const float* radius = level.find(at)) return radius;
    return nullptr;
  }
  [[nodiscard]] std::uint64_t hash() const noexcept {
    std::uint64_t h = 0;
    for (const Cells& level : levels) h = mix(h, level.hash());
    return h;
  }
};

}  // namespace sluice
