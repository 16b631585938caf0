// SPDX-License-Identifier: GPL-3.0-or-later
// What the camera sees, as the pilot finds it: places v of view paths and, one diffuse segment further, y.
// Everything is measured in parts of the picture and not of the scene, so that a room on a plain of a hundred
// kilometres is known as well as the room alone.
#pragma once
#include <array>
#include <atomic>
#include <map>
#include <span>
#include <vector>

#include "scene/scene.h"
#include "transport/cells.h"
#include "transport/settings.h"
#include "transport/target.h"
#include "transport/vertex.h"

namespace sluice {

// A sphere around a part of what is seen.
struct Sight {
  Target sphere;
  float share;  // of all that is seen, beyond the sight before it
};

// Surfaces met by view paths, counted in cells that grow with their distance from the camera, and by the side
// that was seen: light on the outside of a wall brings nothing to a picture of its inside.
class Visible {
 public:
  explicit Visible(const Scene& scene) noexcept : scene_(scene) {}

  void add(const Vertex& vertex, const V3f& direction);  // met by a ray in that direction
  // met just outside of the picture: the cell is known, and nothing was seen in it
  void add_beside(const V3d& p);

  [[nodiscard]] bool empty() const noexcept { return hits_.empty(); }
  // ng on the side that was seen; v and y take turns
  [[nodiscard]] const std::vector<Hit>& hits() const noexcept { return hits_; }
  [[nodiscard]] std::size_t cell_count() const noexcept { return sides_.size(); }
  // The cell that holds p, -1 if nothing was seen there or just beside; and its edge (m).
  [[nodiscard]] int cell(const V3d& p) const noexcept;
  [[nodiscard]] double edge(const V3d& p) const noexcept;
  // How many of the hits in a cell show this side.
  [[nodiscard]] double hits_in(int cell, const V3f& normal) const noexcept;

  // Spheres around the nearest quarter of what is seen, the nearest half and so on, where each is much larger
  // than the one before; the last holds all but outliers. Shares sum to 1. None: nothing is seen.
  [[nodiscard]] std::vector<Sight> sights() const;

  // of a pixel at v (m): half of all see a smaller one (a mean would be the horizon's)
  double footprint = 0;
  double mean_length = 0;  // from v to y (m)

 private:
  using Sides = std::array<std::uint32_t, 6>;  // hits by the axis that their normal is next to
  Sides& sides_of(const V3d& p);
  [[nodiscard]] int level(const V3d& p) const noexcept;

  const Scene& scene_;
  std::map<int, NumberedCells<std::uint32_t>> levels_;  // edge 2^level; each cell holds its number + 1
  std::vector<Sides> sides_;
  std::vector<Hit> hits_;
};

// About `wanted` of hits, evenly chosen: every n-th, n odd, as v and y take turns in what is seen.
class SomeHits {
 public:
  SomeHits(std::span<const Hit> hits, std::size_t wanted) noexcept
      : hits_(hits), step_(hits.size() / wanted | 1) {}

  [[nodiscard]] std::size_t size() const noexcept { return (hits_.size() + step_ - 1) / step_; }
  [[nodiscard]] std::size_t number(std::size_t i) const noexcept { return i * step_; }  // among all hits
  [[nodiscard]] const Hit& operator[](std::size_t i) const noexcept { return hits_[number(i)]; }

 private:
  std::span<const Hit> hits_;
  std::size_t step_;
};

// Camera rays through mirrors and glass to v, and one diffuse segment on to y.
[[nodiscard]] Visible look_around(const Scene& scene, const TransportSettings& settings,
                                  const std::atomic<bool>& cancel);

}  // namespace sluice
