// SPDX-License-Identifier: GPL-3.0-or-later
// What a compiled scene consists of. Private to this folder: compile*.cpp fill it, scene.cpp, surface.cpp and
// the lights read it.
#pragma once
#include <array>

#include "base/cancel.h"
#include "edit/compile_edits.h"
#include "scene/embree.h"
#include "scene/gates_in_view.h"
#include "scene/light_tree.h"
#include "scene/scene.h"
#include "shading/material.h"

namespace sluice {

// Which layers of a mesh a material reads, resolved once per instance and slot; -1: the mesh has none of that
// name (reads 0).
struct MaterialBinding {
  std::uint32_t material = 0;  // index into Parts::materials
  std::int8_t uv_count = 0, color_count = 0;
  std::array<std::int8_t, max_uv_maps> uv{};
  std::array<std::int8_t, max_color_layers> color{};
  bool gradients = false;
};

// A mesh in its place. `baked`: its vertices were moved to the scene's space, else rays visit the mesh's own
// through the matrix.
struct Instance {
  std::uint32_t mesh = 0;
  bool baked = false;
  std::vector<V3f> baked_positions;
  M44d to_scene;                       // local to re-centred
  double side = 1;                     // -1: the matrix mirrors, so that the winding shows the inside
  float clearance = 0;                 // m, plus
  float clearance_rate = 0;            // this times the largest |coordinate| of the hit
  std::vector<MaterialBinding> slots;  // at least one
  std::vector<std::uint32_t> used_materials;
  ObjectShading shading;  // per slot only the material index differs
  std::vector<ObjectShading> slot_shading;
  unsigned mask = mask_any;
  int entity = -1, light = -1;
  Bounds bounds;
};

// What takes long to make: things, materials, lights. Nothing in it depends on the shot but `centre`, and
// that only where quads are far.
struct Scene::Parts {
  SceneDescription description;  // meshes (usable triangles only) and images; the rest has served
  std::vector<Instance> instances;
  std::vector<Material> materials;
  std::vector<char> material_used;
  Accelerator accelerator;
  bool has_transparent_shadows = false;
  std::vector<Light> lights;
  std::vector<int> infinite_lights, shaped_lamps;  // shaped: lamps that rays can hit
  LightTree light_tree;                            // when they are many
  int world_light = -1, world_material = -1, world_entity = -1;
  std::vector<Entity> entities;
  V3d centre{0};
  Bounds geometry_bounds;
  Bounds world_bounds;  // the same before re-centring and rounding
  Warnings warnings;
  double extent = 1;
  std::size_t triangle_count = 0;

  [[nodiscard]] const MeshDescription& mesh(const Instance& instance) const noexcept {
    return description.meshes[instance.mesh];
  }
  // Corners of a triangle in re-centred space, exactly where rays meet it.
  [[nodiscard]] std::array<V3d, 3> corners(const Instance& instance, std::uint32_t triangle) const noexcept;
  [[nodiscard]] const MaterialBinding& binding(const Instance& instance,
                                               std::uint32_t triangle) const noexcept;
};

struct Scene::Shot {
  FrameDescription frame;
  Camera camera;
  PixelFilter pixel_filter;
  Edits edits;
  GatesInView gates_in_view;
  struct EventsAt {
    std::array<EventClass, event_count> classes;  // [kind]
    bool may_be_taken;                            // light, after one of them
  };
  std::vector<EventsAt> events_at;  // [instance]
  Bounds bounds;                    // surfaces and quads
};

[[nodiscard]] inline const Scene::Parts& parts_of(const Scene& scene) noexcept { return *scene.parts_; }

void surface_point_of(const Scene::Parts& parts, const Hit& hit, const V3f& wo, bool camera_ray,
                      SurfacePoint& point) noexcept;

// compile*.cpp, in the order compile() calls them. Each may add warnings and throw SceneError or Cancelled.
void check_description(const SceneDescription& description);       // compile_check.cpp
void check_shot(const ShotDescription& shot, std::size_t images);  // a part of it
// compile_mesh.cpp: drops unusable triangles
void clean_meshes(SceneDescription& description, Warnings& warnings, const CancelPoint& cancel);
// compile_instances.cpp
void place_instances(Scene::Parts& parts, Warnings& warnings, const CancelPoint& cancel);
[[nodiscard]] V3d choose_centre(const Bounds& geometry, const Box& quads) noexcept;  // world coordinates
void add_lamps(Scene::Parts& parts, Warnings& warnings);                             // compile_lights.cpp
void add_mesh_lights(Scene::Parts& parts, const CancelPoint& cancel);
void add_world(Scene::Parts& parts, const std::function<bool()>& cancelled, int threads);

// Warnings that list many items would hide the others: names the first, counts the rest.
class Tally {
 public:
  void add(const std::string& item) {
    if (count_++ == 0) first_ = item;
  }
  void report(const std::string& message, Warnings& warnings) const {
    if (count_ > 0)
      warnings.push_back({first_, count_ == 1
                                      ? message
                                      : message + " (and " + std::to_string(count_ - 1) + " more like it)"});
  }

 private:
  std::string first_;
  std::size_t count_ = 0;
};

[[nodiscard]] inline Box box_of(const Bounds& bounds) {
  return bounds.empty() ? Box() : Box(bounds.low, bounds.high);
}
[[nodiscard]] inline const std::string& first_name(const std::vector<std::string>& names) {
  static const std::string nameless = "unnamed";
  return names.empty() ? nameless : names.front();
}
[[nodiscard]] bool is_finite(const M44d& matrix) noexcept;
[[nodiscard]] inline float mean(const Color& c) noexcept { return (c.x + c.y + c.z) / 3; }

}  // namespace sluice
