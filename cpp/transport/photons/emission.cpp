// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/photons/emission.h"

#include "transport/photons/photon_dimensions.h"

namespace sluice {
namespace {

using Way = EmissionMixture::Way;

// The directions from a point to a target's sphere.
struct Cone {
  V3f axis{0, 0, 1};
  float one_minus_cos;  // 2: all directions, from inside the sphere

  Cone(const Target& target, const V3d& from) noexcept {
    const V3d to = target.centre - from;
    const double distance2 = to.length2();
    one_minus_cos = static_cast<float>(one_minus_cos_of_sphere(target.radius, distance2));
    if (!holds_all()) axis = V3f(to / std::sqrt(distance2));
  }
  [[nodiscard]] bool holds_all() const noexcept { return one_minus_cos >= 2; }
  [[nodiscard]] bool contains(const V3f& d) const noexcept {
    return holds_all() || (d - axis).length2() * 0.5f <= one_minus_cos;
  }
};

// Does a line pass through the target? Then a photon from infinity could have started on the target's disk.
bool passes_through(const Target& target, const V3d& origin, const V3f& direction) noexcept {
  return (target.centre - origin).cross(V3d(direction)).length2() <=
         square(static_cast<double>(target.radius));
}

// Light from infinity: first a direction, then a line: through the disk of the scene or of a target, or where
// lines proved useful.
std::optional<EmittedPhoton> emit_infinite(const Scene& scene, const EmissionGuide& guide, int light,
                                           const EmissionMixture::Choice& chosen,
                                           const Sampler& sampler) noexcept {
  const auto sample = sample_infinite(scene, light, pair_of(sampler, PhotonDimension::Direction));
  if (!sample || !(sample->pdf > 0)) return {};
  const V3f& d = sample->direction;
  const V2f u = pair_of(sampler, PhotonDimension::Position);
  const Target all = whole_scene(scene);
  const EmissionMixture& mixture = guide.mixtures[static_cast<std::size_t>(light)];
  const SunPlane plane(guide.aimed, sun_axis(scene, light));
  V3d through;
  if (chosen.way == Way::Histogram) {
    through = plane.point(mixture.histogram().sample(chosen.u, u));
  } else {
    const Target& disk = chosen.way == Way::Own ? all : guide.targets[chosen.target];
    const V2f on_disk = sample_disk(u) * disk.radius;
    const Frame frame(d);
    through = disk.centre + V3d(frame.t * on_disk.x + frame.b * on_disk.y);
  }
  // Far enough back to be in front of every surface. Entries may lie further out still: the first segment
  // asks the whole line for them.
  const V3d origin = through - V3d(d) * ((through - all.centre).dot(V3d(d)) + 2 * all.radius);

  // The density with which this line is chosen, per area of the plane across it. The line passes through the
  // disk that it was chosen by even where rounding says that it does not.
  const auto by_disk = [&](const Target& disk, bool is_chosen, float share) {
    return is_chosen || passes_through(disk, origin, d) ? share / (pi * square(disk.radius)) : 0.0f;
  };
  const float density = mixture.pdf(
      [&](float share) { return by_disk(all, chosen.way == Way::Own, share); },
      [&](float share) { return share * plane.pdf(mixture.histogram().pdf(plane.uv(origin, d)), d); },
      [&](std::size_t t, float share) { return by_disk(guide.targets[t], chosen.target == t, share); });
  if (!(density > 0)) return {};
  return EmittedPhoton{origin, d,
                       V3f(0), eval_infinite_emission(scene, light, d) / (sample->pdf * density),
                       light,  {0, origin, -d, V3f(0), 0, 0, 0, 0},
                       true};
}

// The direction in which a photon leaves a point of a finite light, by the way that was chosen.
std::optional<V3f> direction_from(const Scene& scene, const EmissionGuide& guide, int light,
                                  const EmissionPoint& point, const EmissionMixture::Choice& chosen,
                                  const V2f& u) noexcept {
  switch (chosen.way) {
    case Way::Histogram:
      return direction_of_uv(guide.mixtures[static_cast<std::size_t>(light)].histogram().sample(chosen.u, u));
    case Way::Target: {
      const Cone cone(guide.targets[chosen.target], point.position);
      return Frame(cone.axis).to_world(sample_cone(u, cone.one_minus_cos));
    }
    case Way::Own: break;
  }
  const auto sample = sample_direction(scene, light, point, chosen.u, u);
  return sample ? std::optional(sample->direction) : std::nullopt;
}

std::optional<EmittedPhoton> emit_finite(const Scene& scene, const EmissionGuide& guide, int light,
                                         float u_part, const EmissionMixture::Choice& chosen,
                                         const Sampler& sampler) noexcept {
  const auto point = sample_position(scene, light, u_part, pair_of(sampler, PhotonDimension::Position));
  if (!point || !(point->pdf_area > 0)) return {};
  const auto direction =
      direction_from(scene, guide, light, *point, chosen, pair_of(sampler, PhotonDimension::Direction));
  if (!direction) return {};
  const EmissionMixture& mixture = guide.mixtures[static_cast<std::size_t>(light)];
  const float density = mixture.pdf(
      [&](float share) { return share * pdf_direction(scene, light, *point, *direction); },
      [&](float share) { return share * mixture.histogram().pdf(uv_of_direction(*direction)) / (4 * pi); },
      [&](std::size_t t, float share) {
        const Cone cone(guide.targets[t], point->position);
        return chosen.target == t || cone.contains(*direction) ? share * cone_pdf(cone.one_minus_cos) : 0.0f;
      });
  if (!(density > 0)) return {};
  return EmittedPhoton{point->position,
                       *direction,
                       point->clearance,
                       eval_emission(scene, light, *point, *direction) / (point->pdf_area * density),
                       light,
                       {0, point->position, point->normal, point->clearance, point->instance, point->triangle,
                        point->u, point->v}};
}

}  // namespace

Target whole_scene(const Scene& scene) noexcept { return sphere_around(scene.geometry_bounds()); }

V3f sun_axis(const Scene& scene, int light) noexcept {
  return common_direction(scene.lights()[static_cast<std::size_t>(light)]).value_or(V3f(0, 0, -1));
}

std::optional<EmittedPhoton> emit_photon(const Scene& scene, const EmissionGuide& guide,
                                         const Sampler& sampler) noexcept {
  if (guide.lights.empty()) return {};
  const V2f u = pair_of(sampler, PhotonDimension::LightAndWay);
  const auto light = guide.lights.sample(u.x);
  const int index = static_cast<int>(light.index);
  const auto chosen = guide.mixtures[light.index].sample(u.y);
  auto photon = is_infinite(scene.lights()[light.index])
                    ? emit_infinite(scene, guide, index, chosen, sampler)
                    : emit_finite(scene, guide, index, light.u, chosen, sampler);
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
