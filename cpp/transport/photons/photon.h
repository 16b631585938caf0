// SPDX-License-Identifier: GPL-3.0-or-later
// One stored photon in 32 bytes (design §5): what arrived at a surface, from where, by which kind of last
// event, in which state of the expressions. Positions are re-centred. Two photons fill a cache line; more
// passes beat bigger maps.
#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>

#include "base/colour.h"
#include "transport/arrival.h"

namespace sluice {

// Unit vectors on the octahedron, 16 bits an axis: 0.004 degrees at worst.
[[nodiscard]] inline std::uint32_t pack_direction(const V3f& d) noexcept {
  const float s = 1 / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  float x = d.x * s, y = d.y * s;
  if (d.z < 0) {
    const float fold = (1 - std::abs(y)) * std::copysign(1.0f, x);
    y = (1 - std::abs(x)) * std::copysign(1.0f, y);
    x = fold;
  }
  const auto quantise = [](float a) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(a, -1.0f, 1.0f) * 32767.0f) + 32768) & 0xffffu;
  };
  return quantise(x) | (quantise(y) << 16);
}

// The point of the octahedron, not of the sphere: in the right direction, 0.57 to 1 long.
[[nodiscard]] inline V3f unpack_octahedron(std::uint32_t bits) noexcept {
  float x = static_cast<float>(static_cast<int>(bits & 0xffffu) - 32768) * (1 / 32767.0f);
  float y = static_cast<float>(static_cast<int>(bits >> 16) - 32768) * (1 / 32767.0f);
  const float z = 1 - std::abs(x) - std::abs(y), fold = std::max(-z, 0.0f);
  x -= std::copysign(fold, x), y -= std::copysign(fold, y);
  return {x, y, z};
}
[[nodiscard]] inline V3f unpack_direction(std::uint32_t bits) noexcept {
  const V3f d = unpack_octahedron(bits);
  return d * (1 / std::sqrt(d.length2()));
}

struct Photon {
  static constexpr int q_bits = 23;

  V3f position{0};
  std::uint32_t wi = 0;            // towards where the light came from
  std::uint32_t normal = 0;        // of shading, on the side the light arrived at
  std::uint16_t mantissa[3] = {};  // flux (W) = mantissa · 2^(exponent - 144)
  std::uint8_t exponent = 18;
  std::uint8_t depth = 0;          // D, S, G events so far
  std::uint32_t q : q_bits = 0;    // state of the path so far, a number of PhotonStates
  std::uint32_t met_gate : 1 = 0;  // on the way so far, as all light that arrives as edited has
  Arrival arrival : 8 = Arrival::Direct;

  // Rounds to 16 bits of the largest channel; flux beyond 2^127 is clamped (the caller bounds it), below
  // 2^-127 becomes 0.
  void set_flux(const Color& flux) noexcept {
    int e = 0;
    std::frexp(std::max(max_component(flux), 0.0f), &e);  // flux < 2^e
    e = std::clamp(e, -110, 127);
    const float scale = std::ldexp(1.0f, 16 - e);
    const auto round = [scale](float c) {
      return static_cast<std::uint16_t>(std::clamp(std::lround(c * scale), 0L, 65535L));
    };
    mantissa[0] = round(flux.x), mantissa[1] = round(flux.y), mantissa[2] = round(flux.z);
    exponent = static_cast<std::uint8_t>(e + 128);
  }
  [[nodiscard]] Color flux() const noexcept {
    // 2^(exponent - 144)
    const float scale = std::bit_cast<float>((static_cast<std::uint32_t>(exponent) - 17u) << 23);
    return {mantissa[0] * scale, mantissa[1] * scale, mantissa[2] * scale};
  }
};
static_assert(sizeof(Photon) == 32);

}  // namespace sluice
