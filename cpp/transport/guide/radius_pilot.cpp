// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/radius_pilot.h"

#include <algorithm>
#include <cmath>

#include "transport/radii.h"

namespace sluice {
namespace {

// Photons that a gather at y should find in the first pass. View samples are the noise, so more cost time and
// blur for nothing; far fewer are noise themselves.
constexpr double min_photons = 8, max_photons = 32;
constexpr std::size_t places_of_density = 1024;
constexpr double max_of_typical = 16;                             // density that counts at one place
constexpr double photons_on_disk = 6, photons_on_soft_disk = 12;  // at v in the first pass
constexpr double parts_of_way = 3;                                // see radius_at()
constexpr unsigned all_arrivals = (1u << arrival_count) - 1;

// Photons of a pass per m² at some of the places seen, above 0. Each place is measured in parts of the
// picture.
std::vector<double> densities_at(const PilotContext& context, PhotonMap::Chunks photons,
                                 const Visible& seen) {
  const SomeHits places(seen.hits(), places_of_density);
  std::vector<float> reach;
  for (std::size_t i = 0; i < places.size(); ++i)
    reach.push_back(static_cast<float>(seen.edge(places[i].position) / 2));
  std::vector<double> densities(reach.size());
  if (reach.empty()) return densities;
  std::vector<float> sorted = reach;
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  const float typical = sorted[sorted.size() / 2];
  PhotonMap map;
  map.build(photons, all_arrivals, 2 * typical, context.pool, context.cancel);
  context.pool.parallel_for(reach.size(), [&](std::size_t i, int) {
    const float radius = std::clamp(reach[i], typical / 2, 4 * typical);
    double found = 0.5;  // none is less than one
    if (!context.cancel) map.query(V3f(places[i].position), radius, [&](const Photon&) { ++found; });
    densities[i] = found * context.settings.photons / context.settings.pilot_paths /
                   (pi * square(static_cast<double>(radius)));
  });
  return densities;
}

// Where photons of these arrivals lie, as far as the camera sees it.
std::vector<V3d> visible_places(PhotonMap::Chunks photons, const Visible& seen, unsigned arrivals) {
  std::vector<V3d> places;
  for (const auto& chunk : photons)
    for (const Photon& photon : chunk)
      if ((arrivals & bit_of(photon.arrival)) && seen.cell(V3d(photon.position)) >= 0)
        places.emplace_back(photon.position);
  return places;
}

// What the radii of one cache are made for.
struct CacheNeeds {
  unsigned arrivals;  // which photons count, bit set
  double held;        // of the pilot's photons are to lie on a disk
  // Radii at a typical place (m): a common one, how far to look for photons first, and how far at most.
  double common, near, widest;
};

// How wide a disk at p must be to hold some of the photons in the map: a part of the way within which lie as
// many as if their density were the same all along. So a disk in the dark stays away from where there are
// many, and edges stay sharp.
float radius_at(const V3d& p, const PhotonMap& map, const CacheNeeds& needs, std::vector<float>& distance2,
                const std::atomic<bool>& cancel) {
  const double reach = needs.widest * parts_of_way, near = needs.near * parts_of_way;
  const auto wanted = static_cast<std::size_t>(std::max(1.0, needs.held * square(parts_of_way)));
  for (const double within : {near, reach}) {  // where there are many they are close by
    distance2.clear();
    if (!cancel)
      map.query(V3f(p), static_cast<float>(within),
                [&](const Photon& photon) { distance2.push_back((photon.position - V3f(p)).length2()); });
    if (distance2.size() >= wanted || near >= reach) break;
  }
  if (distance2.size() < wanted) {
    const double found = std::max<double>(1, static_cast<double>(distance2.size()));
    return static_cast<float>(needs.widest * std::sqrt(static_cast<double>(wanted) / found));
  }
  const auto last = distance2.begin() + static_cast<std::ptrdiff_t>(wanted - 1);
  std::ranges::nth_element(distance2, last);
  return static_cast<float>(std::sqrt(*last) / parts_of_way);
}

RadiusCache make_cache(const PilotContext& context, PhotonMap::Chunks photons, const Visible& seen,
                       const CacheNeeds& needs) {
  RadiusCache cache;
  PhotonMap map;
  map.build(photons, needs.arrivals, static_cast<float>(needs.widest * parts_of_way / 2), context.pool,
            context.cancel);
  if (context.cancel || map.size() == 0) return cache;
  std::vector<std::vector<float>> scratch(static_cast<std::size_t>(context.pool.size()));
  for (double edge = needs.common; edge < needs.widest; edge *= RadiusCache::growth) {
    Cells cells(edge);
    if (cache.levels.empty())
      for (const V3d& place : visible_places(photons, seen, needs.arrivals)) cells.at(place);
    else
      cache.levels.back().for_each([&](const V3d& place) { cells.at(place); });  // they lie in these whole
    cells.set_all(context.pool, [&](const V3d& p, int thread) {
      return radius_at(p, map, needs, scratch[static_cast<std::size_t>(thread)], context.cancel);
    });
    cache.levels.push_back(std::move(cells));
  }
  return cache;
}

}  // namespace

// Where light is far denser than is typical it counts as so many times the typical density, else one bright
// spot would make all radii too small.
std::optional<GatherRadii> size_gathers(const PilotContext& context, PhotonMap::Chunks photons,
                                        const Visible& seen) {
  const std::vector<double> densities = densities_at(context, photons, seen);
  if (densities.empty()) return {};
  double log_typical = 0, density = 0;
  for (const double d : densities) log_typical += std::log(d) / static_cast<double>(densities.size());
  for (const double d : densities)
    density += std::min(d, max_of_typical * std::exp(log_typical)) / static_cast<double>(densities.size());
  const auto radius_for = [&](double wanted) {
    return std::min(widest_gather(context.scene), static_cast<float>(std::sqrt(wanted / (pi * density))));
  };
  const float min = radius_for(min_photons), max = radius_for(max_photons);
  return GatherRadii{min, max, std::clamp(radius_of_segment(seen.mean_length, 1 / pi), min, max)};
}

DiskRadii size_disks(const PilotContext& context, PhotonMap::Chunks photons, const Visible& seen,
                     const DiskBounds& bounds) {
  const auto footprint = static_cast<float>(seen.footprint);
  if (!(footprint > 0)) return {};
  const double part = static_cast<double>(context.settings.pilot_paths) / context.settings.photons;
  const float near = bounds.widest(footprint, false), far = bounds.widest(footprint, true);
  const auto cache_of = [&](unsigned arrivals, double held, float widest) {
    return make_cache(context, photons, seen,
                      {arrivals, held * part, bounds.common(footprint), near, widest});
  };
  return {.sharp = cache_of(caustic_and_edited_arrivals & ~soft_arrivals, photons_on_disk, near),
          .soft = cache_of(soft_arrivals, photons_on_soft_disk, far)};
}

}  // namespace sluice
