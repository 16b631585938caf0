// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/light_trust.h"

#include <algorithm>

#include "transport/pass.h"

namespace sluice {
namespace {

constexpr double hidden_variance = 1;  // of a sample at y, against the square of its mean: photons leave a tenth of that
constexpr float least_trust = 0.05f;   // of that of the most trusted light: one that was not found may still be there
constexpr std::size_t points_per_light = 2048;

// One sample of the irradiance by a light, luminous.
double irradiance(const Scene& scene, int light, const Hit& at, const Sampler& sampler) {
  const auto sample = sample_direct(scene, light, at.position, sampler.first(0), sampler.pair(1));
  const float cosine = sample ? sample->wi.dot(at.ng) : 0;
  if (!(cosine > 0) || !(sample->pdf > 0)) return 0;
  const bool is_shadowed = scene.lights()[static_cast<std::size_t>(light)].casts_shadow;
  const auto left = is_shadowed ? scene.transmittance(ray_from(at, sample->wi, sample->distance)) : Color(1);
  return left ? luminance(sample->radiance * *left) * cosine / sample->pdf : 0;
}

// Sums over the points, of two samples at each.
struct Findings {
  double variance = 0, square_of_mean = 0;
  double square_of_bound = 0;  // of what the light could do there
};

}  // namespace

LightTrusts try_lights(const Scene& scene, const TransportSettings& settings, const Effects& effects, std::span<const Hit> seen, const std::atomic<bool>& cancel) {
  LightTrusts trust;
  const std::size_t lights = scene.lights().size(), step = std::max<std::size_t>(1, seen.size() / points_per_light);
  if (lights > few_lights || seen.empty()) return trust;
  for (std::size_t l = 0; l < lights; ++l) {
    const Light& light = scene.lights()[l];
    Findings sum;
    for (std::size_t i = 0; i < seen.size() && !cancel; i += step) {
      const std::uint64_t key = key_of(settings.seed, PilotPurpose::Lights, i);
      const auto sample = [&](std::size_t index) { return irradiance(scene, static_cast<int>(l), seen[i], Sampler(key, static_cast<std::uint32_t>(index))); };
      const double a = sample(2 * l), b = sample(2 * l + 1);
      sum.variance += square(a - b) / 2, sum.square_of_mean += a * b;
      sum.square_of_bound += square(static_cast<double>(importance(light, seen[i].position, seen[i].ng)));
    }
    // The sky of a room is seen through its window, a bulb through its shade: most shadow segments to it end on the way, where photons
    // find the surfaces that it lights.
    const bool is_hidden = effects.indirect && !is_delta(light) && light.casts_shadow && sum.variance > hidden_variance * sum.square_of_mean;
    trust.at_v.push_back(sum.square_of_bound > 0 ? static_cast<float>(std::sqrt(sum.square_of_mean / sum.square_of_bound)) : 0);
    trust.at_y.push_back(is_hidden ? 0 : 1);
  }
  const float least = least_trust * std::ranges::max(trust.at_v);
  for (std::size_t l = 0; l < lights; ++l) {
    trust.at_v[l] = least > 0 ? std::max(trust.at_v[l], least) : 1;
    trust.at_y[l] *= trust.at_v[l];
  }
  return trust;
}

}  // namespace sluice
