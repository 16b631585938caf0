// SPDX-License-Identifier: GPL-3.0-or-later
// The statistics of the sampler tests: chi² with pooled cells, and the directions it is fed.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/random.h"
#include "shading/lobes.h"

namespace sluice::test {

// Upper tail of the chi² distribution, by Wilson & Hilferty's cube root (good to 1e-3 of probability for the
// degrees met here).
inline double chi2_tail(double chi2, double degrees) {
  const double z = (std::cbrt(chi2 / degrees) - (1 - 2 / (9 * degrees))) / std::sqrt(2 / (9 * degrees));
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

// p-value of counts against expected counts; cells expecting fewer than 5 are pooled. A full cell that
// expects nothing gives 0.
inline double chi2_p(const std::vector<double>& counts, const std::vector<double>& expected) {
  double chi2 = 0, pooled_count = 0, pooled_expected = 0;
  int cells = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (expected[k] < 5) {
      pooled_count += counts[k];
      pooled_expected += expected[k];
      continue;
    }
    chi2 += square(counts[k] - expected[k]) / expected[k];
    ++cells;
  }
  if (pooled_expected >= 5) {
    chi2 += square(pooled_count - pooled_expected) / pooled_expected;
    ++cells;
  } else if (pooled_count > pooled_expected + 6 * std::sqrt(pooled_expected + 1)) {
    return 0;
  }
  return cells > 1 ? chi2_tail(chi2, cells - 1) : 1;
}

inline V3f direction(double mu, double phi = 0.7) {
  const double r = std::sqrt(std::max(0.0, 1 - mu * mu));
  return {static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
          static_cast<float>(mu)};
}

// Independent uniform numbers (not the low-discrepancy ones: chi² wants independence).
struct Uniform {
  std::uint64_t state;
  float next() { return to_unit(static_cast<std::uint32_t>(mix(state++) >> 32)); }
  V2f pair() {
    const float x = next();
    return {x, next()};
  }
};

// A grid over directions i. Diffuse shapes: even in cos θ and φ. Microfacet shapes: over half vectors, even
// in x = 1 - 1 / sqrt(1 + r²), r = slope / alpha, so that a lobe 1e-3 wide is resolved as well as a wide one
// and the density stays bounded at r = infinity.
struct Cells {
  int rows = 24, columns = 24;
  ggx::Alpha alpha{0, 0};  // 0: even over directions
  float eta = 0;           // > 0: half vectors of refraction
  bool below = false;      // directions with z < 0

  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(rows * columns); }

  [[nodiscard]] std::size_t cell_of(const V3f& o, const V3f& i) const {
    double x, phi;
    if (alpha.x == 0) {
      x = std::abs(i.z);
      phi = std::atan2(i.y, i.x);
    } else {
      V3d h = eta > 0 ? V3d(o) + V3d(i) * static_cast<double>(eta) : V3d(o) + V3d(i);
      if (h.z < 0) h = -h;
      const double sx = h.x / h.z / alpha.x, sy = h.y / h.z / alpha.y, r2 = sx * sx + sy * sy;
      x = 1 - 1 / std::sqrt(1 + r2);
      phi = std::atan2(sy, sx);
    }
    const int row = std::clamp(static_cast<int>(x * rows), 0, rows - 1);
    const int column =
        std::clamp(static_cast<int>((phi / (2 * std::numbers::pi) + 0.5) * columns), 0, columns - 1);
    return static_cast<std::size_t>(row * columns + column);
  }

  // Probability that `density` (per solid angle of i) gives each cell, by the midpoint rule on `fine`² points
  // a cell.
  template <class Density>
  [[nodiscard]] std::vector<double> integrate(const V3f& o, Density&& density, int fine = 16) const {
    std::vector<double> p(count(), 0.0);
    for (int a = 0; a < rows * fine; ++a)
      for (int b = 0; b < columns * fine; ++b) {
        const double x = (a + 0.5) / (rows * fine),
                     phi = ((b + 0.5) / (columns * fine) - 0.5) * 2 * std::numbers::pi;
        V3f i;
        const double jacobian = solid_angle(o, x, phi, i);
        if (jacobian > 0)
          p[static_cast<std::size_t>((a / fine) * columns + b / fine)] +=
              density(i) * jacobian * 2 * std::numbers::pi / (rows * fine * columns * fine);
      }
    return p;
  }

 private:
  // dω_i / (dx dφ), and i; 0 where there is no i.
  [[nodiscard]] double solid_angle(const V3f& o, double x, double phi, V3f& i) const {
    if (alpha.x == 0) {
      i = direction(below ? -x : x, phi);
      return 1;
    }
    const double r = std::sqrt(1 / square(1 - x) - 1), sx = r * std::cos(phi) * alpha.x,
                 sy = r * std::sin(phi) * alpha.y;
    const V3d h = V3d(sx, sy, 1) / std::sqrt(1 + sx * sx + sy * sy), od(o);
    // slope area per dx dφ
    const double slopes = alpha.x * alpha.y / ((1 - x) * square(1 - x)), oh = od.dot(h);
    if (oh <= 0) return 0;
    const double half = slopes * h.z * h.z * h.z;
    if (eta == 0) {
      i = V3f(h * (2 * oh) - od);
      return half * 4 * oh;
    }
    const double e = eta, t2 = 1 - (1 - oh * oh) / (e * e);
    if (t2 <= 0) return 0;
    const V3d refracted = h * (oh / e - std::sqrt(t2)) - od / e;
    i = V3f(refracted);
    const double ih = refracted.dot(h);
    return half * square(oh + e * ih) / (e * e * -ih);
  }
};

}  // namespace sluice::test
