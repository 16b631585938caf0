// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene.h"

#include <algorithm>

#include "scene/parts.h"

namespace sluice {

void Bounds::add(const V3d& p) noexcept {
  for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
}

std::array<V3d, 3> Scene::Parts::corners(const Instance& instance, std::uint32_t triangle) const noexcept {
  const MeshDescription& shape = mesh(instance);
  const auto& corner = shape.triangles[triangle];
  if (instance.baked) {
    const V3f* p = instance.baked_positions.data();
    return {V3d(p[corner[0]]), V3d(p[corner[1]]), V3d(p[corner[2]])};
  }
  const V3f* p = shape.positions.data();
  return {V3d(p[corner[0]]) * instance.to_scene, V3d(p[corner[1]]) * instance.to_scene,
          V3d(p[corner[2]]) * instance.to_scene};
}

const MaterialBinding& Scene::Parts::binding(const Instance& instance,
                                             std::uint32_t triangle) const noexcept {
  const auto& of_triangle = mesh(instance).material_slots;
  const std::size_t slot = of_triangle.empty() ? 0 : of_triangle[triangle];
  // as Blender does with slots that were removed
  return instance.slots[std::min(slot, instance.slots.size() - 1)];
}

Scene::Scene(std::shared_ptr<const Parts> parts, std::unique_ptr<const Shot> shot) noexcept
    : parts_(std::move(parts)), shot_(std::move(shot)) {}
Scene::~Scene() = default;

namespace {

// Where the ray enters the single-precision world: off its own surface, on the side that it goes to.
V3f start(const Ray& ray) noexcept {
  const float side = ray.clearance.dot(ray.direction) < 0 ? -1.0f : 1.0f;
  return V3f(ray.origin + V3d(ray.clearance * side));
}

// A shadow ray ends just short of a light, so the end must stay where it is when the start moves off its
// surface: else the light's own mesh blocks it as soon as the receiver's clearance is larger than the
// light's.
RaySegment shadow_segment(const Ray& ray) noexcept {
  const RaySegment plain{start(ray), ray.direction, static_cast<float>(ray.t_max)};
  if (!std::isfinite(ray.t_max)) return plain;
  const V3d to = ray.origin + V3d(ray.direction) * ray.t_max - V3d(plain.origin);
  const double length = std::sqrt(to.length2());
  // as short as the clearance: it has no direction of its own
  if (!(to.dot(V3d(ray.direction)) > 0.5 * length)) return plain;
  return {plain.origin, V3f(to * (1 / length)), static_cast<float>(length)};
}

// The hit in double, from the plane of the triangle as Embree saw it (numerics §1: its float t is off by up
// to 3e-5).
Hit refine(const Scene::Parts& parts, const Ray& ray, const RawHit& raw) noexcept {
  const Instance& instance = parts.instances[raw.instance];
  const std::vector<V3f>& normals = parts.mesh(instance).normals;  // read next, by surface_point_of()
  if (!normals.empty()) __builtin_prefetch(&normals[std::size_t{3} * raw.triangle]);
  const auto [a, b, c] = parts.corners(instance, raw.triangle);
  const V3d direction(ray.direction);
  const V3d n = (b - a).cross(c - a);
  double t = n.dot(a - ray.origin) / n.dot(direction);
  // in the triangle's own plane the quotient means nothing: there Embree's is as good as any
  const double slack =
      instance.clearance + std::abs(ray.clearance.x) + std::abs(ray.clearance.y) + std::abs(ray.clearance.z);
  if (!(std::abs(t - raw.t) <= 1e-3 * raw.t + 8 * slack)) t = raw.t;
  t = std::max(t, 0.0);
  const V3d position = ray.origin + direction * t;
  const double reach = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
  const double squared = n.length2();
  const V3f ng = squared > 0 ? V3f(n * (instance.side / std::sqrt(squared))) : -ray.direction;
  const float clearance = instance.clearance + instance.clearance_rate * static_cast<float>(reach);
  return {t, position, ng, ng * clearance, raw.instance, raw.triangle, raw.u, raw.v};
}

}  // namespace

std::optional<Hit> Scene::intersect(const Ray& ray) const noexcept {
  const auto raw = parts_->accelerator.nearest({start(ray), ray.direction, static_cast<float>(ray.t_max)},
                                               ray.from_camera ? mask_camera : mask_any);
  if (!raw) return {};
  return refine(*parts_, ray, *raw);
}

std::optional<Color> Scene::transmittance(const Ray& ray) const noexcept {
  const Parts& parts = *parts_;
  if (parts.accelerator.blocked(shadow_segment(ray), mask_shadow_opaque)) return Color(0);
  Color left(1);
  if (!parts.has_transparent_shadows) return left;
  Ray rest = ray;
  SurfacePoint point;
  for (int layer = 0; layer < max_alpha_layers; ++layer) {
    const auto raw = parts.accelerator.nearest(shadow_segment(rest), mask_shadow_transparent);
    if (!raw) return left;
    const Hit hit = refine(parts, rest, *raw);
    const Material& surface = material(hit);
    if (surface.is_opaque()) return Color(0);
    surface_point(hit, -rest.direction, false, point);
    left *= eval_transparency(surface, point);
    if (is_black(left)) return left;
    rest.t_max -= hit.t;
    rest.origin = hit.position;
    rest.clearance = hit.clearance;
    if (!(rest.t_max > 0)) return left;
  }
  return {};
}

void Scene::find_clear(std::span<const Ray> rays, std::span<bool> clear) const noexcept {
  std::array<RaySegment, packet_size> packet;
  for (std::size_t begin = 0; begin < rays.size(); begin += packet_size) {
    const std::size_t count = std::min(packet_size, rays.size() - begin);
    for (std::size_t i = 0; i < count; ++i) packet[i] = shadow_segment(rays[begin + i]);
    const unsigned blocked = parts_->accelerator.blocked(std::span(packet).first(count), mask_any);
    for (std::size_t i = 0; i < count; ++i) clear[begin + i] = !((blocked >> i) & 1);
  }
}

const Material& Scene::material(const Hit& hit) const noexcept {
  return parts_->materials[parts_->binding(parts_->instances[hit.instance], hit.triangle).material];
}

void Scene::surface_point(const Hit& hit, const V3f& wo, bool camera_ray,
                          SurfacePoint& point) const noexcept {
  surface_point_of(*parts_, hit, wo, camera_ray, point);
}

std::span<const Light> Scene::lights() const noexcept { return parts_->lights; }
int Scene::mesh_light(std::uint32_t instance) const noexcept { return parts_->instances[instance].light; }
int Scene::world_light() const noexcept { return parts_->world_light; }
std::span<const int> Scene::infinite_lights() const noexcept { return parts_->infinite_lights; }

const std::vector<Entity>& Scene::entities() const noexcept { return parts_->entities; }
int Scene::entity(const Hit& hit) const noexcept { return parts_->instances[hit.instance].entity; }
EventClass Scene::event_class(Event kind, const Hit& hit) const noexcept {
  return shot_->events_at[hit.instance].classes[static_cast<std::size_t>(kind)];
}
bool Scene::may_be_taken_from(const Hit& hit) const noexcept {
  return shot_->events_at[hit.instance].may_be_taken;
}
int Scene::light_entity(int light) const noexcept {
  return parts_->lights[static_cast<std::size_t>(light)].entity;
}
const Edits& Scene::edits() const noexcept { return shot_->edits; }

const GatesInView& Scene::gates_in_view() const noexcept { return shot_->gates_in_view; }

const Camera& Scene::camera() const noexcept { return shot_->camera; }
const FrameDescription& Scene::frame() const noexcept { return shot_->frame; }
const PixelFilter& Scene::pixel_filter() const noexcept { return shot_->pixel_filter; }
const V3d& Scene::centre() const noexcept { return parts_->centre; }
const Bounds& Scene::geometry_bounds() const noexcept { return parts_->geometry_bounds; }
const Bounds& Scene::bounds() const noexcept { return shot_->bounds; }
double Scene::extent() const noexcept { return parts_->extent; }
std::span<const Material> Scene::materials() const noexcept { return parts_->materials; }
bool Scene::material_used(std::size_t material) const noexcept {
  return parts_->material_used[material] != 0;
}
std::size_t Scene::triangle_count() const noexcept { return parts_->triangle_count; }
std::size_t Scene::instance_count() const noexcept { return parts_->instances.size(); }
const Bounds& Scene::instance_bounds(std::size_t instance) const noexcept {
  return parts_->instances[instance].bounds;
}
std::span<const std::uint32_t> Scene::instance_materials(std::size_t instance) const noexcept {
  return parts_->instances[instance].used_materials;
}

}  // namespace sluice
