// SPDX-License-Identifier: GPL-3.0-or-later
// Light from infinity: suns, and the world by a table of texels in latitude and longitude (z up; rows from
// the south pole).
#include "scene/light_kinds.h"

namespace sluice::kinds {
namespace {

// Cosine to the sun's centre; 0 outside of its disc.
float inside_disc(const Sun& sun, const V3f& to_light) noexcept {
  const float cosine = sun.to_sun.dot(to_light);
  if (!(cosine > 0)) return 0;
  const V3f off = to_light - sun.to_sun * cosine;  // |off| / cosine = tan of the angle, exact when small
  return off.length2() <= square(sun.tan_half * cosine) ? cosine : 0;
}

struct Texel {
  std::size_t x, y;
  float sine;  // of the polar angle
};
Texel texel_of(const World& world, const V3f& direction) noexcept {
  const float theta = std::acos(std::clamp(-direction.z, -1.0f, 1.0f));  // from the south pole
  float phi = std::atan2(direction.y, direction.x) / (2 * pi);
  if (phi < 0) phi += 1;
  const auto clamp_to = [](float x, int size) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(x * static_cast<float>(size)), 0, size - 1));
  };
  return {clamp_to(phi, world.width), clamp_to(theta / pi, world.height),
          std::sqrt(std::max(0.0f, 1 - direction.z * direction.z))};
}

}  // namespace

// Uniform on the disc in the tangent plane: density 1 / (pi tan² cos³) per solid angle, which is also Cycles'
// radiance per W/m².
std::optional<EmissionDirection> sample_towards(const Sun& sun, const V2f& u) noexcept {
  if (sun.tan_half == 0) return EmissionDirection{sun.to_sun, 1};
  const V2f p = sample_disk(u) * sun.tan_half;
  const Frame frame(sun.to_sun);
  const V3f direction = (sun.to_sun + frame.t * p.x + frame.b * p.y).normalized();
  const float cosine = sun.to_sun.dot(direction);
  return EmissionDirection{direction, 1 / (pi * square(sun.tan_half) * cosine * cosine * cosine)};
}

float pdf_towards(const Sun& sun, const V3f& to_light) noexcept {
  if (sun.tan_half == 0) return 0;
  const float cosine = inside_disc(sun, to_light);
  return cosine > 0 ? 1 / (pi * square(sun.tan_half) * cosine * cosine * cosine) : 0;
}

Color radiance(const Parts&, const Sun& sun, const V3f& to_light, bool) noexcept {
  return sun.irradiance * pdf_towards(sun, to_light);
}

std::optional<EmissionDirection> sample_towards(const World& world, const V2f& u) noexcept {
  if (world.constant) return EmissionDirection{sample_sphere(u).normalized(), 1 / (4 * pi)};
  const auto row = world.rows.sample(u.y);
  const Distribution& columns = world.columns[row.index];
  const auto column = columns.sample(u.x);
  const float theta = pi * (static_cast<float>(row.index) + row.u) / static_cast<float>(world.height);
  const float phi = 2 * pi * (static_cast<float>(column.index) + column.u) / static_cast<float>(world.width);
  const float sine = std::sin(theta);
  if (!(sine > 0)) return {};
  const V3f direction(sine * std::cos(phi), sine * std::sin(phi), -std::cos(theta));
  const float texels = static_cast<float>(world.width) * static_cast<float>(world.height);
  return EmissionDirection{direction, row.pmf * column.pmf * texels / (2 * pi * pi * sine)};
}

float pdf_towards(const World& world, const V3f& to_light) noexcept {
  if (world.constant) return 1 / (4 * pi);
  const Texel at = texel_of(world, to_light);
  if (!(at.sine > 0)) return 0;
  const float texels = static_cast<float>(world.width) * static_cast<float>(world.height);
  return world.rows.pmf(at.y) * world.columns[at.y].pmf(at.x) * texels / (2 * pi * pi * at.sine);
}

Color radiance(const Parts& parts, const World& world, const V3f& to_light, bool camera_ray) noexcept {
  if (world.constant) return world.radiance;
  return eval_background(parts.materials[static_cast<std::size_t>(parts.world_material)], to_light,
                         camera_ray);
}

}  // namespace sluice::kinds
