// SPDX-License-Identifier: GPL-3.0-or-later
// Emissive meshes: both sides emit, as in Blender. A triangle is chosen by area × average emission of its
// material, from a point also by how it faces that; a point in it uniformly; what the point really emits
// (textures) is the material's answer there.
#include "scene/light_kinds.h"

namespace sluice::kinds {
namespace {

struct Place {
  V3d position;
  V3f normal;
  V3f clearance;
};

Place place_at(const Parts& parts, const Instance& instance, std::uint32_t triangle, float u,
               float v) noexcept {
  const auto [a, b, c] = parts.corners(instance, triangle);
  const V3d e1 = b - a, e2 = c - a;
  const V3d position = a + e1 * static_cast<double>(u) + e2 * static_cast<double>(v);
  const V3f normal(e1.cross(e2).normalized() * instance.side);
  const double reach = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
  return {position, normal,
          normal * (instance.clearance + instance.clearance_rate * static_cast<float>(reach))};
}

// Radiance towards `direction`.
Color radiance_at(const Parts& parts, const MeshLight& light, const Place& place, std::uint32_t triangle,
                  float u, float v, const V3f& direction) noexcept {
  const Instance& instance = parts.instances[light.instance];
  const Material& material = parts.materials[parts.binding(instance, triangle).material];
  if (material.emission_is_constant()) return material.average_emission();
  const Hit hit{0, place.position, place.normal, place.clearance, light.instance, triangle, u, v};
  SurfacePoint point;
  surface_point_of(parts, hit, direction, false, point);
  Bsdf bsdf;
  shade(material, point, bsdf);
  return bsdf.emission;
}

// Share of the photons that leave on the side of the normal: into a closed surface fewer, as they come out
// only if it is transparent.
float share_in_front(const MeshLight& light) noexcept {
  constexpr float outside = 0.8f;  // more would make the others too bright where it is
  return light.facings.front() == 0 ? 0.5f : light.facings.front() > 0 ? outside : 1 - outside;
}

struct TrianglePoint {
  std::uint32_t triangle;
  float u, v, pmf_per_area;
};
TrianglePoint sample_triangle(const MeshLight& light, double u_part, const V2f& u) noexcept {
  const auto choice = light.triangles.sample(u_part);
  const std::uint32_t triangle = light.triangle_of[choice.index];
  const float root = std::sqrt(u.x);
  return {triangle, 1 - root, u.y * root, light.pmf_per_area[triangle]};
}

}  // namespace

std::optional<DirectSample> sample_direct(const Parts& parts, const MeshLight& light, const V3d& from,
                                          float u_part, const V2f& u) noexcept {
  const auto seen = light.facings.seen_from(from);
  const TrianglePoint at = sample_triangle(light, light.facings.choose(seen, u_part), u);
  const Place place = place_at(parts, parts.instances[light.instance], at.triangle, at.u, at.v);
  const V3d to = place.position - from;
  const double distance2 = to.length2(), distance = std::sqrt(distance2);
  if (!(distance > 0)) return {};
  const V3f wi(to / distance);
  const float cosine = std::abs(wi.dot(place.normal));
  if (!(cosine > 1e-7f)) return {};
  const Color radiance = radiance_at(parts, light, place, at.triangle, at.u, at.v, -wi);
  if (is_black(radiance)) return {};
  const float pmf_per_area = at.pmf_per_area * Facings::ratio(seen, light.facings.of(at.triangle));
  return DirectSample{wi,       short_of(distance, place.clearance.length(), cosine),
                      radiance, pmf_per_area * static_cast<float>(distance2) / cosine,
                      false,    distance};
}

float pdf_direct(const Parts&, const MeshLight& light, const V3d& from, const V3f& wi,
                 const Hit* hit) noexcept {
  if (!hit || hit->instance != light.instance) return 0;
  const float cosine = std::abs(wi.dot(hit->ng));
  if (!(cosine > 1e-7f) || light.pmf_per_area[hit->triangle] == 0) return 0;
  const float ratio = Facings::ratio(light.facings.seen_from(from), light.facings.of(hit->triangle));
  return light.pmf_per_area[hit->triangle] * ratio * static_cast<float>((hit->position - from).length2()) /
         cosine;
}

std::optional<EmissionPoint> sample_position(const Parts& parts, const MeshLight& light, float u_part,
                                             const V2f& u) noexcept {
  const TrianglePoint at = sample_triangle(light, u_part, u);
  const Place place = place_at(parts, parts.instances[light.instance], at.triangle, at.u, at.v);
  return EmissionPoint{
      place.position, place.normal, place.clearance, at.pmf_per_area, light.instance, at.triangle,
      at.u,           at.v};
}

std::optional<EmissionDirection> sample_direction(const Parts& parts, const MeshLight& light,
                                                  const EmissionPoint& point, float u_part,
                                                  const V2f& u) noexcept {
  const V3f local = sample_cosine(u);
  const V3f side = u_part < share_in_front(light) ? point.normal : -point.normal;
  const V3f direction = Frame(side).to_world(local).normalized();
  const float pdf = pdf_direction(parts, light, point, direction);
  if (!(pdf > 0)) return {};
  return EmissionDirection{direction, pdf};
}

float pdf_direction(const Parts&, const MeshLight& light, const EmissionPoint& point,
                    const V3f& direction) noexcept {
  const float cosine = point.normal.dot(direction), front = share_in_front(light);
  return std::abs(cosine) / pi * (cosine > 0 ? front : 1 - front);
}

Color eval_emission(const Parts& parts, const MeshLight& light, const EmissionPoint& point,
                    const V3f& direction) noexcept {
  const Place place{point.position, point.normal, point.clearance};
  return radiance_at(parts, light, place, point.triangle, point.u, point.v, direction) *
         std::abs(point.normal.dot(direction));
}

}  // namespace sluice::kinds
