// SPDX-License-Identifier: GPL-3.0-or-later
// One pass = (photons, view samples), a pure function of scene, settings, guide and pass index (Knaus & Zwicker 2011: no statistics
// are kept from pass to pass, so passes may run in any order and on any machine).
#pragma once
#include <cmath>
#include <vector>

#include "base/random.h"
#include "transport/effects.h"
#include "transport/guide.h"
#include "transport/photon_map.h"
#include "transport/photon_states.h"
#include "transport/settings.h"

namespace sluice {

// Names of the random keys: what a number is drawn for. What is found out before the first pass or after the last has a second name.
enum class Purpose : std::uint64_t { Photons = 1, View, PhotonChoices, ViewChoices, Pilot, Turns };
enum class PilotPurpose : std::uint64_t { View, Entries, Photons, Arrivals, Lights, Samples };
[[nodiscard]] inline std::uint64_t key_of(std::uint64_t seed, Purpose purpose, std::uint64_t a, std::uint64_t b = 0) noexcept {
  return mix(mix(mix(seed, static_cast<std::uint64_t>(purpose)), a), b);
}
[[nodiscard]] inline std::uint64_t key_of(std::uint64_t seed, PilotPurpose purpose, std::uint64_t a = 0) noexcept {
  return key_of(seed, Purpose::Pilot, static_cast<std::uint64_t>(purpose), a);
}

inline constexpr float least_radius_of_extent = 1e-6f, most_radius_of_extent = 0.02f;  // bounds of common radii, in sizes of the scene

// r_p = r_0 (p + 1)^(-1/6): alpha = 2/3, the rate with the least error (Kaplanyan & Dachsbacher 2013).
[[nodiscard]] inline float radius_scale(int pass) noexcept { return static_cast<float>(std::pow(pass + 1.0, -1.0 / 6.0)); }

// The widest disk at v in the first pass, where a common one has this radius: for caustics and edited light; for soft ones.
[[nodiscard]] inline float widest_disk(const TransportSettings& settings, float radius) noexcept { return settings.caustic_radius_range * radius; }
[[nodiscard]] inline float widest_soft_disk(const TransportSettings& settings, float radius, double extent) noexcept {
  const float widest = widest_disk(settings, radius);
  return std::max(widest, std::min(settings.soft_range * widest, most_radius_of_extent * static_cast<float>(extent)));
}

// Caustics and edited light are estimated by a kernel that falls to 0 so many radii away (√1.5; density.h).
inline constexpr float round_reach = 1.2247449f;

// Gather radius at y in the first pass. A gather segment stands for a bundle of directions: features below a tenth of its length
// times the spread of its lobe drown in its noise. Near corners, where y is close to v, the radius stays small and so does the bias;
// the guide bounds it from both sides by the number of photons to be found.
[[nodiscard]] inline float gather_radius(const Guide& guide, double length, float lobe_pdf) noexcept {
  const double spread = std::min(1.0, 1 / std::sqrt(static_cast<double>(lobe_pdf)));
  return std::clamp(static_cast<float>(0.1 * length * spread), guide.least_radius, guide.most_radius);
}

// The photons of a pass, sorted.
struct PhotonSet {
  PhotonMap all;    // every stored photon: what a gather segment's end reads
  PhotonMap close;  // caustics and edited light: what the view path's own vertex reads, with a smaller radius
  PhotonMap soft;   // what is soft of them (photon.h), read there with a wider disk
  const PhotonStates* states = nullptr;  // of their q; of the PhotonPass that made them
};

// All that a pass reads; immutable while one of its halves runs.
struct PassContext {
  const Scene& scene;
  const TransportSettings& settings;
  const Effects& effects;
  const Guide& guide;
  int pass = 0;
};

}  // namespace sluice
