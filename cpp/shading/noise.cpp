// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/noise.h"

#include <algorithm>
#include <bit>

namespace sluice::noise {
namespace {

// Bob Jenkins' lookup3, final mix.
[[nodiscard]] std::uint32_t finish(std::uint32_t a, std::uint32_t b, std::uint32_t c) noexcept {
  c ^= b;
  c -= std::rotl(b, 14);
  a ^= c;
  a -= std::rotl(c, 11);
  b ^= a;
  b -= std::rotl(a, 25);
  c ^= b;
  c -= std::rotl(b, 16);
  a ^= c;
  a -= std::rotl(c, 4);
  b ^= a;
  b -= std::rotl(a, 14);
  c ^= b;
  c -= std::rotl(b, 24);
  return c;
}

[[nodiscard]] float fade(float t) noexcept { return t * t * t * (t * (t * 6 - 15) + 10); }

[[nodiscard]] float gradient(std::uint32_t hashed, float x, float y, float z) noexcept {
  const std::uint32_t h = hashed & 15u;
  const float u = h < 8 ? x : y, v = h < 4 ? y : (h == 12 || h == 14) ? x : z;
  return (h & 1u ? -u : u) + (h & 2u ? -v : v);
}

[[nodiscard]] float mix(float a, float b, float t) noexcept { return (1 - t) * a + t * b; }

}  // namespace

std::uint32_t hash(std::uint32_t x, std::uint32_t y) noexcept {
  constexpr std::uint32_t start = 0xdeadbeefu + (2u << 2) + 13u;
  return finish(start + x, start + y, start);
}
std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t z) noexcept {
  constexpr std::uint32_t start = 0xdeadbeefu + (3u << 2) + 13u;
  return finish(start + x, start + y, start + z);
}

float signed_perlin(const V3f& p) noexcept {
  if (!is_finite(p) || max_component(p) > 1e9f || std::min({p.x, p.y, p.z}) < -1e9f) return 0;
  const V3f cell(std::floor(p.x), std::floor(p.y), std::floor(p.z)), f = p - cell;
  const auto corner = [&](int i, int j, int k) {
    const auto at = [](float c, int d) {
      return static_cast<std::uint32_t>(static_cast<std::int32_t>(c) + d);
    };
    return gradient(hash(at(cell.x, i), at(cell.y, j), at(cell.z, k)), f.x - static_cast<float>(i),
                    f.y - static_cast<float>(j), f.z - static_cast<float>(k));
  };
  const float u = fade(f.x), v = fade(f.y), w = fade(f.z);
  const float low =
      mix(mix(corner(0, 0, 0), corner(1, 0, 0), u), mix(corner(0, 1, 0), corner(1, 1, 0), u), v);
  const float high =
      mix(mix(corner(0, 0, 1), corner(1, 0, 1), u), mix(corner(0, 1, 1), corner(1, 1, 1), u), v);
  return 0.9820f * mix(low, high, w);
}

float fractal(const V3f& p, float detail, float roughness, float lacunarity) noexcept {
  detail = std::clamp(detail, 0.0f, 15.0f);
  roughness = std::clamp(roughness, 0.0f, 1.0f);
  float scale = 1, amplitude = 1, most = 0, sum = 0;
  for (int octave = 0; octave <= static_cast<int>(detail); ++octave) {
    sum += perlin(p * scale) * amplitude;
    most += amplitude;
    amplitude *= roughness;
    scale *= lacunarity;
  }
  const float rest = detail - std::floor(detail);
  if (rest == 0) return sum / most;
  const float more = (sum + perlin(p * scale) * amplitude) / (most + amplitude);
  return mix(sum / most, more, rest);
}

V3f offset(float seed) noexcept {
  const auto component = [seed](float k) {
    const float unit =
        static_cast<float>(hash(std::bit_cast<std::uint32_t>(seed), std::bit_cast<std::uint32_t>(k))) /
        static_cast<float>(0xffffffffu);
    return 100 + unit * 100;
  };
  return {component(0), component(1), component(2)};
}

}  // namespace sluice::noise
