// SPDX-License-Identifier: GPL-3.0-or-later
// Tables of what rough GGX surfaces reflect and transmit, computed once, on first use, from stratified
// samples (no data files). They give directional albedos (lobe choice, roulette, layering) and the factors
// that return the energy lost between microfacets. Read at mu = cosine to the normal, in (0, 1], and Blender
// roughness = sqrt(alpha). Error of albedos: below 0.02; near the critical angle of nearly smooth glass seen
// from inside, and of stretched highlights, up to 0.1.
#pragma once
#include "base/math.h"

namespace sluice::energy {

// Single-scattering albedo of reflecting GGX, split for Fresnel curves: total (F = 1), and the shares of F =
// (1-c)^5, c (1-c)^6.
struct Reflecting {
  float total, schlick, edge;
};
[[nodiscard]] Reflecting reflecting(float mu, float roughness) noexcept;
[[nodiscard]] float mean_reflecting(float roughness) noexcept;  // cosine-weighted mean of total

// Factor a with  a(o) ∫ f(o, i) a(i) cos θ_i dω = 1  for F = 1: f·a(o)·a(i) keeps all energy and is
// reciprocal, so that photons and view paths see one and the same surface (a factor of one direction alone,
// Turquin 2019, would not).
[[nodiscard]] float reflecting_balance(float mu, float roughness) noexcept;

// Single-scattering albedos of a rough dielectric with index eta (far side / near side, also < 1), and
// factors that keep its energy: reflection times balance(o) balance(i), refraction times
// transmitted_balance(o; eta) transmitted_balance(i; 1 / eta).
struct Dielectric {
  float reflected, transmitted, balance, transmitted_balance;
};
[[nodiscard]] Dielectric dielectric(float mu, float roughness, float eta) noexcept;

}  // namespace sluice::energy
