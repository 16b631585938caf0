// SPDX-License-Identifier: GPL-3.0-or-later
// Photon density estimation at a vertex: L = Σ f(wi -> wo) Φ k over the photons on a disk, k a kernel (Jensen 1996; progressive radii: Knaus &
// Zwicker 2011, eq. 3). Knows no view path: each photon's contribution goes to the caller, who decides about C and weights.
#pragma once
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
    if (photon.normal != normal_) normal_ = photon.normal, is_like_ = is_like(unpack_octahedron(normal_));
    return is_like_;
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
  [[nodiscard]] bool is_like(const V3f& n) const noexcept {
    const float along = n.dot(vertex_.point.ns);
    return (transmits_ || along > 0) && square(along) >= square(like_normal) * n.length2();
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

// Calls found(photon, f Φ k) for the photons that the kernel reaches; k integrates to 1 over the surface. `radius`: r above, also of the
// round one.
template <Kernel kernel, class Found>
inline void estimate_density(const PhotonMap& map, Receiver receiver, float radius, Found&& found) {
  if (receiver.empty()) return;
  constexpr bool is_round = kernel == Kernel::Round;
  const float reach = is_round ? round_reach * radius : radius, per_reach2 = 1 / square(reach), most = (is_round ? 2 : 1) / pi * per_reach2;
  map.query(receiver.position(), reach, [&](const Photon& photon) {
    if (!receiver.accepts(photon, reach)) return;
    const float k = is_round ? most * std::max(0.0f, 1 - (photon.position - receiver.position()).length2() * per_reach2) : most;
    found(photon, receiver.f(photon) * photon.flux() * k);
  });
}

}  // namespace sluice
