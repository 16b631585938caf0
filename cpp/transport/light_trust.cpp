// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/light_trust.h"

#include <algorithm>

#include "transport/pass.h"

namespace sluice {
namespace {

constexpr double hidden_variance = 1;  // of a sample at y, against the square of its mean: photons leave a tenth of that
constexpr float least_trust = 0.05f;   // of that of the most trusted light: one that was not found may still be there
constexpr float least_in_cell = 0.15f;  // of its trust anywhere: what 10 points in a cell did not find may still be there
constexpr double weight_of_anywhere = 1;  // against that of one point in a cell
constexpr std::size_t most_trials = 32768, trials_of_one_light = 2048;
constexpr double cell_of_extent = 0.02;

// One sample of the irradiance by a light, luminous.
double irradiance(const Scene& scene, int light, const Hit& at, const Sampler& sampler) {
  const auto sample = sample_direct(scene, light, at.position, sampler.first(0), sampler.pair(1));
  const float cosine = sample ? sample->wi.dot(at.ng) : 0;
  if (!(cosine > 0) || !(sample->pdf > 0)) return 0;
  const bool is_shadowed = scene.lights()[static_cast<std::size_t>(light)].casts_shadow;
  const auto left = is_shadowed ? scene.transmittance(ray_from(at, sample->wi, sample->distance)) : Color(1);
  return left ? luminance(sample->radiance * *left) * cosine / sample->pdf : 0;
}

// What two samples at a point tell of a light.
struct Trial {
  double variance = 0, square_of_mean = 0;
  double square_of_bound = 0;  // of what the light could do there

  Trial& operator+=(const Trial& o) noexcept {
    variance += o.variance, square_of_mean += o.square_of_mean, square_of_bound += o.square_of_bound;
    return *this;
  }
  [[nodiscard]] Trial operator*(double by) const noexcept { return {variance * by, square_of_mean * by, square_of_bound * by}; }
  [[nodiscard]] float trust() const noexcept { return square_of_mean > 0 && square_of_bound > 0 ? static_cast<float>(std::sqrt(square_of_mean / square_of_bound)) : 0; }
};

Trial try_light(const Scene& scene, int light, const Hit& at, std::uint64_t key) {
  const auto sample = [&](int index) { return irradiance(scene, light, at, Sampler(key, static_cast<std::uint32_t>(2 * light + index))); };
  const double a = sample(0), b = sample(1);
  return {square(a - b) / 2, a * b, square(static_cast<double>(importance(scene.lights()[static_cast<std::size_t>(light)], at.position, at.ng)))};
}

// Rows of a number per light.
template <class T>
struct Table {
  std::size_t width;
  std::vector<T> values;
  [[nodiscard]] std::span<T> row(std::size_t i) noexcept { return std::span(values).subspan(i * width, width); }
  [[nodiscard]] std::size_t height() const noexcept { return values.size() / width; }
};

// A light that is not found here may still be here: a part of `anywhere` is left to it.
void trust_in_cell(std::span<const Trial> here, std::span<const Trial> anywhere, std::span<const float> trust_anywhere, std::span<float> trust) {
  for (std::size_t l = 0; l < trust.size(); ++l) {
    Trial sum = here[l];
    sum += anywhere[l] * weight_of_anywhere;
    trust[l] = std::max(sum.trust(), least_in_cell * trust_anywhere[l]);
  }
}

}  // namespace

LightTrusts try_lights(const Scene& scene, const TransportSettings& settings, const Effects& effects, std::span<const Hit> seen, ThreadPool& pool, const std::atomic<bool>& cancel) {
  const std::size_t lights = scene.lights().size();
  if (lights == 0 || lights > few_lights || seen.empty()) return {};
  const std::size_t most = lights == 1 ? trials_of_one_light : most_trials / lights, step = (seen.size() + most - 1) / most, points = (seen.size() + step - 1) / step;
  Table<Trial> trials{lights, std::vector<Trial>(points * lights)};
  pool.parallel_for(points, [&](std::size_t i, int) {
    for (std::size_t l = 0; l < lights && !cancel; ++l) trials.row(i)[l] = try_light(scene, static_cast<int>(l), seen[i * step], key_of(settings.seed, PilotPurpose::Lights, i));
  });

  NumberedCells<std::uint32_t> cells(cell_of_extent * scene.extent());
  Table<Trial> sums{lights, std::vector<Trial>(lights)};  // the first row: anywhere
  for (std::size_t i = 0; i < points; ++i) {
    std::uint32_t& cell = cells.at(seen[i * step].position);
    if (cell == 0) cell = static_cast<std::uint32_t>(sums.height()), sums.values.resize(sums.values.size() + lights);
    for (std::size_t l = 0; l < lights; ++l) sums.row(0)[l] += trials.row(i)[l], sums.row(cell)[l] += trials.row(i)[l];
  }

  Table<float> trust{lights, std::vector<float>(sums.values.size())};
  std::vector<char> hidden;
  const std::span anywhere = sums.row(0);
  const std::span trust_anywhere = trust.row(0);
  for (std::size_t l = 0; l < lights; ++l) {
    const Light& light = scene.lights()[l];
    // The sky of a room is seen through its window, a bulb through its shade: most shadow segments to it end on the way, where photons
    // find the surfaces that it lights.
    hidden.push_back(effects.indirect && !is_delta(light) && light.casts_shadow && anywhere[l].variance > hidden_variance * anywhere[l].square_of_mean);
    trust_anywhere[l] = anywhere[l].trust(), anywhere[l] = anywhere[l] * (1.0 / static_cast<double>(points));
  }
  const float least = least_trust * std::ranges::max(trust_anywhere);
  for (float& of_light : trust_anywhere) of_light = least > 0 ? std::max(of_light, least) : 1;
  for (std::size_t cell = 1; cell < sums.height(); ++cell) trust_in_cell(sums.row(cell), anywhere, trust_anywhere, trust.row(cell));
  return {std::move(cells), std::move(trust.values), std::move(hidden)};
}

}  // namespace sluice
