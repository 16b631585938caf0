// SPDX-License-Identifier: GPL-3.0-or-later
// One pass = (photons, view samples), a pure function of scene, settings, guide and pass index (Knaus &
// Zwicker 2011: no statistics are kept from pass to pass, so passes may run in any order and on any machine).
#pragma once
#include <vector>

#include "base/random.h"
#include "transport/effects.h"
#include "transport/guide.h"
#include "transport/settings.h"

namespace sluice {

// Names of the random keys: what a number is drawn for. What is found out before the first pass or after the
// last has a second name.
enum class Purpose : std::uint64_t { Photons = 1, View, PhotonChoices, ViewChoices, Pilot, Turns, Emission };
enum class PilotPurpose : std::uint64_t { View, Entries, Photons, Arrivals, Lights, Samples, Margin };
[[nodiscard]] inline std::uint64_t key_of(std::uint64_t seed, Purpose purpose, std::uint64_t a,
                                          std::uint64_t b = 0) noexcept {
  return mix(mix(mix(seed, static_cast<std::uint64_t>(purpose)), a), b);
}
[[nodiscard]] inline std::uint64_t key_of(std::uint64_t seed, PilotPurpose purpose,
                                          std::uint64_t a = 0) noexcept {
  return key_of(seed, Purpose::Pilot, static_cast<std::uint64_t>(purpose), a);
}

// All that a pass reads; immutable while one of its halves runs.
struct PassContext {
  const Scene& scene;
  const TransportSettings& settings;
  const Effects& effects;
  const Guide& guide;
  int pass = 0;
};

}  // namespace sluice
