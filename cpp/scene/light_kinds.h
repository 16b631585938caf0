// SPDX-License-Identifier: GPL-3.0-or-later
// What each kind of light says, one file per kind: the builder that makes it of its description, and the
// overloads behind light.h, each of which answers for its own struct as light.h's function of that name does.
// Private to this folder. Finite kinds: SphereLamp, AreaLamp, MeshLight; infinite ones: Sun, World.
#pragma once
#include "scene/light.h"
#include "scene/parts.h"

namespace sluice::kinds {

using Parts = Scene::Parts;

template <class Kind>
concept Infinite = Kind::infinite;
template <class Kind>
concept Finite = !Kind::infinite;

// Only sample_direct finds a light of no extent: a true point, a parallel sun.
[[nodiscard]] inline bool is_delta(const SphereLamp& lamp) noexcept { return lamp.radius == 0; }
[[nodiscard]] inline bool is_delta(const AreaLamp&) noexcept { return false; }
[[nodiscard]] inline bool is_delta(const MeshLight&) noexcept { return false; }
[[nodiscard]] inline bool is_delta(const Sun& sun) noexcept { return sun.tan_half == 0; }
[[nodiscard]] inline bool is_delta(const World&) noexcept { return false; }

struct LampCrossing {
  double t;
  Color radiance;
};

// Bounds on directions are wider than what they hold by about this (rad, or a share of a length).
inline constexpr double bound_slack = 1e-3;
// Directions around an axis, a little too wide. half (rad) >= pi: all of them; < 0: none.
struct DirectionCone {
  V3d axis{0, 0, 1};
  double half = std::numbers::pi;
};
// Directions as points of the unit sphere: all within `reach` of `middle`, a little too wide.
struct DirectionBall {
  V3d middle;
  double reach;
};

// ---- from the description. A builder gives the kind and the bounds `power`, `middle`, `reach` and
// `strength`; compile_lights.cpp fills in the rest of Light. `centre`: the scene's, to which positions are
// relative.

// 0, 1, 2: a lamp's axes in the world, with the lengths that its matrix gives them; 3: its place.
[[nodiscard]] inline V3d row_of(const LightDescription& d, int i) noexcept {
  return {d.matrix[i][0], d.matrix[i][1], d.matrix[i][2]};
}

[[nodiscard]] Light make_sphere_lamp(const LightDescription&, const V3d& centre);
[[nodiscard]] Light make_sun(const LightDescription&);
[[nodiscard]] std::optional<Light> make_area_lamp(const LightDescription&, const V3d& centre);

// Empty: it has no area.
[[nodiscard]] inline std::optional<Light> make_lamp(const LightDescription& d, const V3d& centre) {
  switch (d.kind) {
    case LightKind::Point:
    case LightKind::Spot: return make_sphere_lamp(d, centre);
    case LightKind::Sun: return make_sun(d);
    case LightKind::Area: return make_area_lamp(d, centre);
  }
  return {};
}

// Empty: nothing of the instance emits.
[[nodiscard]] std::optional<Light> make_mesh_light(const Parts&, std::uint32_t instance, const CancelPoint&);
// Empty: the world is black.
[[nodiscard]] std::optional<Light> make_world(const Parts&, const std::function<bool()>& cancelled,
                                              int threads);

// ---- answers

// sphere lamps: light_sphere.cpp
[[nodiscard]] float spot_factor(const SphereLamp& lamp, const V3f& direction) noexcept;
[[nodiscard]] std::optional<DirectSample> sample_direct(const Parts&, const SphereLamp&, const V3d& from,
                                                        float, const V2f& u) noexcept;
[[nodiscard]] float pdf_direct(const Parts&, const SphereLamp&, const V3d& from, const V3f& wi,
                               const Hit*) noexcept;
[[nodiscard]] std::optional<LampCrossing> crossing(const SphereLamp&, const V3d& origin,
                                                   const V3f& direction) noexcept;
[[nodiscard]] std::optional<EmissionPoint> sample_position(const Parts&, const SphereLamp&, float,
                                                           const V2f& u) noexcept;
[[nodiscard]] std::optional<EmissionDirection> sample_direction(const Parts&, const SphereLamp&,
                                                                const EmissionPoint&, float,
                                                                const V2f& u) noexcept;
[[nodiscard]] float pdf_direction(const Parts&, const SphereLamp&, const EmissionPoint&,
                                  const V3f& direction) noexcept;
[[nodiscard]] Color eval_emission(const Parts&, const SphereLamp&, const EmissionPoint&,
                                  const V3f& direction) noexcept;

// area lamps: light_area.cpp
[[nodiscard]] std::optional<DirectSample> sample_direct(const Parts&, const AreaLamp&, const V3d& from, float,
                                                        const V2f& u) noexcept;
[[nodiscard]] float pdf_direct(const Parts&, const AreaLamp&, const V3d& from, const V3f& wi,
                               const Hit*) noexcept;
[[nodiscard]] std::optional<LampCrossing> crossing(const AreaLamp&, const V3d& origin,
                                                   const V3f& direction) noexcept;
[[nodiscard]] std::optional<EmissionPoint> sample_position(const Parts&, const AreaLamp&, float,
                                                           const V2f& u) noexcept;
[[nodiscard]] std::optional<EmissionDirection> sample_direction(const Parts&, const AreaLamp&,
                                                                const EmissionPoint&, float,
                                                                const V2f& u) noexcept;
[[nodiscard]] float pdf_direction(const Parts&, const AreaLamp&, const EmissionPoint&,
                                  const V3f& direction) noexcept;
[[nodiscard]] Color eval_emission(const Parts&, const AreaLamp&, const EmissionPoint&,
                                  const V3f& direction) noexcept;

// emissive meshes: light_mesh.cpp
[[nodiscard]] std::optional<DirectSample> sample_direct(const Parts&, const MeshLight&, const V3d& from,
                                                        float u_part, const V2f& u) noexcept;
[[nodiscard]] float pdf_direct(const Parts&, const MeshLight&, const V3d& from, const V3f& wi,
                               const Hit* hit) noexcept;
[[nodiscard]] std::optional<EmissionPoint> sample_position(const Parts&, const MeshLight&, float u_part,
                                                           const V2f& u) noexcept;
[[nodiscard]] std::optional<EmissionDirection> sample_direction(const Parts&, const MeshLight&,
                                                                const EmissionPoint&, float u_part,
                                                                const V2f& u) noexcept;
[[nodiscard]] float pdf_direction(const Parts&, const MeshLight&, const EmissionPoint&,
                                  const V3f& direction) noexcept;
[[nodiscard]] Color eval_emission(const Parts&, const MeshLight&, const EmissionPoint&,
                                  const V3f& direction) noexcept;

// for the choice among lights (light_choice.cpp, light_tree_build.cpp), in each kind's file. Can none of a
// finite light's light come this way? Slack on the side of "it can".
[[nodiscard]] bool is_dark(const SphereLamp&, const V3d& from_middle) noexcept;
[[nodiscard]] bool is_dark(const AreaLamp&, const V3d& from_middle) noexcept;
[[nodiscard]] bool is_dark(const MeshLight&, const V3d& from_middle) noexcept;
// All directions that light of a finite light leaves it by.
[[nodiscard]] DirectionCone emission_cone(const SphereLamp&) noexcept;
[[nodiscard]] DirectionCone emission_cone(const AreaLamp&) noexcept;
[[nodiscard]] DirectionCone emission_cone(const MeshLight&) noexcept;
// A bound on the irradiance of an infinite light of that strength on a surface.
[[nodiscard]] float irradiance_bound(const Sun&, float strength, const V3f& normal) noexcept;
[[nodiscard]] float irradiance_bound(const World&, float strength, const V3f& normal) noexcept;
// All directions to an infinite light.
[[nodiscard]] DirectionBall directions_to(const Sun&) noexcept;
[[nodiscard]] DirectionBall directions_to(const World&) noexcept;

// The direction that all light of an infinite kind travels in, but for the width of a disc; empty: it comes
// from all sides.
[[nodiscard]] inline std::optional<V3f> common_direction(const Sun& sun) noexcept { return -sun.to_sun; }
[[nodiscard]] inline std::optional<V3f> common_direction(const World&) noexcept { return {}; }

// light from infinity: light_infinite.cpp. Directions to the light.
[[nodiscard]] std::optional<EmissionDirection> sample_towards(const Sun&, const V2f& u) noexcept;
[[nodiscard]] float pdf_towards(const Sun&, const V3f& to_light) noexcept;
// 0 for a parallel sun
[[nodiscard]] Color radiance(const Parts&, const Sun&, const V3f& to_light, bool camera_ray) noexcept;
[[nodiscard]] std::optional<EmissionDirection> sample_towards(const World&, const V2f& u) noexcept;
[[nodiscard]] float pdf_towards(const World&, const V3f& to_light) noexcept;
[[nodiscard]] Color radiance(const Parts&, const World&, const V3f& to_light, bool camera_ray) noexcept;

}  // namespace sluice::kinds
