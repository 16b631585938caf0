// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/pilot.h"

#include <algorithm>
#include <iterator>

#include "transport/density.h"
#include "transport/emission.h"
#include "transport/emission_pilot.h"
#include "transport/light_trust.h"
#include "transport/pass.h"
#include "transport/radii.h"
#include "transport/targets.h"
#include "transport/visible.h"

namespace sluice {
namespace {

constexpr std::size_t max_specular_targets = 32, max_entry_targets = 24;
// that find out whether it takes light that is aimed at it
constexpr int min_paths_per_entry = 256, max_paths_per_entry = 4096;
// Photons that a gather at y should find in the first pass. View samples are the noise, so more cost time and
// blur for nothing; far fewer are noise themselves.
constexpr double fewest_photons = 8, most_photons = 32;
constexpr std::size_t places_of_density = 1024;
constexpr double most_of_typical = 16;
constexpr double photons_on_disk = 6, photons_on_soft_disk = 12;  // at v in the first pass
constexpr unsigned close_arrivals = caustic_arrivals | edited_arrivals;

class Pilot {
 public:
  Pilot(const Scene& scene, const TransportSettings& settings, const Effects& effects, ThreadPool& pool,
        const std::atomic<bool>& cancel)
      : scene_(scene), settings_(settings), effects_(effects), pool_(pool), cancel_(cancel) {
    for (int t = 0; t < pool.size(); ++t) tracers_.emplace_back(scene, settings, effects, pool.size());
  }

  Guide run() {
    Guide guide;
    const Visible seen = look_around(scene_, settings_, cancel_);
    const auto extent = static_cast<float>(scene_.extent()), footprint = static_cast<float>(seen.footprint);
    const DiskBounds bounds(scene_.camera(), scene_.frame(), settings_);
    guide.caustic_radius = bounds.common(footprint);
    guide.least_radius = guide.most_radius = guide.radius = most_radius_of_extent * extent;
    if (!effects_.photons() || scene_.lights().empty()) return guide;
    std::vector<Target> things = specular_targets(scene_, max_specular_targets);
    std::ranges::copy(clustered(entries_that_take_light(things), max_entry_targets),
                      std::back_inserter(things));
    const EmissionPlan plan(scene_, std::move(things), seen.sights(), find_far_entries(scene_));
    guide.targets = plan.targets();
    aim_pilot(plan, scene_, guide);
    const double seen_extent = plan.sights.empty()
                                   ? scene_.extent()
                                   : std::min(scene_.extent(), 2.0 * plan.sights.back().sphere.radius);
    guide.trust = try_lights(scene_, settings_, effects_, seen.hits(), seen_extent, pool_, cancel_);
    for (LightTracer& tracer : tracers_) tracer.trust = &guide.trust;
    PilotPhotons pilot = trace_pilot(scene_, settings_, guide, tracers_, pool_, cancel_);
    if (cancel_) return guide;
    learn_emission(plan, scene_, settings_, effects_, pilot, seen, pool_, guide);
    photons_ = std::move(pilot.photons);
    size_gathers(guide, seen);
    if (cancel_ || !(footprint > 0)) return guide;
    // of a pass's photons are the pilot's
    const double part = static_cast<double>(settings_.pilot_paths) / settings_.photons;
    const float near = bounds.widest(footprint, false), far = bounds.widest(footprint, true);
    const auto disks_of = [&](unsigned arrivals, double held, float widest) {
      return size_disks({photons_, visible_places(seen, arrivals), arrivals, held * part,
                         guide.caustic_radius, near, widest},
                        pool_, cancel_);
    };
    guide.sharp_disks = disks_of(close_arrivals & ~soft_arrivals, photons_on_disk, near);
    guide.soft_disks = disks_of(soft_arrivals, photons_on_soft_disk, far);
    return guide;
  }

 private:
  // Entries become targets only if light that an entry takes was really met: else the guide, and so the
  // image, is that of no edit. Each is tried by itself, whatever others there are: an edit that takes nothing
  // must not cost another one its target.
  [[nodiscard]] std::vector<Target> entries_that_take_light(std::span<const Target> specular) {
    const Edits& edits = scene_.edits();
    std::vector<Target> found;
    if (!effects_.light_edits) return found;
    std::vector<int> tried;
    for (int e = 0; e < edits.size(); ++e)
      if (contains(edits.takers(Side::Light), e) && (!edits[e].exits.empty() || edits[e].is_partial))
        tried.push_back(e);
    std::vector<char> moves(tried.size());
    pool_.parallel_for(tried.size(), [&](std::size_t i, int thread) {
      moves[i] = moves_light(tried[i], specular, tracers_[static_cast<std::size_t>(thread)]);
    });
    for (std::size_t i = 0; i < tried.size(); ++i)
      if (moves[i]) found.push_back(sphere_around(edits[tried[i]].entry));
    return found;
  }

  // So many paths that each light has its turn, the one that an expression names too (of thousands: some).
  // Half of them go towards what mirrors or refracts.
  [[nodiscard]] bool moves_light(int edit, std::span<const Target> specular, LightTracer& tracer) const {
    const Guide aim = aim_at(scene_, sphere_around(scene_.edits()[edit].entry), specular, 0);
    const int paths =
        std::clamp(4 * static_cast<int>(std::min<std::size_t>(scene_.lights().size(), max_paths_per_entry)),
                   min_paths_per_entry, max_paths_per_entry);
    tracer.counts.start(scene_.edits().size());
    std::vector<Photon> photons;
    for (int path = 0; path < paths && !cancel_; ++path) {
      const Sampler sampler(key_of(settings_.seed, PilotPurpose::Entries), static_cast<std::uint32_t>(path));
      photons.clear();
      if (const auto photon = emit_photon(scene_, aim, sampler))
        tracer.trace(*photon, 1, sampler, static_cast<std::uint64_t>(path), photons);
      if (tracer.counts.of_edit(edit).moved > 0) return true;
    }
    return false;
  }

  // The radii at y, from the mean density of the pilot's photons where the camera looks. Each place is
  // measured in parts of the picture; where light is far denser than is typical it counts as so many times
  // the typical density, else one bright spot would make all radii too small.
  void size_gathers(Guide& guide, const Visible& seen) {
    const std::vector<double> densities = densities_at(seen);
    if (densities.empty()) return;
    double log_typical = 0, density = 0;
    for (const double d : densities) log_typical += std::log(d) / static_cast<double>(densities.size());
    for (const double d : densities)
      density += std::min(d, most_of_typical * std::exp(log_typical)) / static_cast<double>(densities.size());
    const auto radius_for = [&](double photons) {
      return std::min(guide.radius, static_cast<float>(std::sqrt(photons / (pi * density))));
    };
    guide.least_radius = radius_for(fewest_photons), guide.most_radius = radius_for(most_photons);
    guide.radius = gather_radius(guide, seen.mean_length, 1 / pi);
  }

  // Photons of a pass per m² at some of the places seen, above 0.
  [[nodiscard]] std::vector<double> densities_at(const Visible& seen) const {
    // odd: v and y take turns in what is seen
    const std::size_t step = seen.hits().size() / places_of_density | 1;
    std::vector<float> reach;
    for (std::size_t i = 0; i < seen.hits().size(); i += step)
      reach.push_back(static_cast<float>(seen.edge(seen.hits()[i].position) / 2));
    std::vector<double> densities(reach.size());
    if (reach.empty()) return densities;
    std::vector<float> sorted = reach;
    std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
    const float typical = sorted[sorted.size() / 2];
    PhotonMap map;
    map.build(photons_, (1u << arrival_count) - 1, 2 * typical, pool_, cancel_);
    pool_.parallel_for(reach.size(), [&](std::size_t i, int) {
      const float radius = std::clamp(reach[i], typical / 2, 4 * typical);
      double found = 0.5;  // none is less than one
      if (!cancel_) map.query(V3f(seen.hits()[i * step].position), radius, [&](const Photon&) { ++found; });
      densities[i] =
          found * settings_.photons / settings_.pilot_paths / (pi * square(static_cast<double>(radius)));
    });
    return densities;
  }

  // Where the pilot's photons of these arrivals lie, as far as the camera sees it.
  std::vector<V3d> visible_places(const Visible& seen, unsigned arrivals) const {
    std::vector<V3d> places;
    for (const auto& chunk : photons_)
      for (const Photon& photon : chunk)
        if ((arrivals & bit_of(photon.arrival)) && seen.cell(V3d(photon.position)) >= 0)
          places.emplace_back(photon.position);
    return places;
  }

  const Scene& scene_;
  const TransportSettings& settings_;
  const Effects& effects_;
  ThreadPool& pool_;
  const std::atomic<bool>& cancel_;
  std::vector<LightTracer> tracers_;
  std::vector<std::vector<Photon>> photons_;  // of the pilot, by chunk
};

}  // namespace

Guide make_guide(const Scene& scene, const TransportSettings& settings, const Effects& effects,
                 ThreadPool& pool, const std::atomic<bool>& cancel) {
  return Pilot(scene, settings, effects, pool, cancel).run();
}

}  // namespace sluice
