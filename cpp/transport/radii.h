// SPDX-License-Identifier: GPL-3.0-or-later
// How wide photon densities are estimated: at y, by the length of the gather segment; at v see disks.h. Radii
// are those of the first pass (m), which later ones shrink.
#pragma once
#include <algorithm>
#include <cmath>

#include "scene/scene.h"
#include "transport/guide.h"

namespace sluice {

// At y, whatever the length of the segment.
[[nodiscard]] inline float widest_gather(const Scene& scene) noexcept {
  constexpr float max_of_extent = 0.02f;
  return max_of_extent * static_cast<float>(scene.extent());
}

// r_p = r_0 (p + 1)^(-1/6): alpha = 2/3, the rate with the least error (Kaplanyan & Dachsbacher 2013).
[[nodiscard]] inline float radius_scale(int pass) noexcept {
  return static_cast<float>(std::pow(pass + 1.0, -1.0 / 6.0));
}

// At y. A gather segment stands for a bundle of directions: features below a tenth of its length times the
// spread of its lobe drown in its noise. Near corners, where y is close to v, the radius stays small and so
// does the bias.
[[nodiscard]] inline float radius_of_segment(double length, float lobe_pdf) noexcept {
  const double spread = std::min(1.0, 1 / std::sqrt(static_cast<double>(lobe_pdf)));
  return static_cast<float>(0.1 * length * spread);
}

// The same within the guide's bounds, which the number of photons to be found sets.
[[nodiscard]] inline float gather_radius(const Guide& guide, double length, float lobe_pdf) noexcept {
  return std::clamp(radius_of_segment(length, lobe_pdf), guide.min_radius, guide.max_radius);
}

}  // namespace sluice
