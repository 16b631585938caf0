// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/pilot.h"

#include <algorithm>
#include <tuple>

#include "transport/guide/emission_learning.h"
#include "transport/guide/light_probing.h"
#include "transport/guide/radius_pilot.h"
#include "transport/guide/targets.h"
#include "transport/photons/emission.h"
#include "transport/radii.h"

namespace sluice {
namespace {

constexpr std::size_t max_specular_targets = 32, max_entry_targets = 24;

EmissionPlan plan_emission(const PilotContext& context, const Visible& seen) {
  std::vector<Target> things = specular_targets(context.scene, max_specular_targets);
  const std::vector<Target> entries = clustered(entries_that_take_light(context, things), max_entry_targets);
  things.insert(things.end(), entries.begin(), entries.end());
  return {context.scene, std::move(things), seen.sights(), find_far_entries(context.scene)};
}

// The size of what is seen (m).
double extent_of(const std::vector<Sight>& sights, const Scene& scene) {
  return sights.empty() ? scene.extent() : std::min(scene.extent(), 2.0 * sights.back().sphere.radius);
}

}  // namespace

Guide make_guide(const Scene& scene, const TransportSettings& settings, const Effects& effects,
                 ThreadPool& pool, const std::atomic<bool>& cancel) {
  const PilotContext context{scene, settings, effects, pool, cancel};
  const Visible seen = look_around(scene, settings, cancel);
  const DiskBounds bounds(scene.camera(), scene.frame(), settings);
  Guide guide;
  guide.min_radius = guide.max_radius = guide.radius = widest_gather(scene);
  guide.caustic_radius = bounds.common(static_cast<float>(seen.footprint));
  if (!effects.traces_photons() || scene.lights().empty()) return guide;

  const EmissionPlan plan = plan_emission(context, seen);
  const bool learns = settings.use_guide;
  // else all of it as the lights shine
  guide.emission = learns ? emission_of_pilot(plan, scene) : aim_at(scene, whole_scene(scene), {}, 1);
  guide.trust = probe_lights(context, seen.hits(), extent_of(plan.sights, scene));
  const PilotPhotons pilot = trace_pilot(context, guide.emission, guide.trust);
  if (cancel) return guide;

  if (learns)
    std::tie(guide.emission, guide.unmet) = learn_emission(context, plan, guide.emission, pilot, seen);
  if (const auto radii = size_gathers(context, pilot.photons, seen))
    guide.min_radius = radii->min, guide.max_radius = radii->max, guide.radius = radii->typical;
  if (cancel) return guide;
  DiskRadii disks = size_disks(context, pilot.photons, seen, bounds);
  guide.sharp_disks = std::move(disks.sharp), guide.soft_disks = std::move(disks.soft);
  return guide;
}

}  // namespace sluice
