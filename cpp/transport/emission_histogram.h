// SPDX-License-Identifier: GPL-3.0-or-later
// Where the useful photons of one light start, as a histogram over the unit square: of a finite light the
// direction, of a sun the place on a plane across its rays. Half of a lamp in a fixture lights the fixture,
// most of a sun misses the window; this learns it.
#pragma once
#include <algorithm>
#include <cmath>
#include <span>

#include "base/sampling.h"
#include "transport/target.h"

namespace sluice {

class EmissionHistogram {
 public:
  static constexpr int side = 64, cells = side * side;

  EmissionHistogram() = default;
  explicit EmissionHistogram(std::span<const float> useful) : cells_(useful) {}
  [[nodiscard]] bool empty() const noexcept { return cells_.empty(); }
  [[nodiscard]] const Distribution& distribution() const noexcept { return cells_; }

  // The cell that holds (u, v) in [0, 1)².
  [[nodiscard]] static int cell(const V2f& uv) noexcept {
    const auto index = [](float x) { return std::clamp(static_cast<int>(x * side), 0, side - 1); };
    return index(uv.y) * side + index(uv.x);
  }
  // Density at (u, v), which is 0 outside of the square.
  [[nodiscard]] float pdf(const V2f& uv) const noexcept {
    const bool inside = uv.x >= 0 && uv.x < 1 && uv.y >= 0 && uv.y < 1;
    return inside ? cells_.pmf(static_cast<std::size_t>(cell(uv))) * cells : 0;
  }
  [[nodiscard]] V2f sample(float u_cell, const V2f& u) const noexcept {
    const auto index = static_cast<int>(cells_.sample(u_cell).index);
    const int row = index / side, column = index % side;
    return {(static_cast<float>(column) + u.x) / side, (static_cast<float>(row) + u.y) / side};
  }

 private:
  Distribution cells_;
};

// Directions as (longitude, cos): areas are kept, density per solid angle = density of (u, v) / 4π.
[[nodiscard]] inline V2f uv_of_direction(const V3f& d) noexcept {
  const float turn = std::atan2(d.y, d.x) * (0.5f / pi);
  return {std::min(turn < 0 ? turn + 1 : turn, 0x1.fffffep-1f),
          std::clamp((d.z + 1) * 0.5f, 0.0f, 0x1.fffffep-1f)};
}
[[nodiscard]] inline V3f direction_of_uv(const V2f& uv) noexcept {
  const float z = 2 * uv.y - 1, r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * pi * uv.x;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// The square around a target's disk, across a fixed axis: where lines of a sun cross it.
struct SunPlane {
  Frame frame;
  V3d centre;
  float half;

  SunPlane(const Target& all, const V3f& axis) noexcept : frame(axis), centre(all.centre), half(all.radius) {}
  // Where the line crosses the plane, as (u, v).
  [[nodiscard]] V2f uv(const V3d& origin, const V3f& direction) const noexcept {
    const V3d n(frame.n), d(direction), p = origin + d * ((centre - origin).dot(n) / d.dot(n)) - centre;
    return {static_cast<float>(0.5 + 0.5 * p.dot(V3d(frame.t)) / half),
            static_cast<float>(0.5 + 0.5 * p.dot(V3d(frame.b)) / half)};
  }
  [[nodiscard]] V3d point(const V2f& uv) const noexcept {
    return centre + V3d(frame.t) * ((2.0 * uv.x - 1) * half) + V3d(frame.b) * ((2.0 * uv.y - 1) * half);
  }
  // Density of lines across themselves, from that of (u, v).
  [[nodiscard]] float pdf(float pdf_uv, const V3f& direction) const noexcept {
    return pdf_uv / (4 * half * half * std::abs(direction.dot(frame.n)));
  }
};

}  // namespace sluice
