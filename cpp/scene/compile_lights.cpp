// SPDX-License-Identifier: GPL-3.0-or-later
// The scene's list of lights: lamps, emissive instances and the world. How a light is made of its description
// stands with each kind (light_kinds.h).
#include "scene/light_kinds.h"
#include "scene/parts.h"

namespace sluice {
namespace {

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
         (!has_direction(d.kind) || kinds::row_of(d, 2).length() > 0);
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
    std::optional<Light> light = kinds::make_lamp(d, parts.centre);
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

void add_mesh_lights(Scene::Parts& parts, const CancelPoint& cancel) {
  for (std::uint32_t i = 0; i < parts.instances.size(); ++i) {
    std::optional<Light> light = kinds::make_mesh_light(parts, i, cancel);
    if (!light) continue;
    light->entity = parts.instances[i].entity;
    parts.instances[i].light = static_cast<int>(parts.lights.size());
    parts.lights.push_back(std::move(*light));
  }
}

void add_world(Scene::Parts& parts, const std::function<bool()>& cancelled, int threads) {
  const WorldDescription& description = parts.description.world;
  parts.world_entity = static_cast<int>(parts.entities.size());
  parts.entities.push_back({{description.name.empty() ? "World" : description.name}});
  parts.world_material = description.material;
  std::optional<Light> light = kinds::make_world(parts, cancelled, threads);
  if (!light) return;
  light->entity = parts.world_entity, light->visible_to_camera = true;
  parts.world_light = static_cast<int>(parts.lights.size());
  parts.infinite_lights.push_back(parts.world_light);
  parts.lights.push_back(std::move(*light));
}

}  // namespace sluice
