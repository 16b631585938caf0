// SPDX-License-Identifier: GPL-3.0-or-later
// Every question of light.h, handed to the light's kind.
#include "scene/light.h"

#include "scene/light_kinds.h"

namespace sluice {
namespace {

const Light& light_at(const Scene& scene, int light) noexcept {
  return parts_of(scene).lights[static_cast<std::size_t>(light)];
}

// Of a parallel sun: its irradiance on a plane that faces it.
template <kinds::Infinite Kind>
Color radiance_of(const Scene::Parts& parts, const Kind& kind, const V3f& to_light) noexcept {
  if constexpr (requires { kind.irradiance; })
    if (kinds::is_delta(kind)) return kind.irradiance;
  return kinds::radiance(parts, kind, to_light, false);
}

}  // namespace

bool is_infinite(const Light& light) noexcept {
  return std::visit([](const auto& kind) { return kind.infinite; }, light.kind);
}

bool is_delta(const Light& light) noexcept {
  return std::visit([](const auto& kind) { return kinds::is_delta(kind); }, light.kind);
}

std::optional<V3f> common_direction(const Light& light) noexcept {
  const auto visit = [](const auto& kind) -> std::optional<V3f> {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>)
      return kinds::common_direction(kind);
    else
      return {};
  };
  return std::visit(visit, light.kind);
}

bool is_too_near(const Light& light, float pdf) noexcept {
  return pdf > 0 && pdf < 1 / (2 * pi) && !is_infinite(light) && !is_delta(light);
}

std::optional<DirectSample> sample_direct(const Scene& scene, int light, const V3d& from, float u_part,
                                          const V2f& u) noexcept {
  const auto visit = [&](const auto& kind) -> std::optional<DirectSample> {
    using Kind = std::decay_t<decltype(kind)>;
    if constexpr (kinds::Infinite<Kind>) {
      const auto towards = kinds::sample_towards(kind, u);
      if (!towards) return {};
      return DirectSample{towards->direction,
                          std::numeric_limits<double>::infinity(),
                          radiance_of(parts_of(scene), kind, towards->direction),
                          towards->pdf,
                          kinds::is_delta(kind),
                          std::numeric_limits<double>::infinity()};
    } else {
      return kinds::sample_direct(parts_of(scene), kind, from, u_part, u);
    }
  };
  return std::visit(visit, light_at(scene, light).kind);
}

float pdf_direct(const Scene& scene, int light, const V3d& from, const V3f& wi, const Hit* hit) noexcept {
  const auto visit = [&](const auto& kind) -> float {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>)
      return kinds::is_delta(kind) ? 0.0f : kinds::pdf_towards(kind, wi);
    else
      return kinds::pdf_direct(parts_of(scene), kind, from, wi, hit);
  };
  return std::visit(visit, light_at(scene, light).kind);
}

Color eval_infinite(const Scene& scene, int light, const V3f& direction, bool camera_ray) noexcept {
  const auto visit = [&](const auto& kind) -> Color {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>)
      return kinds::radiance(parts_of(scene), kind, direction, camera_ray);
    else
      return Color(0);
  };
  const Light& asked = light_at(scene, light);
  if (camera_ray && !asked.visible_to_camera) return Color(0);
  return std::visit(visit, asked.kind);
}

std::size_t max_lamp_hits(const Scene& scene) noexcept { return parts_of(scene).shaped_lamps.size(); }

int intersect_lamps(const Scene& scene, const Ray& ray, std::span<LampHit> found) noexcept {
  const Scene::Parts& parts = parts_of(scene);
  std::size_t count = 0;
  for (const int index : parts.shaped_lamps) {
    if (count == found.size()) break;
    const Light& light = parts.lights[static_cast<std::size_t>(index)];
    if (ray.from_camera && !light.visible_to_camera) continue;
    const auto visit = [&](const auto& lamp) {
      if constexpr (std::decay_t<decltype(lamp)>::crossable) {
        const auto crossing = kinds::crossing(lamp, ray.origin, ray.direction);
        if (!crossing || !(crossing->t <= ray.t_max)) return;
        found[count++] = {index, crossing->t, crossing->radiance};
      }
    };
    std::visit(visit, light.kind);
  }
  return static_cast<int>(count);
}

std::optional<EmissionPoint> sample_position(const Scene& scene, int light, float u_part,
                                             const V2f& u) noexcept {
  const auto visit = [&](const auto& kind) -> std::optional<EmissionPoint> {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>)
      return {};
    else
      return kinds::sample_position(parts_of(scene), kind, u_part, u);
  };
  return std::visit(visit, light_at(scene, light).kind);
}

std::optional<EmissionDirection> sample_direction(const Scene& scene, int light, const EmissionPoint& point,
                                                  float u_part, const V2f& u) noexcept {
  const auto visit = [&](const auto& kind) -> std::optional<EmissionDirection> {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>)
      return {};
    else
      return kinds::sample_direction(parts_of(scene), kind, point, u_part, u);
  };
  return std::visit(visit, light_at(scene, light).kind);
}

float pdf_direction(const Scene& scene, int light, const EmissionPoint& point,
                    const V3f& direction) noexcept {
  const auto visit = [&](const auto& kind) -> float {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>)
      return 0;
    else
      return kinds::pdf_direction(parts_of(scene), kind, point, direction);
  };
  return std::visit(visit, light_at(scene, light).kind);
}

Color eval_emission(const Scene& scene, int light, const EmissionPoint& point,
                    const V3f& direction) noexcept {
  const auto visit = [&](const auto& kind) -> Color {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>)
      return Color(0);
    else
      return kinds::eval_emission(parts_of(scene), kind, point, direction);
  };
  return std::visit(visit, light_at(scene, light).kind);
}

std::optional<EmissionDirection> sample_infinite(const Scene& scene, int light, const V2f& u) noexcept {
  const auto visit = [&](const auto& kind) -> std::optional<EmissionDirection> {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>) {
      auto towards = kinds::sample_towards(kind, u);
      if (towards) towards->direction = -towards->direction;
      return towards;
    } else {
      return {};
    }
  };
  return std::visit(visit, light_at(scene, light).kind);
}

Color eval_infinite_emission(const Scene& scene, int light, const V3f& direction) noexcept {
  const auto visit = [&](const auto& kind) -> Color {
    if constexpr (kinds::Infinite<std::decay_t<decltype(kind)>>)
      return radiance_of(parts_of(scene), kind, -direction);
    else
      return Color(0);
  };
  return std::visit(visit, light_at(scene, light).kind);
}

}  // namespace sluice
