// SPDX-License-Identifier: GPL-3.0-or-later
// Geometry of one entry or exit (design §2), in double and re-centred space (world = re-centred + centre).
// Knows no expression. A quad floats in front of its own plane, on the side of its arrow. Quads of one plane
// group are moved onto one plane, so that a ray meets all of them at one and the same t and `order` decides.
#pragma once
#include <array>
#include <optional>
#include <span>

#include "base/cancel.h"
#include "base/math.h"
#include "edit/description.h"

namespace sluice {

// Orthonormal, left-handed for a mirrored quad.
struct QuadFrame {
  V3d t, b, n;  // unit image of local X; ± n × t; unit normal on the arrow's side
  [[nodiscard]] V3d to_local(const V3d& w) const noexcept { return {w.dot(t), w.dot(b), w.dot(n)}; }
  [[nodiscard]] V3d to_world(const V3d& l) const noexcept { return t * l.x + b * l.y + n * l.z; }
};

struct Quad {
  V3d corner, edge_u, edge_v;  // point(u, v) = corner + u edge_u + v edge_v
  QuadFrame frame;
  V3d dual_u, dual_v;  // u = p · dual_u - u0, for p in the plane
  double u0 = 0, v0 = 0;
  V3d plane_normal;  // of the plane group: plane_normal · p = plane_offset
  double plane_offset = 0;
  // A few ulp of the largest coordinate, by which a quad is larger so that neighbours share their edge; in m,
  // and in u and v.
  double slack = 0, slack_u = 0, slack_v = 0;
  double area = 0;
  double offset = 0;  // the artist's
  int order = 0;
  int group = -1;

  [[nodiscard]] V3d point(const V2d& uv) const noexcept { return corner + edge_u * uv.x + edge_v * uv.y; }
};

struct QuadHit {
  double t;
  V2d uv;  // in [0, 1]²
};

// A direction that is more nearly parallel to a quad does not cross it.
inline constexpr double min_crossing_cosine = 1e-6;

// World positions of the corners (0,0) (1,0) (0,1) (1,1). Empty if a number is not finite or beyond 1e15.
[[nodiscard]] std::optional<std::array<V3d, 4>> quad_corners(const QuadDescription& description) noexcept;

// True if quad_corners() has an answer.
[[nodiscard]] bool is_finite(const QuadDescription& description) noexcept;

// The quad before place_quads() makes it float. Empty if it has no corners, or an area below 1e-12 extent².
[[nodiscard]] std::optional<Quad> make_quad(const QuadDescription& description, const V3d& centre,
                                            double extent);

// Floats every quad by delta + its offset, finds the plane groups (normals equal up to sign, floated planes
// within delta / 2) and moves each quad onto the plane of its group. `scale`: largest |coordinate| that rays
// have, for the slack. Returns the number of groups.
int place_quads(std::span<Quad* const> quads, double delta, double scale, const CancelPoint& cancel = {});

// The ray's crossing, whatever its t (also behind the origin); empty outside of the quad or if nearly
// parallel (|n·d| < 1e-6, d unit).
[[nodiscard]] std::optional<QuadHit> intersect(const Quad& quad, const V3d& origin,
                                               const V3d& direction) noexcept;

// (u, v) of a point in the quad's plane; empty if the point lies outside of the quad.
[[nodiscard]] std::optional<V2d> locate(const Quad& quad, const V3d& point) noexcept;

}  // namespace sluice
