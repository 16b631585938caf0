// SPDX-License-Identifier: GPL-3.0-or-later
// How wide photon densities are estimated: at y, by the length of the gather segment; at v see disks.h. Radii
// are those of the first pass (m), which later ones shrink.
#pragma once
#include <algorithm>
#include <cmath>

#include "transport/guide.h"

namespace sluice {

inline constexpr float most_radius_of_extent = 0.02f;  // at y, in sizes of the scene

// r_p = r_0 (p + 1)^(-1/6): alpha = 2/3, the rate with the least error (Kaplanyan & Dachsbacher 2013).
[[nodiscard]] inline float radius_scale(int pass) noexcept {
  return static_cast<float>(std::pow(pass + 1.0, -1.0 / 6.0));
}

// At y. A gather segment stands for a bundle of directions: features below a tenth of its length times the
// spread of its lobe drown in its noise. Near corners, where y is close to v, the radius stays small and so
// does the bias; the guide bounds it from both sides by the number of photons to be found.
[[nodiscard]] inline float gather_radius(const Guide& guide, double length, float lobe_pdf) noexcept {
  const double spread = std::min(1.0, 1 / std::sqrt(static_cast<double>(lobe_pdf)));
  return std::clamp(static_cast<float>(0.1 * length * spread), guide.least_radius, guide.most_radius);
}

}  // namespace sluice
