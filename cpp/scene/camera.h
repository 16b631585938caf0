// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's cameras: continuous pixel coordinates of the full frame (row 0 at the bottom, pixel i covers [i,
// i + 1)) to rays, and back. A border is a crop: it changes which pixels are asked for, nothing here. Also
// the pixel filter, sampled so that all weights are 1.
#pragma once
#include <optional>
#include <vector>

#include "scene/description.h"
#include "scene/ray.h"

namespace sluice {

class Camera {
 public:
  Camera() = default;
  Camera(const CameraDescription& camera, const FrameDescription& frame, const V3d& centre);

  // starts on the near clip plane, ends on the far one
  [[nodiscard]] Ray generate(float x, float y, const V2f& lens) const noexcept;
  // without one, generate() reads no `lens`
  [[nodiscard]] bool has_lens() const noexcept { return aperture_ > 0; }
  // along the view axis, from the camera
  [[nodiscard]] double depth(const V3d& position) const noexcept;
  // to pixels, pinhole; empty: behind the camera
  [[nodiscard]] std::optional<V2d> project(const V3d& position) const noexcept;
  // project() undoes generate() for all that rays meet: not where a parent shears the axes, or rays start
  // behind the camera.
  [[nodiscard]] bool is_invertible() const noexcept;
  // pixels: most distance from project() at which the lens shows a point
  [[nodiscard]] double blur(double depth) const noexcept;
  [[nodiscard]] const V3d& position() const noexcept { return eye_; }
  // Size of a full-frame pixel's footprint (m) at a point, across the ray, told by the point alone: at its
  // straight distance, whatever mirrors may show it; outside of the picture as at its outermost corner.
  [[nodiscard]] double footprint(const V3d& position) const noexcept;
  [[nodiscard]] double footprint_slope() const noexcept;  // the most that it changes, per metre

 private:
  [[nodiscard]] V2f sample_lens(const V2f& u) const noexcept;

  V3d eye_{0};
  V3f right_{1, 0, 0}, up_{0, 1, 0}, forward_{0, 0, -1};
  bool perspective_ = true;
  // view plane: at distance 1 (perspective) or in metres (orthographic): x = low + step · pixel
  double low_x_ = 0, low_y_ = 0, step_x_ = 1, step_y_ = 1;
  float clip_start_ = 0.1f, clip_end_ = 1000;
  float aperture_ = 0, focus_ = 1, rotation_ = 0, inverse_ratio_ = 1;
  int blades_ = 0;
  double min_cosine_ = 1;  // between the axis and what the picture shows, through a pinhole
};

// Offset from a pixel's centre, distributed as the filter (Blackman-Harris, or a box).
class PixelFilter {
 public:
  PixelFilter() = default;
  explicit PixelFilter(const FrameDescription& frame);
  [[nodiscard]] V2f sample_filter(const V2f& u) const noexcept;
  [[nodiscard]] float reach() const noexcept { return width_ / 2; }  // pixels, each way

 private:
  float width_ = 1;
  std::vector<float> edge_distance_;  // empty: box
};

}  // namespace sluice
