// SPDX-License-Identifier: GPL-3.0-or-later
// How wide photon densities are estimated in the first pass, from where the pilot's photons lie.
#pragma once
#include <optional>

#include "transport/guide/pilot_context.h"
#include "transport/guide/visible.h"
#include "transport/photons/disks.h"

namespace sluice {

// Of gathers at y (m): bounds, and what is typical.
struct GatherRadii {
  float min, max, typical;
};
// From the mean density of the pilot's photons where the camera looks; empty: nothing is seen.
[[nodiscard]] std::optional<GatherRadii> size_gathers(const PilotContext& context, PhotonMap::Chunks photons,
                                                      const Visible& seen);

// Of kernels at v: of photons that come by mirrors, glass and exits, and of what is soft of those.
struct DiskRadii {
  RadiusCache sharp, soft;
};
[[nodiscard]] DiskRadii size_disks(const PilotContext& context, PhotonMap::Chunks photons,
                                   const Visible& seen, const DiskBounds& bounds);

}  // namespace sluice
