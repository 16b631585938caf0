// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/light_probing.h"

#include <algorithm>

#include "transport/pass.h"

namespace sluice {
namespace {

// of a sample at y, against the square of its mean: photons leave a tenth of that
constexpr double hidden_variance = 1;
// of that of the most trusted light: one that was not found may still be there
constexpr float min_trust = 0.05f;
// of its trust anywhere: what 10 points in a cell did not find may still be there
constexpr float min_in_cell = 0.15f;
constexpr std::size_t max_probes = 32768, probes_of_one_light = 2048;
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
struct LightProbe {
  double variance = 0, square_of_mean = 0;
  double square_of_bound = 0;  // of what the light could do there

  LightProbe& operator+=(const LightProbe& o) noexcept {
    variance += o.variance, square_of_mean += o.square_of_mean, square_of_bound += o.square_of_bound;
    return *this;
  }
  [[nodiscard]] float trust() const noexcept {
    const double part = square_of_bound > 0 ? square_of_mean / square_of_bound : 0;
    return part > 0 && std::isfinite(part) ? static_cast<float>(std::sqrt(part)) : 0;
  }
};

LightProbe probe_light(const Scene& scene, int light, const Hit& at, std::uint64_t key) {
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

// Sums of probes, in one order for any number of threads. Row 0: anywhere; those of the cells follow, and
// each cell holds its row's number.
struct Sums {
  Table<LightProbe> probes;
  std::vector<std::size_t> points;  // in each row
  NumberedCells<std::uint32_t> cells;

  void add(const V3d& place, std::span<const LightProbe> found) {
    std::uint32_t& row = cells.at(place);
    if (row == 0) {
      row = static_cast<std::uint32_t>(points.size());
      points.push_back(0), probes.values.resize(probes.values.size() + probes.width);
    }
    for (const std::size_t to : {std::size_t{0}, std::size_t{row}}) {
      ++points[to];
      for (std::size_t l = 0; l < found.size(); ++l) probes.row(to)[l] += found[l];
    }
  }
};

Sums probe_what_is_seen(const PilotContext& context, std::span<const Hit> seen, double extent) {
  const std::size_t lights = context.scene.lights().size();
  const SomeHits points(seen, lights == 1 ? probes_of_one_light : max_probes / lights);
  Table<LightProbe> found{lights, std::vector<LightProbe>(points.size() * lights)};
  context.pool.parallel_for(points.size(), [&](std::size_t i, int) {
    const std::uint64_t key = key_of(context.settings.seed, PilotPurpose::Lights, i);
    for (std::size_t l = 0; l < lights && !context.cancel; ++l)
      found.row(i)[l] = probe_light(context.scene, static_cast<int>(l), points[i], key);
  });
  Sums sums{
      {lights, std::vector<LightProbe>(lights)}, {0}, NumberedCells<std::uint32_t>(cell_of_extent * extent)};
  for (std::size_t i = 0; i < points.size(); ++i) sums.add(points[i].position, found.row(i));
  return sums;
}

// The sky of a room is seen through its window, a bulb through its shade: most shadow segments to it end on
// the way, where photons find the surfaces that it lights.
bool is_hidden(const Light& light, const Effects& effects, const LightProbe& anywhere) {
  return effects.indirect && !is_delta(light) && light.casts_shadow &&
         anywhere.variance > hidden_variance * anywhere.square_of_mean;
}

}  // namespace

bool is_seen_lit(const PilotContext& context, int light, const SomeHits& places) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::uint64_t key = key_of(context.settings.seed, PilotPurpose::Lights, places.number(i));
    if (irradiance(context.scene, light, places[i], Sampler(key, static_cast<std::uint32_t>(light))) > 0)
      return true;
  }
  return false;
}

LightTrusts probe_lights(const PilotContext& context, std::span<const Hit> seen, double extent) {
  const Scene& scene = context.scene;
  const std::size_t lights = scene.lights().size();
  if (lights == 0 || lights > few_lights || seen.empty()) return {};
  Sums sums = probe_what_is_seen(context, seen, extent);
  Table<float> trust{lights, std::vector<float>(sums.probes.values.size())};
  std::vector<char> hidden;
  const std::span anywhere = trust.row(0);
  for (std::size_t l = 0; l < lights; ++l) {
    hidden.push_back(is_hidden(scene.lights()[l], context.effects, sums.probes.row(0)[l]));
    anywhere[l] = sums.probes.row(0)[l].trust();
  }
  const float least = min_trust * std::ranges::max(anywhere);
  for (float& of_light : anywhere) of_light = least > 0 ? std::max(of_light, least) : 1;
  for (std::size_t row = 1; row < sums.points.size(); ++row)
    for (std::size_t l = 0; l < lights; ++l) {
      // As if one more point had found what is found anywhere; and a light that is not found here may still
      // be here.
      LightProbe here = sums.probes.row(row)[l];
      here.square_of_mean += here.square_of_bound / static_cast<double>(sums.points[row]) *
                             square(static_cast<double>(anywhere[l]));
      trust.row(row)[l] = std::max(here.trust(), min_in_cell * anywhere[l]);
    }
  return {std::move(sums.cells), std::move(trust.values), std::move(hidden)};
}

}  // namespace sluice
