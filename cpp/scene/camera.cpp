// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/camera.h"

#include <algorithm>

#include "base/sampling.h"

namespace sluice {

// Blender's rules (BKE_camera_params): the sensor's larger or chosen side spans the view; Auto always reads
// the sensor's width; shifts count in units of that side; pixels need not be square. The matrix' scale is
// ignored.
Camera::Camera(const CameraDescription& camera, const FrameDescription& frame, const V3d& centre) {
  const auto axis = [&](int row) {
    return V3d(camera.matrix[row][0], camera.matrix[row][1], camera.matrix[row][2]).normalized();
  };
  right_ = V3f(axis(0)), up_ = V3f(axis(1)), forward_ = V3f(-axis(2));
  eye_ = V3d(camera.matrix[3][0], camera.matrix[3][1], camera.matrix[3][2]) - centre;
  perspective_ = camera.kind == CameraKind::Perspective;

  const double aspect = static_cast<double>(frame.pixel_aspect_y) / frame.pixel_aspect_x;
  const double width = frame.width, height = aspect * frame.height;  // in pixel widths
  bool horizontal = camera.sensor_fit == SensorFit::Horizontal;
  if (camera.sensor_fit == SensorFit::Auto) horizontal = width >= height;
  const double sensor = camera.sensor_fit == SensorFit::Vertical ? camera.sensor_height : camera.sensor_width;
  const double across = horizontal ? width : height;
  // of a pixel width
  const double unit =
      (perspective_ ? sensor / camera.lens : static_cast<double>(camera.ortho_scale)) / across;
  step_x_ = unit, step_y_ = unit * aspect;
  low_x_ = (camera.shift_x * across - width / 2) * unit;
  low_y_ = (camera.shift_y * across - height / 2) * unit;

  const double x = std::max(std::abs(low_x_), std::abs(low_x_ + step_x_ * frame.width)),
               y = std::max(std::abs(low_y_), std::abs(low_y_ + step_y_ * frame.height));
  min_cosine_ = 1 / std::sqrt(1 + x * x + y * y);

  clip_start_ = camera.clip_start, clip_end_ = camera.clip_end;
  aperture_ = camera.aperture_radius, focus_ = camera.focus_distance;
  blades_ = camera.aperture_blades >= 3 ? camera.aperture_blades : 0;
  rotation_ = camera.aperture_rotation;
  inverse_ratio_ = camera.aperture_ratio > 0 ? 1 / camera.aperture_ratio : 1;
}

// A disk, or a regular polygon of as many corners as blades, squeezed by the aperture's ratio (Cycles'
// camera_sample_aperture).
V2f Camera::sample_lens(const V2f& u) const noexcept {
  V2f p;
  if (blades_ == 0) {
    p = sample_disk(u);
  } else {
    const float part = u.x * static_cast<float>(blades_), corner = std::floor(part);
    // weights of the corners of one triangle of the fan
    const float root = std::sqrt(part - corner), a = 1 - root, b = u.y * root;
    const float wedge = pi / static_cast<float>(blades_);
    const V2f q((a + b) * std::cos(wedge), (a - b) * std::sin(wedge));
    const float turn = rotation_ + 2 * corner * wedge, c = std::cos(turn), s = std::sin(turn);
    p = {c * q.x - s * q.y, s * q.x + c * q.y};
  }
  p.x *= inverse_ratio_;
  return p * aperture_;
}

Ray Camera::generate(float x, float y, const V2f& lens) const noexcept {
  const double px = low_x_ + step_x_ * x, py = low_y_ + step_y_ * y;
  const V3d right(right_), up(up_), forward(forward_);
  V3d origin = eye_, towards = forward;
  if (perspective_)
    towards += right * px + up * py;
  else
    origin += right * px + up * py;
  if (aperture_ > 0) {
    const V2f p = sample_lens(lens);
    const V3d focus = origin + towards * static_cast<double>(focus_);
    origin += right * static_cast<double>(p.x) + up * static_cast<double>(p.y);
    towards = (focus - origin) / static_cast<double>(focus_);
  }
  // `towards` advances by 1 along the axis
  const double length = towards.length();
  const V3d direction = towards / length;
  const double t_max = (static_cast<double>(clip_end_) - clip_start_) * length;
  return {.origin = origin + towards * static_cast<double>(clip_start_),
          .direction = V3f(direction),
          .t_max = t_max,
          .from_camera = true};
}

double Camera::depth(const V3d& position) const noexcept { return (position - eye_).dot(V3d(forward_)); }

// A pixel of the view plane at distance 1 subtends pixel² cos³.
double Camera::footprint(const V3d& position) const noexcept {
  const double pixel = std::sqrt(step_x_ * step_y_), distance = (position - eye_).length();
  if (!perspective_ || !(distance > 0)) return perspective_ ? 0 : pixel;
  const double cosine = std::max(depth(position) / distance, min_cosine_);
  return pixel * distance * cosine * std::sqrt(cosine);
}

// Along the ray it grows by pixel c^(3/2), across by pixel 3/2 s c^(1/2), s and c the sine and cosine to the
// axis: together the most at c = √0.6.
double Camera::footprint_slope() const noexcept {
  return perspective_ ? 1.079 * std::sqrt(step_x_ * step_y_) : 0;
}

std::optional<V2d> Camera::project(const V3d& position) const noexcept {
  const V3d to = position - eye_;
  const double z = to.dot(V3d(forward_));
  if (perspective_ && !(z > 0)) return {};
  const double scale = perspective_ ? 1 / z : 1;
  return V2d((to.dot(V3d(right_)) * scale - low_x_) / step_x_, (to.dot(V3d(up_)) * scale - low_y_) / step_y_);
}

bool Camera::is_invertible() const noexcept {
  constexpr float right_angle = 1e-5f;
  return clip_start_ >= 0 && std::abs(right_.dot(up_)) < right_angle &&
         std::abs(up_.dot(forward_)) < right_angle && std::abs(forward_.dot(right_)) < right_angle;
}

// The circle of confusion: the lens point p sees at pixel x what lies at (x z + p (1 - z / focus)) on a plane
// at depth z.
double Camera::blur(double depth) const noexcept {
  if (!(aperture_ > 0)) return 0;
  const double out_of_focus =
      std::abs(perspective_ ? 1 / depth - 1 / static_cast<double>(focus_) : 1 - depth / focus_);
  return aperture_ * std::max(1.0f, inverse_ratio_) * out_of_focus / std::min(step_x_, step_y_);
}

// Cycles' pixel filters: Blackman-Harris over twice Blender's Filter Size, or a box of one pixel. The two
// axes are independent. The window is symmetric: one half is tabulated, as the distance from the edge over
// the fourth root of the mass up to there, which is about linear where the window is nearly 0.
PixelFilter::PixelFilter(const FrameDescription& frame) {
  if (frame.filter_box) return;
  width_ = 2 * frame.filter_width;
  constexpr std::size_t fine = 8192, steps = 512;
  std::vector<double> mass(fine + 1, 0.0);  // over [0, i / fine] of half the width, from the edge
  const auto window = [](double x) {
    const double a = std::numbers::pi * x;
    return 0.35875 - 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) - 0.01168 * std::cos(3 * a);
  };
  for (std::size_t i = 0; i < fine; ++i)
    mass[i + 1] = mass[i] + window((static_cast<double>(i) + 0.5) / fine);
  edge_distance_.resize(steps + 1);
  std::size_t at = 0;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double target = mass[fine] * std::pow(static_cast<double>(i) / steps, 4);
    while (at + 1 < fine && mass[at + 1] < target) ++at;
    const double part = (target - mass[at]) / (mass[at + 1] - mass[at]);
    edge_distance_[i] =
        static_cast<float>((static_cast<double>(at) + std::clamp(part, 0.0, 1.0)) / (2 * fine));
  }
}

V2f PixelFilter::sample_filter(const V2f& u) const noexcept {
  if (edge_distance_.empty()) return {width_ * (u.x - 0.5f), width_ * (u.y - 0.5f)};
  const auto one = [&](float x) {
    const float tail = 2 * std::min(x, 1 - x);
    const float at = std::sqrt(std::sqrt(tail)) * static_cast<float>(edge_distance_.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(at), edge_distance_.size() - 2);
    const float distance =
        edge_distance_[i] + (at - static_cast<float>(i)) * (edge_distance_[i + 1] - edge_distance_[i]);
    return width_ * (x < 0.5f ? distance - 0.5f : 0.5f - distance);
  };
  return {one(u.x), one(u.y)};
}

}  // namespace sluice
