// SPDX-License-Identifier: GPL-3.0-or-later
// How wide photon densities are estimated. At v, caustics and edited light: some footprints of a pixel, narrower or wider by the photons that
// the pilot found there (Disks). At y: by the length of the gather segment. Radii are those of the first pass (m), which later ones shrink.
#pragma once
#include <algorithm>
#include <cmath>

#include "transport/guide.h"
#include "transport/settings.h"

namespace sluice {

inline constexpr float least_radius_of_extent = 1e-6f, most_radius_of_extent = 0.02f;  // bounds of common radii, in sizes of the scene

// r_p = r_0 (p + 1)^(-1/6): alpha = 2/3, the rate with the least error (Kaplanyan & Dachsbacher 2013).
[[nodiscard]] inline float radius_scale(int pass) noexcept { return static_cast<float>(std::pow(pass + 1.0, -1.0 / 6.0)); }

// At v, where a pixel is `footprint` wide. Rounding of positions sets the floor: below it photons of one surface no longer share a disk
// (numerics D6).
[[nodiscard]] inline float common_radius(const TransportSettings& settings, double footprint, double extent) noexcept {
  const auto size = static_cast<float>(extent);
  return std::clamp(settings.caustic_radius_factor * static_cast<float>(footprint), least_radius_of_extent * size, most_radius_of_extent * size);
}
// The widest disk at v, where a common one has this radius: for caustics and edited light; for soft ones.
[[nodiscard]] inline float widest_disk(const TransportSettings& settings, float common) noexcept { return settings.caustic_radius_range * common; }
[[nodiscard]] inline float widest_soft_disk(const TransportSettings& settings, float common, double extent) noexcept {
  const float widest = widest_disk(settings, common);
  return std::max(widest, std::min(settings.soft_range * widest, most_radius_of_extent * static_cast<float>(extent)));
}
// Wider where the pilot found so few photons (or none: null) that noise would hide every feature of that size, narrower where there are
// enough for sharper edges. `needed`: by Disks.
[[nodiscard]] inline float disk_radius(const TransportSettings& settings, float common, const float* needed, float widest, double extent) noexcept {
  const float narrowest = std::max(common / settings.caustic_radius_range, least_radius_of_extent * static_cast<float>(extent));
  return needed ? std::clamp(*needed, narrowest, widest) : widest;
}
// The kernel at v falls to 0 so many radii away (√1.5; density.h).
inline constexpr float round_reach = 1.2247449f;

// At y. A gather segment stands for a bundle of directions: features below a tenth of its length times the spread of its lobe drown in its
// noise. Near corners, where y is close to v, the radius stays small and so does the bias; the guide bounds it from both sides by the
// number of photons to be found.
[[nodiscard]] inline float gather_radius(const Guide& guide, double length, float lobe_pdf) noexcept {
  const double spread = std::min(1.0, 1 / std::sqrt(static_cast<double>(lobe_pdf)));
  return std::clamp(static_cast<float>(0.1 * length * spread), guide.least_radius, guide.most_radius);
}

}  // namespace sluice
