// SPDX-License-Identifier: GPL-3.0-or-later
// How the photons of a pass are shared among lights, and those of each light among directions and targets:
// learned from the pilot's own, by what they bring to the picture. A part of every share is kept by what
// lights can send to what is seen, whatever the pilot found: it may have met none of the few photons that
// come through a keyhole.
#pragma once
#include <utility>
#include <vector>

#include "transport/guide.h"
#include "transport/guide/pilot_photons.h"
#include "transport/guide/targets.h"
#include "transport/guide/visible.h"

namespace sluice {

// What the mixtures of emission are built of.
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
[[nodiscard]] EmissionGuide emission_of_pilot(const EmissionPlan& plan, const Scene& scene);

// For the passes, from photons that the pilot sent out by `first`; and what it did not meet.
[[nodiscard]] std::pair<EmissionGuide, std::vector<Unmet>> learn_emission(const PilotContext& context,
                                                                          const EmissionPlan& plan,
                                                                          const EmissionGuide& first,
                                                                          const PilotPhotons& pilot,
                                                                          const Visible& seen);

}  // namespace sluice
