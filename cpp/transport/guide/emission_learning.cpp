// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/emission_learning.h"

#include <algorithm>
#include <numeric>

#include "transport/guide/light_probing.h"
#include "transport/photons/emission.h"

namespace sluice {
namespace {

constexpr float own_share = 0.25f;  // of a light's own distribution, about, at least (design §5)
// of the photons of a light go towards what sends them on to caustics and edits
constexpr float close_share = 0.25f;
// of a light from infinity towards entries outside of all surfaces, at least
constexpr float far_share = 0.1f;
// towards what the camera sees: by directions that proved useful, or towards sights
constexpr float seen_share = 0.5f;
constexpr double kept_share = 1.0 / 8;     // of all shares, by what can be; the rest by what the pilot found
constexpr std::size_t min_starts = 512;    // useful photons that a histogram is learned from
constexpr double min_cells_of_sight = 16;  // of a histogram: below, it is too coarse for that sight
// at which lights that brought nothing are asked once more, all together
constexpr std::size_t places_of_trials = 1 << 16;

// What the photons of one light brought.
struct LightContribution {
  double worth = 0;  // to the picture
  // luminous flux of stored photons where the camera looks, and anywhere (W)
  double seen = 0, all = 0;
  // per target: worth of light that arrived by mirrors, glass or exits
  std::vector<double> close;
  std::vector<std::pair<int, double>> starts;  // cell of the histogram and worth, photon by photon
};

// Where a photon lies in what is seen: the cell, its hits that show the photon's side, and the area of one of
// its faces (m²). -1 and 0 where none do.
struct Place {
  int cell = -1;
  float hits = 0;
  double area = 0;
};

// What each of the pilot's photons is worth to the picture. Irradiance counts by its part in that of its
// cell, so that a dim room beside a sunny yard has its share: the error of a picture is relative, too
// (error.h, relative_variance).
class Worth {
 public:
  Worth(const PilotPhotons& pilot, const Visible& seen, ThreadPool& pool)
      : places_(pilot.photons.size()), irradiance_(seen.cell_count()) {
    pool.parallel_for(places_.size(), [&](std::size_t c, int) {
      for (const Photon& photon : pilot.photons[c]) places_[c].push_back(place_of(photon, seen));
    });
    std::vector<double> hits(seen.cell_count(), 0);
    double all_hits = 0;
    for (std::size_t c = 0; c < places_.size(); ++c)
      for (std::size_t i = 0; i < places_[c].size(); ++i) {
        const auto [cell, here, area] = places_[c][i];
        if (cell < 0) continue;
        const double share = luminance(pilot.photons[c][i].flux()) / area;
        irradiance_[static_cast<std::size_t>(cell)] += share;
        mean_ += here * share;
        double& most = hits[static_cast<std::size_t>(cell)];  // of both sides of what is thin
        most = std::max(most, static_cast<double>(here));
      }
    for (const double here : hits) all_hits += here;
    mean_ /= std::max(all_hits, 1.0);
  }

  [[nodiscard]] bool is_seen(std::size_t chunk, std::size_t photon) const noexcept {
    return places_[chunk][photon].cell >= 0;
  }
  [[nodiscard]] double operator()(std::size_t chunk, std::size_t photon, double flux) const noexcept {
    const auto [cell, hits, area] = places_[chunk][photon];
    const double around = irradiance_[static_cast<std::size_t>(cell)] + 0.1 * mean_;
    return around > 0 ? hits * flux / area / around : 0;
  }

 private:
  [[nodiscard]] static Place place_of(const Photon& photon, const Visible& seen) noexcept {
    const V3d position(photon.position);
    const int cell = seen.cell(position);
    if (cell < 0) return {};
    const auto hits = static_cast<float>(seen.hits_in(cell, unpack_direction(photon.normal)));
    return hits > 0 ? Place{cell, hits, square(seen.edge(position))} : Place{};
  }

  std::vector<std::vector<Place>> places_;
  std::vector<double> irradiance_;  // by cell, of what is seen in it (W/m²)
  double mean_ = 0;                 // over the hits
};

// Where a path starts, as its light's histogram has it; empty: the world shines along every axis, so places
// tell nothing of it.
std::optional<V2f> start_of(const Scene& scene, const EmissionGuide& first, const PilotPath& path) {
  const Light& light = scene.lights()[static_cast<std::size_t>(path.light)];
  if (is_infinite(light) && !common_direction(light)) return {};
  if (!is_infinite(light)) return uv_of_direction(path.direction);
  const V2f uv = SunPlane(first.aimed, sun_axis(scene, path.light)).uv(path.origin, path.direction);
  return uv.x >= 0 && uv.x < 1 && uv.y >= 0 && uv.y < 1 ? std::optional(uv) : std::nullopt;
}

std::vector<LightContribution> contributions_of(const PilotContext& context, const EmissionGuide& first,
                                                const PilotPhotons& pilot, const Visible& seen) {
  const Worth worth(pilot, seen, context.pool);
  std::vector<LightContribution> lights(context.scene.lights().size());
  for (LightContribution& light : lights) light.close.resize(first.targets.size());
  for (std::size_t c = 0; c < pilot.paths.size(); ++c) {
    std::size_t i = 0;
    for (const PilotPath& path : pilot.paths[c]) {
      LightContribution& light = lights[static_cast<std::size_t>(path.light)];
      double of_path = 0, close = 0;
      for (; i < path.photons_end; ++i) {
        const Photon& photon = pilot.photons[c][i];
        const double flux = luminance(photon.flux());
        light.all += flux;
        if (!worth.is_seen(c, i)) continue;
        const double of_photon = worth(c, i, flux);
        light.seen += flux, of_path += of_photon;
        if (caustic_and_edited_arrivals & bit_of(photon.arrival)) close += of_photon;
      }
      if (!(of_path > 0)) continue;
      light.worth += of_path;
      if (const auto uv = start_of(context.scene, first, path))
        light.starts.emplace_back(EmissionHistogram::cell(*uv), of_path);
      const bool infinite = is_infinite(context.scene.lights()[static_cast<std::size_t>(path.light)]);
      for (std::size_t t = 0; t < first.targets.size() && close > 0; ++t)
        if (aims_at(first.targets[t], path.origin, path.direction, infinite)) light.close[t] += close;
    }
  }
  return lights;
}

// Empty where few useful photons are known.
EmissionHistogram histogram_of(const LightContribution& light) {
  if (light.starts.size() < min_starts) return {};
  std::vector<double> cells(EmissionHistogram::cells, 0);
  for (const auto& [cell, worth] : light.starts) cells[static_cast<std::size_t>(cell)] += worth;
  return EmissionHistogram(std::vector<float>(cells.begin(), cells.end()));
}

// How many cells of a light's histogram a sight takes up.
double cells_of(const Target& sight, const Light& light, const Target& aimed) {
  constexpr int cells = EmissionHistogram::cells;
  if (is_infinite(light)) return cells * pi * square(sight.radius / (2 * aimed.radius));
  return cells * 0.5 * one_minus_cos_of_sphere(sight.radius, (sight.centre - light.middle).length2());
}

EmissionMixture mixture_for(const EmissionPlan& plan, const EmissionGuide& first, const Light& light,
                            bool is_for_far_entries, const LightContribution& brought) {
  EmissionShares shares{.targets = std::vector<float>(first.targets.size(), 0.0f)};
  const auto add_to = [&](std::size_t target, double share) {
    shares.targets[target] += static_cast<float>(share);
  };

  // What was not met may still be there: all things keep a part.
  const double close = std::accumulate(brought.close.begin(), brought.close.end(), 0.0);
  for (std::size_t t = 0; t < plan.things.size(); ++t)
    add_to(t, close_share * kept_share / static_cast<double>(plan.things.size()));
  for (std::size_t t = 0; t < first.targets.size() && close > 0; ++t)
    add_to(t, close_share * (1 - kept_share) * brought.close[t] / close);

  EmissionHistogram histogram = histogram_of(brought);
  const bool is_coarse =
      !plan.sights.empty() && cells_of(plan.sights.front().sphere, light, first.aimed) < min_cells_of_sight;
  const bool is_wasted = brought.seen < 0.5 * brought.all || brought.all == 0;
  const double by_sights = !histogram.empty() ? (is_coarse ? seen_share / 2 : 0) : is_wasted ? seen_share : 0;
  shares.histogram = histogram.empty() ? 0 : static_cast<float>(seen_share - by_sights);
  for (std::size_t s = 0; s < plan.sights.size(); ++s)
    add_to(plan.first_sight() + s, by_sights * plan.sights[s].share);

  if (is_for_far_entries) {
    float& far = shares.targets[plan.far_target()];
    far = std::max(far, far_share);
  }
  shares.own = std::max(own_share, 1 - shares.aimed());
  return {shares, std::move(histogram)};
}

// Lights of which neither photons nor next-event estimation brought anything, and effects without photons.
std::vector<Unmet> find_unmet(const PilotContext& context, const std::vector<LightContribution>& lights,
                              const PilotPhotons& pilot, const Visible& seen, const Distribution& shares) {
  std::vector<std::size_t> dark;
  for (std::size_t l = 0; l < lights.size(); ++l)
    if (!(lights[l].worth > 0)) dark.push_back(l);
  std::vector<char> is_lit(dark.size());
  const std::size_t places =
      std::clamp<std::size_t>(places_of_trials / std::max<std::size_t>(dark.size(), 1), 16, 1024);
  context.pool.parallel_for(dark.size(), [&](std::size_t i, int) {
    is_lit[i] = is_seen_lit(context, static_cast<int>(dark[i]), SomeHits(seen.hits(), places));
  });
  std::vector<Unmet> unmet;
  for (std::size_t i = 0; i < dark.size(); ++i)
    if (!is_lit[i]) unmet.push_back({static_cast<int>(dark[i]), "", shares.pmf(dark[i])});
  unsigned met = 0;
  for (const auto& chunk : pilot.photons)
    for (const Photon& photon : chunk) met |= bit_of(photon.arrival);
  constexpr float kept = close_share * static_cast<float>(kept_share);
  if (context.effects.caustics && !(met & caustic_arrivals)) unmet.push_back({-1, "caustics", kept});
  if (context.effects.edited && !(met & edited_arrivals)) unmet.push_back({-1, "edited light", kept});
  return unmet;
}

}  // namespace

EmissionPlan::EmissionPlan(const Scene& scene, std::vector<Target> the_things, std::vector<Sight> the_sights,
                           FarEntries the_far)
    : things(std::move(the_things)),
      sights(std::move(the_sights)),
      far(std::move(the_far)),
      possible(scene.lights().size(), 0) {
  // Each sight by itself: a sun that can send most into all that is seen need not do so into the room around
  // the camera.
  for (const Sight& sight : sights) {
    const std::vector<double> shares = possible_shares(scene, sight.sphere);
    for (std::size_t l = 0; l < possible.size(); ++l) possible[l] += sight.share * shares[l];
  }
  if (sights.empty())
    std::ranges::fill(possible, 1.0 / static_cast<double>(std::max<std::size_t>(possible.size(), 1)));
}

std::vector<Target> EmissionPlan::targets() const {
  std::vector<Target> all = things;
  for (const Sight& sight : sights) all.push_back(sight.sphere);
  if (far.target) all.push_back(*far.target);
  return all;
}

EmissionGuide emission_of_pilot(const EmissionPlan& plan, const Scene& scene) {
  EmissionGuide guide{.lights = mixed_with_equal(plan.possible),
                      .targets = plan.targets(),
                      .mixtures = {},
                      .aimed = whole_scene(scene)};
  const std::size_t others = plan.things.size() + (plan.far.target ? 1 : 0);
  const float of_other = others > 0 ? 0.25f / static_cast<float>(others) : 0;
  EmissionShares shares{.own = 0.5f, .targets = std::vector<float>(guide.targets.size(), of_other)};
  for (std::size_t s = 0; s < plan.sights.size(); ++s)
    shares.targets[plan.first_sight() + s] = 0.25f * plan.sights[s].share;
  guide.mixtures.assign(scene.lights().size(), EmissionMixture(shares, {}));
  // Useful light may come by a little beside what is seen.
  if (!plan.sights.empty() && 1.5f * plan.sights.back().sphere.radius < guide.aimed.radius)
    guide.aimed = {plan.sights.back().sphere.centre, 1.5f * plan.sights.back().sphere.radius};
  return guide;
}

std::pair<EmissionGuide, std::vector<Unmet>> learn_emission(const PilotContext& context,
                                                            const EmissionPlan& plan,
                                                            const EmissionGuide& first,
                                                            const PilotPhotons& pilot, const Visible& seen) {
  const std::vector<LightContribution> brought = contributions_of(context, first, pilot, seen);
  const double all =
      std::accumulate(brought.begin(), brought.end(), 0.0,
                      [](double sum, const LightContribution& light) { return sum + light.worth; });
  const double kept = all > 0 ? kept_share : 1;
  EmissionGuide learned{.lights = {}, .targets = first.targets, .mixtures = {}, .aimed = first.aimed};
  std::vector<float> shares;
  for (std::size_t l = 0; l < brought.size(); ++l) {
    shares.push_back(
        static_cast<float>(kept * plan.possible[l] + (all > 0 ? (1 - kept) * brought[l].worth / all : 0)));
    learned.mixtures.push_back(
        mixture_for(plan, first, context.scene.lights()[l], plan.far.is_for[l], brought[l]));
  }
  learned.lights = Distribution(shares);
  std::vector<Unmet> unmet = find_unmet(context, brought, pilot, seen, learned.lights);
  return {std::move(learned), std::move(unmet)};
}

}  // namespace sluice
