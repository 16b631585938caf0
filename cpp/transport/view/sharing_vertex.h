// SPDX-License-Identifier: GPL-3.0-or-later
// Vertices v of a bundle that share what their gather segments find, and their connections to such a point y
// (Bekaert, Sbert, Halton 2002, "Accelerating path tracing by re-using paths").
#pragma once
#include <cmath>
#include <span>

#include "transport/view/view_path.h"
#include "transport/view/view_sample.h"

namespace sluice {

// One sample can contribute several such vertices (a mirror over a diffuse base; both branches of glass). All
// of them send gather segments on the passes on which the sample does.
struct SharingVertex {
  std::size_t sample = 0;  // its index in the bundle
  ViewPath path;           // from the eye to v
  Vertex v;
  // Hash of what the path met from the eye to v. Where it is equal, so are events, depth and kinds of lobes;
  // only such vertices share.
  std::uint64_t signature = 0;
};
inline constexpr std::size_t max_sharing = 2 * bundle_size;  // a vertex beyond them gathers for itself

struct Connection {
  const SharingVertex* to = nullptr;
  V3f wi{0};  // from v to y
  double distance = 0;
  float geometry = 0;    // cos at y / distance²
  float pdf = 0;         // with which `to` sends a gather segment by wi (1/sr)
  bool is_open = false;  // nothing lies on it, and no entry takes its light
};

// Closer to grazing, y's shading normal depends on who looks (scene/surface.cpp).
inline constexpr float min_cosine_at_y = 0.02f;

// False: v sees y from a side or at an angle from which y is not what its finder saw.
[[nodiscard]] inline bool connect(const SharingVertex& to, const Vertex& y, Connection& connection) noexcept {
  const V3d towards = y.hit.position - to.v.hit.position;
  const double distance2 = towards.length2();
  connection.to = &to, connection.distance = std::sqrt(distance2);
  if (!(connection.distance > 0)) return false;
  connection.wi = V3f(towards / connection.distance);
  const float cosine = -connection.wi.dot(y.point.ng);
  connection.geometry = static_cast<float>(cosine / distance2);
  return cosine >= min_cosine_at_y && -connection.wi.dot(y.point.ns) >= min_cosine_at_y;
}

// The density (per area at y) with which all open connections together find y. With it as the denominator of
// every estimate (balance heuristic) nothing is counted twice, whoever found y. mean_segments(vertex): how
// many segments it sends in the mean.
template <class MeanSegments>
[[nodiscard]] float density_of(std::span<const Connection> connections, MeanSegments&& mean_segments) {
  float density = 0;
  for (const Connection& c : connections)
    if (c.is_open) density += mean_segments(*c.to) * c.pdf * c.geometry;
  return density;
}

}  // namespace sluice
