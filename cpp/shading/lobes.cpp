// SPDX-License-Identifier: GPL-3.0-or-later
// Diffuse-like shapes; the microfacet ones are in microfacet.cpp.
#include "shading/lobes.h"

namespace sluice {
namespace {

[[nodiscard]] float schlick(float c) noexcept {
  const float m = std::clamp(1 - c, 0.0f, 1.0f);
  return m * m * m * m * m;
}

// Albedos of shapes without a closed form: stratified cosine samples, as the albedo only steers choices and the Albedo pass.
template <class Shape>
[[nodiscard]] float sampled_albedo(const Shape& shape, float mu) noexcept {
  constexpr int side = 4;
  const V3f o(std::sqrt(std::max(0.0f, 1 - mu * mu)), 0, mu);
  float sum = 0;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y) {
      const V3f i = sample_cosine({(static_cast<float>(x) + 0.5f) / side, (static_cast<float>(y) + 0.5f) / side});
      sum += eval_shape(shape, o, i).x * pi / i.z;
    }
  return sum / (side * side);
}

}  // namespace

Color eval_shape(const Lambert&, const V3f&, const V3f& i) noexcept { return Color(std::max(0.0f, i.z) / pi); }
Color eval_shape(const Translucent&, const V3f&, const V3f& i) noexcept { return Color(std::max(0.0f, -i.z) / pi); }

// Fujii's "tiny improvement of Oren-Nayar", with Cycles' normalisation: f = a + b·t.
Color eval_shape(const OrenNayar& s, const V3f& o, const V3f& i) noexcept {
  if (i.z <= 0 || o.z <= 0) return Color(0);
  const float a = 1 / (pi + (3 * pi - 4) / 6 * s.roughness), b = s.roughness * a;
  float t = o.dot(i) - o.z * i.z;
  if (t > 0) t /= std::max(o.z, i.z);
  return Color(i.z * (a + b * t));
}

// Burley 2012: Lambert dimmed at grazing on both sides, plus retro-reflection.
Color eval_shape(const Burley& s, const V3f& o, const V3f& i) noexcept {
  if (i.z <= 0 || o.z <= 0) return Color(0);
  const float fo = schlick(o.z), fi = schlick(i.z), rr = s.roughness * (o.dot(i) + 1);
  return Color(i.z / pi * ((1 - 0.5f * fo) * (1 - 0.5f * fi) + rr * (fi + fo + fi * fo * (rr - 1))));
}

Color eval_shape(const DisneySheen&, const V3f& o, const V3f& i) noexcept {
  if (i.z <= 0 || o.z <= 0) return Color(0);
  const V3f h = o + i;
  const float length = h.length();
  return length > 0 ? Color(i.z * schlick(i.dot(h) / length)) : Color(0);
}

// Estevez & Kulla 2017 ("Charlie"): D = (2 + 1/r) sin^(1/r) θ_h / 2π; V = 1 / (4 (cos_o + cos_i - cos_o cos_i)), Neubelt 2013.
Color eval_shape(const Velvet& s, const V3f& o, const V3f& i) noexcept {
  if (i.z <= 0 || o.z <= 0) return Color(0);
  const V3f h = (o + i).normalized();
  const float inverse = 1 / std::clamp(s.roughness * s.roughness, 1e-2f, 1.0f), sine2 = std::max(0.0f, 1 - h.z * h.z);
  const float d = (2 + inverse) * std::pow(sine2, 0.5f * inverse) / (2 * pi);
  return Color(i.z * d / (4 * (o.z + i.z - o.z * i.z)));
}

Color albedo_shape(const Lambert&, float) noexcept { return Color(1); }
Color albedo_shape(const Translucent&, float) noexcept { return Color(1); }
Color albedo_shape(const OrenNayar& s, float mu) noexcept { return Color(sampled_albedo(s, mu)); }
Color albedo_shape(const Burley& s, float mu) noexcept { return Color(sampled_albedo(s, mu)); }
Color albedo_shape(const DisneySheen& s, float mu) noexcept { return Color(sampled_albedo(s, mu)); }
Color albedo_shape(const Velvet& s, float mu) noexcept { return Color(sampled_albedo(s, mu)); }

}  // namespace sluice
