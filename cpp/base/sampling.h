// SPDX-License-Identifier: GPL-3.0-or-later
// Warps from the unit square, and discrete distributions. Densities are stated per function.
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "base/math.h"

namespace sluice {

// Uniform on the unit disk (Shirley & Chiu's concentric map); density 1 / pi.
[[nodiscard]] inline V2f sample_disk(const V2f& u) noexcept {
  const float x = 2 * u.x - 1, y = 2 * u.y - 1;
  if (x == 0 && y == 0) return {0, 0};
  const bool wide = std::abs(x) > std::abs(y);
  const float r = wide ? x : y;
  const float phi = wide ? (pi / 4) * (y / x) : (pi / 2) - (pi / 4) * (x / y);
  return {r * std::cos(phi), r * std::sin(phi)};
}

// Cosine-weighted directions around +z; density cos / pi.
[[nodiscard]] inline V3f sample_cosine(const V2f& u) noexcept {
  const V2f d = sample_disk(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}

// Uniform directions within a cone around +z, given 1 - cos of its half angle (kept small angles exact);
// density 1 / (2 pi (1 - cos)).
[[nodiscard]] inline V3f sample_cone(const V2f& u, float one_minus_cos) noexcept {
  const float h = u.x * one_minus_cos;  // 1 - cos(theta)
  const float r = std::sqrt(std::max(0.0f, h * (2 - h))), phi = 2 * pi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - h};
}
[[nodiscard]] inline float cone_pdf(float one_minus_cos) noexcept { return 1 / (2 * pi * one_minus_cos); }

// Uniform on the unit sphere; density 1 / (4 pi).
[[nodiscard]] inline V3f sample_sphere(const V2f& u) noexcept { return sample_cone(u, 2.0f); }

// A discrete distribution over [0, size) by its cumulative sums. All weights zero (or none) makes it empty().
class Distribution {
 public:
  Distribution() = default;
  explicit Distribution(std::span<const float> weights) {
    double sum = 0;
    cdf_.reserve(weights.size());
    for (float w : weights) cdf_.push_back(sum += std::isfinite(w) && w > 0 ? w : 0);
    total_ = sum;
    for (double& c : cdf_) c = sum > 0 ? c / sum : 0;
  }
  [[nodiscard]] bool empty() const noexcept { return !(total_ > 0); }
  [[nodiscard]] std::size_t size() const noexcept { return cdf_.size(); }
  [[nodiscard]] double total() const noexcept { return total_; }
  [[nodiscard]] float pmf(std::size_t i) const noexcept {
    assert(i < cdf_.size());
    return static_cast<float>(cdf_[i] - (i ? cdf_[i - 1] : 0));
  }

  struct Choice {
    std::size_t index;
    float pmf, u;  // u: the random number, stretched to [0, 1) again
  };
  [[nodiscard]] Choice sample(double u) const noexcept {
    assert(!empty() && u >= 0 && u < 1);
    auto it = std::upper_bound(cdf_.begin(), cdf_.end(), u);
    // rounding: back to an entry of weight > 0
    while (it == cdf_.end() || (it != cdf_.begin() && *it == *(it - 1))) --it;
    const auto i = static_cast<std::size_t>(it - cdf_.begin());
    const double low = i ? cdf_[i - 1] : 0, width = cdf_[i] - low;
    return {i, static_cast<float>(width),
            std::clamp(static_cast<float>((u - low) / width), 0.0f, 0x1.fffffep-1f)};
  }

 private:
  std::vector<double> cdf_;
  double total_ = 0;
};

}  // namespace sluice
