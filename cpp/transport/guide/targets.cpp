// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/targets.h"

#include <algorithm>
#include <array>

#include "edit/edits.h"
#include "shading/material.h"
#include "transport/pass.h"
#include "transport/photons/emission.h"
#include "transport/photons/light_tracer.h"

namespace sluice {
namespace {

// Paths that find out whether an entry takes light that is aimed at it.
constexpr int min_paths_per_entry = 256, max_paths_per_entry = 4096;

std::array<V3d, 4> corners_of(const Quad& quad) {
  return {quad.point({0, 0}), quad.point({1, 0}), quad.point({0, 1}), quad.point({1, 1})};
}

// Around all spheres of a group.
Target sphere_around(std::span<const Target> group) {
  Bounds bounds;
  for (const Target& t : group) bounds.add(t.centre - V3d(t.radius)), bounds.add(t.centre + V3d(t.radius));
  const V3d middle = bounds.middle();
  double radius = 0;
  for (const Target& t : group) radius = std::max(radius, (t.centre - middle).length() + t.radius);
  return {middle, static_cast<float>(1.0001 * radius)};
}

// Half of a group to each side of the median along the axis on which its middles lie furthest apart.
std::size_t split(std::span<Target> group) {
  Bounds bounds;
  for (const Target& t : group) bounds.add(t.centre);
  const V3d size = bounds.high - bounds.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::ranges::stable_sort(group, {}, [axis](const Target& t) { return t.centre[axis]; });
  return group.size() / 2;
}

}  // namespace

Target sphere_around(const Quad& quad) {
  const double diagonal =
      std::max((quad.edge_u + quad.edge_v).length(), (quad.edge_u - quad.edge_v).length());
  return {quad.point({0.5, 0.5}), static_cast<float>(0.5001 * diagonal)};
}

// The group with the largest sphere is divided as long as there may be more of them.
std::vector<Target> clustered(std::vector<Target> spheres, std::size_t max_count) {
  if (spheres.size() <= max_count) return spheres;
  struct Group {
    std::span<Target> members;
    Target sphere;
  };
  std::vector<Group> groups = {{spheres, sphere_around(std::span<const Target>(spheres))}};
  while (groups.size() < max_count) {
    const auto size_of = [](const Group& g) { return g.members.size() > 1 ? g.sphere.radius : -1; };
    Group& largest = *std::ranges::max_element(groups, {}, size_of);
    const std::size_t middle = split(largest.members);
    const std::span<Target> low = largest.members.first(middle), high = largest.members.subspan(middle);
    largest = {low, sphere_around(std::span<const Target>(low))};
    groups.push_back({high, sphere_around(std::span<const Target>(high))});
  }
  std::vector<Target> out;
  for (const Group& group : groups)
    out.push_back(group.members.size() == 1 ? group.members[0] : group.sphere);
  return out;
}

std::vector<Target> specular_targets(const Scene& scene, std::size_t max_count) {
  std::vector<Target> found;
  const auto is_specular = [&](std::uint32_t material) {
    return scene.materials()[material].has_lobes(followed);
  };
  for (std::size_t i = 0; i < scene.instance_count(); ++i) {
    if (!std::ranges::any_of(scene.instance_materials(i), is_specular)) continue;
    found.push_back(sphere_around(scene.instance_bounds(i)));
  }
  return clustered(std::move(found), max_count);
}

namespace {

// So many paths that each light has its turn, the one that an expression names too (of thousands: some).
// Half of them go towards what mirrors or refracts.
bool moves_light(const PilotContext& context, int edit, std::span<const Target> specular,
                 LightTracer<>& tracer) {
  const Scene& scene = context.scene;
  const EmissionGuide aim = aim_at(scene, sphere_around(scene.edits()[edit].entry), specular, 0);
  const int paths =
      std::clamp(4 * static_cast<int>(std::min<std::size_t>(scene.lights().size(), max_paths_per_entry)),
                 min_paths_per_entry, max_paths_per_entry);
  tracer.counts.start(scene.edits().size());
  std::vector<Photon> photons;
  for (int path = 0; path < paths && !context.cancel; ++path) {
    const Sampler sampler(key_of(context.settings.seed, PilotPurpose::Entries),
                          static_cast<std::uint32_t>(path));
    photons.clear();
    if (const auto photon = emit_photon(scene, aim, sampler))
      tracer.trace(*photon, 1, sampler, static_cast<std::uint64_t>(path), photons);
    if (tracer.counts.of_edit(edit).moved > 0) return true;
  }
  return false;
}

}  // namespace

std::vector<Target> entries_that_take_light(const PilotContext& context, std::span<const Target> specular) {
  const Edits& edits = context.scene.edits();
  std::vector<Target> found;
  if (!context.effects.light_edits) return found;
  std::vector<int> tried;
  for (int e = 0; e < edits.size(); ++e)
    if (contains(edits.could_take(Side::Light), e) && (!edits[e].exits.empty() || edits[e].is_partial))
      tried.push_back(e);
  std::vector<LightTracer<>> tracers;
  for (int t = 0; t < context.pool.size(); ++t)
    tracers.emplace_back(context.scene, context.settings, context.effects, context.pool.size());
  std::vector<char> moves(tried.size());
  context.pool.parallel_for(tried.size(), [&](std::size_t i, int thread) {
    moves[i] = moves_light(context, tried[i], specular, tracers[static_cast<std::size_t>(thread)]);
  });
  for (std::size_t i = 0; i < tried.size(); ++i)
    if (moves[i]) found.push_back(sphere_around(edits[tried[i]].entry));
  return found;
}

// Out there light has met nothing: only entries that take it right after L matter, and those that other such
// entries send it to.
FarEntries find_far_entries(const Scene& scene) {
  const Edits& edits = scene.edits();
  const Target surfaces = whole_scene(scene);
  FarEntries far{.target = {}, .is_for = std::vector<char>(scene.lights().size(), 0)};
  Bounds bounds;
  for (int e = 0; e < edits.size(); ++e) {
    const Edit& edit = edits[e];
    const auto corners = corners_of(edit.entry);
    const auto is_outside = [&](const V3d& p) { return (p - surfaces.centre).length() > surfaces.radius; };
    if (edit.side != Side::Light || (edit.exits.empty() && !edit.is_partial) ||
        std::ranges::none_of(corners, is_outside))
      continue;
    for (const int light : scene.infinite_lights()) {
      if (!contains(
              edits.could_take_after(Side::Light, edits.event_class(Event::L, scene.light_entity(light))), e))
        continue;
      far.is_for[static_cast<std::size_t>(light)] = 1;
      for (const V3d& corner : corners) bounds.add(corner);
    }
  }
  if (!bounds.empty()) far.target = sphere_around(bounds);
  return far;
}

double flux_into(const Light& light, const Target& sphere) noexcept {
  const double disk = std::numbers::pi * square(static_cast<double>(sphere.radius));
  // a world's on all sides
  if (is_infinite(light)) return light.strength * disk * (common_direction(light) ? 1 : 4);
  // from the light's middle, around all that any of its points can see of the sphere
  const double one_minus_cos = one_minus_cos_of_sphere(static_cast<double>(sphere.radius) + light.reach,
                                                       (sphere.centre - light.middle).length2());
  if (one_minus_cos >= 2) return light.power;
  return std::min(static_cast<double>(light.power), light.strength * (2 * std::numbers::pi * one_minus_cos));
}

std::vector<double> possible_shares(const Scene& scene, const Target& sphere) {
  std::vector<double> flux;
  double sum = 0;
  for (const Light& light : scene.lights()) sum += flux.emplace_back(flux_into(light, sphere));
  for (double& share : flux) share = sum > 0 ? share / sum : 1 / static_cast<double>(flux.size());
  return flux;
}

Distribution mixed_with_equal(std::span<const double> possible) {
  std::vector<float> shares;
  for (const double share : possible)
    shares.push_back(static_cast<float>(share + 1 / static_cast<double>(possible.size())));
  return Distribution(shares);
}

EmissionGuide aim_at(const Scene& scene, const Target& place, std::span<const Target> others, float own) {
  EmissionGuide guide{
      .lights = mixed_with_equal(possible_shares(scene, place)), .targets = {place}, .mixtures = {}};
  guide.targets.insert(guide.targets.end(), others.begin(), others.end());
  EmissionShares shares{.own = own, .targets = {others.empty() ? 1 - own : (1 - own) / 2}};
  shares.targets.resize(guide.targets.size(), (1 - own) / 2 / static_cast<float>(others.size()));
  guide.mixtures.assign(scene.lights().size(), EmissionMixture(shares, {}));
  return guide;
}

}  // namespace sluice
