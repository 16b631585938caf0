// SPDX-License-Identifier: GPL-3.0-or-later
// Where photons are sent (design §5): fixed before the first pass, the same for every process that renders
// the scene. Made by a pilot (pilot.h); none of the pilot's photons is in the image. A guide changes noise,
// never what an image converges to. Where view samples go is found out last, with the photons of the first
// pass (sample_pilot.h).
#pragma once
#include <cstdint>
#include <vector>

#include "transport/emission_mixture.h"
#include "transport/light_trust.h"
#include "transport/radius_cache.h"
#include "transport/sample_map.h"

namespace sluice {

// A light (or an effect) that may well bring something to the picture, though the pilot found nothing of it
// there. Its noise is not known before it is found.
struct Unmet {
  int light;  // -1: an effect
  const char* effect;
  float share;  // of the photons, kept for it
};

struct Guide {
  EmissionGuide emission;
  LightTrusts trust;
  float min_radius = 0, max_radius = 0;  // of gathers at y in the first pass (m)
  // of caustics and edited light, and of what is soft of those (arrival.h)
  RadiusCache sharp_disks, soft_disks;
  // typical radii of the first pass, at y, which the photon map's cells are made for, and at v
  float radius = 0, caustic_radius = 0;
  SampleMap samples;         // of each pixel in a pass
  std::vector<Unmet> unmet;  // no part of the hash

  [[nodiscard]] std::uint64_t hash() const noexcept;
};

}  // namespace sluice
