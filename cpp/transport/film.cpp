// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/film.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "base/random.h"

namespace sluice {
namespace {

int total(const std::array<int, stream_count>& passes) noexcept {
  return std::accumulate(passes.begin(), passes.end(), 0);
}

}  // namespace

Film::Film(int width, int height, FilmContents contents, int x0, int y0)
    : width_(width),
      height_(height),
      before_x_(x0 % tile),
      before_y_(y0 % tile),
      stride_(add_planes(std::move(contents))),
      sums_(static_cast<std::size_t>(width) * height * stride_),
      block_(sums_.size()),
      stream_sums_(static_cast<std::size_t>(width) * height * stream_numbers),
      stream_block_(stream_sums_.size()),
      tile_passes_(tile_count()) {}

// Gives each plane that is asked for its place; returns the doubles of a pixel.
int Film::add_planes(FilmContents contents) {
  int numbers = combined_at + 3;
  if (!contents.is_opaque) alpha_at_ = numbers++;
  const auto is_asked_for = [&](const std::string& name) {
    return !contents.passes || std::ranges::find(*contents.passes, name) != contents.passes->end();
  };
  for (Plane& plane : fixed_planes()) {
    const bool has_own = plane.part >= 0 || plane.feature || plane.reading == Reading::Bias;
    if (has_own && !is_asked_for(plane.pass.name)) continue;
    plane.at = has_own ? std::exchange(numbers, numbers + plane.channels()) : combined_at;
    planes_.push_back(std::move(plane));
  }
  layers_at_ = numbers, layer_count_ = static_cast<int>(contents.layers.size());
  for (std::string& layer : contents.layers)
    planes_.push_back({.pass = {std::move(layer), "RGB"}, .at = std::exchange(numbers, numbers + 3)});
  return numbers;
}

// In the order in which hosts list them. Combined and Noise are made of several sums.
std::vector<Film::Plane> Film::fixed_planes() {
  std::vector<Plane> planes{{.pass = {"Combined", "RGBA"}, .reading = Reading::Combined}};
  for (const Feature& f : features)
    if (!f.name.empty())
      planes.push_back({.pass = {std::string(f.name), std::string(f.channels)},
                        .reading = f.is_mean ? Reading::Mean : Reading::Single,
                        .feature = &f});
  for (int i = 0; i < part_count; ++i)
    planes.push_back({.pass = {name_of(static_cast<Part>(i)), "RGB"}, .part = i});
  planes.push_back({.pass = {"Noise", "X"}, .reading = Reading::Noise});
  planes.push_back({.pass = {"Bias", "X"}, .reading = Reading::Bias});
  return planes;
}

std::vector<Film::PassName> Film::fixed_passes() {
  std::vector<PassName> passes;
  for (Plane& plane : fixed_planes()) passes.push_back(std::move(plane.pass));
  return passes;
}

const Film::Plane* Film::find(const std::string& name) const noexcept {
  const auto it = std::ranges::find(planes_, name, [](const Plane& p) -> const auto& { return p.pass.name; });
  return it == planes_.end() ? nullptr : &*it;
}

bool Film::is_fixed(const std::string& name) {
  return std::ranges::any_of(fixed_passes(), [&](const PassName& pass) { return pass.name == name; });
}

Film::Box Film::box(int tile_index) const noexcept {
  const int x = tile_index % tiles_x() * tile - before_x_, y = tile_index / tiles_x() * tile - before_y_;
  return {std::max(x, 0), std::max(y, 0), std::min(x + tile, width_), std::min(y + tile, height_)};
}

void Film::add_tile(int tile_index, int pass, const std::vector<PixelSample>& samples,
                    std::span<const Color> layers) {
  const Box b = box(tile_index);
  const int stream = pass % stream_count;
  auto sample = samples.begin();
  auto layer = layers.begin();
  for (int y = b.y0; y < b.y1; ++y)
    for (int x = b.x0; x < b.x1; ++x, ++sample) {
      const std::size_t pixel = static_cast<std::size_t>(y) * width_ + x;
      double* p = &block_[pixel * stride_];
      const auto add = [p](int at, const V3f& c) { p[at] += c.x, p[at + 1] += c.y, p[at + 2] += c.z; };
      const Color combined = sample->combined();
      for (int c = 0; c < 3; ++c) stream_block_[pixel * stream_numbers + 3 * stream + c] += combined[c];
      add(combined_at, combined);
      if (alpha_at_ >= 0) p[alpha_at_] += sample->alpha;
      for (const Plane& plane : planes_) {
        if (plane.part >= 0) add(plane.at, sample->parts[plane.part]);
        if (plane.reading == Reading::Bias) p[plane.at] += sample->total_bias();
        if (!plane.feature) continue;
        if (plane.feature->vector)
          add(plane.at, *sample.*plane.feature->vector);
        else if (plane.feature->is_mean)
          p[plane.at] += *sample.*plane.feature->number;
        else if (pass == 0)
          p[plane.at] = *sample.*plane.feature->number;
      }
      for (int i = 0; i < layer_count_; ++i) add(layers_at_ + 3 * i, *layer++);
    }
  ++tile_passes_[tile_index][stream];
}

void Film::close_block() {
  if (!std::exchange(has_closed_, true)) {
    std::swap(sums_, block_), std::swap(stream_sums_, stream_block_);
    return;
  }
  for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += block_[i];
  for (std::size_t i = 0; i < stream_sums_.size(); ++i) stream_sums_[i] += stream_block_[i];
  std::ranges::fill(block_.all(), 0.0), std::ranges::fill(stream_block_.all(), 0.0f);
}

int Film::channels(const std::string& name) const noexcept {
  const Plane* plane = find(name);
  return plane ? plane->channels() : 0;
}

Film::Estimate Film::estimate(std::size_t pixel, const std::array<int, stream_count>& passes) const noexcept {
  Streams<V3d> means = stream_means(pixel, passes);
  V3d mean(0);
  int streams = 0;
  for (int s = 0; s < stream_count; ++s)
    if (passes[s] > 0) mean += means[streams++] = means[s];
  if (streams == 0) return {V3d(0), V3d(0)};
  mean /= streams;
  V3d variance(0);
  for (int s = 0; s < streams; ++s) variance += (means[s] - mean) * (means[s] - mean);
  if (streams > 1) variance /= streams * (streams - 1.0);
  return {mean, variance};
}

// One pixel of a plane; `passes` of its tile, some.
void Film::read(const Plane& plane, std::size_t pixel, const std::array<int, stream_count>& passes,
                float* to) const noexcept {
  const int count = total(passes);
  switch (plane.reading) {
    case Reading::Combined: {
      for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(sum(pixel, plane.at + i) / count);
      to[3] = alpha_at_ < 0 ? 1 : static_cast<float>(sum(pixel, alpha_at_) / count);
      break;
    }
    case Reading::Noise: {
      const Estimate e = estimate(pixel, passes);
      const float mean = luminance(Color(e.mean));
      to[0] = mean > 0
                  ? static_cast<float>(std::sqrt((e.variance.x + e.variance.y + e.variance.z) / 3) / mean)
                  : 0;
      break;
    }
    case Reading::Bias: {
      const V3d c(sum(pixel, combined_at), sum(pixel, combined_at + 1), sum(pixel, combined_at + 2));
      const double whole = luminance(c);
      to[0] = whole > 0 ? static_cast<float>(sum(pixel, plane.at) / whole) : 0;
      break;
    }
    case Reading::Mean:
    case Reading::Single: {
      const int samples = plane.reading == Reading::Single ? 1 : count;
      for (int i = 0; i < plane.channels(); ++i)
        to[i] = static_cast<float>(sum(pixel, plane.at + i) / samples);
      break;
    }
  }
}

std::vector<float> Film::image(const std::string& name) const {
  const Plane* plane = find(name);
  if (!plane) return {};
  const auto n = static_cast<std::size_t>(plane->channels());
  std::vector<float> out(static_cast<std::size_t>(width_) * height_ * n);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const auto& passes = tile_passes_[tile_of(x, y)];
      const std::size_t pixel = static_cast<std::size_t>(y) * width_ + x;
      if (total(passes) > 0) read(*plane, pixel, passes, &out[pixel * n]);
    }
  return out;
}

double Film::mean_luminance(const std::string& name) const {
  const Plane* plane = find(name);
  if (!plane || plane->channels() < 3) return 0;
  double mean = 0;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const auto& passes = tile_passes_[tile_of(x, y)];
      if (total(passes) == 0) continue;
      float pixel[4];
      read(*plane, static_cast<std::size_t>(y) * width_ + x, passes, pixel);
      mean += luminance(V3d(pixel[0], pixel[1], pixel[2]));
    }
  return mean / std::max(1, width_ * height_);
}

double Film::relative_error() const {
  if (finished_passes() < stream_count) return -1;
  const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  const double image_mean = mean_luminance("Combined");
  if (!(square(image_mean / 10) > 0)) return -1;  // a black picture says nothing about what it has not found
  std::vector<double> errors(pixels);
  for (std::size_t p = 0; p < pixels; ++p) {
    const int x = static_cast<int>(p % width_), y = static_cast<int>(p / width_);
    const Streams<V3d> means = stream_means(p, tile_passes_[tile_of(x, y)]);
    errors[p] = relative_noise(means, means, surroundings(x, y, image_mean));
  }
  const auto kept = errors.begin() + static_cast<std::ptrdiff_t>(kept_by_trim(pixels));
  std::ranges::nth_element(errors, kept == errors.end() ? kept - 1 : kept);
  return std::sqrt(std::reduce(errors.begin(), kept) / static_cast<double>(kept - errors.begin()));
}

// Eight neighbours, fewer at the border.
Surroundings Film::surroundings(int x, int y, double image_mean) const noexcept {
  V3d around(0);
  int pixels = 0;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height_ - 1); ++j)
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width_ - 1); ++i) {
      if (i == x && j == y) continue;
      const std::size_t p = static_cast<std::size_t>(j) * width_ + i;
      const int passes = std::max(1, total(tile_passes_[tile_of(i, j)]));
      for (int c = 0; c < 3; ++c) around[c] += sum(p, combined_at + c) / passes;
      ++pixels;
    }
  return {around / std::max(1, pixels), image_mean};
}

Streams<V3d> Film::stream_means(std::size_t pixel,
                                const std::array<int, stream_count>& passes) const noexcept {
  Streams<V3d> means;
  for (int s = 0; s < stream_count; ++s)
    means[s] = V3d(stream_sum(pixel, 3 * s), stream_sum(pixel, 3 * s + 1), stream_sum(pixel, 3 * s + 2)) /
               std::max(1, passes[s]);
  return means;
}

int Film::finished_passes() const noexcept {
  int least = tile_passes_.empty() ? 0 : total(tile_passes_[0]);
  for (const auto& passes : tile_passes_) least = std::min(least, total(passes));
  return least;
}

bool Film::has_samples() const noexcept {
  return std::ranges::any_of(tile_passes_, [](const auto& passes) { return total(passes) > 0; });
}

// Pixel by pixel: Combined of each stream, parts, alpha, features, layers, as far as they are held. What is
// told of errors is no part of it.
std::uint64_t Film::hash() const noexcept {
  std::uint64_t h = mix(static_cast<std::uint64_t>(width_), static_cast<std::uint64_t>(height_));
  const auto add = [&h](double total_sum) {
    std::uint64_t bits;
    std::memcpy(&bits, &total_sum, sizeof bits);
    h = mix(h, bits);
  };
  const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  for (std::size_t p = 0; p < pixels; ++p) {
    const auto add_plane = [&](const Plane& plane) {
      for (int c = 0; c < plane.channels(); ++c) add(sum(p, plane.at + c));
    };
    for (int i = 0; i < 3 * stream_count; ++i) add(stream_sum(p, i));
    for (const Plane& plane : planes_)
      if (plane.part >= 0) add_plane(plane);
    const int x = static_cast<int>(p % width_), y = static_cast<int>(p / width_);
    add(alpha_at_ >= 0 ? sum(p, alpha_at_) : total(tile_passes_[tile_of(x, y)]));
    for (const Plane& plane : planes_)
      if (plane.feature) add_plane(plane);
    for (int i = 0; i < 3 * layer_count_; ++i) add(sum(p, layers_at_ + i));
  }
  return h;
}

}  // namespace sluice
