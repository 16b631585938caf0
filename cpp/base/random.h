// SPDX-License-Identifier: GPL-3.0-or-later
// Randomised quasi-Monte Carlo (design §5): shuffled, Owen-scrambled Sobol' pairs, and a base-4 sequence
// dealt to four streams. A sample is a pure function of (key, index, dimension pair), so passes may run in
// any order, on any thread, in any process. Hash-based scrambling: Burley 2020, JCGT 9(4), with the improved
// Laine-Karras hash of Vegdahl.
#pragma once
#include <bit>
#include <cstdint>

#include "base/math.h"

namespace sluice {

[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t x) noexcept {  // splitmix64's finaliser
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t a, std::uint64_t b) noexcept {
  return mix(mix(a) ^ (b * 0xd6e8feb86659fd93ull));
}

// 24 bits, so the result is always < 1 (u32 * 2^-32 rounds up to exactly 1.0f).
[[nodiscard]] constexpr float to_unit(std::uint32_t x) noexcept {
  return static_cast<float>(x >> 8) * 0x1p-24f;
}

namespace detail {

[[nodiscard]] constexpr std::uint32_t reverse_bits(std::uint32_t x) noexcept {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  return __builtin_bswap32(x);
}

// Owen scrambling of a bit-reversed number: each bit is flipped by a hash of the bits below it.
[[nodiscard]] constexpr std::uint32_t laine_karras(std::uint32_t x, std::uint32_t seed) noexcept {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}
[[nodiscard]] constexpr std::uint32_t owen(std::uint32_t x, std::uint32_t seed) noexcept {
  return reverse_bits(laine_karras(reverse_bits(x), seed));
}

// Second dimension of the base-4 sequence of Faure and Niederreiter, digit-reversed: digit r is the sum over
// digits j >= r of the index of binomial(j, r) times it, in GF(4), where binomials are 0 or 1 and sums are
// exclusive or.
[[nodiscard]] constexpr std::uint32_t pascal_reversed(std::uint32_t index) noexcept {
  std::uint32_t x = index;
  x ^= (x & 0xccccccccu) >> 2;
  x ^= (x & 0xf0f0f0f0u) >> 4;
  x ^= (x & 0xff00ff00u) >> 8;
  x ^= (x & 0xffff0000u) >> 16;
  return x;
}

// Second Sobol' dimension, bit-reversed: the same of bits, mod 2, which takes one shift-and-xor step more.
[[nodiscard]] constexpr std::uint32_t sobol1_reversed(std::uint32_t index) noexcept {
  return pascal_reversed(index ^ ((index & 0xaaaaaaaau) >> 1));
}

// First digit of the sequence's third dimension, but for the index's own first digit: the sum of w^j times
// digit j >= 1, where w, one of GF(4)'s two other numbers, multiplies (b1 b0) to (b0 + b1, b1). `higher`: the
// index without its first digit.
[[nodiscard]] constexpr std::uint32_t third_dimension(std::uint32_t higher) noexcept {
  const auto parity = [](std::uint32_t x) { return static_cast<std::uint32_t>(std::popcount(x)) & 1u; };
  return parity(higher & 0x9e79e79eu) | (parity(higher & 0xe79e79e7u) << 1);
}

}  // namespace detail

// One sample point: hands out dimension pairs by number.
class Sampler {
 public:
  Sampler() = default;
  Sampler(std::uint64_t key, std::uint32_t index) noexcept : key_(key), index_(index) {}
  // Point `index` of one of four streams that a sequence is dealt to, by the first digit of its third
  // dimension: the first 4^m points of each are a net, and those of all four together are one.
  Sampler(std::uint64_t key, std::uint32_t index, std::uint32_t stream) noexcept
      : key_(key), index_(index), stream_(stream) {}

  // One of `count` points that this one is split into: together those of all points are a longer sequence.
  [[nodiscard]] Sampler part(std::uint32_t i, std::uint32_t count) const noexcept {
    return {key_, index_ * count + i, stream_};
  }

  // The point of the sequence that comes so many after this one.
  [[nodiscard]] Sampler after(std::uint32_t count) const noexcept { return {key_, index_ + count, stream_}; }

  // One of points that have nothing to do with each other.
  [[nodiscard]] Sampler apart(std::uint32_t i) const noexcept { return {mix(key_, i + 1), index_, stream_}; }

  // The dimension pair `pair` of this point, in [0, 1)².
  [[nodiscard]] V2f pair(std::uint32_t pair) const noexcept {
    const std::uint64_t h = hash_of(pair);
    const auto index = index_of(h),
               second = stream_ < 4 ? detail::pascal_reversed(index) : detail::sobol1_reversed(index);
    return {first(index, h),
            to_unit(detail::reverse_bits(detail::laine_karras(second, static_cast<std::uint32_t>(mix(h)))))};
  }
  // Its first number, for half the work.
  [[nodiscard]] float first(std::uint32_t pair) const noexcept {
    const std::uint64_t h = hash_of(pair);
    return first(index_of(h), h);
  }

 private:
  [[nodiscard]] std::uint64_t hash_of(std::uint32_t pair) const noexcept {
    return mix(key_ ^ (0x9e3779b97f4a7c15ull * (pair + 1)));
  }
  [[nodiscard]] std::uint32_t index_of(std::uint64_t h) const noexcept {
    return stream_ < 4 ? dealt(h) : detail::owen(index_, static_cast<std::uint32_t>(h));
  }
  [[nodiscard]] static float first(std::uint32_t index, std::uint64_t h) noexcept {
    return to_unit(detail::reverse_bits(detail::laine_karras(index, static_cast<std::uint32_t>(h >> 32))));
  }

  // The stream's point, as an index into the sequence that all streams share. Blocks of four points are
  // shuffled for all streams alike; inside a block each stream has an order of its own (its digit times
  // w^power plus a number, from a table of the three products), else pairs of dimensions would go together.
  [[nodiscard]] std::uint32_t dealt(std::uint64_t h) const noexcept {
    std::uint32_t higher = detail::owen(index_, static_cast<std::uint32_t>(h));
    // a hash of three
    auto own = static_cast<std::uint32_t>(h >> 32) + stream_ * 0x9e3779b9u + (higher >> 2) * 0x85ebca6bu;
    own = (own ^ (own >> 16)) * 0x7feb352du;
    own ^= own >> 15;
    const auto power = static_cast<std::uint32_t>(((own >> 2) * 3ull) >> 30);
    higher = (higher & ~3u) | (((0x9c78e4u >> (8 * power + 2 * (higher & 3u))) ^ own) & 3u);
    return (higher << 2) |
           (stream_ ^ (static_cast<std::uint32_t>(h >> 30) & 3u) ^ detail::third_dimension(higher));
  }

  std::uint64_t key_ = 0;
  std::uint32_t index_ = 0, stream_ = 4;
};

}  // namespace sluice
