// SPDX-License-Identifier: GPL-3.0-or-later
// A path's vertex: where it is and how light scatters there. Shared by light paths and view paths.
#pragma once
#include "scene/scene.h"
#include "shading/material.h"

namespace sluice {

struct Vertex {
  Hit hit;
  SurfacePoint point;
  Bsdf bsdf;
  // that a path passes straight through what is transparent here (alpha; no event, design §3)
  float pass_chance = 0;
};

[[nodiscard]] inline float average(const Color& c) noexcept { return (c.x + c.y + c.z) * (1.0f / 3); }

// 1 if there is nothing but what is transparent; decided on averages, never on one colour channel.
[[nodiscard]] inline float chance_to_pass(const Bsdf& bsdf) noexcept {
  if (bsdf.count == 0 && is_black(bsdf.emission)) return is_black(bsdf.transparency) ? 0.0f : 1.0f;
  return std::clamp(average(bsdf.transparency), 0.0f, 0.95f);
}

// Which way flux flows: light paths carry it from wo to wi, view paths look against it.
enum class Carries : std::uint8_t { Flux, Radiance };

inline void make_vertex(const Scene& scene, const Hit& hit, const V3f& wo, bool camera_ray, Carries carries,
                        Vertex& vertex) noexcept {
  vertex.hit = hit;
  scene.surface_point(hit, wo, camera_ray, vertex.point);
  vertex.point.photon = carries == Carries::Flux;
  shade(scene.material(hit), vertex.point, vertex.bsdf);
  vertex.pass_chance = chance_to_pass(vertex.bsdf);
}

// The side from which light can matter at the vertex, for the choice of lights: ng, or 0 where some lobe lets
// light through.
[[nodiscard]] inline V3f lit_side(const Bsdf& bsdf) noexcept {
  for (int i = 0; i < bsdf.count; ++i)
    if (!bsdf.lobes[i].delta && bsdf.lobes[i].transmits) return V3f(0);
  return bsdf.ng;
}

// The kinds of lobes, and the side, that a surface may show to one who sees it from elsewhere on this side.
[[nodiscard]] inline EventMask events_to_all(const Material& material, const Bsdf& bsdf) noexcept {
  return material.sees_direction() ? material.lobe_events() : bsdf.events();
}
[[nodiscard]] inline V3f side_lit_to_all(const Material& material, const Bsdf& bsdf) noexcept {
  if (!material.sees_direction()) return lit_side(bsdf);
  return material.transmits() ? V3f(0) : bsdf.ng;
}

template <class Do>
void for_each_event(EventMask events, Do&& act) {
  for (const Event e : {Event::D, Event::G, Event::S})
    if (events & mask_of(e)) act(e);
}

}  // namespace sluice
