// SPDX-License-Identifier: GPL-3.0-or-later
// Spheres that photons are aimed at.
#pragma once
#include <algorithm>
#include <cmath>

#include "base/math.h"
#include "scene/scene.h"

namespace sluice {

// A sphere (re-centred) that is worth aiming at: around a specular object, an entry that really captures
// light, entries outside of all surfaces, or what the camera sees.
struct Target {
  V3d centre;
  float radius;
};

[[nodiscard]] inline Target sphere_around(const Bounds& bounds) noexcept {
  return {bounds.middle(), static_cast<float>(0.5001 * bounds.diagonal())};
}

// 1 - cos of the half angle under which a sphere is seen: its solid angle over 2π, exact for small ones too.
// 2 = all directions, from inside.
[[nodiscard]] inline double one_minus_cos_of_sphere(double radius, double distance2) noexcept {
  const double sine2 = square(radius) / std::max(distance2, 1e-300);
  return sine2 >= 1 ? 2 : sine2 / (1 + std::sqrt(1 - sine2));
}

}  // namespace sluice
