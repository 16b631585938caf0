// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps, emissive instances and the world from their descriptions. The formulas stand with each kind
// (light_*.cpp).
#include <algorithm>
#include <atomic>

#include "base/threads.h"
#include "scene/parts.h"

namespace sluice {
namespace {

V3d row(const M44d& m, int i) noexcept { return {m[i][0], m[i][1], m[i][2]}; }

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

Light make_sphere(const LightDescription& d, const Scene::Parts& parts) {
  SphereLamp lamp;
  lamp.centre = row(d.matrix, 3) - parts.centre;
  lamp.radius = d.radius > 1e-9f ? d.radius : 0;
  const Color watts = d.color * d.power;
  lamp.radiance = lamp.radius > 0 ? watts / (4 * square(pi * lamp.radius)) : watts / (4 * pi);
  float part = 1;
  if (d.kind == LightKind::Spot) {
    lamp.spot = true;
    lamp.axis = V3f(-row(d.matrix, 2).normalized());
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

Light make_sun(const LightDescription& d) {
  Sun sun;
  sun.to_sun = V3f(row(d.matrix, 2).normalized());
  sun.tan_half = d.angle > 1e-5f ? std::tan(std::min(d.angle / 2, 1.55f)) : 0;
  sun.irradiance = d.color * d.power;
  Light light;
  light.strength = mean(sun.irradiance);
  light.kind = sun;
  return light;
}

// Empty: it has no area.
std::optional<Light> make_area(const LightDescription& d, const Scene::Parts& parts) {
  const bool one_size = d.shape == AreaShape::Square || d.shape == AreaShape::Disk;
  V3d u = row(d.matrix, 0) * static_cast<double>(d.size_x),
      v = row(d.matrix, 1) * static_cast<double>(one_size ? d.size_x : d.size_y);
  V3d n = u.cross(v);
  const double area = n.length();
  if (!(area > 0) || !std::isfinite(static_cast<float>(1 / area))) return {};
  n /= n.dot(row(d.matrix, 2)) > 0 ? -area : area;  // it shines along local -Z
  AreaLamp lamp;
  lamp.centre = row(d.matrix, 3) - parts.centre;
  lamp.normal = V3f(n);
  lamp.half_u = static_cast<float>(u.length() / 2), lamp.half_v = static_cast<float>(area / u.length() / 2);
  u.normalize();
  lamp.axis_u = V3f(u), lamp.axis_v = V3f(n.cross(u));
  lamp.round = d.shape == AreaShape::Disk || d.shape == AreaShape::Ellipse;
  lamp.area = static_cast<float>(area) * (lamp.round ? pi / 4 : 1);
  const Color watts = d.color * d.power;
  lamp.radiance = watts / (4 * lamp.area);
  if (d.spread < pi - 1e-3f) {
    const double half = std::max(static_cast<double>(d.spread), 2e-3) / 2, cot = 1 / std::tan(half);
    lamp.spread_half = static_cast<float>(half), lamp.spread_cot = static_cast<float>(cot);
    lamp.spread_scale = static_cast<float>(1 / (1 - half * cot));
  }
  Light light;
  light.power = mean(watts) * pi / 4;
  light.middle = lamp.centre, light.reach = std::hypot(lamp.half_u, lamp.half_v);
  light.strength = mean(watts) / 4 * lamp.spread_scale;
  light.kind = lamp;
  return light;
}

// Empty: it has no area.
std::optional<Light> make_lamp(const LightDescription& d, const Scene::Parts& parts) {
  switch (d.kind) {
    case LightKind::Point:
    case LightKind::Spot: return make_sphere(d, parts);
    case LightKind::Sun: return make_sun(d);
    case LightKind::Area: return make_area(d, parts);
  }
  return {};
}

bool is_usable(const LightDescription& d) noexcept {
  bool finite = true;
  for_each_member(d, [&](const char*, const auto& member) {
    using Member = std::decay_t<decltype(member)>;
    if constexpr (std::is_same_v<Member, float>)
      finite = finite && std::isfinite(member);
    else if constexpr (std::is_same_v<Member, Color> || std::is_same_v<Member, M44d>)
      finite = finite && is_finite(member);
  });
  return finite && d.power >= 0 && d.color.x >= 0 && d.color.y >= 0 && d.color.z >= 0 &&
         (!has_direction(d.kind) || row(d.matrix, 2).length() > 0);
}

}  // namespace

void add_lamps(Scene::Parts& parts, Warnings& warnings) {
  Tally unusable, sizeless;
  for (const LightDescription& d : parts.description.lights) {
    if (!is_usable(d)) {
      unusable.add(first_name(d.names));
      continue;
    }
    if (d.power == 0 || is_black(d.color)) continue;
    std::optional<Light> light = make_lamp(d, parts);
    if (!light || !std::isfinite(light->strength) || !std::isfinite(light->power)) {
      sizeless.add(first_name(d.names));
      continue;
    }
    light->casts_shadow = d.casts_shadow, light->visible_to_camera = d.visible_to_camera;
    light->entity = static_cast<int>(parts.entities.size());
    parts.entities.push_back({d.names});
    const int index = static_cast<int>(parts.lights.size());
    if (is_infinite(*light))
      parts.infinite_lights.push_back(index);
    else if (!is_delta(*light))
      parts.shaped_lamps.push_back(index);
    parts.lights.push_back(std::move(*light));
  }
  unusable.report("negative or not finite power, colour, size or matrix: the light is off", warnings);
  sizeless.report("the lamp has no area: the light is off", warnings);
}

namespace {

// Is each edge shared by two triangles that agree on their side?
bool is_closed(const MeshDescription& mesh, std::span<const EmissiveTriangle> triangles) {
  std::vector<std::uint64_t> edges, back;
  for (const EmissiveTriangle& t : triangles)
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint64_t from = mesh.triangles[t.triangle][corner],
                          to = mesh.triangles[t.triangle][(corner + 1) % 3];
      edges.push_back(from << 32 | to), back.push_back(to << 32 | from);
    }
  std::ranges::sort(edges), std::ranges::sort(back);
  return edges == back;
}

// How far from the middle the surface that shines goes (m).
double reach_of(std::span<const EmissiveTriangle> triangles, const V3d& middle) {
  double reach2 = 0;
  for (const EmissiveTriangle& t : triangles)
    for (const V3d& p : t.corners) reach2 = std::max(reach2, (p - middle).length2());
  return std::sqrt(reach2);
}

// Is it a lamp that is seen from outside? 1: normals of its closed surface look out; -1: they look in. 0: it
// is open, or has no volume, or is most of the scene, or other things are in it, as in a lantern or under a
// dome.
int front_of(const Scene::Parts& parts, std::uint32_t instance, std::span<const EmissiveTriangle> triangles,
             const V3d& middle, double reach) {
  constexpr double large = 0.25, small = 0.05;  // of the scene: a room; nobody puts things into it
  const double size = reach / parts.geometry_bounds.diagonal();
  if (!(size < large)) return 0;
  if (!is_closed(parts.mesh(parts.instances[instance]), triangles)) return 0;
  double area = 0, volume = 0;
  for (const EmissiveTriangle& t : triangles) {
    area += static_cast<double>(t.area);
    volume += (t.corners[0] - middle).dot(V3d(t.normal)) * t.area / 3;
  }
  if (!(std::abs(volume) > 1e-3 * area * reach)) return 0;
  if (size > small)
    for (std::uint32_t i = 0; i < parts.instances.size(); ++i)
      if (i != instance && (parts.instances[i].bounds.middle() - middle).length() < reach) return 0;
  return volume > 0 ? 1 : -1;
}

// Of triangles in the order of their facings.
MeshLight make_mesh_light(std::uint32_t instance, std::size_t mesh_triangles,
                          std::span<const EmissiveTriangle> triangles, int front) {
  MeshLight light{
      .instance = instance, .triangles = {}, .triangle_of = {}, .pmf_per_area = {}, .facings = {}};
  std::vector<float> weights;
  for (const EmissiveTriangle& t : triangles)
    weights.push_back(t.light), light.triangle_of.push_back(t.triangle);
  light.triangles = Distribution(weights);
  if (light.triangles.empty()) return light;
  light.facings = Facings(triangles, mesh_triangles, front);
  light.pmf_per_area.assign(mesh_triangles, 0);
  for (std::size_t k = 0; k < triangles.size(); ++k)
    light.pmf_per_area[triangles[k].triangle] = light.triangles.pmf(k) / triangles[k].area;
  return light;
}

}  // namespace

void add_mesh_lights(Scene::Parts& parts, const CancelPoint& cancel) {
  for (std::uint32_t i = 0; i < parts.instances.size(); ++i) {
    Instance& instance = parts.instances[i];
    const auto emits = [&](std::uint32_t m) { return parts.materials[m].emits(); };
    if (std::none_of(instance.used_materials.begin(), instance.used_materials.end(), emits)) continue;
    const MeshDescription& mesh = parts.mesh(instance);
    std::vector<EmissiveTriangle> triangles;
    Bounds bounds;
    cancel();
    for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
      cancel.at(triangle);
      const Material& material = parts.materials[parts.binding(instance, triangle).material];
      if (!material.emits()) continue;
      // the average of a texture may be 0 where the mesh reads something else of it
      const float glow = mean(material.average_emission());
      const float radiance = material.emission_is_constant() ? glow : std::max(glow, 1e-3f);
      const auto [a, b, c] = parts.corners(instance, triangle);
      const V3d across = (b - a).cross(c - a) * instance.side;
      const float area = static_cast<float>(across.length() / 2);
      if (!(area * radiance > 0) || !std::isfinite(area * radiance)) continue;
      triangles.push_back({triangle, area, area * radiance, V3f(across.normalized()), {a, b, c}});
      for (const V3d& p : {a, b, c}) bounds.add(p);
    }
    std::ranges::stable_sort(triangles, {},
                             [](const EmissiveTriangle& t) { return Facings::bin_of(t.normal); });
    const V3d middle = bounds.middle();
    const double reach = reach_of(triangles, middle);
    const int front = front_of(parts, i, triangles, middle, reach);
    MeshLight light = make_mesh_light(i, mesh.triangles.size(), triangles, front);
    if (light.triangles.empty()) continue;
    Light out;
    const float total = static_cast<float>(light.triangles.total());
    out.power = 2 * pi * total;  // both sides
    // mean projected areas
    out.middle = middle, out.reach = static_cast<float>(reach), out.strength = total / (front == 0 ? 2 : 4);
    out.entity = instance.entity;
    out.kind = std::move(light);
    instance.light = static_cast<int>(parts.lights.size());
    parts.lights.push_back(std::move(out));
  }
}

namespace {

// Means of radiance by texel, each point evaluated once; false: cancelled.
bool fill_table(const Material& material, World& world, const std::function<bool()>& cancelled, int threads) {
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
  if (stop) return false;
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
  return true;
}

}  // namespace

bool add_world(Scene::Parts& parts, const std::function<bool()>& cancelled, int threads) {
  const WorldDescription& description = parts.description.world;
  parts.world_entity = static_cast<int>(parts.entities.size());
  parts.entities.push_back({{description.name.empty() ? "World" : description.name}});
  parts.world_material = description.material;
  if (description.material < 0) return true;
  const Material& material = parts.materials[static_cast<std::size_t>(description.material)];
  if (!material.emits()) return true;
  World world;
  if (material.emission_is_constant()) {
    world.radiance = world.mean_radiance = material.average_emission();
    if (is_black(world.radiance)) return true;
  } else {
    world.constant = false;
    world.width = std::clamp(description.resolution, 16, 8192), world.height = world.width / 2;
    if (!fill_table(material, world, cancelled, threads)) return false;
  }
  Light light;
  light.strength = std::max(pi * mean(world.mean_radiance), 1e-20f);
  light.entity = parts.world_entity, light.visible_to_camera = true;
  light.kind = std::move(world);
  parts.world_light = static_cast<int>(parts.lights.size());
  parts.infinite_lights.push_back(parts.world_light);
  parts.lights.push_back(std::move(light));
  return true;
}

}  // namespace sluice
