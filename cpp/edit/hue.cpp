// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/hue.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sluice {

namespace {

// One channel of the HSV hexagon of hue h in [0, 6): 1 at its own third, 0 opposite.
double hexagon(double n, double h) noexcept {
  double k = n + h;
  if (k >= 6) k -= 6;
  return 1 - std::clamp(std::min(k, 4 - k), 0.0, 1.0);
}

}  // namespace

Color apply_hue(const Color& color, float angle_rad) noexcept {
  if (angle_rad == 0 || !std::isfinite(angle_rad) || !is_finite(color)) return color;
  if (color.x == color.y && color.y == color.z) return color;
  const double r = std::max(0.0f, color.x), g = std::max(0.0f, color.y), b = std::max(0.0f, color.z);
  const double high = std::max({r, g, b}), low = std::min({r, g, b}), range = high - low;
  if (!(range > 0)) return Color(static_cast<float>(r), static_cast<float>(g), static_cast<float>(b));

  double h = high == r ? (g - b) / range : high == g ? 2 + (b - r) / range : 4 + (r - g) / range;
  h += 3 * std::numbers::inv_pi * angle_rad;
  h -= 6 * std::floor(h / 6);
  if (!(h < 6)) h = 0;  // a tiny negative angle rounds up to 6

  // f(n) of the hexagon counts from the opposite side: k = (n + h) mod 6 with n = 5, 3, 1 for red, green,
  // blue.
  const double turned[] = {low + range * hexagon(5, h), low + range * hexagon(3, h),
                           low + range * hexagon(1, h)};
  const auto luma = [](double x, double y, double z) { return 0.2126 * x + 0.7152 * y + 0.0722 * z; };
  const double scale = luma(r, g, b) / luma(turned[0], turned[1], turned[2]);
  return Color(static_cast<float>(turned[0] * scale), static_cast<float>(turned[1] * scale),
               static_cast<float>(turned[2] * scale));
}

}  // namespace sluice
