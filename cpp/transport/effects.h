// SPDX-License-Identifier: GPL-3.0-or-later
// Which estimators run (design §6, "only what the scene calls for"): decided once per scene from materials,
// lights, edits and the user's switches. What nothing can produce costs no rays, no photons, no memory, and
// the reason is written down.
#pragma once
#include <string>
#include <vector>

#include "scene/scene.h"
#include "transport/settings.h"

namespace sluice {

struct Effects {
  bool direct = false, caustics = false, edited = false, indirect = false;
  // Some light has an extent, so that directions drawn from lobes can meet it: else direct light sends none.
  bool lobes_find_lights = false;
  bool light_edits = false, view_edits = false;
  bool layers = false;         // images of whole paths beside the picture
  bool tracks_states = false;  // one of these three asks what happened to light: else nobody keeps it
  // Bit set of Arrival: photons that some estimator reads; direct ones only of lights that are near or hidden
  // (light_tracer.cpp).
  unsigned stored_arrivals = 0;
  // of those, the ones read at the view path's own vertex: caustics, edited light
  unsigned arrivals_at_v = 0;

  [[nodiscard]] bool traces_photons() const noexcept { return stored_arrivals != 0; }

  struct Reason {
    std::string effect;  // or "edit NAME", "layer NAME"
    bool runs;
    std::string why;
  };
  std::vector<Reason> reasons;
};

[[nodiscard]] Effects find_effects(const Scene& scene, const TransportSettings& settings);

}  // namespace sluice
