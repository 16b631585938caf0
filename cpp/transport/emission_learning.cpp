// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/emission_pilot.h"

#include <algorithm>
#include <numeric>

#include "transport/emission.h"
#include "transport/light_trust.h"
#include "transport/pass.h"

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
constexpr std::size_t min_starts = 512;    // useful photons that a table of aims is learned from
constexpr double min_cells_of_sight = 16;  // of a table of aims: below, it is too coarse for that sight
// at which lights that brought nothing are asked once more, all together
constexpr std::size_t places_of_trials = 1 << 16;
constexpr int paths_per_chunk = 2048;
constexpr unsigned close_arrivals = caustic_arrivals | edited_arrivals;

// What the photons of one light brought.
struct Yield {
  double worth = 0;  // to the picture
  // luminous flux of stored photons where the camera looks, and anywhere (W)
  double seen = 0, all = 0;
  // per target: worth of light that arrived by mirrors, glass or exits
  std::vector<double> close;
  std::vector<std::pair<int, double>> starts;  // cell of AimTable and worth, photon by photon
};

// A photon's cell of what is seen and the hits there that show its side; -1 and 0 where none do.
struct Place {
  int cell = -1;
  float hits = 0;
};

// What each of the pilot's photons is worth to the picture. Irradiance counts by its part in that of its
// cell, so that a dim room beside a sunny yard has its share: the error of a picture is relative, too
// (film.h, relative_variance).
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
        const auto [cell, here] = places_[c][i];
        if (cell < 0) continue;
        const Photon& photon = pilot.photons[c][i];
        const double share = luminance(photon.flux()) / square(seen.edge(V3d(photon.position)));
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
  [[nodiscard]] double operator()(std::size_t chunk, std::size_t photon, double flux,
                                  double edge) const noexcept {
    const auto [cell, hits] = places_[chunk][photon];
    const double around = irradiance_[static_cast<std::size_t>(cell)] + 0.1 * mean_;
    return around > 0 ? hits * flux / square(edge) / around : 0;
  }

 private:
  [[nodiscard]] static Place place_of(const Photon& photon, const Visible& seen) noexcept {
    const int cell = seen.cell(V3d(photon.position));
    if (cell < 0) return {};
    const auto hits = static_cast<float>(seen.hits_in(cell, unpack_direction(photon.normal)));
    return hits > 0 ? Place{cell, hits} : Place{};
  }

  std::vector<std::vector<Place>> places_;
  std::vector<double> irradiance_;  // by cell, of what is seen in it (W/m²)
  double mean_ = 0;                 // over the hits
};

// Where a path starts, as its light's table has it; empty: the world shines along every axis, so places tell
// nothing of it.
std::optional<V2f> aim_of(const Scene& scene, const Guide& guide, const PilotPath& path) {
  const Light& light = scene.lights()[static_cast<std::size_t>(path.light)];
  if (std::holds_alternative<World>(light.kind)) return {};
  if (!is_infinite(light)) return uv_of_direction(path.direction);
  const V2f uv = SunPlane(guide.aimed, sun_axis(scene, path.light)).uv(path.origin, path.direction);
  return uv.x >= 0 && uv.x < 1 && uv.y >= 0 && uv.y < 1 ? std::optional(uv) : std::nullopt;
}

std::vector<Yield> yields_of(const Scene& scene, const PilotPhotons& pilot, const Visible& seen,
                             ThreadPool& pool, const Guide& guide) {
  const Worth worth(pilot, seen, pool);
  std::vector<Yield> yields(scene.lights().size());
  for (Yield& yield : yields) yield.close.resize(guide.targets.size());
  for (std::size_t c = 0; c < pilot.paths.size(); ++c) {
    std::size_t i = 0;
    for (const PilotPath& path : pilot.paths[c]) {
      Yield& yield = yields[static_cast<std::size_t>(path.light)];
      double of_path = 0, close = 0;
      for (; i < path.photons_end; ++i) {
        const Photon& photon = pilot.photons[c][i];
        const double flux = luminance(photon.flux());
        yield.all += flux;
        if (!worth.is_seen(c, i)) continue;
        const double of_photon = worth(c, i, flux, seen.edge(V3d(photon.position)));
        yield.seen += flux, of_path += of_photon;
        if (close_arrivals & bit_of(photon.arrival)) close += of_photon;
      }
      if (!(of_path > 0)) continue;
      yield.worth += of_path;
      if (const auto uv = aim_of(scene, guide, path)) yield.starts.emplace_back(AimTable::cell(*uv), of_path);
      const bool infinite = is_infinite(scene.lights()[static_cast<std::size_t>(path.light)]);
      for (std::size_t t = 0; t < guide.targets.size() && close > 0; ++t)
        if (aims_at(guide.targets[t], path.origin, path.direction, infinite)) yield.close[t] += close;
    }
  }
  return yields;
}

AimTable table_of(const Yield& yield) {
  if (yield.starts.size() < min_starts) return {};
  std::vector<double> cells(AimTable::cells, 0);
  for (const auto& [cell, worth] : yield.starts) cells[static_cast<std::size_t>(cell)] += worth;
  return AimTable(std::vector<float>(cells.begin(), cells.end()));
}

// How many cells of a light's table a sight takes up.
double cells_of(const Target& sight, const Light& light, const Target& aimed) {
  if (is_infinite(light)) return AimTable::cells * pi * square(sight.radius / (2 * aimed.radius));
  const double sine2 =
      square(static_cast<double>(sight.radius)) / std::max((sight.centre - light.middle).length2(), 1e-300);
  return sine2 >= 1 ? AimTable::cells : AimTable::cells * 0.5 * sine2 / (1 + std::sqrt(1 - sine2));
}

// Shares of a light's photons: its own distribution, towards each target, by its table of aims.
Distribution mixture_for(const EmissionPlan& plan, const Scene& scene, const Guide& guide, std::size_t l,
                         const Yield& yield) {
  const Light& light = scene.lights()[l];
  std::vector<float> weights(guide.targets.size() + 2, 0.0f);
  const auto add_to = [&](std::size_t target, double share) {
    weights[target + 1] += static_cast<float>(share);
  };

  // What was not met may still be there: all things keep a part.
  const double close = std::accumulate(yield.close.begin(), yield.close.end(), 0.0);
  for (std::size_t t = 0; t < plan.things.size(); ++t)
    add_to(t, close_share * kept_share / static_cast<double>(plan.things.size()));
  for (std::size_t t = 0; t < guide.targets.size() && close > 0; ++t)
    add_to(t, close_share * (1 - kept_share) * yield.close[t] / close);

  const bool has_table = !guide.aims[l].empty();
  const bool is_coarse =
      !plan.sights.empty() && cells_of(plan.sights.front().sphere, light, guide.aimed) < min_cells_of_sight;
  const bool is_wasted = yield.seen < 0.5 * yield.all || yield.all == 0;
  const double by_sights = has_table ? (is_coarse ? seen_share / 2 : 0) : is_wasted ? seen_share : 0;
  weights.back() = has_table ? static_cast<float>(seen_share - by_sights) : 0;
  for (std::size_t s = 0; s < plan.sights.size(); ++s)
    add_to(plan.first_sight() + s, by_sights * plan.sights[s].share);

  if (plan.far.is_for[l])
    weights[plan.far_target() + 1] = std::max(weights[plan.far_target() + 1], far_share);
  weights[0] = std::max(own_share, 1 - std::accumulate(weights.begin() + 1, weights.end(), 0.0f));
  return Distribution(weights);
}

// Lights of which neither photons nor next-event estimation brought anything, and effects without photons.
void note_unmet(const Scene& scene, const TransportSettings& settings, const Effects& effects,
                const std::vector<Yield>& yields, const PilotPhotons& pilot, const Visible& seen,
                ThreadPool& pool, Guide& guide) {
  std::vector<std::size_t> dark;
  for (std::size_t l = 0; l < yields.size(); ++l)
    if (!(yields[l].worth > 0)) dark.push_back(l);
  std::vector<char> is_lit(dark.size());
  const std::size_t places =
      std::clamp<std::size_t>(places_of_trials / std::max<std::size_t>(dark.size(), 1), 16, 1024);
  pool.parallel_for(dark.size(), [&](std::size_t i, int) {
    is_lit[i] = is_seen_lit(scene, settings, static_cast<int>(dark[i]), seen.hits(), places);
  });
  for (std::size_t i = 0; i < dark.size(); ++i)
    if (!is_lit[i]) guide.unmet.push_back({static_cast<int>(dark[i]), "", guide.lights.pmf(dark[i])});
  unsigned met = 0;
  for (const auto& chunk : pilot.photons)
    for (const Photon& photon : chunk) met |= bit_of(photon.arrival);
  if (effects.caustics && !(met & caustic_arrivals))
    guide.unmet.push_back({-1, "caustics", close_share * static_cast<float>(kept_share)});
  if (effects.edited && !(met & edited_arrivals))
    guide.unmet.push_back({-1, "edited light", close_share * static_cast<float>(kept_share)});
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

void aim_pilot(const EmissionPlan& plan, const Scene& scene, Guide& guide) {
  std::vector<float> shares;
  for (const double possible : plan.possible)
    shares.push_back(static_cast<float>(possible + 1 / static_cast<double>(plan.possible.size())));
  guide.lights = Distribution(shares);
  const std::size_t others = plan.things.size() + (plan.far.target ? 1 : 0);
  std::vector<float> strategy(guide.targets.size() + 2, others > 0 ? 0.25f / static_cast<float>(others) : 0);
  strategy.front() = 0.5f, strategy.back() = 0;
  for (std::size_t s = 0; s < plan.sights.size(); ++s)
    strategy[1 + plan.first_sight() + s] = 0.25f * plan.sights[s].share;
  guide.strategies.assign(shares.size(), Distribution(strategy));
  guide.aims.resize(shares.size());
  // Useful light may come by a little beside what is seen.
  guide.aimed = whole_scene(scene);
  if (!plan.sights.empty() && 1.5f * plan.sights.back().sphere.radius < guide.aimed.radius)
    guide.aimed = {plan.sights.back().sphere.centre, 1.5f * plan.sights.back().sphere.radius};
}

PilotPhotons trace_pilot(const Scene& scene, const TransportSettings& settings, const Guide& guide,
                         std::span<LightTracer> tracers, ThreadPool& pool, const std::atomic<bool>& cancel) {
  const int paths = settings.pilot_paths;
  const auto chunks = static_cast<std::size_t>((paths + paths_per_chunk - 1) / paths_per_chunk);
  PilotPhotons pilot{std::vector<std::vector<Photon>>(chunks), std::vector<std::vector<PilotPath>>(chunks)};
  pool.parallel_for(chunks, [&](std::size_t c, int thread) {
    std::vector<Photon> photons;  // the thread's own while it fills
    std::vector<PilotPath> starts;
    const auto begin = static_cast<std::uint32_t>(c) * paths_per_chunk,
               end = std::min(begin + paths_per_chunk, static_cast<std::uint32_t>(paths));
    for (std::uint32_t path = begin; path < end && !cancel; ++path) {
      const Sampler sampler(key_of(settings.seed, PilotPurpose::Photons), path);
      const auto photon = emit_photon(scene, guide, sampler);
      if (!photon) continue;
      tracers[static_cast<std::size_t>(thread)].trace(*photon, 1.0f / static_cast<float>(paths), sampler,
                                                      path, photons);
      starts.push_back({photon->light, photon->origin, photon->direction, photons.size()});
    }
    pilot.photons[c] = std::move(photons), pilot.paths[c] = std::move(starts);
  });
  return pilot;
}

void learn_emission(const EmissionPlan& plan, const Scene& scene, const TransportSettings& settings,
                    const Effects& effects, const PilotPhotons& pilot, const Visible& seen, ThreadPool& pool,
                    Guide& guide) {
  const std::vector<Yield> yields = yields_of(scene, pilot, seen, pool, guide);
  const double all = std::accumulate(yields.begin(), yields.end(), 0.0,
                                     [](double sum, const Yield& yield) { return sum + yield.worth; });
  std::vector<float> shares;
  for (std::size_t l = 0; l < yields.size(); ++l) {
    const double kept = all > 0 ? kept_share : 1;
    shares.push_back(
        static_cast<float>(kept * plan.possible[l] + (all > 0 ? (1 - kept) * yields[l].worth / all : 0)));
    guide.aims[l] = table_of(yields[l]);
    guide.strategies[l] = mixture_for(plan, scene, guide, l, yields[l]);
  }
  guide.lights = Distribution(shares);
  note_unmet(scene, settings, effects, yields, pilot, seen, pool, guide);
}

}  // namespace sluice
