// SPDX-License-Identifier: GPL-3.0-or-later
// The acceleration structure: nearest hit and blocked segment over triangles and one level of instances.
// embree.cpp is the only file that includes Embree (3 or 4). Knows no materials, no doubles: scene.cpp turns
// what it finds into hits.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/math.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace sluice {

// Who may be met by which rays.
inline constexpr unsigned mask_any = 1, mask_camera = 2, mask_shadow_opaque = 4, mask_shadow_transparent = 8;

// One thing to build: triangles in the scene's space, or a placed prototype. Its index is its instance.
struct AcceleratorItem {
  // one more V3f must be readable behind them; both spans must outlive the accelerator
  std::span<const V3f> positions;
  std::span<const std::array<std::uint32_t, 3>> triangles;
  int prototype = -1;  // index into the prototypes: then the spans above are empty
  M44d to_scene;       // of a prototype
  unsigned mask = mask_any;
};

struct RawHit {
  std::uint32_t instance, triangle;
  float t, u, v;
};

// A segment as the accelerator sees it.
struct RaySegment {
  V3f origin, direction;
  float t_max;
};
inline constexpr std::size_t packet_size = 8;

class Accelerator {
 public:
  Accelerator() = default;
  Accelerator(Accelerator&& other) noexcept;
  Accelerator& operator=(Accelerator&& other) noexcept;
  ~Accelerator();

  // False: `cancelled` said so. Throws SceneError when memory runs out.
  [[nodiscard]] bool build(std::span<const AcceleratorItem> prototypes,
                           std::span<const AcceleratorItem> items, int threads,
                           const std::function<bool()>& cancelled);

  // A ray that is not finite, has no direction or an empty range meets nothing: Embree may abort the process
  // on such (numerics R4).
  [[nodiscard]] std::optional<RawHit> nearest(const RaySegment& segment, unsigned mask) const noexcept;
  [[nodiscard]] bool blocked(const RaySegment& segment, unsigned mask) const noexcept;
  // Bit i: segments[i] is blocked. At most packet_size of them; fast if they run side by side.
  [[nodiscard]] unsigned blocked(std::span<const RaySegment> segments, unsigned mask) const noexcept;

 private:
  void release() noexcept;

  RTCDeviceTy* device_ = nullptr;
  RTCSceneTy* top_ = nullptr;
  std::vector<RTCSceneTy*> prototypes_;
};

}  // namespace sluice
