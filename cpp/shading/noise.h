// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's gradient noise in three dimensions: Perlin's, on Jenkins' hash, value for value.
#pragma once
#include "base/math.h"

namespace sluice::noise {

[[nodiscard]] std::uint32_t hash(std::uint32_t x, std::uint32_t y) noexcept;
[[nodiscard]] std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t z) noexcept;

[[nodiscard]] float signed_perlin(const V3f& p) noexcept;  // about -1..1
[[nodiscard]] inline float perlin(const V3f& p) noexcept { return 0.5f * signed_perlin(p) + 0.5f; }

// The Noise texture's sum of octaves; `detail` may be fractional. Normalised to 0..1.
[[nodiscard]] float fractal(const V3f& p, float detail, float roughness, float lacunarity) noexcept;

// The far offsets by which Blender takes several independent values at one point.
[[nodiscard]] V3f offset(float seed) noexcept;

}  // namespace sluice::noise
