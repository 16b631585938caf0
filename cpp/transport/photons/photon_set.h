// SPDX-License-Identifier: GPL-3.0-or-later
// The photons of one pass as view paths read them.
#pragma once
#include "transport/photons/photon_map.h"
#include "transport/photons/photon_states.h"

namespace sluice {

struct PhotonSet {
  PhotonMap
      at_y;  // every stored photon, for the far ends y of gather segments; empty while indirect light is off
  PhotonMap at_v;  // caustics and edited light, for the vertices v of view paths, each by its own reach
  const PhotonStates* states = nullptr;  // of their q; of the PhotonPass that made them
};

}  // namespace sluice
