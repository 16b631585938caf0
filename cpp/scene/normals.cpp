// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/normals.h"

#include <algorithm>

namespace sluice {
namespace {

V3d direction(const V3d& v) noexcept {
  const double squared = v.length2();
  // Blender's limit: what is shorter points nowhere. NaN stays
  return squared <= 1e-35 ? V3d(0) : v * (1 / std::sqrt(squared));
}

class Polygon {
 public:
  Polygon(const MeshDescription& mesh, std::size_t index) noexcept
      : mesh_(mesh),
        first_(mesh.polygons.corners.data() + mesh.polygons.starts[index]),
        size_(mesh.polygons.sizes[index]) {}

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::uint32_t vertex(std::size_t corner) const noexcept { return first_[corner]; }
  [[nodiscard]] V3d at(std::size_t corner) const noexcept { return V3d(mesh_.positions[first_[corner]]); }
  // Newell's: that of the polygon's mean plane, bent or not. Without area it is +z, as in Blender.
  [[nodiscard]] V3d normal() const noexcept {
    V3d sum(0);
    const V3d origin = at(0);
    V3d last = at(1) - origin;
    for (std::size_t i = 2; i < size_; ++i) {
      const V3d next = at(i) - origin;
      sum += last.cross(next);
      last = next;
    }
    const V3d n = direction(sum);
    return n == V3d(0) ? V3d(0, 0, 1) : n;  // not a number: one of its vertices is none
  }

 private:
  const MeshDescription& mesh_;
  const std::uint32_t* first_;
  std::size_t size_;
};

struct Normals {
  std::vector<V3f> of_polygons;
  std::vector<V3d> of_vertices;  // sums, of no length in particular
};

void add_at_corners(const Polygon& polygon, const V3d& normal, std::vector<V3d>& sums) noexcept {
  const std::size_t size = polygon.size();
  V3d at = polygon.at(0), behind = direction(at - polygon.at(size - 1));
  for (std::size_t i = 0; i < size; ++i) {
    const V3d next = polygon.at(i + 1 < size ? i + 1 : 0), ahead = direction(next - at);
    const auto cosine = static_cast<float>(-behind.dot(ahead));
    // a weight need not be exact
    sums[polygon.vertex(i)] += normal * static_cast<double>(std::acos(std::clamp(cosine, -1.0f, 1.0f)));
    at = next, behind = ahead;
  }
}

Normals add_up(const MeshDescription& mesh, const CancelPoint& cancel) {
  const std::size_t count = mesh.polygons.starts.size();
  Normals normals{std::vector<V3f>(count, V3f(0)), std::vector<V3d>(mesh.positions.size(), V3d(0))};
  for (std::size_t i = 0; i < count; ++i) {
    cancel.at(i);
    const Polygon polygon(mesh, i);
    if (polygon.size() < 3) continue;
    const V3d normal = polygon.normal();
    if (!is_finite(normal)) continue;  // a vertex that is no number would spoil its neighbours
    normals.of_polygons[i] = V3f(normal);
    add_at_corners(polygon, normal, normals.of_vertices);
  }
  return normals;
}

}  // namespace

void make_normals(MeshDescription& mesh, const CancelPoint& cancel) {
  if (mesh.normals.empty() && !mesh.polygons.starts.empty()) {
    const Normals made = add_up(mesh, cancel);
    std::vector<V3f> of_vertices(made.of_vertices.size());
    for (std::size_t i = 0; i < of_vertices.size(); ++i) {
      const V3d n = direction(made.of_vertices[i]);
      // where they cancel out, Blender's is the position's
      of_vertices[i] = V3f(n == V3d(0) ? direction(V3d(mesh.positions[i])) : n);
    }
    mesh.normals.reserve(3 * mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const std::uint32_t polygon = mesh.polygons.of_triangles[i];
      for (const std::uint32_t vertex : mesh.triangles[i])
        mesh.normals.push_back(mesh.polygons.smooth[polygon] ? of_vertices[vertex]
                                                             : made.of_polygons[polygon]);
    }
  }
  mesh.polygons = {};
}

}  // namespace sluice
