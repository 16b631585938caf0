// SPDX-License-Identifier: GPL-3.0-or-later
// All that the parts of a ViewTracer read. The last three are those of the pass.
#pragma once
#include "transport/photons/photon_set.h"
#include "transport/pass.h"

namespace sluice {

struct ViewContext {
  const Scene& scene;
  const TransportSettings& settings;
  const Effects& effects;
  const PhotonSet* photons = nullptr;
  const Guide* guide = nullptr;
  float radius_scale = 1;  // of photon densities, which shrink from pass to pass
};

}  // namespace sluice
