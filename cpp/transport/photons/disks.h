// SPDX-License-Identifier: GPL-3.0-or-later
// How wide the kernels of caustics and edited light are, which the view path's own vertex v reads. The width
// belongs to the photon, told by its place alone, so that each photon lays down its flux once wherever it
// lies (the sample-point estimator; Silverman 1986, §2.6, §5.3). Were it the receiver's, a thin bright
// caustic would be counted by wide disks beside it and by narrow ones on it.
#pragma once
#include "transport/photons/photon_map.h"
#include "transport/radius_cache.h"
#include "transport/settings.h"

namespace sluice {

class Camera;
struct FrameDescription;

// Of the picture's side, at most: a common radius, for pictures so small that some pixels are much of them.
inline constexpr float max_disk_of_picture = 1.0f / 16;

// Bounds of radii of the first pass: some footprints of a pixel, so that they do not know how large the scene
// is. Wider where the pilot found so few photons that noise would hide every feature of that size, narrower
// where there are enough for sharper edges.
class DiskBounds {
 public:
  DiskBounds(const Camera& camera, const FrameDescription& frame, const TransportSettings& settings);

  [[nodiscard]] float common(float footprint) const noexcept { return common_ * footprint; }
  [[nodiscard]] float widest(float footprint, bool soft) const noexcept {
    return (soft ? widest_soft_ : widest_) * footprint;
  }
  // How far the kernel of a photon there reaches when radii have shrunk to `scale`; `needed`: by a
  // RadiusCache.
  [[nodiscard]] float reach(const V3f& p, bool soft, const float* needed, float scale) const noexcept;
  // Bounds of that for all photons whose kernels may hold v.
  [[nodiscard]] Reaches around(const V3f& v, float scale) const noexcept;

 private:
  [[nodiscard]] float footprint(const V3f& p) const noexcept;

  const Camera& camera_;
  float narrowest_, common_, widest_, widest_soft_;  // in footprints
  float slope_;                                      // of the footprint, per metre
};

// What the kernels of one pass's photons reach.
class DiskReach {
 public:
  DiskReach(const DiskBounds& bounds, const RadiusCache& sharp, const RadiusCache& soft, float scale) noexcept
      : bounds_(bounds), sharp_(sharp), soft_(soft), scale_(scale) {}
  [[nodiscard]] float operator()(const Photon& photon) const noexcept;

 private:
  const DiskBounds& bounds_;
  const RadiusCache &sharp_, &soft_;
  float scale_;
};

}  // namespace sluice
