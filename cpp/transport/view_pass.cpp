// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view_pass.h"

namespace sluice {

ViewPass::ViewPass(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads)
    : samples_(static_cast<std::size_t>(threads)), layers_(samples_.size()) {
  tracers_.reserve(static_cast<std::size_t>(threads));
  for (int t = 0; t < threads; ++t) tracers_.emplace_back(scene, settings, effects, threads);
}

bool ViewPass::run(const PassContext& context, const PhotonSet& photons, ThreadPool& pool, const std::atomic<bool>& cancel, Film& film,
                   std::mutex& film_lock, Counts& counts) {
  for (ViewTracer& tracer : tracers_) tracer.start_pass(context, photons);
  tile_counts_.assign(static_cast<std::size_t>(film.tile_count()), {});
  const FrameDescription& frame = context.scene.frame();
  const auto stream = static_cast<std::uint32_t>(context.pass % stream_count), index = static_cast<std::uint32_t>(context.pass / stream_count);

  pool.parallel_for(static_cast<std::size_t>(film.tile_count()), [&](std::size_t t, int thread) {
    if (cancel.load(std::memory_order_relaxed)) return;
    ViewTracer& tracer = tracers_[static_cast<std::size_t>(thread)];
    std::vector<PixelSample>& samples = samples_[static_cast<std::size_t>(thread)];
    std::vector<Color>& layers = layers_[static_cast<std::size_t>(thread)];
    samples.clear(), layers.clear();
    tracer.counts = {};
    tracer.counts.edits.resize(static_cast<std::size_t>(context.scene.edits().size()));
    const Film::Box box = film.box(static_cast<int>(t));
    for (int y = box.y0 + frame.y0; y < box.y1 + frame.y0; ++y)
      for (int x = box.x0 + frame.x0; x < box.x1 + frame.x0; ++x) {
        if (cancel.load(std::memory_order_relaxed)) return;
        const auto pixel = static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(frame.width) + static_cast<std::uint64_t>(x);
        const Sampler sampler(key_of(context.settings.seed, Purpose::View, pixel), index, stream);
        samples.push_back(tracer.trace(x, y, sampler, key_of(context.settings.seed, Purpose::ViewChoices, pixel, static_cast<std::uint64_t>(context.pass))));
        if (context.effects.layers) layers.insert(layers.end(), tracer.layers().begin(), tracer.layers().end());
      }
    tile_counts_[t] = tracer.counts;
    const std::lock_guard lock(film_lock);
    film.add_tile(static_cast<int>(t), context.pass, samples, layers);
  });
  for (const Counts& t : tile_counts_) counts += t;
  return !cancel;
}

}  // namespace sluice
