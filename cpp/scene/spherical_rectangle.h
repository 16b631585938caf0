// SPDX-License-Identifier: GPL-3.0-or-later
// Uniform sampling of the solid angle of a rectangle (Ureña, Fajardo, King 2013, "An area-preserving
// parametrization for spherical rectangles"), seen from the origin: the rectangle lies at distance z in
// front, [x0, x1] × [y0, y1] in its own plane.
#pragma once
#include <algorithm>

#include "base/math.h"

namespace sluice {

class SphericalRectangle {
 public:
  SphericalRectangle(double x0, double x1, double y0, double y1, double z) noexcept
      : x0_(x0), x1_(x1), y0_(y0), y1_(y1), z_(-z) {
    // normals of the four planes through the origin and an edge; only their z is needed (§4 of theirs)
    const double zz = z * z;
    const double n0 = -y0 / std::sqrt(zz + y0 * y0), n1 = x1 / std::sqrt(zz + x1 * x1);
    const double n2 = y1 / std::sqrt(zz + y1 * y1), n3 = -x0 / std::sqrt(zz + x0 * x0);
    const auto angle = [](double a, double b) { return std::acos(std::clamp(-a * b, -1.0, 1.0)); };
    const double g0 = angle(n0, n1), g1 = angle(n1, n2), g2 = angle(n2, n3), g3 = angle(n3, n0);
    b0_ = n0, b1_ = n2;
    k_ = 2 * std::numbers::pi - g2 - g3;
    solid_angle_ = g0 + g1 - k_;
  }

  [[nodiscard]] double solid_angle() const noexcept { return solid_angle_; }

  // A point of the rectangle, density 1 / solid_angle() per solid angle.
  [[nodiscard]] V2d sample(const V2f& u) const noexcept {
    const double au = u.x * solid_angle_ + k_;
    const double fu = (std::cos(au) * b0_ - b1_) / std::sin(au);
    const double cu = std::clamp((fu > 0 ? 1.0 : -1.0) / std::sqrt(fu * fu + b0_ * b0_), -1.0, 1.0);
    const double xu = std::clamp(-(cu * z_) / std::max(std::sqrt(1 - cu * cu), 1e-300), x0_, x1_);
    const double d2 = xu * xu + z_ * z_;
    const double h0 = y0_ / std::sqrt(d2 + y0_ * y0_), h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
    const double hv = h0 + u.y * (h1 - h0), hv2 = hv * hv;
    const double yv = hv2 < 1 - 1e-12 ? hv * std::sqrt(d2 / (1 - hv2)) : y1_;
    return {xu, std::clamp(yv, y0_, y1_)};
  }

 private:
  double x0_, x1_, y0_, y1_, z_;
  double b0_, b1_, k_, solid_angle_;
};

}  // namespace sluice
