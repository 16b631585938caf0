// SPDX-License-Identifier: GPL-3.0-or-later
// Instances in their place: which matrices can be used, where the origin goes, whose vertices are moved, who
// reads which layers.
#include <algorithm>
#include <map>

#include "scene/parts.h"

namespace sluice {
namespace {

constexpr double ulp = 0x1p-24;  // relative rounding of a float
bool is_regular(const M44d& m) noexcept {
  if (!is_finite(m)) return false;
  const V3d x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]), z(m[2][0], m[2][1], m[2][2]);
  const double lengths = x.length() * y.length() * z.length();
  return lengths > 0 && std::abs(x.cross(y).dot(z)) > 1e-12 * lengths;
}

double determinant(const M44d& m) noexcept {
  const V3d x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]), z(m[2][0], m[2][1], m[2][2]);
  return x.cross(y).dot(z);
}

// Largest row sum of the linear part: bounds how much a coordinate's error grows.
double growth(const M44d& m) noexcept {
  double most = 0;
  for (int i = 0; i < 3; ++i)
    most = std::max(most, std::abs(m[0][i]) + std::abs(m[1][i]) + std::abs(m[2][i]));
  return most;
}

Bounds world_bounds(const MeshDescription& mesh, const M44d& matrix, const CancelPoint& cancel) {
  cancel();
  Bounds bounds;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    cancel.at(i);
    for (const std::uint32_t index : mesh.triangles[i]) bounds.add(V3d(mesh.positions[index]) * matrix);
  }
  return bounds;
}

std::int8_t index_of(const std::string& name, const auto& layers) noexcept {
  if (name.empty()) return layers.empty() ? -1 : 0;
  for (std::size_t i = 0; i < layers.size() && i < 127; ++i)
    if (layers[i].name == name) return static_cast<std::int8_t>(i);
  return -1;
}

MaterialBinding bind(const Scene::Parts& parts, const MeshDescription& mesh, int material) {
  MaterialBinding binding;
  binding.material = material < 0 ? static_cast<std::uint32_t>(parts.materials.size() - 1)
                                  : static_cast<std::uint32_t>(material);
  const MaterialNeeds& needs = parts.materials[binding.material].needs();
  binding.gradients = needs.uv_gradients;
  binding.uv_count = static_cast<std::int8_t>(std::min(needs.uv_maps.size(), std::size_t{max_uv_maps}));
  binding.color_count =
      static_cast<std::int8_t>(std::min(needs.color_layers.size(), std::size_t{max_color_layers}));
  for (std::size_t i = 0; i < static_cast<std::size_t>(binding.uv_count); ++i)
    binding.uv[i] = index_of(needs.uv_maps[i], mesh.uv_maps);
  for (std::size_t i = 0; i < static_cast<std::size_t>(binding.color_count); ++i)
    binding.color[i] = index_of(needs.color_layers[i], mesh.colors);
  return binding;
}

void set_materials(Scene::Parts& parts, const InstanceDescription& description, Instance& instance) {
  const MeshDescription& mesh = parts.mesh(instance);
  for (const int material : description.materials) instance.slots.push_back(bind(parts, mesh, material));
  if (instance.slots.empty()) instance.slots.push_back(bind(parts, mesh, -1));
  std::vector<char> used(instance.slots.size(), 0);
  if (mesh.material_slots.empty()) used[0] = 1;
  for (const std::uint16_t slot : mesh.material_slots) used[std::min<std::size_t>(slot, used.size() - 1)] = 1;
  bool opaque = true;
  for (std::size_t slot = 0; slot < used.size(); ++slot) {
    ObjectShading shading = instance.shading;
    shading.material_index = static_cast<int>(slot);
    instance.slot_shading.push_back(shading);
    if (!used[slot]) continue;
    const std::uint32_t material = instance.slots[slot].material;
    parts.material_used[material] = 1;
    opaque = opaque && parts.materials[material].is_opaque();
    if (std::find(instance.used_materials.begin(), instance.used_materials.end(), material) ==
        instance.used_materials.end())
      instance.used_materials.push_back(material);
  }
  if (description.visible_to_camera) instance.mask |= mask_camera;
  if (description.casts_shadow) instance.mask |= opaque ? mask_shadow_opaque : mask_shadow_transparent;
  parts.has_transparent_shadows |= description.casts_shadow && !opaque;
}

// Vertices moved to the scene's space (one extra that Embree may read), bounds, and how far rays must start
// off the surface. What rounds: the ray's origin (ulp of the hit's coordinates), differences between it and
// the triangle's corners (ulp of the triangle's size), and for a placed mesh its matrix and the ray in local
// space.
void set_geometry(Scene::Parts& parts, Instance& instance, const CancelPoint& cancel) {
  cancel();
  const MeshDescription& mesh = parts.mesh(instance);
  if (instance.baked) {
    instance.baked_positions.reserve(mesh.positions.size() + 1);
    for (const V3f& p : mesh.positions) instance.baked_positions.push_back(V3f(V3d(p) * instance.to_scene));
    instance.baked_positions.push_back(V3f(0));
  }
  double longest = 0;
  for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
    cancel.at(triangle);
    Bounds one;
    for (const V3d& p : parts.corners(instance, triangle)) one.add(p);
    const V3d size = one.high - one.low;
    longest = std::max({longest, size.x, size.y, size.z});
    instance.bounds.add(one.low), instance.bounds.add(one.high);
  }
  instance.clearance = static_cast<float>(8 * ulp * longest);
  instance.clearance_rate = static_cast<float>(8 * ulp);
  if (!instance.baked) {
    const double condition = growth(instance.to_scene) * growth(instance.to_scene.inverse());
    const V3d shift(instance.to_scene[3][0], instance.to_scene[3][1], instance.to_scene[3][2]);
    instance.clearance += static_cast<float>(2 * ulp * condition * shift.length());
    instance.clearance_rate = static_cast<float>(ulp * (8 + 2 * condition));
  }
  instance.shading.bump_step = static_cast<float>(instance.bounds.diagonal() * 0x1p-11);
}

Imath::M44f to_float(const M44d& m) noexcept { return Imath::M44f(m); }

void set_shading(const InstanceDescription& description, const MeshDescription& mesh, Instance& instance) {
  ObjectShading& shading = instance.shading;
  shading.object_to_world = to_float(description.matrix);
  shading.world_to_object = to_float(description.matrix.inverse());
  shading.texture_origin = mesh.texture_origin, shading.texture_size = mesh.texture_size;
  shading.color = description.color, shading.random = description.random;
  shading.object_index = description.object_index;
}

}  // namespace

// Re-centring makes float vertices fine near the origin. It must not depend on edits that do nothing, so it
// happens only where it is needed: a scene far from its origin, or quads so small and far away that floats
// would be coarse there.
V3d choose_centre(const Bounds& geometry, const Box& quads) noexcept {
  V3d centre(0);
  if (!geometry.empty() && geometry.middle().length() > geometry.diagonal()) centre = geometry.middle();
  if (quads.isEmpty()) return centre;
  const V3d middle = quads.center();
  if (geometry.empty() || (middle - centre).length() > 4096 * quads.size().length()) return middle;
  return centre;
}

void place_instances(Scene::Parts& parts, Warnings& warnings, const CancelPoint& cancel) {
  const SceneDescription& description = parts.description;
  Tally singular, grey, huge;
  std::vector<const InstanceDescription*> usable;
  std::vector<std::size_t> uses(description.meshes.size(), 0);
  Bounds& world = parts.world_bounds;
  for (const InstanceDescription& instance : description.instances) {
    if (instance.mesh < 0) continue;
    const MeshDescription& mesh = description.meshes[static_cast<std::size_t>(instance.mesh)];
    if (mesh.triangles.empty()) continue;
    if (!is_regular(instance.matrix)) {
      singular.add(first_name(instance.names));
      continue;
    }
    const Bounds bounds = world_bounds(mesh, instance.matrix, cancel);
    // rays further out meet nothing, and squares of distances must fit into floats
    constexpr double max_length = 1e15;
    if (!(bounds.diagonal() < max_length && bounds.middle().length() < max_length)) {
      huge.add(first_name(instance.names));
      continue;
    }
    const bool named =
        std::any_of(instance.materials.begin(), instance.materials.end(), [](int m) { return m >= 0; });
    if (!named) grey.add(first_name(instance.names));
    usable.push_back(&instance);
    ++uses[static_cast<std::size_t>(instance.mesh)];
    world.add(bounds.low), world.add(bounds.high);
  }
  singular.report("its scale is 0 in some direction, or its matrix is not finite: left out", warnings);
  huge.report("it is more than 1e15 m large or away: left out", warnings);
  grey.report("has no material: drawn in neutral grey", warnings);

  parts.centre = choose_centre(world, quad_bounds(description.edits, box_of(world)));
  M44d recentre;
  recentre.setTranslation(-parts.centre);

  std::map<std::vector<std::string>, int> entity_of;
  for (const InstanceDescription* source : usable) {
    Instance instance;
    instance.mesh = static_cast<std::uint32_t>(source->mesh);
    const MeshDescription& mesh = parts.mesh(instance);
    // a mesh in one place is moved there: exact, and one level to trace. Copies of shared ones were measured:
    // never faster, twice as slow from 100,000 triangles on
    instance.baked = uses[instance.mesh] == 1;
    instance.to_scene = source->matrix * recentre;
    instance.side = determinant(source->matrix) < 0 ? -1 : 1;
    set_shading(*source, mesh, instance);
    set_geometry(parts, instance, cancel);
    set_materials(parts, *source, instance);
    const auto [known, is_new] =
        entity_of.try_emplace(source->names, static_cast<int>(parts.entities.size()));
    if (is_new) parts.entities.push_back({source->names});
    instance.entity = known->second;
    parts.geometry_bounds.add(instance.bounds.low), parts.geometry_bounds.add(instance.bounds.high);
    parts.triangle_count += mesh.triangles.size();
    parts.instances.push_back(std::move(instance));
  }
  parts.extent = parts.geometry_bounds.diagonal() > 0 ? parts.geometry_bounds.diagonal() : 1;
}

}  // namespace sluice
