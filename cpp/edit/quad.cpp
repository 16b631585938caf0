// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/quad.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace sluice {

namespace {

V3d row(const M44d& m, int i) noexcept { return {m[i][0], m[i][1], m[i][2]}; }

void set_duals(Quad& q) noexcept {
  const V3d n = q.edge_u.cross(q.edge_v);
  q.dual_u = q.edge_v.cross(n) / n.dot(n);
  q.dual_v = n.cross(q.edge_u) / n.dot(n);
  q.u0 = q.dual_u.dot(q.corner);
  q.v0 = q.dual_v.dot(q.corner);
  q.slack_u = q.dual_u.length() * q.slack;
  q.slack_v = q.dual_v.length() * q.slack;
}

V3d middle(const Quad& q) noexcept { return q.corner + (q.edge_u + q.edge_v) * 0.5; }

// All of `q` lies within `distance` of the plane of `other`.
bool is_near_plane(const Quad& q, const Quad& other, double distance) noexcept {
  const V3d from = q.corner - middle(other);
  const double d = from.dot(other.frame.n), du = q.edge_u.dot(other.frame.n),
               dv = q.edge_v.dot(other.frame.n);
  return std::max({std::abs(d), std::abs(d + du), std::abs(d + dv), std::abs(d + du + dv)}) <= distance;
}

constexpr double like_normal = 1e-4;  // rad; quads of float32 matrices agree to 1e-6

// One plane: normals equal up to sign and planes within `distance` of each other all over both quads.
bool share_plane(const Quad& a, const Quad& b, double distance) noexcept {
  if (1 - std::abs(a.frame.n.dot(b.frame.n)) > 0.5 * like_normal * like_normal) return false;
  return is_near_plane(a, b, distance) && is_near_plane(b, a, distance);
}

// Union-find over quads that share planes: root of each quad. Such planes lie about equally far from the
// origin, so in that order only near ones are compared.
std::vector<std::size_t> find_groups(std::span<Quad* const> quads, double distance,
                                     const CancelPoint& cancel) {
  std::vector<std::size_t> parent(quads.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<std::pair<double, std::size_t>> order;
  double reach = 0;
  for (std::size_t i = 0; i < quads.size(); ++i) {
    const V3d m = middle(*quads[i]);
    order.emplace_back(std::abs(m.dot(quads[i]->frame.n)), i);
    reach = std::max(reach, m.length());
  }
  std::ranges::sort(order);
  // |n·m| of two that share a plane differ by no more
  const double window = 1.001 * (distance + like_normal * reach);
  for (std::size_t a = 0; a < order.size(); ++a) {
    cancel();
    for (std::size_t b = a; b > 0 && order[a].first - order[b - 1].first <= window; --b) {
      const std::size_t i = order[a].second, j = order[b - 1].second;
      if (root(i) != root(j) && share_plane(*quads[i], *quads[j], distance))
        parent[std::max(root(i), root(j))] = std::min(root(i), root(j));
    }
  }
  for (std::size_t i = 0; i < quads.size(); ++i) parent[i] = root(i);
  return parent;
}

}  // namespace

std::optional<std::array<V3d, 4>> quad_corners(const QuadDescription& description) noexcept {
  const V3d c = row(description.matrix, 3), x = row(description.matrix, 0) * description.half_size,
            y = row(description.matrix, 1) * description.half_size;
  const std::array<V3d, 4> corners{c - x - y, c + x - y, c - x + y, c + x + y};
  for (const V3d& p : corners)
    if (!is_finite(p) || std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > 1e15) return std::nullopt;
  return corners;
}

bool is_finite(const QuadDescription& description) noexcept {
  return quad_corners(description) && is_finite(row(description.matrix, 2)) &&
         std::isfinite(description.offset) && std::isfinite(description.half_size);
}

std::optional<Quad> make_quad(const QuadDescription& description, const V3d& centre, double extent) {
  if (!is_finite(description)) return std::nullopt;
  const V3d z = row(description.matrix, 2);

  Quad q;
  const double s = std::abs(description.half_size);
  const V3d x = row(description.matrix, 0) * s, y = row(description.matrix, 1) * s;
  q.corner = row(description.matrix, 3) - centre - x - y;
  q.edge_u = x * 2.0;
  q.edge_v = y * 2.0;
  const V3d across = q.edge_u.cross(q.edge_v);
  q.area = across.length();
  if (!(q.area > 0) || !(q.area >= 1e-12 * extent * extent)) return std::nullopt;

  // Design §2: n on the side of the image of local +Z, b = ±n × t, so that a mirrored quad has a mirrored
  // frame. b keeps to local Y.
  const V3d n = across / q.area;
  q.frame.t = q.edge_u.normalized();
  q.frame.b = n.cross(q.frame.t).normalized();
  q.frame.n = n.dot(z) < 0 ? -n : n;
  q.offset = description.offset;
  q.order = description.order;
  q.plane_normal = q.frame.n;
  q.plane_offset = q.frame.n.dot(middle(q));
  set_duals(q);
  return q;
}

int place_quads(std::span<Quad* const> quads, double delta, double scale, const CancelPoint& cancel) {
  for (Quad* q : quads) q->corner += q->frame.n * (delta + q->offset);

  const std::vector<std::size_t> root = find_groups(quads, delta / 2, cancel);
  std::vector<int> number(quads.size(), -1);
  std::vector<const Quad*> first;  // [group]: the quad of lowest order, whose plane all of them get
  for (std::size_t i = 0; i < quads.size(); ++i) {
    int& group = number[root[i]];
    if (group < 0) {
      group = static_cast<int>(first.size());
      first.push_back(quads[i]);
    }
    quads[i]->group = group;
    auto& lowest = first[static_cast<std::size_t>(group)];
    if (quads[i]->order < lowest->order) lowest = quads[i];
  }
  std::vector<V3d> normal;
  std::vector<double> offset;
  for (const Quad* q : first) {
    normal.push_back(q->frame.n);
    offset.push_back(q->frame.n.dot(middle(*q)));
  }
  for (Quad* q : quads) {
    const V3d& n = normal[static_cast<std::size_t>(q->group)];
    q->plane_normal = n;
    q->plane_offset = offset[static_cast<std::size_t>(q->group)];
    q->corner -= n * (n.dot(q->corner) - q->plane_offset);
    q->edge_u -= n * n.dot(q->edge_u);
    q->edge_v -= n * n.dot(q->edge_v);
    q->slack = 0x1p-48 * scale;
    set_duals(*q);
  }
  return static_cast<int>(first.size());
}

std::optional<V2d> locate(const Quad& q, const V3d& p) noexcept {
  const double u = q.dual_u.x * p.x + q.dual_u.y * p.y + q.dual_u.z * p.z - q.u0;
  const double v = q.dual_v.x * p.x + q.dual_v.y * p.y + q.dual_v.z * p.z - q.v0;
  if (!(u >= -q.slack_u && u <= 1 + q.slack_u && v >= -q.slack_v && v <= 1 + q.slack_v)) return std::nullopt;
  return V2d(std::clamp(u, 0.0, 1.0), std::clamp(v, 0.0, 1.0));
}

std::optional<QuadHit> intersect(const Quad& q, const V3d& o, const V3d& d) noexcept {
  const V3d& n = q.plane_normal;
  const double cosine = n.x * d.x + n.y * d.y + n.z * d.z;
  if (!(std::abs(cosine) >= min_crossing_cosine)) return std::nullopt;
  const double t = (q.plane_offset - (n.x * o.x + n.y * o.y + n.z * o.z)) / cosine;
  const auto uv = locate(q, {o.x + t * d.x, o.y + t * d.y, o.z + t * d.z});
  if (!uv) return std::nullopt;
  return QuadHit{t, *uv};
}

}  // namespace sluice
