// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/pilot_photons.h"

#include <algorithm>

#include "transport/pass.h"
#include "transport/photons/light_tracer.h"

namespace sluice {
namespace {

constexpr int paths_per_chunk = 2048;

}  // namespace

PilotPhotons trace_pilot(const PilotContext& context, const EmissionGuide& emission,
                         const LightTrusts& trust) {
  const int paths = context.settings.pilot_paths;
  const auto chunks = static_cast<std::size_t>((paths + paths_per_chunk - 1) / paths_per_chunk);
  std::vector<LightTracer<>> tracers;
  for (int t = 0; t < context.pool.size(); ++t)
    tracers.emplace_back(context.scene, context.settings, context.effects, context.pool.size()).trust =
        &trust;
  PilotPhotons pilot{std::vector<std::vector<Photon>>(chunks), std::vector<std::vector<PilotPath>>(chunks)};
  context.pool.parallel_for(chunks, [&](std::size_t c, int thread) {
    std::vector<Photon> photons;  // the thread's own while it fills
    std::vector<PilotPath> starts;
    const auto begin = static_cast<std::uint32_t>(c) * paths_per_chunk,
               end = std::min(begin + paths_per_chunk, static_cast<std::uint32_t>(paths));
    for (std::uint32_t path = begin; path < end && !context.cancel; ++path) {
      const Sampler sampler(key_of(context.settings.seed, PilotPurpose::Photons), path);
      const auto photon = emit_photon(context.scene, emission, sampler);
      if (!photon) continue;
      tracers[static_cast<std::size_t>(thread)].trace(*photon, 1.0f / static_cast<float>(paths), sampler,
                                                      path, photons);
      starts.push_back({photon->light, photon->origin, photon->direction, photons.size()});
    }
    pilot.photons[c] = std::move(photons), pilot.paths[c] = std::move(starts);
  });
  return pilot;
}

}  // namespace sluice
