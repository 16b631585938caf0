// SPDX-License-Identifier: GPL-3.0-or-later
// Spheres that are worth aiming photons at, of entries and of things that mirror or refract; one that must be
// aimed at; and what lights can send into a sphere.
#pragma once
#include <optional>
#include <vector>

#include "edit/quad.h"
#include "transport/emission_mixture.h"
#include "transport/guide/pilot_context.h"
#include "transport/target.h"

namespace sluice {

[[nodiscard]] Target sphere_around(const Quad& quad);

// Spheres around all of them, at most so many: near ones share one, so that the last is aimed at as well as
// the first. As few as there is room for are left as they are.
[[nodiscard]] std::vector<Target> clustered(std::vector<Target> spheres, std::size_t max_count);

// Around the scene's things that mirror or refract, clustered.
[[nodiscard]] std::vector<Target> specular_targets(const Scene& scene, std::size_t max_count);

// Around the entries of light edits that take light which was really met: else the guide, and so the image,
// is that of no edit. Each is tried by itself, whatever others there are: an edit that takes nothing must not
// cost another one its target. `specular`: where light may come by on its way.
[[nodiscard]] std::vector<Target> entries_that_take_light(const PilotContext& context,
                                                          std::span<const Target> specular);

// Light from infinity starts all over the sphere around the surfaces. What passes by that may still be moved,
// by entries that hang outside of it, wholly or in part: without a target of their own no photon would ever
// come there.
struct FarEntries {
  std::optional<Target> target;  // around all of them; none: nothing to do
  std::vector<char> is_for;      // per light: may they take its light?
};
[[nodiscard]] FarEntries find_far_entries(const Scene& scene);

// The most that a light can send into a sphere (W), as far as its kind and place tell; what stands in between
// is not asked.
[[nodiscard]] double flux_into(const Light& light, const Target& sphere) noexcept;

// Of each light's flux into a sphere, as shares that sum to 1; equal ones where no light has any.
[[nodiscard]] std::vector<double> possible_shares(const Scene& scene, const Target& sphere);

// Shares of lights of which half are `possible` ones and half are equal: an expression may name a dim light.
[[nodiscard]] Distribution mixed_with_equal(std::span<const double> possible);

// To one place alone: lights by what they can send there, mixed with equal shares. `own`: of each light's
// photons leave as they would anyway, the rest towards the place and, as many, towards the others.
[[nodiscard]] EmissionGuide aim_at(const Scene& scene, const Target& place, std::span<const Target> others,
                                   float own);

}  // namespace sluice
