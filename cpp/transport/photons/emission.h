// SPDX-License-Identifier: GPL-3.0-or-later
// First segments of light paths, drawn from the guide's mixtures: a light, a position, and a direction from
// the light's own distribution or towards a target. Flux is divided by the density of the whole mixture, so
// every choice of guide gives the same image.
#pragma once
#include <optional>

#include "base/random.h"
#include "scene/scene.h"
#include "transport/emission_mixture.h"

namespace sluice {

struct EmittedPhoton {
  V3d origin;
  V3f direction, clearance;
  Color flux;  // W; divide by the number of paths
  int light;
  Hit emitter;                 // of a mesh light: where it was left
  bool from_infinity = false;  // the origin is only a point of the line: gates behind it count too
};

// By the first dimensions of photon_dimensions.h. Empty: this sample carries no light.
[[nodiscard]] std::optional<EmittedPhoton> emit_photon(const Scene& scene, const EmissionGuide& guide,
                                                       const Sampler& sampler) noexcept;

// A sphere around all surfaces; the way a sun's light travels (of the world: none in particular).
[[nodiscard]] Target whole_scene(const Scene& scene) noexcept;
[[nodiscard]] V3f sun_axis(const Scene& scene, int light) noexcept;

// Is a light path that starts at `origin` along `direction` one that could have been aimed at the target?
[[nodiscard]] bool aims_at(const Target& target, const V3d& origin, const V3f& direction,
                           bool infinite_light) noexcept;

}  // namespace sluice
