// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/sample_pilot.h"

#include <algorithm>
#include <deque>

#include "transport/view/view_tracer.h"

namespace sluice {
namespace {

constexpr int min_side = 4, max_blocks = 512;  // of a block, in pixels; along the frame's longer side
// Of a view sample by itself and of each gather segment, against that of asking one light; of a sample of
// emission alone.
constexpr double cost_of_path = 4.5, cost_of_segment = 5.5, cost_of_emission = 1.3;
constexpr std::uint8_t max_light_samples = 4, pilot_light_samples = 2;
constexpr std::uint8_t choices_of_segments[] = {SampleCount::by_turns, 1, 2, 4};
// Weight of a block's own estimate of its noise against each neighbour's, per axis, in the smoothing filter.
constexpr double own_weight = 4;
// samples of a pixel, by the time they take; fewer leave nothing to place, more make passes long
constexpr double wanted_mean = 2.5;

double cost_of_one(const SampleCount& count) {
  return cost_of_path + count.light_samples + cost_of_segment * count.mean_segments();
}

// What pairs of samples in one block say, summed up.
struct Block {
  V3d mean{0};      // of the picture
  V3d variance{0};  // of one sample, but for emission that is seen
  V3d lights{0};    // of that what comes by the samples of lights
  V3d segments{0};  // and what by gather segments
  // of what is seen: mean, mean square, and of one sample
  V3d emission{0}, emission2{0}, emission_variance{0};
  double pairs = 0;
  void operator+=(const Block& o) { add(o, 1); }
  void add(const Block& o, double weight) {
    mean += o.mean * weight, variance += o.variance * weight, lights += o.lights * weight,
        segments += o.segments * weight;
    emission += o.emission * weight, emission2 += o.emission2 * weight,
        emission_variance += o.emission_variance * weight;
    pairs += o.pairs * weight;
  }

  // Of emission. Lamps are so bright that pixels on their edges need many samples, and a pair finds few of
  // those pixels: there what differs between pixels counts too.
  [[nodiscard]] double relative_of_emission(double image_mean) const {
    const V3d seen = emission / pairs;
    V3d edges = emission2 / pairs - seen * seen;
    for (int c = 0; c < 3; ++c) edges[c] = std::max(0.0, edges[c]);  // rounding
    return relative_variance(emission_variance / pairs + edges, mean / pairs, image_mean);
  }
};

// Of one sample in a block, against the picture.
struct Noise {
  double rest, lights, segments;  // the last two with one light sample and one gather segment
  double emission;                // that is seen

  Noise(const Block& b, double image_mean) : emission(b.relative_of_emission(image_mean)) {
    const auto relative = [&](const V3d& variance) {
      return relative_variance(variance / b.pairs, b.mean / b.pairs, image_mean);
    };
    V3d left = b.variance - b.lights - b.segments;
    for (int c = 0; c < 3; ++c) left[c] = std::max(0.0, left[c]);  // all are estimates
    rest = relative(left), lights = relative(b.lights) * pilot_light_samples,
    segments = relative(b.segments) * SampleCount{}.mean_segments();
  }
  // Of all but emission.
  [[nodiscard]] double of_one(const SampleCount& count) const {
    return rest + lights / count.light_samples + segments / count.mean_segments();
  }
};

// Calls act(count) for each choice of what one sample may take.
template <class Act>
void for_each_kind(Act&& act) {
  for (const std::uint8_t segments : choices_of_segments)
    for (std::uint8_t lights = 1; lights <= max_light_samples; ++lights)
      act(SampleCount{.light_samples = lights, .gather_segments = segments});
}

// Two samples of a pixel in each quarter of a block: differences inside of a pixel are noise, those between
// pixels may be texture. Blocks are looked at by fours, as a bundle is.
constexpr std::size_t quarters = 4;
static_assert(bundle_size == 4 * quarters);

// Of the block at (x0, y0), one in each quarter; `which` of the two.
ViewSample sample_of(const PassContext& context, int x0, int y0, int side, int quarter, std::uint32_t which) {
  const auto width = static_cast<std::uint64_t>(context.scene.frame().width);
  const std::uint64_t key = key_of(context.settings.seed, Purpose::Pilot,
                                   static_cast<std::uint64_t>(y0) * width + static_cast<std::uint64_t>(x0),
                                   static_cast<std::uint64_t>(quarter));
  const auto place = [half = static_cast<std::uint64_t>(side / 2)](std::uint64_t bits) {
    return static_cast<int>((bits & 0xffffffffu) * half >> 32);
  };
  const int x = x0 + side / 2 * (quarter % 2) + place(key),
            y = y0 + side / 2 * (quarter / 2) + place(key >> 32);
  const Sampler sampler(mix(key, 2 + which), 0);
  // as in passes, like the fields of a chessboard
  const bool has_turn = static_cast<std::uint32_t>(quarter % 2 ^ quarter / 2) == which;
  return {.x = x,
          .y = y,
          .sampler = sampler,
          .key = mix(key, 4 + which),
          .share = 0,
          .segments = {.mean = SampleCount{}.mean_segments(), .count = has_turn, .first = sampler},
          .light_samples = pilot_light_samples,
          .measures_lights = true};
}

// The blocks next to each other in a square of two by two, as far as they lie in the frame.
void look_at(ViewTracer& tracer, const PassContext& context, std::size_t column, std::size_t row, int side,
             std::size_t width, std::vector<Block>& blocks) {
  const FrameDescription& frame = context.scene.frame();
  std::array<ViewSample, bundle_size> bundle[2];
  std::array<std::size_t, bundle_size> block_of;
  std::size_t count = 0;
  for (std::size_t i = 0; i < bundle_size; ++i) {
    const std::size_t x = column + i / quarters % 2, y = row + i / quarters / 2;
    for (std::uint32_t which = 0; which < 2; ++which)
      bundle[which][count] = sample_of(context, static_cast<int>(x) * side, static_cast<int>(y) * side, side,
                                       static_cast<int>(i % quarters), which);
    if (bundle[0][count].x >= frame.width || bundle[0][count].y >= frame.height) continue;
    block_of[count++] = y * width + x;
  }
  std::array<PixelSample, bundle_size> value[2];
  std::array<V3d, bundle_size> lights[2];
  for (int which = 0; which < 2; ++which) {
    tracer.trace(std::span(bundle[which]).first(count));
    for (std::size_t i = 0; i < count; ++i)
      value[which][i] = tracer.sample(i), lights[which][i] = tracer.light_variance(i);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const V3d a(value[0][i].combined()), b(value[1][i].combined());
    const auto emission = [&](int which) {
      return V3d(value[which][i].parts[static_cast<std::size_t>(Part::Emission)]);
    };
    const auto indirect = [&](int which) {
      return V3d(value[which][i].parts[static_cast<std::size_t>(Part::Indirect)]);
    };
    const V3d of_indirect = indirect(0) - indirect(1);
    const V3d seen = (emission(0) + emission(1)) / 2, of_emission = emission(0) - emission(1),
              of_rest = a - b - of_emission;
    blocks[block_of[i]] += {.mean = (a + b) / 2,
                            .variance = of_rest * of_rest / 2,
                            .lights = (lights[0][i] + lights[1][i]) / 2,
                            .segments = of_indirect * of_indirect / 2,
                            .emission = seen,
                            .emission2 = seen * seen,
                            .emission_variance = of_emission * of_emission / 2,
                            .pairs = 1};
  }
}

// Four differences are too few to trust: each block's neighbours speak for it too, but more softly, as noise
// changes at edges.
std::vector<Block> smoothed(const std::vector<Block>& blocks, std::size_t width, std::size_t height) {
  std::vector<Block> out;
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      Block sum;
      for (std::size_t v = y - (y > 0); v <= std::min(y + 1, height - 1); ++v)
        for (std::size_t u = x - (x > 0); u <= std::min(x + 1, width - 1); ++u)
          sum.add(blocks[v * width + u], (u == x ? own_weight : 1) * (v == y ? own_weight : 1));
      out.push_back(sum);
    }
  return out;
}

std::uint8_t rounded(double count, double least, double most) {
  return static_cast<std::uint8_t>(std::clamp(std::round(count), least, most));
}

// What leaves a block least noise, where time costs so much of it.
SampleCount best_count(const Noise& noise, double price) {
  SampleCount best;
  double least = infinity;
  for_each_kind([&](SampleCount count) {
    const double of_one = noise.of_one(count), cost = price * cost_of_one(count);
    count.samples = rounded(std::sqrt(of_one / cost), 1, SampleMap::max_samples);
    const double loss = of_one / count.samples + cost * count.samples;
    if (loss < least) least = loss, best = count;
  });
  best.emission_samples =
      rounded(std::sqrt(noise.emission / (price * cost_of_emission)), 0, SampleMap::max_emission_samples);
  // the others see as much (and what was meant for them is left)
  if (best.emission_samples <= best.samples) best.emission_samples = 0;
  return best;
}

// How many each block takes: the picture's error is least for a time if one more sample lowers it by the same
// for its cost everywhere. Then numbers are as the root of a sample's noise over its cost. Empty: there is no
// noise, or more than numbers hold.
std::vector<SampleCount> share_out(const std::vector<Block>& blocks, double image_mean) {
  double sum = 0;  // of the roots of noise times cost: all time is that over the root of the price
  std::vector<Noise> noises;
  for (const Block& b : blocks) {
    const Noise& noise = noises.emplace_back(b, image_mean);
    double least = infinity;
    for_each_kind(
        [&](const SampleCount& count) { least = std::min(least, noise.of_one(count) * cost_of_one(count)); });
    sum += std::sqrt(least) + std::sqrt(noise.emission * cost_of_emission);
  }
  const double price = square(sum / (wanted_mean * cost_of_one({}) * static_cast<double>(blocks.size())));
  if (!(price > 0) || !std::isfinite(price)) return {};
  std::vector<SampleCount> counts;
  for (const Noise& noise : noises) counts.push_back(best_count(noise, price));
  return counts;
}

}  // namespace

SampleMap place_samples(const PassContext& first, const PhotonSet& photons, ThreadPool& pool,
                        const std::atomic<bool>& cancel) {
  TransportSettings settings = first.settings;
  settings.seed = key_of(settings.seed, PilotPurpose::Samples);  // none of these samples is in the picture
  const PassContext context{first.scene, settings, first.effects, first.guide, first.pass};
  const FrameDescription& frame = context.scene.frame();
  const int side = std::max(min_side, (std::max(frame.width, frame.height) + max_blocks - 1) / max_blocks);
  const auto blocks_of = [side](int pixels) { return static_cast<std::size_t>((pixels + side - 1) / side); };
  const std::size_t width = blocks_of(frame.width), height = blocks_of(frame.height);
  std::deque<ViewTracer> tracers;
  for (int t = 0; t < pool.size(); ++t)
    tracers.emplace_back(context.scene, settings, context.effects, pool.size()).start_pass(context, photons);
  std::vector<Block> blocks(width * height);
  pool.parallel_for((height + 1) / 2, [&](std::size_t pair, int thread) {
    for (std::size_t x = 0; x < width && !cancel.load(std::memory_order_relaxed); x += 2)
      look_at(tracers[static_cast<std::size_t>(thread)], context, x, 2 * pair, side, width, blocks);
  });
  if (cancel) return {};

  double image_mean = 0;
  for (const Block& b : blocks)
    if (b.pairs > 0) image_mean += luminance(b.mean / b.pairs) / static_cast<double>(blocks.size());
  if (!(image_mean > 0) || !std::isfinite(image_mean)) return {};
  return {side, width, share_out(smoothed(blocks, width, height), image_mean)};
}

}  // namespace sluice
