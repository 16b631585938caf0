// SPDX-License-Identifier: GPL-3.0-or-later
// Lights as a closed set: kinds are structs in a variant, every question is one free function. Lights are
// named by their index in Scene::lights(). Radiometry is Cycles' (W, W/m² for suns). Positions are
// re-centred; directions unit. Nothing here tests visibility. Each kind says whether it is infinite (its
// light comes from outside of the scene, by direction alone) and whether it is crossable (a ray can meet it
// though it is no surface). To add a kind: a struct, an alternative, the overloads of light_kinds.h, which
// lists them; a missing one does not compile (tests/python/test_closed_sets.py).
#pragma once
#include <optional>
#include <span>
#include <variant>

#include "base/colour.h"
#include "base/sampling.h"
#include "scene/description.h"
#include "scene/facings.h"
#include "scene/ray.h"

namespace sluice {

class Scene;

// Point and spot: a sphere, or a true point when radius is 0. Radiance (intensity, W/sr, for a true point)
// times the spot's falloff.
struct SphereLamp {
  static constexpr bool infinite = false, crossable = true;
  V3d centre;
  float radius;
  Color radiance;  // of the sphere, or intensity of the point
  bool spot = false;
  V3f axis{0, 0, -1};  // the spot looks along it
  float cos_half = -1, blend = 0;
  bool times_cosine = true;
};
// A disc of light at infinity, or one direction when tan_half is 0. As in Cycles 3.4 the disc lies in the
// plane that touches the unit sphere, of radius tan_half = tan(angle / 2), uniform per area: radiance =
// irradiance / (pi tan_half² cos³) towards the sun.
struct Sun {
  static constexpr bool infinite = true, crossable = false;
  V3f to_sun;
  float tan_half;
  Color irradiance;  // W/m², on a plane facing the sun (of a disc: nearly)
};
// A rectangle or an ellipse that emits on the side of `normal`, uniformly or within a spread.
struct AreaLamp {
  static constexpr bool infinite = false, crossable = true;
  V3d centre;
  V3f axis_u, axis_v, normal;  // unit; u × v is ± the normal
  float half_u, half_v, area;
  bool round = false;
  Color radiance;                          // before the spread's factor
  float spread_half = pi / 2;              // half angle
  float spread_cot = 0, spread_scale = 1;  // factor: scale · (1 - cot · tan(angle to the normal))
};
// An instance whose material emits, both sides. Photons choose triangles by area × average emission, points
// that ask also by how they face them.
struct MeshLight {
  static constexpr bool infinite = false, crossable = false;
  std::uint32_t instance;
  Distribution triangles;                  // those that emit, in the order of their facings
  std::vector<std::uint32_t> triangle_of;  // index in the mesh of each entry of the distribution
  std::vector<float> pmf_per_area;         // by triangle of the mesh; 0 = does not emit
  Facings facings;
};
// Light from infinity by the world's program; importance by a table of texels, each with a floor, so no lit
// direction has density 0.
struct World {
  static constexpr bool infinite = true, crossable = false;
  bool constant = true;
  Color radiance{0};  // constant
  int width = 0, height = 0;
  Distribution rows;
  std::vector<Distribution> columns;
  Color mean_radiance{0};  // over the sphere
};

struct Light {
  std::variant<SphereLamp, Sun, AreaLamp, MeshLight, World> kind;
  int entity = -1;
  bool casts_shadow = true;  // false: lights through everything
  bool visible_to_camera = false;
  float power = 0;  // W, of finite lights
  // bounds for choose_light: all of it within `reach` of `middle` (finite lights); intensity (W/sr) or
  // irradiance (W/m², infinite)
  V3d middle{0};
  float reach = 0, strength = 0;
};

[[nodiscard]] bool is_infinite(const Light& light) noexcept;  // sun, world
// true point, parallel sun: only sample_direct finds it
[[nodiscard]] bool is_delta(const Light& light) noexcept;

// The direction that all of its light travels in, if there is one (a sun's, whatever the width of its disc).
[[nodiscard]] std::optional<V3f> common_direction(const Light& light) noexcept;

// ---- light seen from a point

// A direction from a point to a light. Unshadowed: times Scene::transmittance of a ray of length `distance`,
// unless the light casts none.
struct DirectSample {
  V3f wi;
  // of the shadow ray: to the light, a little less so that it does not shadow itself; infinite for sun and
  // world
  double distance;
  // towards the point; delta lights: intensity / distance², or irradiance on a plane facing it
  Color radiance;
  float pdf;  // per solid angle; 1 for delta lights
  bool delta;
  // to the light, exactly: gates on the way there take the light, one laid on the light itself too
  double reach;
};
[[nodiscard]] std::optional<DirectSample> sample_direct(const Scene& scene, int light, const V3d& from,
                                                        float u_part, const V2f& u) noexcept;
// Density with which sample_direct makes wi. `hit`: the surface the ray met when the light is a mesh (null
// otherwise).
[[nodiscard]] float pdf_direct(const Scene& scene, int light, const V3d& from, const V3f& wi,
                               const Hit* hit) noexcept;
// Where the light is sampled by its area and lies so near that one sample stands for more than a hemisphere
// of directions: there weights of next-event estimation have no bound. `pdf`: what pdf_direct() or
// sample_direct() says there.
[[nodiscard]] bool is_too_near(const Light& light, float pdf) noexcept;
// Radiance of a sun (discs only) or the world along a ray that meets nothing. A mesh light's is its
// material's emission.
[[nodiscard]] Color eval_infinite(const Scene& scene, int light, const V3f& direction,
                                  bool camera_ray) noexcept;

// Lamps with a shape (area, point and spot with a radius) on a ray. They block nothing; a path collects them
// as it passes.
struct LampHit {
  int light;
  double t;
  Color radiance;
};
[[nodiscard]] std::size_t max_lamp_hits(const Scene& scene) noexcept;  // of one ray
// Writes the lamps on [0, t_max] in front of the ray, at most found.size() of them, in no order; returns how
// many. A camera ray sees only those whose description says so.
[[nodiscard]] int intersect_lamps(const Scene& scene, const Ray& ray, std::span<LampHit> found) noexcept;

// ---- choice of one light for a point

struct LightChoice {
  int light;
  float pmf, u;  // u: the random number, stretched to [0, 1) again
};
inline constexpr std::size_t few_lights = 16;
// How much of what each of a few lights can do it really does; none: all of it.
using LightTrust = std::span<const float>;

// By a bound on what each light can do there: of few lights times its trust, of many down a tree of them.
// normal 0: light from both sides counts. No light that is trusted and reaches the point has pmf 0. Empty: no
// light can.
[[nodiscard]] std::optional<LightChoice> choose_light(const Scene& scene, const V3d& point, const V3f& normal,
                                                      float u, LightTrust trust = {}) noexcept;
[[nodiscard]] float choice_pmf(const Scene& scene, const V3d& point, const V3f& normal, int light,
                               LightTrust trust = {}) noexcept;
// That bound, an irradiance (W/m²).
[[nodiscard]] float importance(const Light& light, const V3d& point, const V3f& normal) noexcept;

// ---- light that leaves (photons). Finite lights: position, then direction. Flux of a photon = eval_emission
// / (pdf_area · pdf).

struct EmissionPoint {
  V3d position;
  V3f normal;                                // of the emitting surface; a true point: 0
  V3f clearance;                             // for Ray::clearance
  float pdf_area;                            // 1/m²; 1 for a true point
  std::uint32_t instance = 0, triangle = 0;  // mesh lights
  float u = 0, v = 0;
};
[[nodiscard]] std::optional<EmissionPoint> sample_position(const Scene& scene, int light, float u_part,
                                                           const V2f& u) noexcept;

struct EmissionDirection {
  V3f direction;  // the way the light travels
  float pdf;      // per solid angle; parallel sun: 1
};
// Directions from a point of a finite light, about as eval_emission.
[[nodiscard]] std::optional<EmissionDirection> sample_direction(const Scene& scene, int light,
                                                                const EmissionPoint& point, float u_part,
                                                                const V2f& u) noexcept;
[[nodiscard]] float pdf_direction(const Scene& scene, int light, const EmissionPoint& point,
                                  const V3f& direction) noexcept;
// Radiance × |cos| leaving the point (W/m²/sr); a true point: intensity (W/sr).
[[nodiscard]] Color eval_emission(const Scene& scene, int light, const EmissionPoint& point,
                                  const V3f& direction) noexcept;

// Light from infinity: the direction it travels; the caller chooses the disk it starts from. Flux =
// eval_infinite_emission / (pdf · density on the disk).
[[nodiscard]] std::optional<EmissionDirection> sample_infinite(const Scene& scene, int light,
                                                               const V2f& u) noexcept;
// Radiance travelling along `direction`; a parallel sun: its irradiance (ask with the sampled direction
// only).
[[nodiscard]] Color eval_infinite_emission(const Scene& scene, int light, const V3f& direction) noexcept;

}  // namespace sluice
