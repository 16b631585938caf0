// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors, matrices and frames: Imath's types under short names. Float for shading and storage, double
// wherever a gate or a hit position is decided (numerics: a hit must be known far better than the distance a
// quad floats in front of its plane).
#pragma once
#include <Imath/ImathMatrix.h>
#include <Imath/ImathVec.h>

#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace sluice {

using V2f = Imath::V2f;
using V3f = Imath::V3f;
using V2d = Imath::V2d;
using V3d = Imath::V3d;
using M44d = Imath::M44d;  // Imath multiplies row vectors: p * m, translation in the last row

inline constexpr float pi = std::numbers::pi_v<float>;
inline constexpr float infinity = std::numeric_limits<float>::infinity();

template <class T>
[[nodiscard]] inline T square(T x) noexcept {
  return x * x;
}

template <class T>
[[nodiscard]] inline bool is_finite(const Imath::Vec3<T>& v) noexcept {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

[[nodiscard]] inline float max_component(const V3f& v) noexcept { return std::max(v.x, std::max(v.y, v.z)); }

// Up to what rounding and packed directions leave: for assertions.
[[nodiscard]] inline bool is_unit(const V3f& v) noexcept { return std::abs(v.length2() - 1) < 1e-3f; }

// Orthonormal, right-handed frame around a unit normal n; branchless (Duff et al. 2017).
struct Frame {
  V3f t, b, n;

  explicit Frame(const V3f& normal) noexcept : n(normal) {
    assert(is_unit(normal));
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z), c = n.x * n.y * a;
    t = V3f(1.0f + sign * n.x * n.x * a, sign * c, -sign * n.x);
    b = V3f(c, sign + n.y * n.y * a, -n.y);
  }
  Frame(const V3f& tangent, const V3f& bitangent, const V3f& normal) noexcept
      : t(tangent), b(bitangent), n(normal) {}

  [[nodiscard]] V3f to_local(const V3f& w) const noexcept { return {w.dot(t), w.dot(b), w.dot(n)}; }
  [[nodiscard]] V3f to_world(const V3f& l) const noexcept { return t * l.x + b * l.y + n * l.z; }
};

}  // namespace sluice
