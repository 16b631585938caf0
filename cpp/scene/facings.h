// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh light's triangles in groups of like normals. Of a lamp's surface one sees half or less from any
// point: a group tells how much of its light may come there, so that next-event estimation seldom asks
// triangles that look away (for a sphere, every second sample).
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"
#include "base/sampling.h"

namespace sluice {

struct EmissiveTriangle {
  std::uint32_t triangle;  // index in the mesh
  float area, light;       // m²; of the light, a share that is not normalised
  V3f normal;              // unit
  std::array<V3d, 3> corners;
};

class Facings {
 public:
  static constexpr int max_facings = 24;  // quarters of a cube's faces

  // Which quarter of which face a normal goes through.
  [[nodiscard]] static int bin_of(const V3f& normal) noexcept;

  Facings() = default;
  // Of triangles, in the order of their bins, of a mesh that has `mesh_triangles`. `front`: 1 or -1 = a
  // closed surface that is seen from where the normals point, or from the other side; 0 = open, seen from
  // both.
  Facings(std::span<const EmissiveTriangle> triangles, std::size_t mesh_triangles, int front);

  // the group of a triangle of the mesh
  [[nodiscard]] int of(std::uint32_t triangle) const noexcept { return of_[triangle]; }
  [[nodiscard]] int front() const noexcept { return front_; }

  // How strongly a group lights a point, relative to its light: about the cosine between its normals and the
  // way to the point, by the way's square.
  struct Seen {
    std::array<float, max_facings> part;
    double all;  // of the whole mesh's light
  };
  [[nodiscard]] Seen seen_from(const V3d& point) const noexcept;
  // A number for Distribution::sample(), so that groups are chosen by what is seen of them. `u` in [0, 1). In
  // double, as small groups may be all that is seen.
  [[nodiscard]] double choose(const Seen& seen, float u) const noexcept;
  // How many times likelier that makes a triangle of the group than its light alone.
  [[nodiscard]] static float ratio(const Seen& seen, int group) noexcept {
    return static_cast<float>(seen.part[static_cast<std::size_t>(group)] / seen.all);
  }

 private:
  struct Group {
    V3f axis;            // of a cone around its normals
    float cosine, sine;  // of that cone's half angle
    V3d middle;          // of a sphere around its triangles (m)
    double reach;
    double before, share;  // of the light: of the groups before it; its own
  };
  [[nodiscard]] static Group group_of(std::span<const EmissiveTriangle> triangles);
  [[nodiscard]] float part(const Group& group, const V3d& point) const noexcept;

  std::vector<Group> groups_;
  std::vector<std::uint8_t> of_;
  int front_ = 0;
};

}  // namespace sluice
