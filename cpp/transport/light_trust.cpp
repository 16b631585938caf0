// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/light_trust.h"

#include <algorithm>

#include "transport/pass.h"

namespace sluice {
namespace {

// of a sample at y, against the square of its mean: photons leave a tenth of that
constexpr double hidden_variance = 1;
// of that of the most trusted light: one that was not found may still be there
constexpr float least_trust = 0.05f;
// of its trust anywhere: what 10 points in a cell did not find may still be there
constexpr float least_in_cell = 0.15f;
constexpr std::size_t most_trials = 32768, trials_of_one_light = 2048;
constexpr double cell_of_extent = 0.02;

// One sample of the irradiance by a light, luminous; more than numbers hold: 0.
double irradiance(const Scene& scene, int light, const Hit& at, const Sampler& sampler) {
  const auto sample = sample_direct(scene, light, at.position, sampler.first(0), sampler.pair(1));
  const float cosine = sample ? sample->wi.dot(at.ng) : 0;
  if (!(cosine > 0) || !(sample->pdf > 0)) return 0;
  const bool is_shadowed = scene.lights()[static_cast<std::size_t>(light)].casts_shadow;
  const auto left = is_shadowed ? scene.transmittance(ray_from(at, sample->wi, sample->distance)) : Color(1);
  const double found =
      left ? static_cast<double>(luminance(sample->radiance * *left)) * cosine / sample->pdf : 0;
  return std::isfinite(found) ? found : 0;
}

// What two samples at a point tell of a light.
struct Trial {
  double variance = 0, square_of_mean = 0;
  double square_of_bound = 0;  // of what the light could do there

  Trial& operator+=(const Trial& o) noexcept {
    variance += o.variance, square_of_mean += o.square_of_mean, square_of_bound += o.square_of_bound;
    return *this;
  }
  [[nodiscard]] float trust() const noexcept {
    const double part = square_of_bound > 0 ? square_of_mean / square_of_bound : 0;
    return part > 0 && std::isfinite(part) ? static_cast<float>(std::sqrt(part)) : 0;
  }
};

Trial try_light(const Scene& scene, int light, const Hit& at, std::uint64_t key) {
  const auto sample = [&](std::uint64_t index) {
    return irradiance(scene, light, at, Sampler(mix(key, 2 * static_cast<std::uint64_t>(light) + index), 0));
  };
  const double a = sample(0), b = sample(1),
               bound = importance(scene.lights()[static_cast<std::size_t>(light)], at.position, at.ng);
  return {square(a - b) / 2, a * b, std::isfinite(bound) ? square(bound) : 0};
}

// Rows of a number per light.
template <class T>
struct Table {
  std::size_t width;
  std::vector<T> values;
  [[nodiscard]] std::span<T> row(std::size_t i) noexcept {
    return std::span(values).subspan(i * width, width);
  }
};

// Sums of trials, in one order for any number of threads. Row 0: anywhere; those of the cells follow, and
// each cell holds its row's number.
struct Sums {
  Table<Trial> trials;
  std::vector<std::size_t> points;  // in each row
  NumberedCells<std::uint32_t> cells;

  void add(const V3d& place, std::span<const Trial> found) {
    std::uint32_t& row = cells.at(place);
    if (row == 0) {
      row = static_cast<std::uint32_t>(points.size());
      points.push_back(0), trials.values.resize(trials.values.size() + trials.width);
    }
    for (const std::size_t to : {std::size_t{0}, std::size_t{row}}) {
      ++points[to];
      for (std::size_t l = 0; l < found.size(); ++l) trials.row(to)[l] += found[l];
    }
  }
};

Sums try_where_seen(const Scene& scene, const TransportSettings& settings, std::span<const Hit> seen,
                    double extent, ThreadPool& pool, const std::atomic<bool>& cancel) {
  const std::size_t lights = scene.lights().size(),
                    most = lights == 1 ? trials_of_one_light : most_trials / lights;
  // odd: v and y take turns in what is seen
  const std::size_t step = seen.size() / most | 1, points = (seen.size() + step - 1) / step;
  Table<Trial> found{lights, std::vector<Trial>(points * lights)};
  pool.parallel_for(points, [&](std::size_t i, int) {
    const std::uint64_t key = key_of(settings.seed, PilotPurpose::Lights, i);
    for (std::size_t l = 0; l < lights && !cancel; ++l)
      found.row(i)[l] = try_light(scene, static_cast<int>(l), seen[i * step], key);
  });
  Sums sums{{lights, std::vector<Trial>(lights)}, {0}, NumberedCells<std::uint32_t>(cell_of_extent * extent)};
  for (std::size_t i = 0; i < points; ++i) sums.add(seen[i * step].position, found.row(i));
  return sums;
}

// The sky of a room is seen through its window, a bulb through its shade: most shadow segments to it end on
// the way, where photons find the surfaces that it lights.
bool is_hidden(const Light& light, const Effects& effects, const Trial& anywhere) {
  return effects.indirect && !is_delta(light) && light.casts_shadow &&
         anywhere.variance > hidden_variance * anywhere.square_of_mean;
}

}  // namespace

bool is_seen_lit(const Scene& scene, const TransportSettings& settings, int light, std::span<const Hit> seen,
                 std::size_t places) {
  const std::size_t step = seen.size() / places | 1;  // odd: v and y take turns in what is seen
  for (std::size_t i = 0; i < seen.size(); i += step)
    if (irradiance(
            scene, light, seen[i],
            Sampler(key_of(settings.seed, PilotPurpose::Lights, i), static_cast<std::uint32_t>(light))) > 0)
      return true;
  return false;
}

LightTrusts try_lights(const Scene& scene, const TransportSettings& settings, const Effects& effects,
                       std::span<const Hit> seen, double extent, ThreadPool& pool,
                       const std::atomic<bool>& cancel) {
  const std::size_t lights = scene.lights().size();
  if (lights == 0 || lights > few_lights || seen.empty()) return {};
  Sums sums = try_where_seen(scene, settings, seen, extent, pool, cancel);
  Table<float> trust{lights, std::vector<float>(sums.trials.values.size())};
  std::vector<char> hidden;
  const std::span anywhere = trust.row(0);
  for (std::size_t l = 0; l < lights; ++l) {
    hidden.push_back(is_hidden(scene.lights()[l], effects, sums.trials.row(0)[l]));
    anywhere[l] = sums.trials.row(0)[l].trust();
  }
  const float least = least_trust * std::ranges::max(anywhere);
  for (float& of_light : anywhere) of_light = least > 0 ? std::max(of_light, least) : 1;
  for (std::size_t row = 1; row < sums.points.size(); ++row)
    for (std::size_t l = 0; l < lights; ++l) {
      // As if one more point had found what is found anywhere; and a light that is not found here may still
      // be here.
      Trial here = sums.trials.row(row)[l];
      here.square_of_mean += here.square_of_bound / static_cast<double>(sums.points[row]) *
                             square(static_cast<double>(anywhere[l]));
      trust.row(row)[l] = std::max(here.trust(), least_in_cell * anywhere[l]);
    }
  return {std::move(sums.cells), std::move(trust.values), std::move(hidden)};
}

}  // namespace sluice
