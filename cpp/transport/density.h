// SPDX-License-Identifier: GPL-3.0-or-later
// Photon density estimation at a vertex: L = Σ f(wi -> wo) Φ k over the photons on a disk, k a kernel (Jensen 1996; progressive radii: Knaus &
// Zwicker 2011, eq. 3). Knows no view path: each photon's contribution goes to the caller, who decides about C and weights.
#pragma once
#include <bit>
#include <limits>

#include "transport/photon_map.h"
#include "transport/radii.h"
#include "transport/vertex.h"

namespace sluice {

// A photon counts if it lies on the same surface as far as one can tell: on a thin disk, with a like normal (numerics D1, D2).
inline constexpr float disk_thickness = 0.25f;  // of how far the kernel reaches
inline constexpr float like_normal = 0.5f;      // least |cos| between normals
inline constexpr float max_shading_ratio = 4;   // |wi·ns| / |wi·ng| at grazing shading normals, clamped

// Evaluates the gathering lobes of a vertex for photons; what does not depend on the photon is done once.
class Receiver {
 public:
  // `distance`: to where the light goes, in direction wo.
  Receiver(const Vertex& vertex, EventMask mask, double distance = std::numeric_limits<double>::infinity()) noexcept
      : vertex_(vertex), mask_(static_cast<EventMask>(mask & gathering)), nearness_(static_cast<float>(1 / distance)) {
    const Bsdf& bsdf = vertex.bsdf;
    int lobes = 0, last = 0;
    for (int i = 0; i < bsdf.count; ++i) {
      if (!(mask_of(bsdf.lobes[i].event) & mask_)) continue;
      ++lobes, last = i;
      transmits_ = transmits_ || std::visit([](const auto& shape) { return transmits(shape); }, bsdf.lobes[i].shape);
    }
    const Lobe& lobe = bsdf.lobes[last];
    flat_lambert_ = lobes == 1 && std::holds_alternative<Lambert>(lobe.shape) && lobe.n == bsdf.ng;
    if (flat_lambert_) lambert_ = lobe.weight / pi;
    empty_ = lobes == 0;
  }
  [[nodiscard]] bool empty() const noexcept { return empty_; }

  // Does the photon lie on this surface, on a side that the lobes can see? Normals of the vertex look to the eye's side. The last normal's
  // answer is remembered: on a flat surface there is one.
  [[nodiscard]] bool accepts(const Photon& photon, float reach) noexcept {
    if (std::abs((photon.position - position()).dot(vertex_.bsdf.ng)) > disk_thickness * reach) return false;
    return has_like_normal(photon.normal);
  }
#if defined(__AVX2__)
  // The same for lanes of a map: bits.
  [[nodiscard]] unsigned accepts(const PhotonMap& map, const PhotonMap::Lanes& lanes, float reach) noexcept {
    const V3f& n = vertex_.bsdf.ng;
    const auto times = [](const __m256& a, float b) { return _mm256_mul_ps(a, _mm256_set1_ps(b)); };
    const __m256 height = _mm256_add_ps(times(lanes.x, n.x), _mm256_add_ps(times(lanes.y, n.y), times(lanes.z, n.z)));
    const __m256 off = _mm256_andnot_ps(_mm256_set1_ps(-0.0f), height);
    const unsigned low = lanes.inside & static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(off, _mm256_set1_ps(disk_thickness * reach), _CMP_LE_OQ)));
    if (!low) return 0;
    const __m256i normals = map.normals(lanes);
    const auto known = static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(normals, _mm256_set1_epi32(static_cast<int>(normal_))))));
    unsigned accepted = is_like_ ? low & known : 0;
    for (unsigned others = low & ~known; others; others &= others - 1) {
      const int lane = std::countr_zero(others);
      if (has_like_normal(map[lanes.first + static_cast<std::size_t>(lane)].normal)) accepted |= 1u << lane;
    }
    return accepted;
  }
#endif
  // One that sends the same to all sides, of the same for all photons that it accepts.
  [[nodiscard]] bool is_flat() const noexcept { return flat_lambert_; }
  [[nodiscard]] const Color& flat_f() const noexcept { return lambert_; }
  // How far such a photon may lie from the vertex along each axis.
  [[nodiscard]] V3f room(float reach) const noexcept {
    const V3f& n = vertex_.bsdf.ng;
    const auto along = [reach](float c) { return reach * std::min(1.0f, std::sqrt(std::max(0.0f, 1 - c * c)) + disk_thickness * std::abs(c)) * 1.0001f; };
    return {along(n.x), along(n.y), along(n.z)};
  }
  // f(wi -> wo) as the photon's own place has it: its direction to the eye, its normal. On a curved surface with a sharp lobe the
  // disk would smear what the lobe throws otherwise (a rough glass ball's caustic: 9 % off). Directions are turned, not the lobes.
  [[nodiscard]] Color f(const Photon& photon) const noexcept {
    if (flat_lambert_) return lambert_;
    V3f n = unpack_direction(photon.normal);
    if (n.dot(vertex_.point.ns) < 0) n = -n;
    const V3f wi = turned(unpack_direction(photon.wi), n);
    const V3f wo = turned((vertex_.point.wo - (photon.position - position()) * nearness_).normalized(), n);
    const float cosine = std::abs(wi.dot(vertex_.bsdf.ng));  // photons measure flux through the geometric surface
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
    normal_ = packed, is_like_ = (transmits_ || along > 0) && square(along) >= square(like_normal) * n.length2();
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

// How the weight of a photon falls with its distance. Even: 1 / (π r²) on the disk of radius r, the fewest photons to look at. Round
// (Epanechnikov's parabola; Silverman 1986, §4.2): to 0 at √1.5 r, so that it blurs as much as that disk; it has 8/9 of its variance, and no
// rim to see where photons are few.
enum class Kernel : std::uint8_t { Even, Round };

// Photons that may be added up without a question: those that met no gate, up to this depth.
struct Unasked {
  bool any = false;
  int depth = 0;
  bool tells_states = false;  // of theirs: meet(q) is called for each, more than once if need be
};
struct Sum {
  Color radiance{0};
  std::uint32_t photons = 0;
};

// Photons on a flat diffuse surface, eight at a time: there f and the normal are the same for all.
#if defined(__AVX2__)
class FlatSum {
 public:
  // Weights are scale · (1 - falloff · distance²).
  FlatSum(const PhotonMap& map, const Unasked& unasked, float falloff) noexcept
      : map_(map), unasked_(unasked), falloff_(_mm256_set1_ps(falloff)), deepest_(_mm256_set1_epi32(std::min(unasked.depth, 255))) {}

  // Adds those of the lanes `lying` on the surface that need no question; returns the others.
  template <class Meet>
  [[nodiscard]] unsigned add(const PhotonMap::Lanes& lanes, unsigned lying, Meet&& meet) noexcept {
    const __m256i tags = map_.tags(lanes);
    const __m256i asked = _mm256_cmpgt_epi32(_mm256_and_si256(tags, _mm256_set1_epi32(0x1ff)), deepest_);  // met_gate is 256 deep
    const unsigned added = lying & ~bits_of(asked);
    if (unasked_.tells_states) tell(_mm256_srli_epi32(tags, 9), added, meet);
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128), chosen = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(added)), bit);
    const __m256 weight = _mm256_and_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, bit)),
                                        _mm256_sub_ps(_mm256_set1_ps(1), _mm256_mul_ps(lanes.distance2, falloff_)));
    for (int c = 0; c < 3; ++c) sum_[c] = _mm256_add_ps(sum_[c], _mm256_mul_ps(weight, map_.flux(lanes, c)));
    count_ += static_cast<std::uint32_t>(std::popcount(added));
    return lying & ~added;
  }
  [[nodiscard]] Sum sum(const Color& scale) const noexcept {
    Sum out{.photons = count_};
    for (int c = 0; c < 3; ++c) {
      alignas(32) float lane[8];
      _mm256_store_ps(lane, sum_[c]);
      out.radiance[c] = scale[c] * (((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7])));
    }
    return out;
  }
  [[nodiscard]] static unsigned bits_of(__m256i lanes) noexcept { return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(lanes))); }

 private:
  template <class Meet>
  void tell(__m256i states, unsigned some, Meet&& meet) noexcept {
    some &= ~bits_of(_mm256_cmpeq_epi32(states, _mm256_set1_epi32(static_cast<int>(told_))));
    if (!some) return;
    alignas(32) std::uint32_t q[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(q), states);
    for (; some; some &= some - 1)
      if (const std::uint32_t state = q[std::countr_zero(some)]; state != told_) meet(told_ = state);
  }

  const PhotonMap& map_;
  const Unasked& unasked_;
  __m256 falloff_;
  __m256i deepest_;
  __m256 sum_[3] = {_mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps()};
  std::uint32_t count_ = 0, told_ = ~0u;
};
#endif

// The sum of f Φ k over the photons that need no question, and found(photon, f Φ k) for each of the others that the kernel reaches; k
// integrates to 1 over the surface. `radius`: r above, also of the round one. (What needs no question may come to found() as well.)
template <Kernel kernel, class Meet, class Found>
[[nodiscard]] inline Sum estimate_density(const PhotonMap& map, Receiver receiver, float radius, [[maybe_unused]] const Unasked& unasked, [[maybe_unused]] Meet&& meet,
                                          Found&& found) {
  if (receiver.empty()) return {};
  constexpr bool is_round = kernel == Kernel::Round;
  const float reach = is_round ? round_reach * radius : radius, per_reach2 = 1 / square(reach), most = (is_round ? 2 : 1) / pi * per_reach2;
  const auto hand_over = [&](const Photon& photon) {
    const float k = is_round ? most * std::max(0.0f, 1 - (photon.position - receiver.position()).length2() * per_reach2) : most;
    found(photon, receiver.f(photon) * photon.flux() * k);
  };
#if defined(__AVX2__)
  if (unasked.any && receiver.is_flat()) {
    FlatSum sum(map, unasked, is_round ? per_reach2 : 0);
    map.visit(receiver.position(), reach, receiver.room(reach), [&](const PhotonMap::Lanes& lanes) {
      const unsigned lying = receiver.accepts(map, lanes, reach);
      if (!lying) return;
      for (unsigned others = sum.add(lanes, lying, meet); others; others &= others - 1) hand_over(map[lanes.first + static_cast<std::size_t>(std::countr_zero(others))]);
    });
    return sum.sum(receiver.flat_f() * most);
  }
#endif
  map.query(receiver.position(), reach, receiver.room(reach), [&](const Photon& photon) {
    if (receiver.accepts(photon, reach)) hand_over(photon);
  });
  return {};
}

}  // namespace sluice
