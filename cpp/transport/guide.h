// SPDX-License-Identifier: GPL-3.0-or-later
// Where photons are sent (design §5): fixed before the first pass, the same for every process that renders the scene. Made by a pilot
// (pilot.h); none of the pilot's photons is in the image. A guide changes noise, never what an image converges to.
#pragma once
#include <cstdint>
#include <vector>

#include "base/sampling.h"

namespace sluice {

// A sphere (re-centred) that is worth aiming at: around a specular object, an entry that really captures light, or what the camera sees.
struct Target {
  V3d centre;
  float radius;
};

// Directions (world) in which a finite light's photons turned out to be useful: equal cells of (cos, longitude). Half of a lamp in a
// fixture lights the fixture; this learns it.
class DirectionTable {
 public:
  static constexpr int rows = 16, columns = 32, cells = rows * columns;

  DirectionTable() = default;
  explicit DirectionTable(std::span<const float> useful) : cells_(useful) {}
  [[nodiscard]] bool empty() const noexcept { return cells_.empty(); }
  [[nodiscard]] const Distribution& distribution() const noexcept { return cells_; }
  [[nodiscard]] static int cell(const V3f& d) noexcept {
    const int row = std::clamp(static_cast<int>((d.z + 1) * 0.5f * rows), 0, rows - 1);
    const float turn = std::atan2(d.y, d.x) * (0.5f / pi);
    return row * columns + std::clamp(static_cast<int>((turn < 0 ? turn + 1 : turn) * columns), 0, columns - 1);
  }
  [[nodiscard]] float pdf(const V3f& d) const noexcept { return cells_.pmf(static_cast<std::size_t>(cell(d))) * (cells / (4 * pi)); }
  [[nodiscard]] V3f sample(float u_cell, const V2f& u) const noexcept {
    const auto index = static_cast<int>(cells_.sample(u_cell).index);
    const float z = 2 * (static_cast<float>(index / columns) + u.x) / rows - 1, phi = 2 * pi * (static_cast<float>(index % columns) + u.y) / columns;
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  Distribution cells_;
};

struct Guide {
  Distribution lights;                    // share of the photons of each light
  std::vector<Target> targets;
  std::vector<DirectionTable> directions; // per light; empty for light from infinity
  // Per light: 0 = its own distribution (>= 25 %), 1 + t = towards target t, 1 + number of targets = by its directions.
  std::vector<Distribution> strategies;
  float least_radius = 0, most_radius = 0;  // of gathers at y in the first pass (m)
  float radius = 0, caustic_radius = 0;     // typical gather radii of the first pass, at y and v: sizes of the photon maps' cells

  [[nodiscard]] std::uint64_t hash() const noexcept;
};

}  // namespace sluice
