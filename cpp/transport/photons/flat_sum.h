// SPDX-License-Identifier: GPL-3.0-or-later
// Photons on a flat diffuse surface, added up eight at a time: there f is the same for all. Which of them
// belong to a sum is said state by state, so the same photons are added in the same way whether or not edits
// and layers ask for their states.
#pragma once
#include <bit>

#include "transport/photons/photon_map.h"

namespace sluice {

// Photons that met no gate and are at most `depth` deep may be added up.
struct SumRule {
  bool sums = false;
  int depth = 0;
  bool asks = false;  // their states matter: ask(q) is called whenever q changes
};
// What becomes of those in one state.
struct SumAnswer {
  bool is_summed = true;
  bool is_handed_over = false;  // to found(), too or only
};
struct Sum {
  Color radiance{0};
  float bias = 0;  // luminance (density.h)
  std::uint32_t photons = 0;
};

#if defined(__AVX2__)
class FlatSum {
 public:
  FlatSum(const PhotonMap& map, const SumRule& rule) noexcept
      : map_(map), rule_(rule), deepest_(_mm256_set1_epi32(std::min(rule.depth, 255))) {}

  struct Split {
    unsigned summed, handed_over;  // lanes, bit set
  };
  // Adds those of the lanes `lying` on the surface that belong to the sum, with their weights, and with those
  // of the kernel's bias.
  template <class Ask>
  [[nodiscard]] Split add(const PhotonMap::Lanes& lanes, unsigned lying, const __m256& weights,
                          const __m256& bias_weights, Ask&& ask) {
    const __m256i tags = map_.tags(lanes);
    // The bit of photons that met a gate lies above those of depth, so the one comparison rejects them too.
    const __m256i depth_or_gate =
        _mm256_and_si256(tags, _mm256_set1_epi32(PhotonMap::tag_depth | PhotonMap::tag_gate));
    const unsigned out = lying & bits_of(_mm256_cmpgt_epi32(depth_or_gate, deepest_));
    Split split{lying & ~out, out};
    if (rule_.asks) ask_states(_mm256_srli_epi32(tags, PhotonMap::tag_bits_below_q), split, ask);
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i chosen = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(split.summed)), bit);
    const __m256 is_chosen = _mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, bit));
    const __m256 weight = _mm256_and_ps(is_chosen, weights),
                 bias_weight = _mm256_and_ps(is_chosen, bias_weights);
    for (int c = 0; c < 3; ++c) {
      const __m256 flux = map_.flux(lanes, c);
      sum_[c] = _mm256_add_ps(sum_[c], _mm256_mul_ps(weight, flux));
      bias_[c] = _mm256_add_ps(bias_[c], _mm256_mul_ps(bias_weight, flux));
    }
    count_ += static_cast<std::uint32_t>(std::popcount(split.summed));
    return split;
  }

  [[nodiscard]] Sum sum(const Color& scale) const noexcept {
    Sum out{.photons = count_};
    Color bias;
    for (int c = 0; c < 3; ++c) {
      out.radiance[c] = scale[c] * sum_of(sum_[c]);
      bias[c] = scale[c] * sum_of(bias_[c]);
    }
    out.bias = luminance(bias);
    return out;
  }
  [[nodiscard]] static unsigned bits_of(__m256i lanes) noexcept {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(lanes)));
  }

 private:
  [[nodiscard]] static float sum_of(const __m256& lanes) noexcept {
    alignas(32) float lane[8];
    _mm256_store_ps(lane, lanes);
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
  }
  // Neighbours are often in one state, and most states are summed and no more.
  template <class Ask>
  void ask_states(__m256i states, Split& split, Ask&& ask) {
    const unsigned others =
        split.summed & ~bits_of(_mm256_cmpeq_epi32(states, _mm256_set1_epi32(static_cast<int>(q_))));
    if (!others && answer_.is_summed && !answer_.is_handed_over) return;
    alignas(32) std::uint32_t q[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(q), states);
    for (unsigned left = split.summed; left; left &= left - 1) {
      const int lane = std::countr_zero(left);
      if (q[lane] != q_) q_ = q[lane], answer_ = ask(q_);
      if (!answer_.is_summed) split.summed &= ~(1u << lane);
      if (answer_.is_handed_over) split.handed_over |= 1u << lane;
    }
  }

  const PhotonMap& map_;
  const SumRule& rule_;
  __m256i deepest_;
  __m256 sum_[3] = {_mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps()};
  __m256 bias_[3] = {_mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps()};
  std::uint32_t count_ = 0, q_ = ~0u;  // no photon's
  SumAnswer answer_;
};
#endif

}  // namespace sluice
