// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/view_pass.h"

namespace sluice {
namespace {

// A bundle is every second pixel, both ways, of a square of the full frame: near each other, while neighbours
// in the picture belong to other bundles and do not share their errors.
constexpr int cell_side = 8, pixels_apart = 2;
static_assert((cell_side / pixels_apart) * (cell_side / pixels_apart) == bundle_size &&
              Film::tile % cell_side == 0);

struct Pixel {
  int x, y;
  // of the tile: else it is traced for the others' sake, so that the picture does not depend on the border
  bool is_inside;
  SampleCount count;  // in a pass
  int probe;          // < 0: it is none
};

class PixelGroup {
 public:
  PixelGroup(const PassContext& context, int x0, int y0, const Film::Box& box, const ProbeGrid* grid)
      : key_(key_of(context.settings.seed, Purpose::Turns, static_cast<std::uint64_t>(y0),
                    static_cast<std::uint64_t>(x0))) {
    const FrameDescription& frame = context.scene.frame();
    for (int place = 0; place < static_cast<int>(bundle_size); ++place) {
      // Rows are walked there and back, so that each pixel lies next to the one before.
      const int j = place / in_row, i = j % 2 == 0 ? place % in_row : in_row - 1 - place % in_row;
      const int x = x0 + pixels_apart * i, y = y0 + pixels_apart * j;
      if (x >= frame.width || y >= frame.height) continue;
      const bool inside = x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1;
      const int probe = inside && grid ? grid->index_of(x, y) : -1;
      pixels_[count_++] = {x, y, inside, context.guide.samples.at(x, y), probe};
      is_inside_ = is_inside_ || inside;
    }
  }
  [[nodiscard]] bool is_inside() const noexcept { return is_inside_; }  // some pixel
  [[nodiscard]] std::span<const Pixel> pixels() const noexcept { return {pixels_.data(), count_}; }
  [[nodiscard]] std::uint64_t key() const noexcept { return key_; }

 private:
  static constexpr int in_row = cell_side / pixels_apart;
  std::array<Pixel, bundle_size> pixels_;
  std::size_t count_ = 0;
  std::uint64_t key_;
  bool is_inside_ = false;
};

std::uint64_t number_of(const PassContext& context, const Pixel& pixel) noexcept {
  return static_cast<std::uint64_t>(pixel.y) * static_cast<std::uint64_t>(context.scene.frame().width) +
         static_cast<std::uint64_t>(pixel.x);
}

// A pixel's sample `round` in this pass, of so many, by the sequence of the key.
Sampler sampler_of(const PassContext& context, std::uint64_t key, std::uint32_t samples,
                   std::uint32_t round) noexcept {
  const auto stream = static_cast<std::uint32_t>(context.pass % stream_count),
             index = static_cast<std::uint32_t>(context.pass / stream_count);
  return Sampler(key, index * samples + round, stream);
}

ViewSample sample_of(const PassContext& context, const Pixel& pixel, std::uint32_t round) {
  const std::uint64_t number = number_of(context, pixel);
  const std::uint64_t choices =
      key_of(context.settings.seed, Purpose::ViewChoices, number, static_cast<std::uint64_t>(context.pass));
  return {.x = pixel.x,
          .y = pixel.y,
          .sampler = sampler_of(context, key_of(context.settings.seed, Purpose::View, number),
                                pixel.count.samples, round),
          .key = mix(choices, round),
          .share = pixel.is_inside ? 1 / static_cast<float>(pixel.count.samples) : 0,
          .light_samples = pixel.count.light_samples,
          .seeks = pixel.count.emission_samples > 0 ? Seeks::AllButEmission : Seeks::All,
          .is_probed = pixel.probe >= 0};
}

// The same of those of emission alone: points of a sequence of their own.
ViewSample emission_sample_of(const PassContext& context, const Pixel& pixel, std::uint32_t round) {
  const std::uint64_t key = key_of(context.settings.seed, Purpose::Emission, number_of(context, pixel));
  return {.x = pixel.x,
          .y = pixel.y,
          .sampler = sampler_of(context, key, pixel.count.emission_samples, round),
          .key = mix(mix(key, static_cast<std::uint64_t>(context.pass)), round),
          .share = 1 / static_cast<float>(pixel.count.emission_samples),
          .seeks = Seeks::Emission,
          .is_probed = pixel.probe >= 0};
}

std::size_t index_in(const Film::Box& box, const Pixel& p) noexcept {
  return static_cast<std::size_t>(p.y - box.y0) * static_cast<std::size_t>(box.x1 - box.x0) +
         static_cast<std::size_t>(p.x - box.x0);
}

// Gather segments of one round, to the samples of a bundle. Those that send one by turns go like the fields
// of a chessboard, in each stream the other way round from pass to pass; who begins is a matter of chance.
void deal_segments(const PassContext& context, std::uint64_t key, std::uint32_t round,
                   std::span<const Pixel* const> pixels, std::span<ViewSample> bundle) {
  auto turn = static_cast<std::uint32_t>(context.pass % stream_count + context.pass / stream_count) + round +
              static_cast<std::uint32_t>(key & 1);
  std::uint32_t place = 0, always = 0, by_turns = 0;
  for (std::size_t i = 0; i < bundle.size(); ++i) {
    const SampleCount& count = pixels[i]->count;
    const bool has_turns = count.gather_segments == SampleCount::by_turns;
    bundle[i].segments = {.mean = count.mean_segments(),
                          .count = has_turns ? turn++ % 2 : count.gather_segments,
                          .first = {},
                          .place = place};
    place += bundle[i].segments.count;
    always += count.gather_segments, by_turns += has_turns;
  }
  // segments that a pass sends: so many of the sequence's points are its own
  const std::uint32_t most = always + (by_turns + 1) / 2;
  const Sampler first = sampler_of(context, mix(key, round), most, 0);
  for (ViewSample& sample : bundle) sample.segments.first = first;
}

// In rounds: a bundle takes at most one sample of a pixel. Adds count_of(pixel) samples of each to the tile,
// as made by sample(pixel, round).
template <class Count, class Sample>
void trace_rounds(const PassContext& context, const PixelGroup& group, const Film::Box& box,
                  const Count& count_of, const Sample& sample, ViewTracer& tracer, TileSamples& tile) {
  std::array<ViewSample, bundle_size> samples;
  std::array<const Pixel*, bundle_size> pixels;
  for (std::uint32_t round = 0;; ++round) {
    std::size_t count = 0;
    for (const Pixel& p : group.pixels())
      if (count_of(p) > round) {
        samples[count] = sample(p, round);
        pixels[count++] = &p;
      }
    if (count == 0) break;
    const std::span bundle = std::span(samples).first(count);
    if (bundle[0].seeks != Seeks::Emission)
      deal_segments(context, group.key(), round, std::span(pixels).first(count), bundle);
    tracer.trace(bundle);
    for (std::size_t i = 0; i < count; ++i) {
      const Pixel& p = *pixels[i];
      if (!p.is_inside) continue;
      tile.add(index_in(box, p), tracer.sample(i), tracer.layers(i));
      if (p.probe >= 0) tile.add_probed(p.probe, index_in(box, p), tracer.edits(i));
    }
  }
}

// Means of the pixels' samples, and of those of emission alone: these come in bundles of their own, which
// share nothing.
void sample_pixels(const PassContext& context, const PixelGroup& group, const Film::Box& box,
                   ViewTracer& tracer, TileSamples& tile) {
  const auto scale = [&](const Pixel& p, float factor) {
    if (p.is_inside) tile.scale(index_in(box, p), factor);
  };
  const auto emission_of = [](const Pixel& p) -> std::uint32_t {
    return p.is_inside ? p.count.emission_samples : 0;
  };
  const auto emission_sample = [&](const Pixel& p, std::uint32_t round) {
    return emission_sample_of(context, p, round);
  };
  trace_rounds(context, group, box, emission_of, emission_sample, tracer, tile);
  for (const Pixel& p : group.pixels())
    if (emission_of(p) > 0)
      scale(p, static_cast<float>(p.count.samples) / static_cast<float>(p.count.emission_samples));
  const auto all_of = [](const Pixel& p) -> std::uint32_t { return p.count.samples; };
  const auto sample = [&](const Pixel& p, std::uint32_t round) { return sample_of(context, p, round); };
  trace_rounds(context, group, box, all_of, sample, tracer, tile);
  // once, so that alpha is exactly 1
  for (const Pixel& p : group.pixels()) scale(p, 1 / static_cast<float>(p.count.samples));
}

}  // namespace

void TileSamples::add(std::size_t pixel, const PixelSample& sample, std::span<const Color> of_layers) {
  samples[pixel] += sample;
  for (std::size_t l = 0; l < of_layers.size(); ++l) layers[pixel * of_layers.size() + l] += of_layers[l];
}

void TileSamples::add_probed(int probe, std::size_t pixel, std::span<const TakenLight> of_edits) {
  if (place_of[pixel] < 0) {
    place_of[pixel] = static_cast<int>(probed.size());
    probed.push_back({probe, pixel}), edits.insert(edits.end(), of_edits.begin(), of_edits.end());
    return;
  }
  const std::size_t first = static_cast<std::size_t>(place_of[pixel]) * of_edits.size();
  for (std::size_t e = 0; e < of_edits.size(); ++e) edits[first + e] += of_edits[e];
}

// What edits took has its share of the pixel's mean already (ViewSample::share).
void TileSamples::scale(std::size_t pixel, float factor) {
  samples[pixel] *= factor;
  const std::size_t count = layers.size() / samples.size();
  for (std::size_t l = 0; l < count; ++l) layers[pixel * count + l] *= factor;
}

ViewPass::ViewPass(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads)
    : tiles_(static_cast<std::size_t>(threads)) {
  for (int t = 0; t < threads; ++t) tracers_.emplace_back(scene, settings, effects, threads);
}

bool ViewPass::run(const PassContext& context, const PhotonSet& photons, ThreadPool& pool,
                   const std::atomic<bool>& cancel, Film& film, std::mutex& film_lock, Counts& counts,
                   Probes* probes) {
  const ProbeGrid* grid = probes ? &probes->grid() : nullptr;
  for (ViewTracer& tracer : tracers_) tracer.start_pass(context, photons);
  tile_counts_.assign(static_cast<std::size_t>(film.tile_count()), {});
  pool.parallel_for(static_cast<std::size_t>(film.tile_count()), [&](std::size_t t, int thread) {
    ViewTracer& tracer = tracers_[static_cast<std::size_t>(thread)];
    TileSamples& tile = tiles_[static_cast<std::size_t>(thread)];
    tracer.counts().start(context.scene.edits().size());
    if (!sample_tile(context, film.box(static_cast<int>(t)), grid, tracer, tile, cancel)) return;
    tile_counts_[t] = std::move(tracer.counts());
    const std::lock_guard lock(film_lock);
    film.add_tile(static_cast<int>(t), context.pass, tile.samples, tile.layers);
    for (std::size_t i = 0; i < tile.probed.size(); ++i) {
      const auto [probe, pixel] = tile.probed[i];
      const std::size_t count = tile.edits.size() / tile.probed.size();
      probes->add(probe, context.pass, tile.samples[pixel], std::span(tile.edits).subspan(i * count, count));
    }
  });
  for (const Counts& t : tile_counts_) counts += t;
  return !cancel;
}

// The means of a pass's samples, pixel by pixel of the tile. False: cancelled.
bool ViewPass::sample_tile(const PassContext& context, Film::Box box, const ProbeGrid* grid,
                           ViewTracer& tracer, TileSamples& tile, const std::atomic<bool>& cancel) {
  const FrameDescription& frame = context.scene.frame();
  box = {box.x0 + frame.x0, box.y0 + frame.y0, box.x1 + frame.x0, box.y1 + frame.y0};
  const std::size_t pixels =
                        static_cast<std::size_t>(box.x1 - box.x0) * static_cast<std::size_t>(box.y1 - box.y0),
                    layers = context.scene.edits().layers().size();
  tile.samples.assign(pixels, {}), tile.layers.assign(pixels * layers, Color(0));
  tile.probed.clear(), tile.edits.clear(), tile.place_of.assign(pixels, -1);
  const auto down = [](int x) { return x / cell_side * cell_side; };
  for (int y = down(box.y0); y < box.y1; y += cell_side)
    for (int x = down(box.x0); x < box.x1; x += cell_side)
      for (int part = 0; part < square(pixels_apart); ++part) {
        if (cancel.load(std::memory_order_relaxed)) return false;
        const PixelGroup group(context, x + part % pixels_apart, y + part / pixels_apart, box, grid);
        if (group.is_inside()) sample_pixels(context, group, box, tracer, tile);
      }
  return true;
}

}  // namespace sluice
