// SPDX-License-Identifier: GPL-3.0-or-later
// The error of a picture, told from the picture itself (design §5): noise by streams of passes that are
// independent of each other, an honest estimate under randomised quasi-Monte Carlo; bias by what kernels of
// two widths make of the same photons (density.h).
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>

#include "base/colour.h"
#include "base/math.h"

namespace sluice {

inline constexpr int stream_count = 4;

// Variance relative to the mean, as the error of a picture counts it, mean over the channels: what is dark
// counts as a tenth of the picture's mean luminance.
[[nodiscard]] inline double relative_variance(const V3d& variance, const V3d& mean,
                                              double image_mean) noexcept {
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += variance[c] / (square(mean[c]) + square(image_mean / 10)) / 3;
  return sum;
}

// Means of something by stream: estimates of it that are independent of each other.
template <class T>
using Streams = std::array<T, stream_count>;

// What a pixel's errors are relative to, beside itself: the mean of its neighbours and that of the picture
// (luminance), of which a tenth counts at least.
struct Surroundings {
  V3d neighbours;
  double image_mean;
};

// Relative variance of the mean of all streams of one part of the pixel's light, mean over all pairs of
// them: a pair's half squared difference is the variance of one stream. It is relative to the square of
// what the pixel is, and that the other streams say, never those two: where one path in many brings a
// thousand times the rest, the pixel that found it would have an error of 100 % and no more. As far as the
// two differ, the others know too little as well, and the neighbours are asked.
[[nodiscard]] inline double relative_noise(const Streams<V3d>& part, const Streams<V3d>& pixel,
                                           const Surroundings& place) noexcept {
  double sum = 0;
  for (std::size_t a = 0; a < stream_count; ++a)
    for (std::size_t b = a + 1; b < stream_count; ++b) {
      V3d value;
      for (int c = 0; c < 3; ++c) {
        double others = 0;
        for (std::size_t s = 0; s < stream_count; ++s)
          if (s != a && s != b) others += pixel[s][c] / (stream_count - 2);
        // their mean's variance is half a stream's, as far as a and b tell
        const double trust = square(others), noise = square(pixel[a][c] - pixel[b][c]) / 4;
        value[c] = trust + noise > 0 ? (trust * others + noise * place.neighbours[c]) / (trust + noise) : 0;
      }
      const V3d off = part[a] - part[b];
      sum += relative_variance(off * off / (2 * stream_count), value, place.image_mean);
    }
  constexpr int pairs = stream_count * (stream_count - 1) / 2;
  return sum / pairs;
}
// The square of a part's bias, without the noise of its estimates: their products in pairs. Relative to the
// pixel's own mean: what a photon brings in one stream alone is no product, so that no rare path stands out.
[[nodiscard]] inline double relative_bias(const Streams<double>& bias, const Streams<V3d>& pixel,
                                          const Surroundings& place) noexcept {
  double sum = 0, squares = 0;
  V3d mean(0);
  for (std::size_t s = 0; s < stream_count; ++s) {
    sum += bias[s], squares += square(bias[s]);
    mean += pixel[s] / stream_count;
  }
  const double product = (square(sum) - squares) / (stream_count * (stream_count - 1));
  // Both are luminances: what is blurred has about the pixel's own colour.
  return product / (square(luminance(mean)) + square(place.image_mean / 10));
}

// Errors of pictures are told without the worst 0.1 % of their pixels: there one path in many brings so much
// that neither its error nor an estimate of it says anything of the others. So many of them count.
[[nodiscard]] inline std::size_t kept_by_trim(std::size_t pixels) noexcept { return pixels - pixels / 1000; }

}  // namespace sluice
