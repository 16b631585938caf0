// SPDX-License-Identifier: GPL-3.0-or-later
// Spheres that are worth aiming photons at, of entries and of things that mirror or refract; and one that must be aimed at.
#pragma once
#include <algorithm>
#include <optional>
#include <vector>

#include "edit/quad.h"
#include "scene/scene.h"
#include "shading/material.h"
#include "transport/guide.h"

namespace sluice {

[[nodiscard]] inline Target sphere_around(const Quad& quad) {
  const double diagonal = std::max((quad.edge_u + quad.edge_v).length(), (quad.edge_u - quad.edge_v).length());
  return {quad.point({0.5, 0.5}), static_cast<float>(0.5001 * diagonal)};
}

// Adds the scene's specular things, in its order, as long as there are fewer than `most` targets.
inline void add_specular_targets(const Scene& scene, std::size_t most, std::vector<Target>& targets) {
  const auto is_specular = [&](std::uint32_t material) { return scene.materials()[material].has_lobes(followed); };
  for (std::size_t i = 0; i < scene.instance_count() && targets.size() < most; ++i) {
    if (!std::ranges::any_of(scene.instance_materials(i), is_specular)) continue;
    const Bounds& b = scene.instance_bounds(i);
    targets.push_back({b.middle(), static_cast<float>(0.5001 * b.diagonal())});
  }
}

// Light from infinity starts all over the sphere around the surfaces. What passes by that may still be moved, by entries that hang outside
// of it, wholly or in part: without a target of their own no photon would ever come there.
struct FarEntries {
  std::optional<Target> target;  // around all of them; none: nothing to do
  std::vector<char> is_for;      // per light: may they take its light?
};
[[nodiscard]] FarEntries find_far_entries(const Scene& scene);

}  // namespace sluice
