// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view_pass.h"

namespace sluice {
namespace {

// The mean of a pass's samples of pixel (x, y); that of the layers is added to `layers`.
PixelSample sample_pixel(const PassContext& context, ViewTracer& tracer, int x, int y, std::vector<Color>& layers) {
  const FrameDescription& frame = context.scene.frame();
  const auto pixel = static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(frame.width) + static_cast<std::uint64_t>(x);
  const std::uint64_t key = key_of(context.settings.seed, Purpose::View, pixel);
  const std::uint64_t choices = key_of(context.settings.seed, Purpose::ViewChoices, pixel, static_cast<std::uint64_t>(context.pass));
  const auto stream = static_cast<std::uint32_t>(context.pass % stream_count), index = static_cast<std::uint32_t>(context.pass / stream_count);
  const std::uint32_t count = context.guide.samples.at(x, y);
  const std::size_t layers_at = layers.size();
  const float share = 1 / static_cast<float>(count);
  PixelSample mean;
  if (context.effects.layers) layers.resize(layers_at + tracer.layers().size(), Color(0));
  for (std::uint32_t i = 0; i < count; ++i) {
    PixelSample sample = tracer.trace(x, y, Sampler(key, index * count + i, stream), i == 0 ? choices : mix(choices, i));
    mean += sample *= share;
    for (std::size_t l = layers_at; l < layers.size(); ++l) layers[l] += tracer.layers()[l - layers_at] * share;
  }
  return mean;
}

}  // namespace

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
        samples.push_back(sample_pixel(context, tracer, x, y, layers));
      }
    tile_counts_[t] = std::move(tracer.counts);
    const std::lock_guard lock(film_lock);
    film.add_tile(static_cast<int>(t), context.pass, samples, layers);
  });
  for (const Counts& t : tile_counts_) counts += t;
  return !cancel;
}

}  // namespace sluice
