// SPDX-License-Identifier: GPL-3.0-or-later
// What the artist sets for transport (design §8, scene.sluice). Plain data; a pass is a pure function of
// these, the scene and its index.
#pragma once
#include <cstddef>
#include <cstdint>

namespace sluice {

struct TransportSettings {
  std::uint64_t seed = 0;  // already mixed with the frame when use_animated_seed
  int photons = 65536;     // paths emitted per pass
  // of the guide; fewer in previews, and no more than a pass has photons if it is longer than a short one
  int pilot_paths = 1 << 16;
  static constexpr int short_pilot = 1 << 15;  // it finds what matters in most scenes
  int max_depth = 12;                          // D, S and G events of a whole path
  bool use_direct = true, use_caustics = true, use_edited = true, use_indirect = true;
  bool transparent_film = false;
  // photons are sent where a pilot found that they matter; false: as lights shine, to see what that brings
  bool use_guide = true;
  // several samples of a pixel in each pass, and several lights asked by each, where a pilot finds noise
  bool use_adaptive_sampling = true;
  // bytes, of the states of paths (edit/state_table.h) of all threads together
  std::size_t state_memory = std::size_t{2} << 30;
  float caustic_radius_factor = 4;  // k: radius of caustics and edited light in footprints of a pixel
  // that radius is at most so many times wider or narrower where the pilot finds few or many photons; 1:
  // never
  float caustic_radius_range = 2.5f;
  float soft_range = 3;  // of light that was scattered before, so many times wider still
};

// What one table of states may hold: a thread has one for light paths and one for view paths, and edits are
// explained with one more.
[[nodiscard]] inline std::size_t state_memory_of_one(const TransportSettings& settings,
                                                     int threads) noexcept {
  return settings.state_memory / (2 * static_cast<std::size_t>(threads) + 1);
}

}  // namespace sluice
