// SPDX-License-Identifier: GPL-3.0-or-later
// Point and spot lamps. Cycles: a lamp of P watts has radiance P / (4 pi² r²) on a sphere of radius r, so
// intensity P / (4 pi) from far away and flux P; a spot is that times a factor of the direction alone, not
// made up for. Cycles 3.4 draws the sphere as a disk that faces the point it lights; the sphere itself (as
// Cycles 4) differs by (r / distance)². Light leaves outwards only.
#include "scene/light_kinds.h"

namespace sluice::kinds {
namespace {

// 1 - cos of the half angle under which the sphere is seen, kept exact when small; empty inside it.
std::optional<float> cone_of(const SphereLamp& lamp, double distance2) noexcept {
  const double sin2 = square(static_cast<double>(lamp.radius)) / distance2;
  if (!(sin2 < 1)) return {};
  return static_cast<float>(sin2 / (1 + std::sqrt(1 - sin2)));
}

float clearance_of(const SphereLamp& lamp) noexcept {
  return 0x1p-20f * static_cast<float>(std::max({std::abs(lamp.centre.x), std::abs(lamp.centre.y),
                                                 std::abs(lamp.centre.z), static_cast<double>(lamp.radius)}));
}

// Part of the sphere, around its axis, from which light enters the spot's cone: all normals up to 90° beyond
// it.
float cap_of(const SphereLamp& lamp) noexcept {
  if (lamp.cos_half <= 0) return 2;
  return 1 + std::sqrt(1 - lamp.cos_half * lamp.cos_half);  // 1 - cos(90° + half)
}

// 1 - cos of the half angle of the cone that a spot sends light into.
float cone_of_spot(const SphereLamp& lamp) noexcept {
  return 1 - (lamp.times_cosine ? std::max(lamp.cos_half, 0.0f) : lamp.cos_half);
}

// Flux of a spot / (power / 4 pi): the integral of its factor over directions, by Simpson's rule.
double spot_integral(double cos_half, double blend, bool times_cosine) {
  const double low = times_cosine ? std::max(cos_half, 0.0) : cos_half, band = (1 - cos_half) * blend;
  const auto factor = [&](double c) {
    const double x = band > 0 ? std::clamp((c - cos_half) / band, 0.0, 1.0) : 1.0;
    return (times_cosine ? c : 1) * x * x * (3 - 2 * x);
  };
  constexpr int steps = 4096;
  double sum = factor(low) + factor(1.0);
  for (int i = 1; i < steps; ++i) sum += factor(low + (1 - low) * i / steps) * (i % 2 ? 4 : 2);
  return 2 * std::numbers::pi * sum * (1 - low) / (3.0 * steps);
}

}  // namespace

Light make_sphere_lamp(const LightDescription& d, const V3d& centre) {
  SphereLamp lamp;
  lamp.centre = row_of(d, 3) - centre;
  lamp.radius = d.radius > 1e-9f ? d.radius : 0;
  const Color watts = d.color * d.power;
  lamp.radiance = lamp.radius > 0 ? watts / (4 * square(pi * lamp.radius)) : watts / (4 * pi);
  float part = 1;
  if (d.kind == LightKind::Spot) {
    lamp.spot = true;
    lamp.axis = V3f(-row_of(d, 2).normalized());
    lamp.cos_half = std::cos(std::clamp(d.spot_angle, 1e-3f, 2 * pi) / 2);
    lamp.blend = std::clamp(d.spot_blend, 0.0f, 1.0f);
    lamp.times_cosine = d.spot_cosine;
    part = static_cast<float>(spot_integral(lamp.cos_half, lamp.blend, lamp.times_cosine)) / (4 * pi);
  }
  Light light;
  light.power = mean(watts) * part;
  light.middle = lamp.centre, light.reach = lamp.radius, light.strength = mean(watts) / (4 * pi);
  light.kind = lamp;
  return light;
}

// Cycles: smoothstep over the part `blend` of 1 - cos(half angle) next to the edge; in Blender 3 times the
// cosine to the axis.
float spot_factor(const SphereLamp& lamp, const V3f& direction) noexcept {
  if (!lamp.spot) return 1;
  const float cosine = direction.dot(lamp.axis), inside = cosine - lamp.cos_half;
  if (!(inside > 0 && (cosine > 0 || !lamp.times_cosine))) return 0;
  const float band = (1 - lamp.cos_half) * lamp.blend, most = lamp.times_cosine ? cosine : 1;
  if (inside >= band) return most;
  const float x = inside / band;
  return most * x * x * (3 - 2 * x);
}

std::optional<LampCrossing> crossing(const SphereLamp& lamp, const V3d& origin,
                                     const V3f& direction) noexcept {
  const V3d to = lamp.centre - origin, d(direction);
  const double along = to.dot(d) / d.length2(), r2 = square(static_cast<double>(lamp.radius));
  const double off2 = (to - d * along).length2();
  if (!(along > 0) || off2 > r2 || to.length2() <= r2) return {};
  return LampCrossing{along - std::sqrt(r2 - off2), lamp.radiance * spot_factor(lamp, -direction)};
}

std::optional<DirectSample> sample_direct(const Parts&, const SphereLamp& lamp, const V3d& from, float,
                                          const V2f& u) noexcept {
  const V3d to = lamp.centre - from;
  const double distance2 = to.length2();
  if (!(distance2 > 0)) return {};
  const V3f axis(to / std::sqrt(distance2));
  if (lamp.radius == 0)
    return DirectSample{axis,
                        std::sqrt(distance2),
                        lamp.radiance * (spot_factor(lamp, -axis) / static_cast<float>(distance2)),
                        1,
                        true,
                        std::sqrt(distance2)};
  const auto cone = cone_of(lamp, distance2);
  if (!cone) return {};
  const V3f wi = Frame(axis).to_world(sample_cone(u, *cone)).normalized();
  auto hit = crossing(lamp, from, wi);
  // rounding at the rim
  if (!hit) hit = LampCrossing{std::sqrt(distance2), lamp.radiance * spot_factor(lamp, -wi)};
  return DirectSample{wi,    short_of(hit->t, clearance_of(lamp), 1), hit->radiance, cone_pdf(*cone), false,
                      hit->t};
}

float pdf_direct(const Parts&, const SphereLamp& lamp, const V3d& from, const V3f& wi, const Hit*) noexcept {
  if (lamp.radius == 0 || !crossing(lamp, from, wi)) return 0;
  const auto cone = cone_of(lamp, (lamp.centre - from).length2());
  return cone ? cone_pdf(*cone) : 0;
}

std::optional<EmissionPoint> sample_position(const Parts&, const SphereLamp& lamp, float,
                                             const V2f& u) noexcept {
  if (lamp.radius == 0)
    return EmissionPoint{.position = lamp.centre, .normal = V3f(0), .clearance = V3f(0), .pdf_area = 1};
  const float cap = lamp.spot ? cap_of(lamp) : 2;
  const V3f n = Frame(lamp.axis).to_world(sample_cone(u, cap)).normalized();
  return EmissionPoint{.position = lamp.centre + V3d(n) * static_cast<double>(lamp.radius),
                       .normal = n,
                       .clearance = n * clearance_of(lamp),
                       .pdf_area = cone_pdf(cap) / square(lamp.radius)};
}

std::optional<EmissionDirection> sample_direction(const Parts& parts, const SphereLamp& lamp,
                                                  const EmissionPoint& point, float, const V2f& u) noexcept {
  V3f direction;
  if (lamp.spot)
    direction = Frame(lamp.axis).to_world(sample_cone(u, cone_of_spot(lamp)));
  else if (lamp.radius == 0)
    direction = sample_sphere(u);
  else
    direction = Frame(point.normal).to_world(sample_cosine(u));
  direction = direction.normalized();
  const float pdf = pdf_direction(parts, lamp, point, direction);
  if (!(pdf > 0)) return {};
  return EmissionDirection{direction, pdf};
}

float pdf_direction(const Parts&, const SphereLamp& lamp, const EmissionPoint& point,
                    const V3f& direction) noexcept {
  if (lamp.spot) {
    const float cone = cone_of_spot(lamp);
    return direction.dot(lamp.axis) >= 1 - cone ? cone_pdf(cone) : 0;
  }
  if (lamp.radius == 0) return 1 / (4 * pi);
  return std::max(0.0f, point.normal.dot(direction)) / pi;
}

Color eval_emission(const Parts&, const SphereLamp& lamp, const EmissionPoint& point,
                    const V3f& direction) noexcept {
  const float cosine = lamp.radius == 0 ? 1.0f : std::max(0.0f, point.normal.dot(direction));
  return lamp.radiance * (cosine * spot_factor(lamp, direction));
}

bool is_dark(const SphereLamp& lamp, const V3d& from_middle) noexcept {
  if (!lamp.spot) return false;
  const double distance = from_middle.length();
  if (distance <= lamp.radius) return false;
  // beyond the half angle by more than the sphere's own
  const double limit = std::acos(std::clamp(static_cast<double>(lamp.cos_half), -1.0, 1.0)) +
                       std::asin(lamp.radius / distance) + bound_slack;
  return limit < std::numbers::pi && from_middle.dot(V3d(lamp.axis)) < distance * std::cos(limit);
}

DirectionCone emission_cone(const SphereLamp& lamp) noexcept {
  if (!lamp.spot) return {};
  const double half = std::acos(std::clamp(static_cast<double>(lamp.cos_half), -1.0, 1.0));
  return {V3d(lamp.axis), half + 2 * bound_slack};
}

}  // namespace sluice::kinds
