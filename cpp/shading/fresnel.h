// SPDX-License-Identifier: GPL-3.0-or-later
// Fresnel reflectance of smooth (micro)surfaces: dielectrics, dielectrics with an artist's colour at normal
// incidence, metals. c is the cosine between direction and (micro)normal, eta the index of the far side
// relative to the near one.
#pragma once
#include <algorithm>

#include "base/colour.h"

namespace sluice {

// Unpolarised; 1 under total internal reflection. Transmittance is 1 minus this.
[[nodiscard]] inline float fresnel_dielectric(float c, float eta) noexcept {
  const float g2 = eta * eta - 1 + c * c;
  if (!(g2 > 0)) return 1;
  const float g = std::sqrt(g2), a = (g - c) / (g + c), b = (c * (g + c) - 1) / (c * (g - c) + 1);
  return std::min(1.0f, 0.5f * a * a * (1 + b * b));
}
[[nodiscard]] inline float f0_of_ior(float eta) noexcept { return square((eta - 1) / (eta + 1)); }
[[nodiscard]] inline float ior_of_f0(float f0) noexcept {
  const float root = std::sqrt(std::clamp(f0, 0.0f, 0.99f));
  return (1 + root) / (1 - root);
}

// Cosine-weighted mean of fresnel_dielectric; d'Eon's fit (Hitchhiker's Guide to Multiple Scattering), the
// one Cycles uses.
[[nodiscard]] inline float fresnel_dielectric_mean(float eta) noexcept {
  if (eta < 1)
    return std::clamp(0.997118f + eta * (0.1014f - eta * (0.965241f + eta * 0.130607f)), 0.0f, 1.0f);
  return (eta - 1) / (4.08567f + 1.00071f * eta);
}

struct Fresnel {
  enum class Kind : std::uint8_t {
    None,        // f0 at every angle
    Dielectric,  // of index eta
    // f0 at normal incidence, 1 at grazing, following the dielectric's curve between (Cycles' generalised
    // Schlick)
    Tinted,
    Metal,  // Schlick with f0, pulled by b to a colour at 82° (Kutz et al. 2021, F82)
  };
  Kind kind = Kind::None;
  float eta = 1;
  Color f0{1}, b{0};
};

// The F82 model's b from the tint at 82° (Kutz et al. 2021, with cos 82° ~ 1/7).
[[nodiscard]] inline Fresnel metal_fresnel(const Color& f0, const Color& tint82) noexcept {
  constexpr float c = 6.0f / 7.0f, c5 = c * c * c * c * c;
  const Color schlick = f0 + (Color(1) - f0) * c5;
  return {Fresnel::Kind::Metal, 1, f0, schlick * (7 / (c5 * c)) * (Color(1) - tint82)};
}

[[nodiscard]] inline Color clamp01(const Color& c) noexcept {
  return {std::clamp(c.x, 0.0f, 1.0f), std::clamp(c.y, 0.0f, 1.0f), std::clamp(c.z, 0.0f, 1.0f)};
}

// How far a dielectric's curve has risen from normal incidence (0) to grazing (1).
[[nodiscard]] inline float fresnel_rise(float reflectance, float eta) noexcept {
  const float f0 = f0_of_ior(eta);
  return f0 < 0.999f ? std::clamp((reflectance - f0) / (1 - f0), 0.0f, 1.0f) : 1.0f;
}

[[nodiscard]] inline Color eval_fresnel(const Fresnel& fresnel, float c) noexcept {
  switch (fresnel.kind) {
    case Fresnel::Kind::None: return fresnel.f0;
    case Fresnel::Kind::Dielectric: return Color(fresnel_dielectric(c, fresnel.eta));
    case Fresnel::Kind::Tinted: {
      const float s = fresnel_rise(fresnel_dielectric(c, fresnel.eta), fresnel.eta);
      return fresnel.f0 * (1 - s) + Color(s);
    }
    case Fresnel::Kind::Metal: {
      const float m = 1 - std::clamp(c, 0.0f, 1.0f), m5 = m * m * m * m * m;
      return clamp01(fresnel.f0 * (1 - m5) + Color(m5) - fresnel.b * (c * m5 * m));
    }
  }
  return Color(1);
}

// Cosine-weighted mean over the hemisphere: what a second bounce inside a rough surface meets.
[[nodiscard]] inline Color mean_fresnel(const Fresnel& fresnel) noexcept {
  switch (fresnel.kind) {
    case Fresnel::Kind::None: return fresnel.f0;
    case Fresnel::Kind::Dielectric: return Color(fresnel_dielectric_mean(fresnel.eta));
    case Fresnel::Kind::Tinted: {
      const float s = fresnel_rise(fresnel_dielectric_mean(fresnel.eta), fresnel.eta);
      return fresnel.f0 * (1 - s) + Color(s);
    }
    case Fresnel::Kind::Metal:
      return clamp01(fresnel.f0 * (20.0f / 21) + Color(1.0f / 21) - fresnel.b * (1.0f / 126));
  }
  return Color(1);
}

}  // namespace sluice
