// SPDX-License-Identifier: GPL-3.0-or-later
// Description to compiled scene, top to bottom.
#include "scene/parts.h"

namespace sluice {
namespace {

void compile_materials(Scene::Parts& parts, Warnings& warnings, const CancelPoint& cancel) {
  const SceneDescription& description = parts.description;
  for (const MaterialDescription& material : description.materials) {
    cancel();
    parts.materials.push_back(
        compile_material(material, description.images, description.specular_threshold, warnings));
  }
  parts.materials.push_back(
      compile_material(default_material(), description.images, description.specular_threshold, warnings));
  parts.material_used.assign(parts.materials.size(), 0);
}

// A mesh whose instances are all copies needs its own vertices no more; the others need one that Embree may
// read beyond the end.
void settle_vertices(Scene::Parts& parts) {
  std::vector<char> placed(parts.description.meshes.size(), 0);
  for (const Instance& instance : parts.instances)
    if (!instance.baked) placed[instance.mesh] = 1;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    auto& positions = parts.description.meshes[i].positions;
    if (placed[i])
      positions.push_back(V3f(0));
    else
      positions = {};
  }
}

bool build_accelerator(Scene::Parts& parts, const std::function<bool()>& cancelled, int threads) {
  std::vector<AcceleratorItem> prototypes, items;
  std::vector<int> prototype_of(parts.description.meshes.size(), -1);
  for (const Instance& instance : parts.instances) {
    const MeshDescription& mesh = parts.mesh(instance);
    AcceleratorItem item;
    item.mask = instance.mask;
    if (instance.baked) {
      item.positions = std::span(instance.baked_positions).first(instance.baked_positions.size() - 1);
      item.triangles = mesh.triangles;
    } else {
      int& prototype = prototype_of[instance.mesh];
      if (prototype < 0) {
        prototype = static_cast<int>(prototypes.size());
        prototypes.push_back(
            {std::span(mesh.positions).first(mesh.positions.size() - 1), mesh.triangles, -1, {}, mask_any});
      }
      item.prototype = prototype;
      item.to_scene = instance.to_scene;
    }
    items.push_back(item);
  }
  return parts.accelerator.build(prototypes, items, threads, cancelled);
}

// What can happen at each thing, for the words that paths can spell.
void name_events(Scene::Parts& parts) {
  for (Entity& entity : parts.entities) entity.events = 0;
  const auto at = [&](int entity) -> EventMask& {
    return parts.entities[static_cast<std::size_t>(entity)].events;
  };
  for (const Instance& instance : parts.instances)
    for (const std::uint32_t m : instance.used_materials)
      at(instance.entity) |= static_cast<EventMask>(parts.materials[m].lobe_events() |
                                                    (parts.materials[m].emits() ? mask_of(Event::L) : 0));
  for (const Light& light : parts.lights) at(light.entity) |= mask_of(Event::L);
}

void warn_of_oddities(const Scene::Parts& parts, Warnings& warnings) {
  if (parts.instances.empty())
    warnings.push_back({"scene", "there is nothing to see: no surface in the scene"});
  if (parts.lights.empty()) warnings.push_back({"scene", "there is no light: the picture will be black"});
  const double size = parts.geometry_bounds.diagonal();
  if (!parts.instances.empty() && !(size > 1e-5 && size < 1e7))
    warnings.push_back(
        {"scene", "it is " + std::to_string(size) + " m large: hits and gates are inexact at such a scale"});
}

std::shared_ptr<const Scene::Parts> compile_parts(SceneDescription description,
                                                  const std::function<bool()>& cancelled, int threads) {
  const CancelPoint cancel(cancelled);
  auto parts = std::make_shared<Scene::Parts>();
  Warnings& warnings = parts->warnings;
  clean_meshes(description, warnings, cancel);
  parts->description = std::move(description);
  compile_materials(*parts, warnings, cancel);
  place_instances(*parts, warnings, cancel);
  settle_vertices(*parts);
  cancel();
  if (!build_accelerator(*parts, cancelled, threads)) return nullptr;
  add_lamps(*parts, warnings);
  add_mesh_lights(*parts, cancel);
  add_world(*parts, cancelled, threads);
  cancel();
  if (parts->lights.size() > few_lights) parts->light_tree = LightTree(parts->lights);
  name_events(*parts);
  warn_of_oddities(*parts, warnings);
  return parts;
}

std::unique_ptr<const Scene> shoot(std::shared_ptr<const Scene::Parts> parts,
                                   const ShotDescription& description, Warnings& warnings,
                                   const CancelPoint& cancel) {
  warnings.insert(warnings.end(), parts->warnings.begin(), parts->warnings.end());
  auto shot = std::make_unique<Scene::Shot>();
  const V3d& centre = parts->centre;
  Box box = box_of(parts->geometry_bounds);
  if (!box.isEmpty()) box = Box(box.min + centre, box.max + centre);
  shot->edits = compile_edits(description.edits, parts->entities, parts->description.images, {centre, box},
                              description.max_gates, warnings, description.layers, cancel);
  for (const Instance& instance : parts->instances) {
    auto& [classes, may_be_taken] = shot->events_at.emplace_back();
    for (std::size_t kind = 0; kind < event_count; ++kind)
      classes[kind] = shot->edits.event_class(static_cast<Event>(kind), instance.entity);
    for (const Event e : {Event::L, Event::D, Event::S, Event::G})
      may_be_taken = may_be_taken ||
                     !shot->edits.could_take_after(Side::Light, classes[static_cast<std::size_t>(e)]).empty();
  }
  shot->frame = description.frame;
  shot->camera = Camera(description.camera, description.frame, centre);
  shot->pixel_filter = PixelFilter(description.frame);
  shot->gates_in_view = GatesInView(shot->edits, shot->camera, shot->pixel_filter, description.frame);
  shot->bounds = parts->geometry_bounds;
  const Box quads = quad_bounds(description.edits, box_of(parts->world_bounds));
  if (!quads.isEmpty()) shot->bounds.add(quads.min - centre), shot->bounds.add(quads.max - centre);
  return std::make_unique<const Scene>(std::move(parts), std::move(shot));
}

}  // namespace

std::unique_ptr<const Scene> compile(SceneDescription description, Warnings& warnings,
                                     const std::function<bool()>& cancelled, int threads) {
  check_description(description);
  try {
    auto parts = compile_parts(std::move(description), cancelled, threads);
    if (!parts) return nullptr;
    const ShotDescription& shot = parts->description;
    return shoot(parts, shot, warnings, CancelPoint(cancelled));
  } catch (const Cancelled&) { return nullptr; }
}

bool can_recompile(const Scene& base, const ShotDescription& shot) {
  const Scene::Parts& parts = parts_of(base);
  return choose_centre(parts.world_bounds, quad_bounds(shot.edits, box_of(parts.world_bounds))) ==
         parts.centre;
}

std::unique_ptr<const Scene> recompile(const Scene& base, const ShotDescription& shot, Warnings& warnings,
                                       const std::function<bool()>& cancelled) {
  check_shot(shot, parts_of(base).description.images.size());
  try {
    return shoot(base.parts_, shot, warnings, CancelPoint(cancelled));
  } catch (const Cancelled&) { return nullptr; }
}

}  // namespace sluice
