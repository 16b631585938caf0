// SPDX-License-Identifier: GPL-3.0-or-later
// Radiance that photons may have brought, with what their kernels' width is expected to add to it.
#pragma once
#include "base/colour.h"

namespace sluice {

struct BlurredLight {
  Color radiance{0};
  // luminance by which it is expected to be too bright (density.h); of the mean over many passes: one sample
  // tells nothing
  float bias = 0;

  BlurredLight() = default;
  // Light of other estimators is not blurred.
  BlurredLight(const Color& some_radiance,
               float some_bias = 0) noexcept  // NOLINT(google-explicit-constructor)
      : radiance(some_radiance), bias(some_bias) {}
  BlurredLight& operator+=(const BlurredLight& o) noexcept {
    radiance += o.radiance, bias += o.bias;
    return *this;
  }
  // What is left of it after factors by colour.
  [[nodiscard]] BlurredLight changed_to(const Color& changed) const noexcept {
    return {changed, bias_of(changed)};
  }
  // The same share of it after factors by colour: what is lost of the light is lost of the bias.
  [[nodiscard]] float bias_of(const Color& changed) const noexcept {
    const float before = luminance(radiance);
    return before > 0 ? bias * (luminance(changed) / before) : 0;
  }
};

// What an edit took of it.
struct TakenLight {
  float luminance = 0, bias = 0;
  void operator+=(const TakenLight& o) noexcept { luminance += o.luminance, bias += o.bias; }
};

}  // namespace sluice
