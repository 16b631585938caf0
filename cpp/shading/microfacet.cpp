// SPDX-License-Identifier: GPL-3.0-or-later
// GGX reflection and refraction (Walter et al. 2007), sampled by visible normals (Heitz 2018), and their
// smooth limits.
#include "shading/energy.h"
#include "shading/lobes.h"

namespace sluice {
namespace {

[[nodiscard]] float roughness_of(ggx::Alpha a) noexcept { return std::sqrt(std::sqrt(a.x * a.y)); }

// What sampling a visible normal h leaves as weight: Fresnel, shadowing and returned energy.
[[nodiscard]] Color reflection_weight(const Reflection& s, const V3f& o, const V3f& i, float c) noexcept {
  const float g = ggx::shadowing_ratio(o, i, s.alpha), roughness = roughness_of(s.alpha);
  const Color f = eval_fresnel(s.fresnel, c);
  if (s.balanced) {
    const float eta = s.fresnel.eta;
    return f * (g * energy::dielectric(o.z, roughness, eta).balance *
                energy::dielectric(i.z, roughness, eta).balance);
  }
  if (is_black(s.multiple)) return f * g;
  const float more =
      energy::reflecting_balance(o.z, roughness) * energy::reflecting_balance(i.z, roughness) - 1;
  return (f + s.multiple * more) * g;
}

[[nodiscard]] Color refraction_weight(const Refraction& s, const V3f& o, const V3f& i, float c) noexcept {
  float g = ggx::shadowing_ratio(o, i, {s.alpha, s.alpha});
  if (s.balanced) {
    const float roughness = std::sqrt(s.alpha);
    g *= energy::dielectric(o.z, roughness, s.eta).transmitted_balance *
         energy::dielectric(-i.z, roughness, 1 / s.eta).transmitted_balance;
  }
  return s.lossless ? Color(g) : (Color(1) - eval_fresnel(s.fresnel, c)) * g;
}

// Share of a balanced glass that is reflected. From the thin side both halves are raised alike; from the
// dense side the refracted half is what the thin side's factor makes of it, about the mean of that factor.
[[nodiscard]] float balanced_reflectance(const energy::Dielectric& d, float mu, float roughness,
                                         float eta) noexcept {
  if (eta >= 1) return d.reflected / std::max(d.reflected + d.transmitted, 0.05f);
  return std::clamp(1 - d.transmitted * energy::dielectric(mu, roughness, 1 / eta).transmitted_balance, 0.0f,
                    1.0f);
}

// Half vector of a refraction, on the side of o; false where i cannot come from it.
[[nodiscard]] bool refraction_half(const V3f& o, const V3f& i, float eta, V3f& h) noexcept {
  h = o + i * eta;
  const float length = h.length();
  if (!(length > 0)) return false;
  h *= (h.z < 0 ? -1 : 1) / length;
  return o.dot(h) > 0 && i.dot(h) < 0;
}

[[nodiscard]] float refraction_density(const Refraction& s, const V3f& o, const V3f& i,
                                       const V3f& h) noexcept {
  const float oh = o.dot(h), ih = i.dot(h), sum = oh + s.eta * ih;
  // Walter, eq. 17
  return ggx::visible_density(o, h, {s.alpha, s.alpha}) * s.eta * s.eta * -ih / (sum * sum);
}

}  // namespace

Color eval_shape(const Reflection& s, const V3f& o, const V3f& i) noexcept {
  if (is_delta(s) || o.z <= 0 || i.z <= 0) return Color(0);
  const V3f h = (o + i).normalized();
  const float c = o.dot(h);
  if (!(c > 0)) return Color(0);
  return reflection_weight(s, o, i, c) * (ggx::visible_density(o, h, s.alpha) / (4 * c));
}

float pdf_shape(const Reflection& s, const V3f& o, const V3f& i) noexcept {
  if (is_delta(s) || o.z <= 0 || i.z <= 0) return 0;
  const V3f h = (o + i).normalized();
  const float c = o.dot(h);
  return c > 0 ? ggx::visible_density(o, h, s.alpha) / (4 * c) : 0;
}

bool sample_shape(const Reflection& s, const V3f& o, const V2f& u, ShapeSample& out) noexcept {
  if (o.z <= 0) return false;
  if (is_delta(s)) {
    out = {V3f(-o.x, -o.y, o.z), eval_fresnel(s.fresnel, o.z), 1};
    return true;
  }
  const V3f h = ggx::sample_visible(o, s.alpha, u);
  const float c = o.dot(h);
  out.i = ggx::reflect(o, h);
  if (!(out.i.z > 0 && c > 0)) return false;
  out.pdf = ggx::visible_density(o, h, s.alpha) / (4 * c);
  out.weight = reflection_weight(s, o, out.i, c);
  return out.pdf > 0;
}

Color albedo_shape(const Reflection& s, float mu) noexcept {
  if (is_delta(s)) return eval_fresnel(s.fresnel, mu);
  const float roughness = roughness_of(s.alpha);
  const energy::Reflecting e = energy::reflecting(mu, roughness);
  Color single = s.fresnel.f0 * e.total;
  if (s.fresnel.kind == Fresnel::Kind::Dielectric || s.fresnel.kind == Fresnel::Kind::Tinted) {
    const energy::Dielectric d = energy::dielectric(mu, roughness, s.fresnel.eta);
    const float f0 = f0_of_ior(s.fresnel.eta),
                rise = std::clamp((d.reflected - f0 * e.total) / (1 - f0), 0.0f, e.total);
    single = s.fresnel.kind == Fresnel::Kind::Tinted ? s.fresnel.f0 * (e.total - rise) + Color(rise)
                                                     : Color(d.reflected);
    if (s.balanced)
      return single * (balanced_reflectance(d, mu, roughness, s.fresnel.eta) / std::max(d.reflected, 1e-4f));
  } else if (s.fresnel.kind == Fresnel::Kind::Metal) {
    single = s.fresnel.f0 * (e.total - e.schlick) + Color(e.schlick) - s.fresnel.b * e.edge;
  }
  return single + s.multiple * std::max(0.0f, 1 - e.total);
}

Color multiple_reflectance(const Fresnel& fresnel, ggx::Alpha alpha) noexcept {
  const Color f = mean_fresnel(fresnel);
  const float e = energy::mean_reflecting(roughness_of(alpha));
  return f * f * e / (Color(1) - f * (1 - e));
}

Color eval_shape(const Refraction& s, const V3f& o, const V3f& i) noexcept {
  V3f h;
  if (is_delta(s) || o.z <= 0 || i.z >= 0 || !refraction_half(o, i, s.eta, h)) return Color(0);
  return refraction_weight(s, o, i, o.dot(h)) * refraction_density(s, o, i, h);
}

float pdf_shape(const Refraction& s, const V3f& o, const V3f& i) noexcept {
  V3f h;
  if (is_delta(s) || o.z <= 0 || i.z >= 0 || !refraction_half(o, i, s.eta, h)) return 0;
  return refraction_density(s, o, i, h);
}

bool sample_shape(const Refraction& s, const V3f& o, const V2f& u, ShapeSample& out) noexcept {
  if (o.z <= 0) return false;
  if (is_delta(s)) {
    if (bends_nothing(s.eta))
      out.i = -o;
    else if (!ggx::refract(o, V3f(0, 0, 1), s.eta, out.i))
      return false;
    out.weight = s.lossless ? Color(1) : Color(1) - eval_fresnel(s.fresnel, o.z);
    out.pdf = 1;
    return true;
  }
  const ggx::Alpha alpha{s.alpha, s.alpha};
  const V3f h = ggx::sample_visible(o, alpha, u);
  if (!(o.dot(h) > 0) || !ggx::refract(o, h, s.eta, out.i) || !(out.i.z < 0)) return false;
  out.pdf = refraction_density(s, o, out.i, h);
  out.weight = refraction_weight(s, o, out.i, o.dot(h));
  return out.pdf > 0 && std::isfinite(out.pdf);
}

Color albedo_shape(const Refraction& s, float mu) noexcept {
  const bool straight = bends_nothing(s.eta);
  if (is_delta(s)) {
    V3f i;
    const V3f o(std::sqrt(std::max(0.0f, 1 - mu * mu)), 0, mu);
    if (!straight && !ggx::refract(o, V3f(0, 0, 1), s.eta, i)) return Color(0);
    return s.lossless ? Color(1) : Color(1) - eval_fresnel(s.fresnel, mu);
  }
  const energy::Dielectric d = energy::dielectric(mu, std::sqrt(s.alpha), s.eta);
  float t = d.transmitted;
  if (s.balanced) t = 1 - balanced_reflectance(d, mu, std::sqrt(s.alpha), s.eta);
  t = std::max(t, 1e-3f);  // never 0 where a tilted facet could transmit: a lobe of no albedo is never chosen
  const float f0 = f0_of_ior(s.eta);
  if (s.lossless) return Color(std::min(1.0f, t / std::max(0.05f, 1 - fresnel_dielectric(mu, s.eta))));
  return s.fresnel.kind == Fresnel::Kind::Tinted ? (Color(1) - s.fresnel.f0) * (t / (1 - f0)) : Color(t);
}

}  // namespace sluice
