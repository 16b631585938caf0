// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/photons/disks.h"

#include <algorithm>

#include "scene/camera.h"

namespace sluice {
namespace {

// Radii are bounded by parts of the picture, for pictures so small that some pixels are much of them, and by
// parts of the distance to the camera: else footprints would change too much along a disk.
constexpr float max_soft_of_picture = 1.0f / 8, max_of_distance = 0.4f;
// The kernel falls to 0 so many radii away (√1.5; density.h).
constexpr float round_reach = 1.2247449f;
// Positions are rounded to 2⁻²⁴ of their coordinates: far below this part of them photons of one surface
// would no longer share a disk (numerics D6).
constexpr float min_of_coordinate = 0x1p-20f;
constexpr float rounding = 1.001f;

float min_radius(const V3f& p) noexcept { return min_of_coordinate * p.length(); }

// Anywhere on the surface within half a cell, by a hash of the place; of the digits alone, so that the size
// of the scene is no matter.
V3d offset_of_lookup(const Photon& photon) noexcept {
  const auto digits = [](float x) {
    return static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(x) & 0x7fffffu);
  };
  const std::uint64_t bits =
      mix(mix(digits(photon.position.x), digits(photon.position.y)), digits(photon.position.z));
  const float s = to_unit(static_cast<std::uint32_t>(bits)) - 0.5f,
              t = to_unit(static_cast<std::uint32_t>(bits >> 32)) - 0.5f;
  const Frame along(unpack_direction(photon.normal));
  return V3d(along.t * s + along.b * t);
}

}  // namespace

DiskBounds::DiskBounds(const Camera& camera, const FrameDescription& frame, const TransportSettings& settings)
    : camera_(camera), slope_(static_cast<float>(camera.footprint_slope())) {
  const float side = std::sqrt(static_cast<float>(frame.width) * static_cast<float>(frame.height));
  const float ever = slope_ > 0 ? max_of_distance / (round_reach * slope_) : infinity;
  common_ = std::min({settings.caustic_radius_factor, max_disk_of_picture * side, ever});
  narrowest_ = common_ / settings.caustic_radius_range;
  widest_ = std::min(settings.caustic_radius_range * common_, ever);
  widest_soft_ =
      std::max(widest_, std::min({settings.soft_range * widest_, max_soft_of_picture * side, ever}));
}

float DiskBounds::footprint(const V3f& p) const noexcept {
  return static_cast<float>(camera_.footprint(V3d(p)));
}

float DiskBounds::reach(const V3f& p, bool soft, const float* needed, float scale) const noexcept {
  const float pixel = footprint(p), most = widest(pixel, soft);
  const float radius = needed ? std::clamp(*needed, narrowest_ * pixel, most) : most;
  return round_reach * std::max(radius * scale, min_radius(p));
}

// A photon at p, d from v, has a footprint within slope · d of that at v, and d is at most its reach R: R ≤ k
// (f + slope R), k the widest reach in footprints.
Reaches DiskBounds::around(const V3f& v, float scale) const noexcept {
  const float pixel = footprint(v), k = round_reach * scale * widest_soft_,
              floor = round_reach * min_radius(v);
  const float most = std::max(k * pixel / (1 - k * slope_), floor);
  const float least =
      std::max(round_reach * scale * narrowest_ * std::max(0.0f, pixel - slope_ * most), floor);
  return {least / rounding, most * rounding};
}

float DiskReach::operator()(const Photon& photon) const noexcept {
  const bool soft = soft_arrivals & bit_of(photon.arrival);
  return bounds_.reach(photon.position, soft,
                       (soft ? soft_ : sharp_).find(V3d(photon.position), offset_of_lookup(photon)), scale_);
}

}  // namespace sluice
