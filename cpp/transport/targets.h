// SPDX-License-Identifier: GPL-3.0-or-later
// Spheres that are worth aiming photons at, of entries and of things that mirror or refract; one that must be
// aimed at; and what lights can send into a sphere.
#pragma once
#include <optional>
#include <vector>

#include "edit/quad.h"
#include "scene/scene.h"
#include "transport/guide.h"

namespace sluice {

[[nodiscard]] Target sphere_around(const Quad& quad);

// Spheres around all of them, at most so many: near ones share one, so that the last is aimed at as well as
// the first. As few as there is room for are left as they are.
[[nodiscard]] std::vector<Target> clustered(std::vector<Target> spheres, std::size_t max_count);

// Around the scene's things that mirror or refract, clustered.
[[nodiscard]] std::vector<Target> specular_targets(const Scene& scene, std::size_t max_count);

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

// A guide to one place alone: a half of the photons from lights by what they can send there, a half from all
// alike, as an expression may name a dim one. `own`: of each light's photons leave as they would anyway, the
// rest towards the place and, as many, towards the others.
[[nodiscard]] Guide aim_at(const Scene& scene, const Target& place, std::span<const Target> others,
                           float own);

}  // namespace sluice
