// SPDX-License-Identifier: GPL-3.0-or-later
// Where photons are sent (design §5): fixed before the first pass, the same for every process that renders
// the scene. Made by a pilot (pilot.h); none of the pilot's photons is in the image. A guide changes noise,
// never what an image converges to. Where view samples go is found out last, with the photons of the first
// pass (sample_pilot.h).
#pragma once
#include <cstdint>
#include <vector>

#include "base/sampling.h"
#include "scene/light.h"
#include "transport/cells.h"
#include "transport/disks.h"
#include "transport/sample_map.h"

namespace sluice {

// A sphere (re-centred) that is worth aiming at: around a specular object, an entry that really captures
// light, entries outside of all surfaces, or what the camera sees.
struct Target {
  V3d centre;
  float radius;
};

// Where the useful photons of one light start: of a finite light the direction (equal cells of the sphere),
// of a sun the place on a plane across its rays. Half of a lamp in a fixture lights the fixture, most of a
// sun misses the window; this learns it.
class AimTable {
 public:
  static constexpr int side = 64, cells = side * side;

  AimTable() = default;
  explicit AimTable(std::span<const float> useful) : cells_(useful) {}
  [[nodiscard]] bool empty() const noexcept { return cells_.empty(); }
  [[nodiscard]] const Distribution& distribution() const noexcept { return cells_; }

  // (u, v) in [0, 1]² and back, density there.
  [[nodiscard]] static int cell(const V2f& uv) noexcept {
    const auto index = [](float x) { return std::clamp(static_cast<int>(x * side), 0, side - 1); };
    return index(uv.y) * side + index(uv.x);
  }
  [[nodiscard]] float pdf(const V2f& uv) const noexcept {
    const bool inside = uv.x >= 0 && uv.x < 1 && uv.y >= 0 && uv.y < 1;
    return inside ? cells_.pmf(static_cast<std::size_t>(cell(uv))) * cells : 0;
  }
  [[nodiscard]] V2f sample(float u_cell, const V2f& u) const noexcept {
    const auto index = static_cast<int>(cells_.sample(u_cell).index);
    return {(static_cast<float>(index % side) + u.x) / side, (static_cast<float>(index / side) + u.y) / side};
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

// How next-event estimation chooses of a few lights, by places: a wall that the sun never reaches asks the
// lamp.
class LightTrusts {
 public:
  LightTrusts() = default;
  // One row of numbers, a number per light, for anywhere; then one for each of the cells, which tell their
  // rows. `hidden`: per light, whether photon density has its straight light at y.
  LightTrusts(NumberedCells<std::uint32_t> cells, std::vector<float> rows, std::vector<char> hidden)
      : cells_(std::move(cells)), hidden_(std::move(hidden)), at_v_(std::move(rows)), at_y_(at_v_) {
    for (std::size_t i = 0; i < at_y_.size(); ++i)
      if (hidden_[i % hidden_.size()]) at_y_[i] = 0;
  }

  [[nodiscard]] LightTrust at_v(const V3d& p) const noexcept { return row(at_v_, p); }
  // 0 for the hidden ones
  [[nodiscard]] LightTrust at_y(const V3d& p) const noexcept { return row(at_y_, p); }
  [[nodiscard]] bool is_hidden(int light) const noexcept {
    return !hidden_.empty() && hidden_[static_cast<std::size_t>(light)];
  }
  [[nodiscard]] std::uint64_t hash() const noexcept {
    std::uint64_t h = cells_.hash();
    for (const float t : at_v_) h = mix(h, std::bit_cast<std::uint32_t>(t));
    for (const char is : hidden_) h = mix(h, static_cast<std::uint64_t>(is));
    return h;
  }

 private:
  [[nodiscard]] LightTrust row(const std::vector<float>& rows, const V3d& p) const noexcept {
    // a light alone is chosen anyway
    const std::uint32_t* cell = hidden_.size() > 1 ? cells_.find(p) : nullptr;
    return LightTrust(rows).subspan((cell ? *cell : 0) * hidden_.size(), hidden_.size());
  }

  NumberedCells<std::uint32_t> cells_;
  std::vector<char> hidden_;
  std::vector<float> at_v_, at_y_;
};

// A light (or an effect) that may well bring something to the picture, though the pilot found nothing of it
// there. Its noise is not known before it is found.
struct Unmet {
  int light;  // -1: an effect
  const char* effect;
  float share;  // of the photons, kept for it
};

struct Guide {
  LightTrusts trust;
  Distribution lights;  // share of the photons of each light
  std::vector<Target> targets;
  // per light; empty for the world, and where few useful photons are known
  std::vector<AimTable> aims;
  Target aimed{V3d(0), 0};  // the sphere that the tables of suns cover
  // Per light: 0 = its own distribution (>= 25 %), 1 + t = towards target t, 1 + number of targets = by its
  // aims.
  std::vector<Distribution> strategies;
  float least_radius = 0, most_radius = 0;  // of gathers at y in the first pass (m)
  // of caustics and edited light, and of what is soft of those (photon.h)
  Disks sharp_disks, soft_disks;
  // typical radii of the first pass, at y, which the photon map's cells are made for, and at v
  float radius = 0, caustic_radius = 0;
  SampleMap samples;         // of each pixel in a pass
  std::vector<Unmet> unmet;  // no part of the hash

  [[nodiscard]] std::uint64_t hash() const noexcept;
};

}  // namespace sluice
