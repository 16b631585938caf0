// SPDX-License-Identifier: GPL-3.0-or-later
// Diffuse-like shapes; the microfacet ones are in microfacet.cpp.
#include "shading/lobes.h"

#include <array>

#include "base/random.h"

namespace sluice {
namespace {

[[nodiscard]] float schlick(float c) noexcept {
  const float m = std::clamp(1 - c, 0.0f, 1.0f);
  return m * m * m * m * m;
}

// Albedo of a shape without a closed form, over roughness and sqrt(mu), from cosine-weighted samples; made on
// first use.
template <class Shape>
struct AlbedoTable {
  static constexpr int roughness_nodes = 11, mu_nodes = 24, samples = 1024;
  std::array<std::array<float, mu_nodes>, roughness_nodes> nodes;

  template <class Make>
  explicit AlbedoTable(Make&& make) {
    for (int r = 0; r < roughness_nodes; ++r)
      for (int m = 0; m < mu_nodes; ++m) {
        const Shape shape = make(static_cast<float>(r) / (roughness_nodes - 1));
        const float mu = std::max(1e-4f, square(static_cast<float>(m) / (mu_nodes - 1)));
        const V3f o(std::sqrt(std::max(0.0f, 1 - mu * mu)), 0, mu);
        float sum = 0;
        for (std::uint32_t k = 0; k < samples; ++k) {
          const V3f i = sample_cosine(Sampler(13, k).pair(0));
          if (i.z > 0) sum += eval_shape(shape, o, i).x * pi / i.z;
        }
        nodes[static_cast<std::size_t>(r)][static_cast<std::size_t>(m)] = sum / samples;
      }
  }
  [[nodiscard]] Color read(float roughness, float mu) const noexcept {
    const float x = std::clamp(roughness, 0.0f, 1.0f) * (roughness_nodes - 1),
                y = std::sqrt(std::clamp(mu, 0.0f, 1.0f)) * (mu_nodes - 1);
    const auto r = std::min(static_cast<std::size_t>(x), std::size_t{roughness_nodes - 2}),
               m = std::min(static_cast<std::size_t>(y), std::size_t{mu_nodes - 2});
    const float f = x - static_cast<float>(r), g = y - static_cast<float>(m);
    return Color((nodes[r][m] * (1 - g) + nodes[r][m + 1] * g) * (1 - f) +
                 (nodes[r + 1][m] * (1 - g) + nodes[r + 1][m + 1] * g) * f);
  }
};

}  // namespace

Color eval_shape(const Lambert&, const V3f&, const V3f& i) noexcept {
  return Color(std::max(0.0f, i.z) / pi);
}
Color eval_shape(const Translucent&, const V3f&, const V3f& i) noexcept {
  return Color(std::max(0.0f, -i.z) / pi);
}

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

// Ashikhmin 2000 with a cosine-cut Gaussian of slopes, normalised as in Cycles: f·cos_i = D G / (4 cos_o).
Color eval_shape(const Velvet& s, const V3f& o, const V3f& i) noexcept {
  if (i.z <= 0 || o.z <= 0) return Color(0);
  const V3f h = (o + i).normalized();
  const float oh = std::abs(o.dot(h)), cosine2 = h.z * h.z, sine2 = 1 - cosine2;
  if (!(sine2 > 2e-5f && oh > 1e-5f)) return Color(0);
  const float inverse = 1 / square(std::max(s.sigma, 0.01f)), ratio = 2 * std::max(h.z / oh, 1e-5f);
  const float d = std::exp(-cosine2 / sine2 * inverse) * inverse / (pi * sine2 * sine2),
              g = std::min(1.0f, ratio * std::min(o.z, i.z));
  return Color(0.25f * d * g / o.z);
}

// Estevez & Kulla 2017 ("Charlie"): D = (2 + 1/r) sin^(1/r) θ_h / 2π; V = 1 / (4 (cos_o + cos_i - cos_o
// cos_i)), Neubelt 2013. Cycles' own sheen (Zeltner et al. 2022) is a table; width and height here are set,
// per tenth of roughness, to give its albedos (5.2 measured).
Color eval_shape(const Sheen& s, const V3f& o, const V3f& i) noexcept {
  if (i.z <= 0 || o.z <= 0) return Color(0);
  constexpr float widths[] = {0.1f, 0.1f, 0.1f, 0.2f, 0.3f, 0.4f, 0.55f, 0.7f, 1, 1, 1};
  constexpr float heights[] = {0.126f, 0.158f, 0.617f, 0.494f, 0.641f, 0.836f,
                               0.983f, 1.171f, 1.295f, 1.595f, 1.877f};
  const float x = std::clamp(s.roughness, 0.0f, 1.0f) * 10;
  const auto low = std::min(static_cast<std::size_t>(x), std::size_t{9});
  const float f = x - static_cast<float>(low), width = widths[low] + (widths[low + 1] - widths[low]) * f,
              height = heights[low] + (heights[low + 1] - heights[low]) * f;
  const V3f h = (o + i).normalized();
  const float inverse = 1 / square(width), sine2 = std::max(0.0f, 1 - h.z * h.z);
  const float d = (2 + inverse) * std::pow(sine2, 0.5f * inverse) / (2 * pi);
  return Color(height * i.z * d / (4 * (o.z + i.z - o.z * i.z)));
}

Color albedo_shape(const Lambert&, float) noexcept { return Color(1); }
Color albedo_shape(const Translucent&, float) noexcept { return Color(1); }
Color albedo_shape(const OrenNayar& s, float mu) noexcept {
  static const AlbedoTable<OrenNayar> table([](float roughness) { return OrenNayar{roughness}; });
  return table.read(s.roughness, mu);
}
Color albedo_shape(const Burley& s, float mu) noexcept {
  static const AlbedoTable<Burley> table([](float roughness) { return Burley{roughness}; });
  return table.read(s.roughness, mu);
}
Color albedo_shape(const DisneySheen&, float mu) noexcept {
  static const AlbedoTable<DisneySheen> table([](float) { return DisneySheen{}; });
  return table.read(0, mu);
}
Color albedo_shape(const Velvet& s, float mu) noexcept {
  static const AlbedoTable<Velvet> table([](float sigma) { return Velvet{sigma}; });
  return table.read(s.sigma, mu);
}
Color albedo_shape(const Sheen& s, float mu) noexcept {
  static const AlbedoTable<Sheen> table([](float roughness) { return Sheen{roughness}; });
  return table.read(s.roughness, mu);
}

}  // namespace sluice
