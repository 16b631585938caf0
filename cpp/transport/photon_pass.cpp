// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/photon_pass.h"

#include <algorithm>

namespace sluice {
namespace {

constexpr int paths_per_chunk = 1024;

}  // namespace

PhotonPass::PhotonPass(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads) {
  tracers_.reserve(static_cast<std::size_t>(threads));
  for (int t = 0; t < threads; ++t) tracers_.emplace_back(scene, settings, effects, threads);
}

bool PhotonPass::run(const PassContext& context, ThreadPool& pool, const std::atomic<bool>& cancel, PhotonSet& photons, Counts& counts) {
  const int paths = std::max(context.settings.photons, 1);
  const auto chunk_count = static_cast<std::size_t>((paths + paths_per_chunk - 1) / paths_per_chunk);
  chunks_.resize(chunk_count), chunk_thread_.assign(chunk_count, 0), chunk_counts_.assign(chunk_count, {});
  const std::uint64_t key = key_of(context.settings.seed, Purpose::Photons, static_cast<std::uint64_t>(context.pass));
  const std::uint64_t choices = key_of(context.settings.seed, Purpose::PhotonChoices, static_cast<std::uint64_t>(context.pass));

  pool.parallel_for(chunk_count, [&](std::size_t c, int thread) {
    LightTracer& tracer = tracers_[static_cast<std::size_t>(thread)];
    tracer.counts = {}, tracer.trust_at_y = context.guide.trust.at_y;
    chunks_[c].clear();
    chunk_thread_[c] = thread;
    const int end = std::min(paths, static_cast<int>(c + 1) * paths_per_chunk);
    for (int path = static_cast<int>(c) * paths_per_chunk; path < end && !cancel.load(std::memory_order_relaxed); ++path) {
      const Sampler sampler(key, static_cast<std::uint32_t>(path));
      if (const auto photon = emit_photon(context.scene, context.guide, sampler))
        tracer.trace(*photon, 1.0f / static_cast<float>(paths), sampler, mix(choices, static_cast<std::uint64_t>(path)), chunks_[c]);
    }
    chunk_counts_[c] = std::move(tracer.counts);
  });
  if (cancel) return false;
  for (const Counts& t : chunk_counts_) counts += t;

  photons.states.clear();
  if (context.effects.words) number_states(photons, pool, cancel);
  const float shrink = radius_scale(context.pass);
  photons.all.build(chunks_, context.effects.indirect ? context.effects.stored_arrivals : 0, 2 * context.guide.radius * shrink, pool, cancel);
  photons.close.build(chunks_, context.effects.close_arrivals, 2 * context.settings.caustic_radius_range * context.guide.caustic_radius * shrink, pool, cancel);
  return !cancel;
}

// Each thread has numbered states as it met them; here they get numbers by content.
void PhotonPass::number_states(PhotonSet& photons, ThreadPool& pool, const std::atomic<bool>& cancel) {
  std::vector<std::vector<std::uint8_t>> used(tracers_.size());
  for (std::size_t t = 0; t < tracers_.size(); ++t) used[t].assign(tracers_[t].states().size(), 0);
  for (std::size_t c = 0; c < chunks_.size() && !cancel; ++c)
    for (const Photon& photon : chunks_[c]) used[static_cast<std::size_t>(chunk_thread_[c])][photon.q()] = 1;

  for (std::size_t t = 0; t < tracers_.size(); ++t)
    for (StateId q = 0; q < used[t].size(); ++q)
      if (used[t][q]) {
        const auto content = tracers_[t].states().content(q);
        photons.states.emplace_back(content.begin(), content.end());
      }
  std::ranges::sort(photons.states);
  photons.states.erase(std::ranges::unique(photons.states).begin(), photons.states.end());

  std::vector<std::vector<StateId>> number(tracers_.size());
  for (std::size_t t = 0; t < tracers_.size(); ++t) {
    number[t].assign(used[t].size(), 0);
    for (StateId q = 0; q < used[t].size(); ++q) {
      if (!used[t][q]) continue;
      const auto content = tracers_[t].states().content(q);
      const auto at = std::ranges::lower_bound(photons.states, std::vector<std::uint32_t>(content.begin(), content.end()));
      number[t][q] = static_cast<StateId>(at - photons.states.begin());
    }
  }
  pool.parallel_for(chunks_.size(), [&](std::size_t c, int) {
    if (cancel) return;
    const auto& numbers = number[static_cast<std::size_t>(chunk_thread_[c])];
    for (Photon& photon : chunks_[c]) photon.set_q(numbers[photon.q()]);
  });
}

}  // namespace sluice
