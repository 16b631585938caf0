// SPDX-License-Identifier: GPL-3.0-or-later
// Photon density estimation at a vertex: L = Σ f(wi -> wo) Φ k over the photons on a disk, k a kernel (Jensen
// 1996; progressive radii: Knaus & Zwicker 2011, eq. 3). Knows no view path: each photon's contribution goes
// to the caller, who decides about C and weights.
#pragma once
#include <limits>

#include "transport/photons/disks.h"
#include "transport/photons/flat_sum.h"
#include "transport/photons/photon_map.h"
#include "transport/radii.h"
#include "transport/vertex.h"

namespace sluice {

// A photon counts if it lies on the same surface as far as one can tell: on a thin disk, with a like normal
// (numerics D1, D2).
inline constexpr float disk_thickness = 0.25f;  // of how far its kernel reaches
inline constexpr float like_normal = 0.5f;      // least |cos| between normals
inline constexpr float max_shading_ratio = 4;   // |wi·ns| / |wi·ng| at grazing shading normals, clamped

// Evaluates the gathering lobes of a vertex for photons; what does not depend on the photon is done once.
class Receiver {
 public:
  // `distance`: to where the light goes, in direction wo.
  Receiver(const Vertex& vertex, EventMask mask,
           double distance = std::numeric_limits<double>::infinity()) noexcept
      : vertex_(vertex),
        mask_(static_cast<EventMask>(mask & gathering)),
        nearness_(static_cast<float>(1 / distance)) {
    const Bsdf& bsdf = vertex.bsdf;
    int lobes = 0, last = 0;
    for (int i = 0; i < bsdf.count; ++i) {
      if (!(mask_of(bsdf.lobes[i].event) & mask_)) continue;
      ++lobes, last = i;
      transmits_ = transmits_ || bsdf.lobes[i].transmits;
    }
    const Lobe& lobe = bsdf.lobes[last];
    flat_lambert_ = lobes == 1 && std::holds_alternative<Lambert>(lobe.shape) && lobe.n == bsdf.ng;
    if (flat_lambert_) lambert_ = lobe.weight / pi;
    empty_ = lobes == 0;
  }
  [[nodiscard]] bool empty() const noexcept { return empty_; }

  // Does the photon lie on this surface, on a side that the lobes can see? Normals of the vertex look to the
  // eye's side. The last normal's answer is remembered: on a flat surface there is one.
  [[nodiscard]] bool accepts(const Photon& photon, float per_reach2) noexcept {
    if (square((photon.position - position()).dot(vertex_.bsdf.ng)) * per_reach2 > square(disk_thickness))
      return false;
    return has_like_normal(photon.normal);
  }
#if defined(__AVX2__)
  // The same for lanes of a map: bits.
  [[nodiscard]] unsigned accepts(const PhotonMap& map, const PhotonMap::Lanes& lanes,
                                 const __m256& per_reach2) noexcept {
    const V3f& n = vertex_.bsdf.ng;
    const auto times = [](const __m256& a, float b) { return _mm256_mul_ps(a, _mm256_set1_ps(b)); };
    const __m256 height =
        _mm256_add_ps(times(lanes.x, n.x), _mm256_add_ps(times(lanes.y, n.y), times(lanes.z, n.z)));
    const __m256 off = _mm256_mul_ps(_mm256_mul_ps(height, height), per_reach2),
                 is_low = _mm256_cmp_ps(off, _mm256_set1_ps(square(disk_thickness)), _CMP_LE_OQ);
    const unsigned low = lanes.inside & FlatSum::bits_of(_mm256_castps_si256(is_low));
    if (!low) return 0;
    const __m256i normals = map.normals(lanes);
    const unsigned known =
        FlatSum::bits_of(_mm256_cmpeq_epi32(normals, _mm256_set1_epi32(static_cast<int>(normal_))));
    unsigned accepted = is_like_ ? low & known : 0;
    if (low & ~known) {
      alignas(32) std::uint32_t normal[8];
      _mm256_store_si256(reinterpret_cast<__m256i*>(normal), normals);
      for (unsigned others = low & ~known; others; others &= others - 1)
        if (const int lane = std::countr_zero(others); has_like_normal(normal[lane])) accepted |= 1u << lane;
    }
    return accepted;
  }
#endif
  // One that sends the same to all sides, of the same for all photons that it accepts.
  [[nodiscard]] bool is_flat() const noexcept { return flat_lambert_; }
  [[nodiscard]] const Color& flat_f() const noexcept { return lambert_; }
  // How far such a photon may lie from the vertex along each axis.
  [[nodiscard]] V3f extent(float reach) const noexcept {
    const V3f& n = vertex_.bsdf.ng;
    const auto along = [reach](float c) {
      // rounding
      return 1.0001f * reach *
             std::min(1.0f, std::sqrt(std::max(0.0f, 1 - c * c)) + disk_thickness * std::abs(c));
    };
    return {along(n.x), along(n.y), along(n.z)};
  }
  // f(wi -> wo) as the photon's own place has it: its direction to the eye, its normal. On a curved surface
  // with a sharp lobe the disk would smear what the lobe throws otherwise (a rough glass ball's caustic: 9 %
  // off). Directions are turned, not the lobes.
  [[nodiscard]] Color f(const Photon& photon) const noexcept {
    if (flat_lambert_) return lambert_;
    V3f n = unpack_direction(photon.normal);
    if (n.dot(vertex_.point.ns) < 0) n = -n;
    const V3f wi = turned(unpack_direction(photon.wi), n);
    const V3f wo = turned((vertex_.point.wo - (photon.position - position()) * nearness_).normalized(), n);
    // photons measure flux through the geometric surface
    const float cosine = std::abs(wi.dot(vertex_.bsdf.ng));
    if (cosine < 1e-4f || wo.dot(vertex_.bsdf.ng) <= 0) return Color(0);
    Color value = eval(vertex_.bsdf, wo, wi, mask_) / cosine;
    const float ratio = std::abs(wi.dot(vertex_.point.ns)) / cosine;
    if (ratio > max_shading_ratio) value *= max_shading_ratio / ratio;
    return value;
  }
  [[nodiscard]] V3f position() const noexcept { return V3f(vertex_.hit.position); }

 private:
  [[nodiscard]] bool has_like_normal(std::uint32_t packed) noexcept {
    if (packed == normal_) return is_like_;
    const V3f n = unpack_octahedron(packed);
    const float along = n.dot(vertex_.point.ns);
    normal_ = packed;
    is_like_ = (transmits_ || along > 0) && square(along) >= square(like_normal) * n.length2();
    return is_like_;
  }
  // d after the least rotation that takes n to the vertex's normal (n is on its side).
  [[nodiscard]] V3f turned(const V3f& d, const V3f& n) const noexcept {
    const V3f& to = vertex_.point.ns;
    const V3f sum = n + to;
    return d - sum * (sum.dot(d) / (1 + n.dot(to))) + to * (2 * n.dot(d));
  }

  const Vertex& vertex_;
  EventMask mask_;
  float nearness_;  // 1 / distance
  bool transmits_ = false, flat_lambert_ = false, empty_ = true;
  Color lambert_{0};
  std::uint32_t normal_ = 0;  // no photon's
  bool is_like_ = false;
};

// The bias of a density grows with the kernel's radius, so a kernel of half the radius has less of it, and a
// multiple of the difference of both is an estimate of it (Richardson's extrapolation): 4/3 of it where the
// density is smooth and the bias grows as r² (Silverman 1986, §4.3), 2.15 of it across a step, by root mean
// squares. One factor stands for both, at most 27 % off. Both sums go over the same photons, so that it costs
// no other query.
inline constexpr float smaller_kernel = 0.5f, bias_per_difference = 1.7f;

// Of one photon: the bias that it tells of, relative to what it brings, by the kernel's value there and that
// of the smaller kernel.
[[nodiscard]] inline float bias_share(float kernel, float smaller) noexcept {
  return kernel > 0 ? bias_per_difference * (kernel - smaller) / kernel : 0;
}

// Epanechnikov's kernel of half the radius, in units in which that of the whole radius is c = 1 - d² / R².
[[nodiscard]] inline float smaller_closeness(float c) noexcept {
  static_assert(smaller_kernel == 0.5f);
  return std::max(0.0f, 16 * c - 12);  // 4 (1 - 4 d² / R²)
}

// Both estimators return the sum of f Φ k over the photons that `rule` lets in, where the kernel k integrates
// to 1 over the surface. They call found(photon, f Φ k, its bias_share, is_summed) for every other photon
// that the kernel reaches, and for a photon of the sum if ask(q), called for its state q, wants it handed
// over as well. Only flat diffuse receivers (Receiver::is_flat) sum; others hand over every photon.
//
// At y, one radius for all photons: k = 1 / (π r²), the fewest photons to look at.
template <class Ask, class Found>
[[nodiscard]] inline Sum estimate_density(const PhotonMap& map, Receiver receiver, float radius,
                                          [[maybe_unused]] const SumRule& rule, [[maybe_unused]] Ask&& ask,
                                          Found&& found) {
  if (receiver.empty()) return {};
  const float per_reach2 = 1 / square(radius), k = 1 / pi * per_reach2;
  const float near2 = square(smaller_kernel * radius), smaller = 1 / square(smaller_kernel);
  const auto hand_over = [&](const Photon& photon, bool is_summed) {
    const bool is_near = (photon.position - receiver.position()).length2() < near2;
    found(photon, receiver.f(photon) * photon.flux() * k, bias_share(1, is_near ? smaller : 0), is_summed);
  };
#if defined(__AVX2__)
  if (rule.sums && receiver.is_flat()) {
    FlatSum sum(map, rule);
    map.visit(receiver.position(), radius, receiver.extent(radius), [&](const PhotonMap::Lanes& lanes) {
      const unsigned lying = receiver.accepts(map, lanes, _mm256_set1_ps(per_reach2));
      if (!lying) return;
      const __m256 is_near = _mm256_cmp_ps(lanes.distance2, _mm256_set1_ps(near2), _CMP_LT_OQ);
      const __m256 bias =
          _mm256_blendv_ps(_mm256_set1_ps(bias_share(1, 0)), _mm256_set1_ps(bias_share(1, smaller)), is_near);
      const auto [summed, handed_over] = sum.add(lanes, lying, _mm256_set1_ps(1), bias, ask);
      for (unsigned left = handed_over; left; left &= left - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
        hand_over(map[lanes.first + lane], (summed >> lane) & 1);
      }
    });
    return sum.sum(receiver.flat_f() * k);
  }
#endif
  map.query(receiver.position(), radius, receiver.extent(radius), [&](const Photon& photon) {
    if (receiver.accepts(photon, per_reach2)) hand_over(photon, false);
  });
  return {};
}

// At v, each photon by its own kernel, round (Epanechnikov's parabola; Silverman 1986, §4.2): k = 2 / (π R²)
// (1 - d² / R²), R its reach. To 0 at R = √1.5 r it blurs as much as the even one of radius r; it has 8/9 of
// its variance, and no rim to see where photons are few.
template <class Ask, class Found>
[[nodiscard]] inline Sum estimate_density(const PhotonMap& map, Receiver receiver, const Reaches& reaches,
                                          [[maybe_unused]] const SumRule& rule, [[maybe_unused]] Ask&& ask,
                                          Found&& found) {
  if (receiver.empty()) return {};
  const auto hand_over = [&](const Photon& photon, float per_reach2, bool is_summed) {
    const float closeness =
        std::max(0.0f, 1 - (photon.position - receiver.position()).length2() * per_reach2);
    found(photon, receiver.f(photon) * photon.flux() * (2 / pi * per_reach2 * closeness),
          bias_share(closeness, smaller_closeness(closeness)), is_summed);
  };
#if defined(__AVX2__)
  if (rule.sums && receiver.is_flat()) {
    FlatSum sum(map, rule);
    map.visit(receiver.position(), reaches, receiver.extent(1), [&](const PhotonMap::ReachLanes& lanes) {
      const unsigned lying = receiver.accepts(map, lanes, lanes.per_reach2);
      if (!lying) return;
      // as bias_share and smaller_closeness have it
      const __m256 smaller = _mm256_max_ps(
          _mm256_setzero_ps(),
          _mm256_sub_ps(_mm256_mul_ps(_mm256_set1_ps(16), lanes.closeness), _mm256_set1_ps(12)));
      const __m256 bias =
          _mm256_mul_ps(_mm256_set1_ps(bias_per_difference), _mm256_sub_ps(lanes.closeness, smaller));
      const auto [summed, handed_over] =
          sum.add(lanes, lying, _mm256_mul_ps(lanes.closeness, lanes.per_reach2),
                  _mm256_mul_ps(bias, lanes.per_reach2), ask);
      for (unsigned left = handed_over; left; left &= left - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
        hand_over(map[lanes.first + lane], map.per_reach2(lanes.first + lane), (summed >> lane) & 1);
      }
    });
    return sum.sum(receiver.flat_f() * (2 / pi));
  }
#endif
  map.query(receiver.position(), reaches, receiver.extent(1), [&](const Photon& photon, float per_reach2) {
    if (receiver.accepts(photon, per_reach2)) hand_over(photon, per_reach2, false);
  });
  return {};
}

}  // namespace sluice
