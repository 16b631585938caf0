// SPDX-License-Identifier: GPL-3.0-or-later
// The scattering of light at one point seen from one direction: a short list of lobes, each with its event
// (design §3). Directions are unit, in world space, and point away from the surface. Knows no textures, no
// scene. eval, pdf, sample and albedo are those of the whole list, functions named …_lobe those of one of its
// lobes, and functions named …_shape (lobes.h) those of a lobe's shape in its own frame. A new lobe is an
// alternative of LobeShape with what lobes.h asks of it, and a row in the chi² list; a forgotten overload
// does not compile.
#pragma once
#include <array>
#include <optional>

#include "base/event.h"
#include "shading/lobes.h"

namespace sluice {

inline constexpr int max_lobes = 8;

// Hardly any default values: a Bsdf on the stack should cost next to nothing.
struct Lobe {
  // D, S (delta, whatever its roughness, or Blender roughness <= specular_threshold) or G
  Event event;
  bool delta = false;      // one direction only: eval() and pdf() leave it out
  bool transmits = false;  // as its shape says: light leaves on the far side
  // bit i: light passes Bsdf::layers[i] on its way here (photons only; on view paths it is folded into
  // weight)
  std::uint8_t under;
  float choice;  // average of `albedo`: what picks this lobe
  Color weight;
  Color albedo;  // directional albedo seen from wo, weight included
  V3f n;         // its shading normal, on the side of wo
  LobeShape shape;
};

// A coating that dims what lies under it by what it reflects towards the eye and by its tint (Cycles'
// layering).
struct Layer {
  LobeShape shape;
  V3f n;
  Color weight, tint;
  float eta;  // of the tinted coat
};
inline constexpr int max_layers = 3;

struct Bsdf {
  std::array<Lobe, max_lobes> lobes;  // [0, count)
  std::array<Layer, max_layers> layers;
  int count = 0;
  bool photon = false;  // shaded for a light path: the eye is on the side of wi
  Color emission{0};
  Color transparency{0};  // weight of what goes straight through: no event (design §3)
  // geometric normal, on the side of wo: decides what is reflection and what transmission
  V3f ng{0, 0, 1};

  [[nodiscard]] EventMask events() const noexcept;
  [[nodiscard]] bool is_exact() const noexcept;  // all lobes are delta ones: a mirror, glass
};

// wi: unit. weight = f·|cos θ_i| / pdf of the lobes that share the chosen lobe's event, in the flux
// convention: no η². Multiply by 1 / eta² on a view path (light flows wi -> wo, radiance scales by
// (η_wo/η_wi)²). Delta: weight of the lobe / its probability.
struct BsdfSample {
  V3f wi;
  Color weight;
  float pdf;  // what pdf() says of wi with the same mask; of a delta lobe the probability of its choice
  Event event;
  int lobe;  // index into Bsdf::lobes
  bool delta;
  float eta;  // η(side of wi) / η(side of wo); 1 for reflection
};

// Σ over non-delta lobes of the mask of f(wi -> wo)·|cos θ_i| (θ_i to the lobe's shading normal), radiance
// convention: refraction carries (η_wo/η_wi)². wi on the side that ng says is the other one meets
// transmitting lobes only.
[[nodiscard]] Color eval(const Bsdf& bsdf, const V3f& wo, const V3f& wi, EventMask mask) noexcept;

// Solid-angle density with which sample() with that mask makes wi, non-delta lobes only.
[[nodiscard]] float pdf(const Bsdf& bsdf, const V3f& wo, const V3f& wi, EventMask mask) noexcept;

// Picks one lobe of the mask by its albedo. Empty: no lobe in the mask, or a direction that the surface
// hides.
[[nodiscard]] std::optional<BsdfSample> sample(const Bsdf& bsdf, const V3f& wo, float u_lobe, const V2f& u,
                                               EventMask mask) noexcept;

// That lobe alone with probability 1: weight and pdf are its own.
[[nodiscard]] std::optional<BsdfSample> sample_lobe(const Bsdf& bsdf, int lobe, const V3f& wo,
                                                    const V2f& u) noexcept;

// Directional albedo: exact for smooth and Lambertian lobes, from tables for rough ones (stated in energy.h).
[[nodiscard]] Color albedo(const Bsdf& bsdf, const V3f& wo, EventMask mask) noexcept;

// Veach's factor for flux at a shading normal, |wo·n||wi·ng| / (|wo·ng||wi·n|); unclamped, 0 if it is not
// finite. Numerics R11: clamp to 4, count.
[[nodiscard]] float adjoint_factor(const Bsdf& bsdf, int lobe, const V3f& wo, const V3f& wi) noexcept;

// What a coating lets through to the eye in direction w: 1 minus its albedo's largest channel, times its tint
// along the slanted way.
[[nodiscard]] Color layer_transmission(const Layer& layer, const V3f& w) noexcept;

// Adds a lobe (a black one is left out; into a full list it replaces the weakest if that is weaker) and
// computes its albedo. `event` is that of its roughness: a lobe of one direction is S.
void add_lobe(Bsdf& bsdf, Event event, const Color& weight, const V3f& n, const LobeShape& shape,
              const V3f& wo, std::uint8_t under = 0) noexcept;

}  // namespace sluice
