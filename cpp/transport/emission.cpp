// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/emission.h"

#include <algorithm>
#include <bit>

namespace sluice {
namespace {

// The directions from a point to a target's sphere.
struct Cone {
  V3f axis;
  float one_minus_cos;  // 2: all directions, from inside the sphere

  Cone(const Target& target, const V3d& from) noexcept {
    const V3d to = target.centre - from;
    const double d2 = to.length2(), s2 = square(static_cast<double>(target.radius)) / std::max(d2, 1e-300);
    const bool inside = s2 >= 1;
    axis = inside ? V3f(0, 0, 1) : V3f(to / std::sqrt(d2));
    one_minus_cos = inside ? 2.0f : static_cast<float>(s2 / (1 + std::sqrt(1 - s2)));
  }
  [[nodiscard]] bool contains(const V3f& d) const noexcept {
    return one_minus_cos >= 2 || (d - axis).length2() * 0.5f <= one_minus_cos;
  }
};

// Does a line pass through the target? Then a photon from infinity could have started on the target's disk.
bool passes_through(const Target& target, const V3d& origin, const V3f& direction) noexcept {
  return (target.centre - origin).cross(V3d(direction)).length2() <=
         square(static_cast<double>(target.radius));
}

// Light from infinity: first a direction, then a line: through the disk of the scene or of a target, or where
// lines proved useful.
std::optional<EmittedPhoton> emit_infinite(const Scene& scene, const Guide& guide, int light,
                                           const Distribution::Choice& strategy,
                                           const Sampler& sampler) noexcept {
  const auto sample = sample_infinite(scene, light, sampler.pair(2));
  if (!sample || !(sample->pdf > 0)) return {};
  const V3f& d = sample->direction;
  const Target all = whole_scene(scene);
  const std::size_t by_table = guide.targets.size() + 1;
  const AimTable& table = guide.aims[static_cast<std::size_t>(light)];
  const SunPlane plane(guide.aimed, sun_axis(scene, light));
  V3d through;
  if (strategy.index == by_table) {
    through = plane.point(table.sample(strategy.u, sampler.pair(1)));
  } else {
    const Target& disk = strategy.index == 0 ? all : guide.targets[strategy.index - 1];
    const V2f on_disk = sample_disk(sampler.pair(1)) * disk.radius;
    const Frame frame(d);
    through = disk.centre + V3d(frame.t * on_disk.x + frame.b * on_disk.y);
  }
  // Far enough back to be in front of every surface. Entries may lie further out still: the first segment
  // asks the whole line for them.
  const V3d origin = through - V3d(d) * ((through - all.centre).dot(V3d(d)) + 2 * all.radius);

  float density = 0;  // of the line, on the plane across it
  const Distribution& strategies = guide.strategies[static_cast<std::size_t>(light)];
  if (strategies.pmf(by_table) > 0)
    density += strategies.pmf(by_table) * plane.pdf(table.pdf(plane.uv(origin, d)), d);
  for (std::size_t s = 0; s < by_table; ++s) {
    const Target& candidate = s == 0 ? all : guide.targets[s - 1];
    if (strategies.pmf(s) > 0 && (s == strategy.index || passes_through(candidate, origin, d)))
      density += strategies.pmf(s) / (pi * square(candidate.radius));
  }
  if (!(density > 0)) return {};
  return EmittedPhoton{origin, d,
                       V3f(0), eval_infinite_emission(scene, light, d) / (sample->pdf * density),
                       light,  {0, origin, -d, V3f(0), 0, 0, 0, 0},
                       true};
}

std::optional<EmittedPhoton> emit_finite(const Scene& scene, const Guide& guide, int light, float u_part,
                                         const Distribution::Choice& strategy,
                                         const Sampler& sampler) noexcept {
  const auto point = sample_position(scene, light, u_part, sampler.pair(1));
  if (!point || !(point->pdf_area > 0)) return {};
  V3f direction;
  const std::size_t by_table = guide.targets.size() + 1;
  const AimTable& table = guide.aims[static_cast<std::size_t>(light)];
  if (strategy.index == by_table) {
    direction = direction_of_uv(table.sample(strategy.u, sampler.pair(2)));
  } else if (strategy.index == 0) {
    const auto sample = sample_direction(scene, light, *point, strategy.u, sampler.pair(2));
    if (!sample) return {};
    direction = sample->direction;
  } else {
    const Cone cone(guide.targets[strategy.index - 1], point->position);
    direction = Frame(cone.axis).to_world(sample_cone(sampler.pair(2), cone.one_minus_cos));
  }
  const Distribution& strategies = guide.strategies[light];
  float density = strategies.pmf(0) * pdf_direction(scene, light, *point, direction);
  if (strategies.pmf(by_table) > 0)
    density += strategies.pmf(by_table) * table.pdf(uv_of_direction(direction)) / (4 * pi);
  for (std::size_t s = 1; s < by_table; ++s) {
    if (!(strategies.pmf(s) > 0)) continue;
    const Cone cone(guide.targets[s - 1], point->position);
    if (s == strategy.index || cone.contains(direction))
      density += strategies.pmf(s) * cone_pdf(cone.one_minus_cos);
  }
  if (!(density > 0)) return {};
  return EmittedPhoton{point->position,
                       direction,
                       point->clearance,
                       eval_emission(scene, light, *point, direction) / (point->pdf_area * density),
                       light,
                       {0, point->position, point->normal, point->clearance, point->instance, point->triangle,
                        point->u, point->v}};
}

}  // namespace

Target whole_scene(const Scene& scene) noexcept {
  const Bounds& bounds = scene.geometry_bounds();
  return {bounds.middle(), static_cast<float>(0.5001 * bounds.diagonal())};
}

V3f sun_axis(const Scene& scene, int light) noexcept {
  const Sun* sun = std::get_if<Sun>(&scene.lights()[static_cast<std::size_t>(light)].kind);
  return sun ? -sun->to_sun : V3f(0, 0, -1);
}

std::uint64_t Guide::hash() const noexcept {
  std::uint64_t h = 0;
  const auto add = [&h](auto x) { h = mix(h, std::bit_cast<std::uint32_t>(static_cast<float>(x))); };
  for (std::size_t i = 0; i < lights.size(); ++i) add(lights.pmf(i));
  const auto add_target = [&add](const Target& t) {
    add(t.centre.x), add(t.centre.y), add(t.centre.z), add(t.radius);
  };
  std::ranges::for_each(targets, add_target);
  add_target(aimed);
  for (const Distribution& d : strategies)
    for (std::size_t i = 0; i < d.size(); ++i) add(d.pmf(i));
  for (const AimTable& table : aims)
    for (std::size_t i = 0; i < table.distribution().size(); ++i) add(table.distribution().pmf(i));
  add(least_radius), add(most_radius), add(radius), add(caustic_radius);
  return mix(mix(mix(h, trust.hash()), mix(sharp_disks.hash(), soft_disks.hash())), samples.hash());
}

std::optional<EmittedPhoton> emit_photon(const Scene& scene, const Guide& guide,
                                         const Sampler& sampler) noexcept {
  if (guide.lights.empty()) return {};
  const V2f u = sampler.pair(0);
  const auto light = guide.lights.sample(u.x);
  const int index = static_cast<int>(light.index);
  const auto strategy = guide.strategies[light.index].sample(u.y);
  auto photon = is_infinite(scene.lights()[light.index])
                    ? emit_infinite(scene, guide, index, strategy, sampler)
                    : emit_finite(scene, guide, index, light.u, strategy, sampler);
  if (!photon) return {};
  photon->flux /= light.pmf;
  if (!is_finite(photon->flux) || is_black(photon->flux)) return {};
  return photon;
}

bool aims_at(const Target& target, const V3d& origin, const V3f& direction, bool infinite_light) noexcept {
  return infinite_light ? passes_through(target, origin, direction)
                        : Cone(target, origin).contains(direction);
}

}  // namespace sluice
