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

struct Guide {
  Distribution lights;                    // share of the photons of each light
  std::vector<Target> targets;
  std::vector<Distribution> strategies;   // per light: 0 = its own distribution (>= 25 %), 1 + t = towards target t
  float radius = 0, caustic_radius = 0;   // typical gather radii of the first pass (m): sizes of the photon maps' cells

  [[nodiscard]] std::uint64_t hash() const noexcept;
};

}  // namespace sluice
