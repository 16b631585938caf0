// SPDX-License-Identifier: GPL-3.0-or-later
// How the photons of a pass are shared among lights, and those of each light among directions and targets:
// learned from the pilot's own, by what they bring to the picture. A part of every share is kept by what
// lights can send to what is seen, whatever the pilot found: it may have met none of the few photons that
// come through a keyhole.
#pragma once
#include <vector>

#include "transport/light_path.h"
#include "transport/targets.h"
#include "transport/visible.h"

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

// What the mixture of emission is built of.
struct EmissionPlan {
  std::vector<Target> things;  // that mirror or refract, and entries that take light
  std::vector<Sight> sights;
  FarEntries far;
  std::vector<double> possible;  // shares of lights by what they can send to the sights

  EmissionPlan(const Scene& scene, std::vector<Target> things, std::vector<Sight> sights, FarEntries far);
  // Targets of the guide: things, sights, and the one of far entries. Sights and that one start at these.
  [[nodiscard]] std::vector<Target> targets() const;
  [[nodiscard]] std::size_t first_sight() const noexcept { return things.size(); }
  [[nodiscard]] std::size_t far_target() const noexcept { return things.size() + sights.size(); }
};

// For the pilot itself, which knows nothing yet. Half of its photons come from lights by what they can send
// to the sights, half from all alike; of each light's, half leave as they would anyway, a quarter go towards
// things and a quarter towards sights.
void aim_pilot(const EmissionPlan& plan, const Scene& scene, Guide& guide);

[[nodiscard]] PilotPhotons trace_pilot(const Scene& scene, const TransportSettings& settings,
                                       const Guide& guide, std::span<LightTracer> tracers, ThreadPool& pool,
                                       const std::atomic<bool>& cancel);

// Sets guide.lights, strategies, aims and unmet.
void learn_emission(const EmissionPlan& plan, const Scene& scene, const TransportSettings& settings,
                    const Effects& effects, const PilotPhotons& pilot, const Visible& seen, ThreadPool& pool,
                    Guide& guide);

}  // namespace sluice
