// SPDX-License-Identifier: GPL-3.0-or-later
// Comparing means of independent batches: Welch's test, Šidák's correction, quantiles of Student's t.
#pragma once
#include <cmath>
#include <span>

namespace sluice::oracle {

struct Sample {
  double mean = 0, variance = 0;  // of the mean
  int count = 0;
};

inline Sample summarise(std::span<const double> values) {
  Sample s{.count = static_cast<int>(values.size())};
  for (const double v : values) s.mean += v / s.count;
  for (const double v : values)
    s.variance += (v - s.mean) * (v - s.mean) / (static_cast<double>(s.count) * (s.count - 1));
  return s;
}

// Regularised incomplete beta function, by its continued fraction (Lentz).
inline double incomplete_beta(double a, double b, double x) {
  if (x <= 0 || x >= 1) return x <= 0 ? 0 : 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - incomplete_beta(b, a, 1 - x);
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log(1 - x)) /
      a;
  double f = 1, c = 1, d = 0;
  for (int i = 0; i <= 500; ++i) {
    const int m = i / 2;
    const double numerator = i == 0       ? 1
                             : i % 2 == 0 ? m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
                                          : -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 + numerator * d, d = 1 / (std::abs(d) < 1e-300 ? 1e-300 : d);
    c = 1 + numerator / c, c = std::abs(c) < 1e-300 ? 1e-300 : c;
    f *= c * d;
    if (std::abs(1 - c * d) < 1e-13) break;
  }
  return front * (f - 1);
}

// Two-sided p of Student's t.
inline double student_p(double t, double freedom) {
  return incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t * t));
}

// t with that two-sided p.
inline double student_t(double p, double freedom) {
  double low = 0, high = 1e6;
  for (int i = 0; i < 200; ++i) (student_p((low + high) / 2, freedom) > p ? low : high) = (low + high) / 2;
  return (low + high) / 2;
}

// Per comparison, so that `comparisons` independent ones err with probability `family`.
inline double sidak(double family, int comparisons) { return -std::expm1(std::log1p(-family) / comparisons); }

struct Difference {
  // error: standard error; Welch & Satterthwaite's degrees of freedom
  double value = 0, error = 0, freedom = 1;
  [[nodiscard]] double p() const {
    return error > 0 ? student_p(value / error, freedom) : value == 0 ? 1 : 0;
  }
  [[nodiscard]] double margin(double at_p) const { return error > 0 ? student_t(at_p, freedom) * error : 0; }
};

inline Difference difference(const Sample& a, const Sample& b) {
  Difference d{a.mean - b.mean, std::sqrt(a.variance + b.variance), 1};
  const double sum = a.variance + b.variance,
               parts = a.variance * a.variance / (a.count - 1) + b.variance * b.variance / (b.count - 1);
  if (parts > 0) d.freedom = sum * sum / parts;
  return d;
}

}  // namespace sluice::oracle
