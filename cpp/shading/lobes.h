// SPDX-License-Identifier: GPL-3.0-or-later
// The shapes a lobe can have. Every overload set works in the lobe's frame: z = shading normal on the side of
// o, o = direction to where the light goes (or, on a photon path, comes from), i = the other one, both away
// from the surface.
//   eval_shape    f·|cos θ_i| without the lobe's weight and without η² (flux convention)
//   pdf_shape     solid-angle density of sample_shape
//   sample_shape  i, with weight = eval_shape / pdf_shape; false: no such direction (a loss to the albedo)
//   albedo_shape  ∫ eval_shape over i
// Delta shapes (is_delta) have eval_shape and pdf_shape 0; their sample has the whole weight and pdf 1.
//
// Each shape says three things about itself, from which the rest follows:
//   sampling  by the cosine, so that pdf_shape, sample_shape, is_delta and angular_width need no overload; or
//             its own
//   side      on which light leaves; one that refracts has a member `eta`, far side / near side
//   response  uniform: f is the same for all pairs of directions, so the albedo knows no direction; broad or
//             peaked otherwise; a peaked one may have a tangent, which turns its frame
// A shape that forgets one of them, or an overload, does not compile (tests/python/test_closed_sets.py).
#pragma once
#include <variant>

#include "base/sampling.h"
#include "shading/fresnel.h"
#include "shading/ggx.h"

namespace sluice {

enum class Sampling { Cosine, Own };
enum class LeavesOn { NearSide, FarSide, FarSideRefracted };
enum class Response { Uniform, Broad, Peaked };

struct Lambert {
  static constexpr auto sampling = Sampling::Cosine;
  static constexpr auto side = LeavesOn::NearSide;
  static constexpr auto response = Response::Uniform;
};
struct Translucent {  // Lambert on the other side
  static constexpr auto sampling = Sampling::Cosine;
  static constexpr auto side = LeavesOn::FarSide;
  static constexpr auto response = Response::Uniform;
};
struct OrenNayar {  // Fujii's form, as Cycles' Diffuse BSDF
  static constexpr auto sampling = Sampling::Cosine;
  static constexpr auto side = LeavesOn::NearSide;
  static constexpr auto response = Response::Broad;
  float roughness;
};
struct Burley {  // Disney's diffuse, of Blender 3's Principled
  static constexpr auto sampling = Sampling::Cosine;
  static constexpr auto side = LeavesOn::NearSide;
  static constexpr auto response = Response::Broad;
  float roughness;
};
struct DisneySheen {  // Schlick's factor at the half vector, of Blender 3's Principled
  static constexpr auto sampling = Sampling::Cosine;
  static constexpr auto side = LeavesOn::NearSide;
  static constexpr auto response = Response::Broad;
};
struct Velvet {  // Ashikhmin's, of Blender 3's Velvet node
  static constexpr auto sampling = Sampling::Cosine;
  static constexpr auto side = LeavesOn::NearSide;
  static constexpr auto response = Response::Broad;
  float sigma;
};
struct Sheen {  // Estevez & Kulla's, with Neubelt's visibility, for Blender 4's Principled and Sheen node
  static constexpr auto sampling = Sampling::Cosine;
  static constexpr auto side = LeavesOn::NearSide;
  static constexpr auto response = Response::Broad;
  float roughness;
};
struct Reflection {
  static constexpr auto sampling = Sampling::Own;
  static constexpr auto side = LeavesOn::NearSide;
  static constexpr auto response = Response::Peaked;
  ggx::Alpha alpha;  // below ggx::smooth_alpha: a mirror
  V3f tangent;       // world space; read when alpha.x != alpha.y
  Fresnel fresnel;
  // reflectance of light that meets more than one microfacet; 0: it is lost, as in Cycles' "GGX"
  Color multiple{0};
  bool balanced = false;  // the reflecting half of a rough glass that keeps its energy
};
struct Refraction {
  static constexpr auto sampling = Sampling::Own;
  static constexpr auto side = LeavesOn::FarSideRefracted;
  static constexpr auto response = Response::Peaked;
  float alpha, eta;
  Fresnel fresnel;        // what this does not reflect is refracted
  bool lossless = false;  // refracts all of it (the Refraction node)
  bool balanced = false;  // the refracting half of a rough glass that keeps its energy
};
using LobeShape =
    std::variant<Lambert, Translucent, OrenNayar, Burley, DisneySheen, Velvet, Sheen, Reflection, Refraction>;

struct ShapeSample {
  V3f i;
  Color weight;
  float pdf;
};

template <class Shape>
[[nodiscard]] constexpr bool transmits(const Shape&) noexcept {
  return Shape::side != LeavesOn::NearSide;
}
// η(side of i) / η(side of o)
template <class Shape>
[[nodiscard]] constexpr float eta_of(const Shape& shape) noexcept {
  if constexpr (Shape::side == LeavesOn::FarSideRefracted)
    return shape.eta;
  else
    return 1;
}

[[nodiscard]] Color eval_shape(const Lambert&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] Color eval_shape(const Translucent&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] Color eval_shape(const OrenNayar&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] Color eval_shape(const Burley&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] Color eval_shape(const DisneySheen&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] Color eval_shape(const Velvet&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] Color eval_shape(const Sheen&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] Color eval_shape(const Reflection&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] Color eval_shape(const Refraction&, const V3f& o, const V3f& i) noexcept;

template <class Shape>
concept CosineSampled = Shape::sampling == Sampling::Cosine;

template <CosineSampled Shape>
[[nodiscard]] float pdf_shape(const Shape& shape, const V3f&, const V3f& i) noexcept {
  return std::max(0.0f, transmits(shape) ? -i.z : i.z) / pi;
}
[[nodiscard]] float pdf_shape(const Reflection&, const V3f& o, const V3f& i) noexcept;
[[nodiscard]] float pdf_shape(const Refraction&, const V3f& o, const V3f& i) noexcept;

template <CosineSampled Shape>
[[nodiscard]] bool sample_shape(const Shape& shape, const V3f& o, const V2f& u, ShapeSample& s) noexcept {
  s.i = sample_cosine(u);
  if (transmits(shape)) s.i.z = -s.i.z;
  s.pdf = pdf_shape(shape, o, s.i);
  if (!(s.pdf > 0)) return false;
  s.weight = eval_shape(shape, o, s.i) / s.pdf;
  return true;
}
[[nodiscard]] bool sample_shape(const Reflection&, const V3f& o, const V2f& u, ShapeSample&) noexcept;
[[nodiscard]] bool sample_shape(const Refraction&, const V3f& o, const V2f& u, ShapeSample&) noexcept;

[[nodiscard]] Color albedo_shape(const Lambert&, float mu) noexcept;
[[nodiscard]] Color albedo_shape(const Translucent&, float mu) noexcept;
[[nodiscard]] Color albedo_shape(const OrenNayar&, float mu) noexcept;
[[nodiscard]] Color albedo_shape(const Burley&, float mu) noexcept;
[[nodiscard]] Color albedo_shape(const DisneySheen&, float mu) noexcept;
[[nodiscard]] Color albedo_shape(const Velvet&, float mu) noexcept;
[[nodiscard]] Color albedo_shape(const Sheen&, float mu) noexcept;
[[nodiscard]] Color albedo_shape(const Reflection&, float mu) noexcept;
[[nodiscard]] Color albedo_shape(const Refraction&, float mu) noexcept;

template <CosineSampled Shape>
[[nodiscard]] constexpr bool is_delta(const Shape&) noexcept {
  return false;
}
[[nodiscard]] inline bool is_delta(const Reflection& r) noexcept {
  return std::max(r.alpha.x, r.alpha.y) < ggx::smooth_alpha;
}
// one index on both sides
[[nodiscard]] inline bool bends_nothing(float eta) noexcept { return std::abs(eta - 1) < 1e-3f; }
[[nodiscard]] inline bool is_delta(const Refraction& r) noexcept {
  return r.alpha < ggx::smooth_alpha || bends_nothing(r.eta);
}

// An angle (rad) over which f changes little; infinite where it does not change at all.
template <CosineSampled Shape>
[[nodiscard]] constexpr float angular_width(const Shape&) noexcept {
  return Shape::response == Response::Uniform ? infinity : 1.0f;
}
[[nodiscard]] inline float angular_width(const Reflection& r) noexcept {
  return std::min({1.0f, r.alpha.x, r.alpha.y});
}
[[nodiscard]] inline float angular_width(const Refraction& r) noexcept { return std::min(1.0f, r.alpha); }

// Reflectance for Reflection::multiple: Kulla & Conty's series of bounces between microfacets (2017, eq. 18
// and appendix).
[[nodiscard]] Color multiple_reflectance(const Fresnel&, ggx::Alpha) noexcept;

}  // namespace sluice
