// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/photons/photon_pass.h"

#include <algorithm>

#include "transport/photons/disks.h"
#include "transport/radii.h"

namespace sluice {
namespace {

constexpr int paths_per_chunk = 1024;

}  // namespace

PhotonPass::PhotonPass(const Scene& scene, const TransportSettings& settings, const Effects& effects,
                       int threads) {
  tracers_.reserve(static_cast<std::size_t>(threads));
  for (int t = 0; t < threads; ++t)
    tracers_.emplace_back(scene, settings, effects, threads, effects.tracks_states ? &states_ : nullptr);
}

bool PhotonPass::run(const PassContext& context, ThreadPool& pool, const std::atomic<bool>& cancel,
                     PhotonSet& photons, Counts& counts) {
  const int paths = std::max(context.settings.photons, 1);
  const auto chunk_count = static_cast<std::size_t>((paths + paths_per_chunk - 1) / paths_per_chunk);
  chunks_.resize(chunk_count), chunk_counts_.assign(chunk_count, {});
  const std::uint64_t key =
      key_of(context.settings.seed, Purpose::Photons, static_cast<std::uint64_t>(context.pass));
  const std::uint64_t choices =
      key_of(context.settings.seed, Purpose::PhotonChoices, static_cast<std::uint64_t>(context.pass));

  pool.parallel_for(chunk_count, [&](std::size_t c, int thread) {
    LightTracer<>& tracer = tracers_[static_cast<std::size_t>(thread)];
    tracer.counts.start(context.scene.edits().size()), tracer.trust = &context.guide.trust;
    // the thread's own while it fills: heads of neighbours share cache lines
    std::vector<Photon> found = std::move(chunks_[c]);
    found.clear();
    const int end = std::min(paths, static_cast<int>(c + 1) * paths_per_chunk);
    for (int path = static_cast<int>(c) * paths_per_chunk;
         path < end && !cancel.load(std::memory_order_relaxed); ++path) {
      const Sampler sampler(key, static_cast<std::uint32_t>(path));
      if (const auto photon = emit_photon(context.scene, context.guide.emission, sampler))
        tracer.trace(*photon, 1.0f / static_cast<float>(paths), sampler,
                     mix(choices, static_cast<std::uint64_t>(path)), found);
    }
    chunks_[c] = std::move(found);
    chunk_counts_[c] = std::move(tracer.counts);
  });
  if (cancel) return false;
  for (const Counts& t : chunk_counts_) counts += t;

  photons.states = &states_;
  const float shrink = radius_scale(context.pass);
  photons.at_y.build(chunks_, context.effects.indirect ? context.effects.stored_arrivals : 0,
                     2 * context.guide.radius * shrink, pool, cancel);
  const DiskBounds bounds(context.scene.camera(), context.scene.frame(), context.settings);
  const DiskReach reach_of(bounds, context.guide.sharp_disks, context.guide.soft_disks, shrink);
  photons.at_v.build_by_reach(chunks_, context.effects.arrivals_at_v, reach_of, pool, cancel);
  return !cancel;
}

}  // namespace sluice
