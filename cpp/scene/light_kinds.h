// SPDX-License-Identifier: GPL-3.0-or-later
// The overloads behind light.h, one file per kind; each answers for its own struct as light.h's function of
// that name does. Private to this folder. Finite kinds: SphereLamp, AreaLamp, MeshLight; infinite ones: Sun,
// World.
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

// choice of lights: light_choice.cpp, light_tree_build.cpp. Can none of a finite light's light come this way?
// Slack on the side of "it can".
[[nodiscard]] bool is_dark(const SphereLamp&, const V3d& from_middle) noexcept;
[[nodiscard]] bool is_dark(const AreaLamp&, const V3d& from_middle) noexcept;
[[nodiscard]] bool is_dark(const MeshLight&, const V3d& from_middle) noexcept;
// A bound on the irradiance of an infinite light of that strength on a surface.
[[nodiscard]] float irradiance_bound(const Sun&, float strength, const V3f& normal) noexcept;
[[nodiscard]] float irradiance_bound(const World&, float strength, const V3f& normal) noexcept;

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
