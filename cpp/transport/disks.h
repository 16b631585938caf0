// SPDX-License-Identifier: GPL-3.0-or-later
// How wide the kernels of caustics and edited light are, which the view path's own vertex v reads. The width
// belongs to the photon, told by its place alone, so that each photon lays down its flux once wherever it
// lies (the sample-point estimator; Silverman 1986, §2.6, §5.3). Were it the receiver's, a thin bright
// caustic would be counted by wide disks beside it and by narrow ones on it.
#pragma once
#include <span>
#include <vector>

#include "transport/cells.h"
#include "transport/photon_map.h"
#include "transport/settings.h"

namespace sluice {

class Camera;
struct FrameDescription;

// Radius in the first pass that finds a few photons (m): of the smallest cell there that holds any photon of
// the pilot's: where those are sparse, larger cells answer.
struct Disks {
  static constexpr double growth = 3;  // of the cells' edge
  std::vector<Cells> levels;           // the smallest first

  // Looked up at `offset`, in edges of a cell, from p: drawn anew for each photon it hides the cells'
  // borders. Where that leads off the surface or out of the light, p's own cell answers. Null: the pilot
  // found no photon as far as the largest cells reach.
  [[nodiscard]] const float* find(const V3d& p, const V3d& offset) const noexcept {
    for (const Cells& level : levels)
      for (const V3d& at : {p + offset * level.edge(), p})
        if (const float* radius = level.find(at)) return radius;
    return nullptr;
  }
  [[nodiscard]] std::uint64_t hash() const noexcept {
    std::uint64_t h = 0;
    for (const Cells& level : levels) h = mix(h, level.hash());
    return h;
  }
};

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
  // How far the kernel of a photon there reaches when radii have shrunk to `scale`; `needed`: by Disks.
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
  DiskReach(const DiskBounds& bounds, const Disks& sharp, const Disks& soft, float scale) noexcept
      : bounds_(bounds), sharp_(sharp), soft_(soft), scale_(scale) {}
  [[nodiscard]] float operator()(const Photon& photon) const noexcept;

 private:
  const DiskBounds& bounds_;
  const Disks &sharp_, &soft_;
  float scale_;
};

// Photons of the pilot, of which `held` are to lie on a disk.
struct DiskSizing {
  std::span<const std::vector<Photon>> photons;
  std::span<const V3d> places;  // where disks may lie
  unsigned arrivals;            // which photons count, bit set
  double held;
  // radii at a typical place (m): a common one, how far to look for photons first, and how far at most
  double common, near, widest;
};
[[nodiscard]] Disks size_disks(const DiskSizing& asked, ThreadPool& pool, const std::atomic<bool>& cancel);

}  // namespace sluice
