// SPDX-License-Identifier: GPL-3.0-or-later
// What the artist sets for transport (design §8, scene.sluice). Plain data; a pass is a pure function of these, the scene and its index.
#pragma once
#include <cstdint>

namespace sluice {

struct TransportSettings {
  std::uint64_t seed = 0;     // already mixed with the frame when use_animated_seed
  int photons = 65536;        // paths emitted per pass
  int pilot_paths = 1 << 17;  // of the guide; fewer in previews
  int max_depth = 12;         // D, S and G events of a whole path
  bool use_direct = true, use_caustics = true, use_edited = true, use_indirect = true;
  bool transparent_film = false;
  float caustic_radius_factor = 4;  // k: radius of caustics and edited light in footprints of a pixel
};

}  // namespace sluice
