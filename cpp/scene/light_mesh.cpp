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

// In the order of their facings.
std::vector<EmissiveTriangle> triangles_that_emit(const Parts& parts, const Instance& instance,
                                                  const CancelPoint& cancel) {
  const std::size_t count = parts.mesh(instance).triangles.size();
  std::vector<EmissiveTriangle> triangles;
  for (std::uint32_t triangle = 0; triangle < count; ++triangle) {
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
  }
  std::ranges::stable_sort(triangles, {},
                           [](const EmissiveTriangle& t) { return Facings::bin_of(t.normal); });
  return triangles;
}

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
int front_of(const Parts& parts, std::uint32_t instance, std::span<const EmissiveTriangle> triangles,
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
MeshLight mesh_light_of(std::uint32_t instance, std::size_t mesh_triangles,
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

std::optional<Light> make_mesh_light(const Parts& parts, std::uint32_t index, const CancelPoint& cancel) {
  const Instance& instance = parts.instances[index];
  const auto emits = [&](std::uint32_t m) { return parts.materials[m].emits(); };
  if (std::none_of(instance.used_materials.begin(), instance.used_materials.end(), emits)) return {};
  cancel();
  const std::vector<EmissiveTriangle> triangles = triangles_that_emit(parts, instance, cancel);
  Bounds bounds;
  for (const EmissiveTriangle& t : triangles)
    for (const V3d& p : t.corners) bounds.add(p);
  const V3d middle = bounds.middle();
  const double reach = reach_of(triangles, middle);
  const int front = front_of(parts, index, triangles, middle, reach);
  MeshLight mesh_light = mesh_light_of(index, parts.mesh(instance).triangles.size(), triangles, front);
  if (mesh_light.triangles.empty()) return {};
  Light light;
  const float total = static_cast<float>(mesh_light.triangles.total());
  light.power = 2 * pi * total;  // both sides
  light.middle = middle, light.reach = static_cast<float>(reach);
  light.strength = total / (front == 0 ? 2 : 4);  // mean projected areas
  light.kind = std::move(mesh_light);
  return light;
}

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

bool is_dark(const MeshLight&, const V3d&) noexcept { return false; }

DirectionCone emission_cone(const MeshLight&) noexcept { return {}; }

}  // namespace sluice::kinds
