// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/gate.h"

#include <algorithm>

namespace sluice {

namespace {

constexpr float min_cosine_out = 1e-3f;  // design §4

V3d to_double(const V3f& v) noexcept { return {v.x, v.y, v.z}; }
V3f unit(const V3d& v) noexcept {
  const V3d n = v / v.length();  // at every gate, or frames of float descriptions drift (numerics P12)
  return {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
}

// NaN, negative and huge texels are clamped here too: numbers times texture (numerics P8).
float clamp_intensity(float x) noexcept { return x >= 0 ? std::min(x, max_intensity) : 0.0f; }

V2f to_float(const V2d& uv) noexcept { return {static_cast<float>(uv.x), static_cast<float>(uv.y)}; }

// Border of `width` half sides on one axis: 0 at the edge, 1 inside, smooth at both ends.
float soft_border(double x, float width) noexcept {
  const double from_edge = 1 - std::abs(2 * x - 1);
  const double s = std::min(1.0, from_edge / static_cast<double>(width));
  return static_cast<float>(s * s * (3 - 2 * s));
}

float intensity_at(const Exit& exit, const V2d& uv, std::span<const Image> images) noexcept {
  if (exit.intensity_texture < 0) return exit.intensity;
  const V2f at = to_float(uv);
  return clamp_intensity(
      exit.intensity *
      luminance(sample_clamped(images[static_cast<std::size_t>(exit.intensity_texture)], at.x, at.y)));
}

float hue_at(const Exit& exit, const V2d& uv, std::span<const Image> images) noexcept {
  if (exit.hue_shift == 0 || exit.hue_shift_texture < 0) return exit.hue_shift;
  const V2f at = to_float(uv);
  const float h = exit.hue_shift * luminance(sample_clamped(
                                       images[static_cast<std::size_t>(exit.hue_shift_texture)], at.x, at.y));
  return std::isfinite(h) ? h : 0.0f;
}

std::optional<QuadFrame> turn_at(const Exit& exit, const V2d& uv, std::span<const Image> images) noexcept {
  if (exit.normal_map < 0) return std::nullopt;
  const V2f at = to_float(uv);
  return normal_map_turn(sample_clamped(images[static_cast<std::size_t>(exit.normal_map)], at.x, at.y));
}

}  // namespace

QuadFrame normal_map_turn(const Color& texel) noexcept {
  const QuadFrame identity{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  V3d n(2.0 * texel.x - 1, 2.0 * texel.y - 1, 2.0 * texel.z - 1);
  // No normal points below its own surface: black and other texels that are none turn nothing.
  if (!is_finite(n) || !(n.z > 0)) return identity;
  n /= n.length();
  const double a = -1 / (1 + n.z), c = n.x * n.y * a;  // Duff et al. 2017, n.z > 0
  return {{1 + n.x * n.x * a, c, -n.x}, {c, 1 + n.y * n.y * a, -n.y}, n};
}

float entry_weight(const Edit& e, const V2d& uv) noexcept {
  return e.feather > 0 ? e.amount * soft_border(uv.x, e.feather) * soft_border(uv.y, e.feather) : e.amount;
}

std::optional<Passage> pass_forward(const Edit& e, int exit, const V2d& uv, const V3f& direction,
                                    std::span<const Image> images) noexcept {
  if (exit == straight_on) return Passage{e.entry.point(uv), direction, Color(1), 0, e.entry.group};
  const Exit& x = e.exits[static_cast<std::size_t>(exit)];
  V3d d = e.entry.frame.to_local(to_double(direction));  // T_d of the paper: B'_{W<-O} B_{I<-W} d
  if (const auto m = turn_at(x, uv, images)) {
    d = m->to_world(d);
    if (e.side == Side::Light && std::abs(d.z) < static_cast<double>(min_cosine_out)) return std::nullopt;
  }
  // view edits carry radiance (design §4)
  const float gain = intensity_at(x, uv, images) * (e.side == Side::Light ? x.area_ratio : 1.0f);
  return Passage{x.quad.point(uv), unit(x.quad.frame.to_world(d)), x.tint * gain, hue_at(x, uv, images),
                 x.quad.group};
}

std::optional<Passage> pass_backward(const Edit& e, int exit, const V2d& uv, const V3f& direction,
                                     std::span<const Image> images) noexcept {
  const Exit& x = e.exits[static_cast<std::size_t>(exit)];
  V3d d = x.quad.frame.to_local(to_double(direction));
  float gain = intensity_at(x, uv, images) * x.radiance_ratio;
  if (const auto m = turn_at(x, uv, images)) {
    const double cos_out = std::abs(d.z);
    if (cos_out < static_cast<double>(min_cosine_out)) return std::nullopt;
    d = m->to_local(d);
    // flux L A cos dω is what the law is about (design §4)
    gain *= static_cast<float>(std::abs(d.z) / cos_out);
  }
  return Passage{e.entry.point(uv), unit(e.entry.frame.to_world(d)), x.tint * gain, hue_at(x, uv, images),
                 e.entry.group};
}

}  // namespace sluice
