// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/targets.h"

#include <algorithm>
#include <array>

#include "edit/edits.h"
#include "shading/material.h"
#include "transport/emission.h"

namespace sluice {
namespace {

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
    const Bounds& b = scene.instance_bounds(i);
    found.push_back({b.middle(), static_cast<float>(0.5001 * b.diagonal())});
  }
  return clustered(std::move(found), max_count);
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
      if (!contains(edits.takers_after(Side::Light, edits.event_class(Event::L, scene.light_entity(light))),
                    e))
        continue;
      far.is_for[static_cast<std::size_t>(light)] = 1;
      for (const V3d& corner : corners) bounds.add(corner);
    }
  }
  if (!bounds.empty()) far.target = Target{bounds.middle(), static_cast<float>(0.5001 * bounds.diagonal())};
  return far;
}

double flux_into(const Light& light, const Target& sphere) noexcept {
  const double disk = std::numbers::pi * square(static_cast<double>(sphere.radius));
  // a world's on all sides
  if (is_infinite(light)) return light.strength * disk * (std::holds_alternative<Sun>(light.kind) ? 1 : 4);
  const double radius = static_cast<double>(sphere.radius) + light.reach,
               distance2 = (sphere.centre - light.middle).length2();
  const double sine2 = square(radius) / std::max(distance2, 1e-300);
  if (sine2 >= 1) return light.power;
  const double solid_angle = 2 * std::numbers::pi * sine2 / (1 + std::sqrt(1 - sine2));
  return std::min(static_cast<double>(light.power), light.strength * solid_angle);
}

std::vector<double> possible_shares(const Scene& scene, const Target& sphere) {
  std::vector<double> flux;
  double sum = 0;
  for (const Light& light : scene.lights()) sum += flux.emplace_back(flux_into(light, sphere));
  for (double& share : flux) share = sum > 0 ? share / sum : 1 / static_cast<double>(flux.size());
  return flux;
}

Guide aim_at(const Scene& scene, const Target& place, std::span<const Target> others, float own) {
  Guide guide;
  guide.targets.push_back(place);
  guide.targets.insert(guide.targets.end(), others.begin(), others.end());
  std::vector<float> shares, strategy = {own, others.empty() ? 1 - own : (1 - own) / 2};
  for (std::size_t i = 0; i < others.size(); ++i)
    strategy.push_back((1 - own) / 2 / static_cast<float>(others.size()));
  strategy.push_back(0);  // no light's useful directions are known
  for (const double possible : possible_shares(scene, place))
    shares.push_back(static_cast<float>(possible + 1 / static_cast<double>(scene.lights().size())));
  guide.lights = Distribution(shares);
  guide.strategies.assign(shares.size(), Distribution(strategy));
  guide.aims.resize(shares.size());
  return guide;
}

}  // namespace sluice
