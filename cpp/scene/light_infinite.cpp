// SPDX-License-Identifier: GPL-3.0-or-later
// Light from infinity: suns, and the world by a table of texels in latitude and longitude (z up; rows from
// the south pole).
#include <atomic>

#include "base/threads.h"
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

// Means of radiance by texel, each point evaluated once.
void tabulate(const Material& material, World& world, const std::function<bool()>& cancelled, int threads) {
  const auto width = static_cast<std::size_t>(world.width), height = static_cast<std::size_t>(world.height);
  std::vector<Color> texels(width * height);
  std::atomic<bool> stop = false;
  ThreadPool pool(threads > 0 ? threads : hardware_threads());
  pool.parallel_for(height, [&](std::size_t y, int thread) {
    if (thread == 0 && cancelled && cancelled()) stop = true;
    if (stop) return;
    const float theta = pi * (static_cast<float>(y) + 0.5f) / static_cast<float>(height),
                sine = std::sin(theta);
    for (std::size_t x = 0; x < width; ++x) {
      const float phi = 2 * pi * (static_cast<float>(x) + 0.5f) / static_cast<float>(width);
      texels[y * width + x] =
          eval_background(material, {sine * std::cos(phi), sine * std::sin(phi), -std::cos(theta)}, false);
    }
  });
  if (stop) throw Cancelled();
  std::vector<float> row_weights(height), line(width);
  double weight = 0, sum[3] = {};
  std::vector<double> sines(height);
  for (std::size_t y = 0; y < height; ++y) {
    sines[y] = std::sin(std::numbers::pi * (static_cast<double>(y) + 0.5) / static_cast<double>(height));
    for (std::size_t x = 0; x < width; ++x) {
      weight += sines[y];
      for (int i = 0; i < 3; ++i) sum[i] += sines[y] * texels[y * width + x][i];
    }
  }
  world.mean_radiance = Color(static_cast<float>(sum[0] / weight), static_cast<float>(sum[1] / weight),
                              static_cast<float>(sum[2] / weight));
  // the floor: what lies between texel centres keeps a density
  const float floor = std::max(0.02f * mean(world.mean_radiance), 1e-20f);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) line[x] = std::max(mean(texels[y * width + x]), 0.0f) + floor;
    world.columns.emplace_back(line);
    row_weights[y] = static_cast<float>(world.columns.back().total() * sines[y]);
  }
  world.rows = Distribution(row_weights);
}

}  // namespace

Light make_sun(const LightDescription& d) {
  Sun sun;
  sun.to_sun = V3f(row_of(d, 2).normalized());
  sun.tan_half = d.angle > 1e-5f ? std::tan(std::min(d.angle / 2, 1.55f)) : 0;
  sun.irradiance = d.color * d.power;
  Light light;
  light.strength = mean(sun.irradiance);
  light.kind = sun;
  return light;
}

std::optional<Light> make_world(const Parts& parts, const std::function<bool()>& cancelled, int threads) {
  if (parts.world_material < 0) return {};
  const Material& material = parts.materials[static_cast<std::size_t>(parts.world_material)];
  if (!material.emits()) return {};
  World world;
  if (material.emission_is_constant()) {
    world.radiance = world.mean_radiance = material.average_emission();
    if (is_black(world.radiance)) return {};
  } else {
    world.constant = false;
    world.width = std::clamp(parts.description.world.resolution, 16, 8192), world.height = world.width / 2;
    tabulate(material, world, cancelled, threads);
  }
  Light light;
  light.strength = std::max(pi * mean(world.mean_radiance), 1e-20f);
  light.kind = std::move(world);
  return light;
}

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

float irradiance_bound(const Sun& sun, float strength, const V3f& normal) noexcept {
  const float cosine = normal.dot(sun.to_sun);
  return cosine < -sun.tan_half - 1e-3f ? 0.0f : strength * std::max(0.1f, cosine);
}
float irradiance_bound(const World&, float strength, const V3f&) noexcept { return strength; }

DirectionBall directions_to(const Sun& sun) noexcept {
  return {V3d(sun.to_sun), sun.tan_half + 2 * bound_slack};
}
DirectionBall directions_to(const World&) noexcept { return {V3d(0), 2}; }

}  // namespace sluice::kinds
