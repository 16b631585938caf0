// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/sample_pilot.h"

#include <algorithm>
#include <numeric>

#include "transport/photon_pass.h"
#include "transport/view_path.h"

namespace sluice {
namespace {

constexpr int least_side = 4, most_blocks = 512;  // of a block, in pixels; along the frame's longer side
constexpr double wanted_mean = 1.5;  // samples of a pixel; fewer leave nothing to place, more make passes long

// What the pilot's pairs of samples in one block say.
struct Block {
  V3d mean{0}, variance{0};  // of one sample
  void operator+=(const Block& o) { mean += o.mean, variance += o.variance; }
  void operator/=(double n) { mean /= n, variance /= n; }
};

// Two samples of a pixel in each quarter of the block: differences inside of a pixel are noise, those between pixels may be texture.
Block look_at(ViewTracer& tracer, const PassContext& context, int x0, int y0, int side) {
  const FrameDescription& frame = context.scene.frame();
  Block block;
  int pairs = 0;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const std::uint64_t key = key_of(context.settings.seed, Purpose::Pilot, static_cast<std::uint64_t>(y0) * static_cast<std::uint64_t>(frame.width) + static_cast<std::uint64_t>(x0), static_cast<std::uint64_t>(quarter));
    const auto place = [half = static_cast<std::uint64_t>(side / 2)](std::uint64_t bits) { return static_cast<int>((bits & 0xffffffffu) * half >> 32); };
    const int x = x0 + side / 2 * (quarter % 2) + place(key), y = y0 + side / 2 * (quarter / 2) + place(key >> 32);
    if (x >= frame.width || y >= frame.height) continue;
    V3d value[2];
    for (std::uint32_t i = 0; i < 2; ++i) value[i] = V3d(tracer.trace(x, y, Sampler(mix(key, 2 + i), 0), mix(key, 4 + i)).combined());
    block += {(value[0] + value[1]) / 2, (value[0] - value[1]) * (value[0] - value[1]) / 2};
    ++pairs;
  }
  if (pairs > 0) block /= pairs;
  return block;
}

// Eight differences are too few to trust: each block speaks for its neighbours too.
std::vector<Block> smoothed(const std::vector<Block>& blocks, std::size_t width, std::size_t height) {
  std::vector<Block> out;
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      Block sum;
      int count = 0;
      for (std::size_t v = y - (y > 0); v <= std::min(y + 1, height - 1); ++v)
        for (std::size_t u = x - (x > 0); u <= std::min(x + 1, width - 1); ++u, ++count) sum += blocks[v * width + u];
      sum /= count;
      out.push_back(sum);
    }
  return out;
}

}  // namespace

SampleMap place_samples(const PassContext& first, ThreadPool& pool, const std::atomic<bool>& cancel) {
  TransportSettings settings = first.settings;
  settings.seed = key_of(settings.seed, Purpose::Pilot, 3);  // none of these samples is in the picture
  const PassContext context{first.scene, settings, first.effects, first.guide, 0};
  PhotonSet photons;
  Counts unused;
  PhotonPass photon_pass(context.scene, settings, context.effects, pool.size());
  if (context.effects.photons() && !photon_pass.run(context, pool, cancel, photons, unused)) return {};

  const FrameDescription& frame = context.scene.frame();
  const int side = std::max(least_side, (std::max(frame.width, frame.height) + most_blocks - 1) / most_blocks);
  const auto blocks_of = [side](int pixels) { return static_cast<std::size_t>((pixels + side - 1) / side); };
  const std::size_t width = blocks_of(frame.width), height = blocks_of(frame.height);
  std::vector<ViewTracer> tracers;
  tracers.reserve(static_cast<std::size_t>(pool.size()));
  for (int t = 0; t < pool.size(); ++t) tracers.emplace_back(context.scene, settings, context.effects, pool.size()).start_pass(context, photons);
  std::vector<Block> blocks(width * height);
  pool.parallel_for(height, [&](std::size_t row, int thread) {
    for (std::size_t x = 0; x < width && !cancel.load(std::memory_order_relaxed); ++x)
      blocks[row * width + x] = look_at(tracers[static_cast<std::size_t>(thread)], context, static_cast<int>(x) * side, static_cast<int>(row) * side, side);
  });
  if (cancel) return {};

  // The picture's error is least for n in proportion to the relative standard deviation.
  double image_mean = 0;
  for (const Block& b : blocks) image_mean += luminance(b.mean) / static_cast<double>(blocks.size());
  if (!(image_mean > 0) || !std::isfinite(image_mean)) return {};
  std::vector<double> deviation;
  for (const Block& b : smoothed(blocks, width, height)) deviation.push_back(std::sqrt(relative_variance(b.variance, b.mean, image_mean)));
  const double all = std::accumulate(deviation.begin(), deviation.end(), 0.0);
  if (!(all > 0) || !std::isfinite(all)) return {};  // no noise, or more than numbers hold
  const double scale = wanted_mean * static_cast<double>(deviation.size()) / all;
  std::vector<std::uint8_t> counts;
  for (const double d : deviation) counts.push_back(static_cast<std::uint8_t>(std::clamp(std::round(scale * d), 1.0, static_cast<double>(SampleMap::most))));
  return {side, width, std::move(counts)};
}

}  // namespace sluice
