// SPDX-License-Identifier: GPL-3.0-or-later
// The pilot's own photons: what lights bring to the scene, found out before anything is known of it.
#pragma once
#include <vector>

#include "transport/guide.h"
#include "transport/guide/pilot_context.h"
#include "transport/photons/photon.h"

namespace sluice {

// A photon that the pilot sent out, and where those that it left behind end in their chunk.
struct PilotPath {
  int light;
  V3d origin;
  V3f direction;
  std::size_t photons_end;
};

// By chunks of paths, which do not depend on threads.
struct PilotPhotons {
  std::vector<std::vector<Photon>> photons;
  std::vector<std::vector<PilotPath>> paths;
};

[[nodiscard]] PilotPhotons trace_pilot(const PilotContext& context, const EmissionGuide& emission,
                                       const LightTrusts& trust);

}  // namespace sluice
