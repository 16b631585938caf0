// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/probes.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"

namespace sluice {

ProbeGrid::ProbeGrid(const FrameDescription& frame) noexcept
    : x0_(frame.x0), y0_(frame.y0), x1_(frame.x1), y1_(frame.y1), side_(1) {
  const auto blocks = [this](int pixels) { return (pixels + side_ - 1) / side_; };
  while (static_cast<std::int64_t>(blocks(x1_ - x0_)) * blocks(y1_ - y0_) > max_probes) ++side_;
  blocks_x_ = blocks(x1_ - x0_), blocks_y_ = blocks(y1_ - y0_);
}

int ProbeGrid::index_of(int x, int y) const noexcept {
  if (x < x0_ || y < y0_ || x >= x1_ || y >= y1_) return -1;
  const int bx = (x - x0_) / side_, by = (y - y0_) / side_;
  const std::uint64_t chance = mix(static_cast<std::uint64_t>(bx), static_cast<std::uint64_t>(by));
  // The last blocks may hang over the border's edge.
  const int width = std::min(side_, x1_ - x0_ - bx * side_), height = std::min(side_, y1_ - y0_ - by * side_);
  const auto place = [](std::uint64_t bits, int size) {
    return static_cast<int>(bits % static_cast<std::uint64_t>(size));
  };
  const bool is_probe = (x - x0_) % side_ == place(chance & 0xffffffffu, width) &&
                        (y - y0_) % side_ == place(chance >> 32, height);
  return is_probe ? by * blocks_x_ + bx : -1;
}

Probes::Probes(const FrameDescription& frame, int edits)
    : grid_(frame),
      probes_(static_cast<std::size_t>(grid_.size())),
      edit_count_(static_cast<std::size_t>(edits)),
      edits_(probes_.size() * stream_count * edit_count_) {}

void Probes::add(int probe, int pass, const PixelSample& sample, std::span<const float> of_edits) noexcept {
  const auto at = static_cast<std::size_t>(probe), stream = static_cast<std::size_t>(pass % stream_count);
  Stream& sums = probes_[at][stream];
  for (std::size_t part = 0; part < part_count; ++part) {
    sums.parts[part] += V3d(sample.parts[part]);
    sums.bias[part] += sample.bias[part];
  }
  ++sums.passes;
  float* edits = edits_.data() + (at * stream_count + stream) * edit_count_;
  for (std::size_t e = 0; e < of_edits.size(); ++e) edits[e] += of_edits[e];
}

// One probe's share in the means.
struct Probes::Measured {
  ErrorSquares picture;
  std::array<ErrorSquares, part_count> parts;
};

namespace {

// The square of an expectation, without the noise of its estimates: the mean of their products in pairs.
double squared_mean(const std::array<double, stream_count>& estimates) noexcept {
  double sum = 0, squares = 0;
  for (const double x : estimates) sum += x, squares += x * x;
  return (sum * sum - squares) / (stream_count * (stream_count - 1));
}

// Variance of the mean of the streams, channel by channel.
V3d variance_of(const std::array<V3d, stream_count>& means) noexcept {
  V3d mean(0), variance(0);
  for (const V3d& m : means) mean += m / stream_count;
  for (const V3d& m : means) variance += (m - mean) * (m - mean);
  return variance / (stream_count * (stream_count - 1.0));
}

}  // namespace

Probes::Measured Probes::measure(const Probe& probe, double image_mean) const noexcept {
  Measured measured;
  std::array<V3d, stream_count> whole;
  std::array<double, stream_count> whole_bias{};
  V3d mean(0);
  for (std::size_t s = 0; s < stream_count; ++s) {
    whole[s] = V3d(0);
    for (std::size_t part = 0; part < part_count; ++part) {
      whole[s] += probe[s].parts[part] / probe[s].passes;
      whole_bias[s] += probe[s].bias[part] / probe[s].passes;
    }
    mean += whole[s] / stream_count;
  }
  const double dark = square(luminance(mean)) + square(image_mean / 10);
  measured.picture = {relative_variance(variance_of(whole), mean, image_mean),
                      squared_mean(whole_bias) / dark};
  for (std::size_t part = 0; part < part_count; ++part) {
    std::array<V3d, stream_count> means;
    std::array<double, stream_count> bias;
    for (std::size_t s = 0; s < stream_count; ++s) {
      means[s] = probe[s].parts[part] / probe[s].passes;
      bias[s] = probe[s].bias[part] / probe[s].passes;
    }
    measured.parts[part] = {relative_variance(variance_of(means), mean, image_mean),
                            squared_mean(bias) / dark};
  }
  return measured;
}

double Probes::edit_noise(std::size_t probe, std::size_t edit, double image_mean) const noexcept {
  std::array<V3d, stream_count> means;
  V3d mean(0);
  for (std::size_t s = 0; s < stream_count; ++s) {
    const Stream& stream = probes_[probe][s];
    means[s] = V3d(edits_[(probe * stream_count + s) * edit_count_ + edit] / stream.passes);
    for (const V3d& part : stream.parts) mean += part / stream.passes / stream_count;
  }
  return relative_variance(variance_of(means), mean, image_mean);
}

ErrorShares Probes::shares(double image_mean) const {
  ErrorShares shares;
  shares.edits.resize(edit_count_);
  if (!(square(image_mean / 10) > 0)) return shares;
  std::vector<std::pair<double, std::size_t>> order;  // by error, the probes that every stream has met
  std::vector<Measured> all(probes_.size());
  for (std::size_t i = 0; i < probes_.size(); ++i) {
    if (std::ranges::any_of(probes_[i], [](const Stream& s) { return s.passes == 0; })) continue;
    all[i] = measure(probes_[i], image_mean);
    order.emplace_back(all[i].picture.noise + std::max(0.0, all[i].picture.bias), i);
  }
  std::ranges::sort(order);
  order.resize(kept_by_trim(order.size()));
  const double count = static_cast<double>(std::max<std::size_t>(order.size(), 1));
  const auto add = [count](ErrorSquares& to, const ErrorSquares& from) {
    to.noise += from.noise / count, to.bias += from.bias / count;
  };
  for (const auto& [error, i] : order) {
    add(shares.picture, all[i].picture);
    for (std::size_t part = 0; part < part_count; ++part) add(shares.parts[part], all[i].parts[part]);
    for (std::size_t e = 0; e < edit_count_; ++e) shares.edits[e] += edit_noise(i, e, image_mean) / count;
  }
  // A square whose estimate came out below 0 is too small to be told from it.
  shares.picture.bias = std::max(0.0, shares.picture.bias);
  for (ErrorSquares& part : shares.parts) part.bias = std::max(0.0, part.bias);
  return shares;
}

}  // namespace sluice
