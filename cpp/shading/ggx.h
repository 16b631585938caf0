// SPDX-License-Identifier: GPL-3.0-or-later
// The GGX distribution of microfacets with the height-correlated Smith term, in the local frame (z = shading
// normal), anisotropic. Directions point away from the surface. alpha = Blender roughness².
#pragma once
#include <algorithm>

#include "base/math.h"

namespace sluice::ggx {

inline constexpr float smooth_alpha = 1e-3f;  // below: a mirror (numerics R8)

struct Alpha {
  float x, y;
};

// Normal distribution D(h); written in squares of h.x / alpha, which stays exact where 1 - h.z² cancels.
[[nodiscard]] inline float density(const V3f& h, Alpha a) noexcept {
  const float t = square(h.x / a.x) + square(h.y / a.y) + h.z * h.z;
  return 1 / (pi * a.x * a.y * t * t);
}

[[nodiscard]] inline float lambda(const V3f& w, Alpha a) noexcept {
  const float t = (square(a.x * w.x) + square(a.y * w.y)) / (w.z * w.z);
  return 0.5f * (std::sqrt(1 + t) - 1);
}

// G2(o, i) / G1(o): what sampling the normals visible from o leaves as weight.
[[nodiscard]] inline float shadowing_ratio(const V3f& o, const V3f& i, Alpha a) noexcept {
  const float lo = lambda(o, a);
  return (1 + lo) / (1 + lo + lambda(i, a));
}

// Density of visible normals: G1(o) (o·h) D(h) / o.z.
[[nodiscard]] inline float visible_density(const V3f& o, const V3f& h, Alpha a) noexcept {
  return density(h, a) * std::max(0.0f, o.dot(h)) / (o.z * (1 + lambda(o, a)));
}

// A normal visible from o (o.z > 0), by spherical caps (Dupuy & Benyoub 2023).
[[nodiscard]] inline V3f sample_visible(const V3f& o, Alpha a, const V2f& u) noexcept {
  const V3f s = V3f(o.x * a.x, o.y * a.y, o.z).normalized();
  const float phi = 2 * pi * u.x, z = (1 - u.y) * (1 + s.z) - s.z, r = std::sqrt(std::max(0.0f, 1 - z * z));
  const V3f h(r * std::cos(phi) + s.x, r * std::sin(phi) + s.y, z + s.z);
  return V3f(h.x * a.x, h.y * a.y, std::max(h.z, 1e-12f)).normalized();
}

[[nodiscard]] inline V3f reflect(const V3f& o, const V3f& h) noexcept { return h * (2 * o.dot(h)) - o; }

// Snell; eta = index of the far side / of o's side. False under total internal reflection.
[[nodiscard]] inline bool refract(const V3f& o, const V3f& h, float eta, V3f& i) noexcept {
  const float c = o.dot(h), t2 = 1 - (1 - c * c) / (eta * eta);
  if (!(t2 > 0)) return false;
  i = h * (c / eta - std::sqrt(t2)) - o / eta;
  return true;
}

}  // namespace sluice::ggx
