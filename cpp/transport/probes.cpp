// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/probes.h"

#include <algorithm>
#include <cassert>
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
  const int probe = (y - y0_) / side_ * blocks_x_ + (x - x0_) / side_;
  return pixel_of(probe) == std::pair(x - x0_, y - y0_) ? probe : -1;
}

std::pair<int, int> ProbeGrid::pixel_of(int probe) const noexcept {
  const int x = probe % blocks_x_ * side_, y = probe / blocks_x_ * side_;
  const std::uint64_t chance = mix(static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y));
  // The last blocks may hang over the border's edge.
  const auto place = [this](std::uint64_t bits, int from, int end) {
    return from + static_cast<int>(bits % static_cast<std::uint64_t>(std::min(side_, end - from)));
  };
  return {place(chance & 0xffffffffu, x, x1_ - x0_), place(chance >> 32, y, y1_ - y0_)};
}

Probes::Probes(const FrameDescription& frame, int edits)
    : grid_(frame),
      probes_(static_cast<std::size_t>(grid_.size())),
      edit_count_(static_cast<std::size_t>(edits)),
      edits_(probes_.size() * stream_count * edit_count_) {}

void Probes::add(int probe, int pass, const PixelSample& sample,
                 std::span<const TakenLight> of_edits) noexcept {
  const auto at = static_cast<std::size_t>(probe), stream = static_cast<std::size_t>(pass % stream_count);
  Stream& sums = probes_[at][stream];
  assert(of_edits.size() == edit_count_);
  for (std::size_t part = 0; part < part_count; ++part) {
    sums.parts[part] += V3d(sample.parts[part]);
    sums.bias[part] += sample.bias[part];
  }
  ++sums.passes;
  TakenLight* edits = edits_.data() + (at * stream_count + stream) * edit_count_;
  for (std::size_t e = 0; e < of_edits.size(); ++e) edits[e] += of_edits[e];
}

// One probe's share in the means.
struct Probes::Measured {
  ErrorSquares picture;
  std::array<ErrorSquares, part_count> parts;
};

Probes::Measured Probes::measure(const Probe& probe, const Surroundings& place) const noexcept {
  Measured measured;
  const Streams<V3d> pixel = pixel_of(probe);
  Streams<double> bias_of_all{};
  for (std::size_t part = 0; part < part_count; ++part) {
    Streams<V3d> light;
    Streams<double> bias;
    for (std::size_t s = 0; s < stream_count; ++s) {
      light[s] = probe[s].parts[part] / probe[s].passes;
      bias[s] = probe[s].bias[part] / probe[s].passes;
      bias_of_all[s] += bias[s];
    }
    measured.parts[part] = {relative_noise(light, pixel, place), relative_bias(bias, pixel, place)};
  }
  measured.picture = {relative_noise(pixel, pixel, place), relative_bias(bias_of_all, pixel, place)};
  return measured;
}

Streams<V3d> Probes::pixel_of(const Probe& probe) noexcept {
  Streams<V3d> pixel;
  for (std::size_t s = 0; s < stream_count; ++s) {
    pixel[s] = V3d(0);
    for (const V3d& part : probe[s].parts) pixel[s] += part / probe[s].passes;
  }
  return pixel;
}

ErrorSquares Probes::measure_edit(std::size_t probe, std::size_t edit,
                                  const Surroundings& place) const noexcept {
  Streams<V3d> light;
  Streams<double> bias;
  for (std::size_t s = 0; s < stream_count; ++s) {
    const TakenLight& taken = edits_[(probe * stream_count + s) * edit_count_ + edit];
    const int passes = probes_[probe][s].passes;
    light[s] = V3d(taken.luminance / static_cast<double>(passes));
    bias[s] = taken.bias / static_cast<double>(passes);
  }
  const Streams<V3d> pixel = pixel_of(probes_[probe]);
  return {relative_noise(light, pixel, place), relative_bias(bias, pixel, place)};
}

ErrorShares Probes::shares(const Film& film) const {
  ErrorShares shares;
  shares.edits.resize(edit_count_);
  const double image_mean = film.mean_luminance("Combined");
  if (!(square(image_mean / 10) > 0)) return shares;
  std::vector<std::pair<double, std::size_t>> order;  // by error, the probes that every stream has met
  std::vector<Measured> all(probes_.size());
  std::vector<Surroundings> places(probes_.size());
  for (std::size_t i = 0; i < probes_.size(); ++i) {
    if (std::ranges::any_of(probes_[i], [](const Stream& s) { return s.passes == 0; })) continue;
    const auto [x, y] = grid_.pixel_of(static_cast<int>(i));
    places[i] = film.surroundings(x, y, image_mean);
    all[i] = measure(probes_[i], places[i]);
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
    for (std::size_t e = 0; e < edit_count_; ++e) add(shares.edits[e], measure_edit(i, e, places[i]));
  }
  // A square whose estimate came out below 0 is too small to be told from it.
  shares.picture.bias = std::max(0.0, shares.picture.bias);
  for (ErrorSquares& part : shares.parts) part.bias = std::max(0.0, part.bias);
  for (ErrorSquares& edit : shares.edits) edit.bias = std::max(0.0, edit.bias);
  return shares;
}

}  // namespace sluice
