// SPDX-License-Identifier: GPL-3.0-or-later
// A ray and what it hits, in re-centred space (world minus Scene::centre()). Positions and distances are
// double: the gates of design §2 decide by them. Knows nothing of materials or of the acceleration structure.
#pragma once
#include <algorithm>

#include "base/math.h"

namespace sluice {

struct Ray {
  V3d origin;
  V3f direction;  // unit
  double t_max = std::numeric_limits<double>::infinity();
  // Hit::clearance or EmissionPoint::clearance of the surface it leaves; 0: it starts in free space or on a
  // gate
  V3f clearance{0};
  bool from_camera = false;  // then instances hidden from the camera are not met
};

// Nearest intersection: t and position from the hit triangle's plane in double, consistent with each other
// (position = origin + t d).
struct Hit {
  double t;
  V3d position;
  V3f ng;         // unit, not flipped: the side the mesh's outside looks to
  V3f clearance;  // ng times the distance beyond which rounding cannot make a ray meet its own surface again
  std::uint32_t instance, triangle;
  float u, v;  // weights of the triangle's second and third corner
};

// The ray that goes on from a hit, on whichever side `direction` points to.
[[nodiscard]] inline Ray ray_from(const Hit& hit, const V3f& direction,
                                  double t_max = std::numeric_limits<double>::infinity()) noexcept {
  return {hit.position, direction, t_max, hit.clearance, false};
}

// Length of a shadow ray to a surface at `distance`, met at `cosine`: short of what rounding may make of the
// distance to a surface in that one's own plane (`clearance`: its error in m, without what grows with the
// distance).
[[nodiscard]] inline double short_of(double distance, double clearance, float cosine) noexcept {
  return std::max(distance - (2 * clearance + 0x1p-21 * distance) / cosine, 0.5 * distance);
}

}  // namespace sluice
