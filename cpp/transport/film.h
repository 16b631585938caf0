// SPDX-License-Identifier: GPL-3.0-or-later
// Where samples add up, in planes for the render passes that somebody asked for. Sums are double; Combined
// is also kept per stream (stream = pass mod 4), in float, for its noise (error.h). A block of 8 passes is
// summed alone and blocks are added in index order, so any split into processes gives the same bits
// (design §5). Knows nothing of radii, photons or files. Not locked: the session does that.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/colour.h"
#include "base/zeros.h"
#include "transport/error.h"
#include "transport/pixel_sample.h"

namespace sluice {

inline constexpr int passes_per_block = 8;

// What a film holds beside Combined and its noise.
struct FilmContents {
  std::vector<std::string> layers = {};                 // under names of their own
  std::optional<std::vector<std::string>> passes = {};  // fixed passes by name; empty: all
  bool is_opaque = false;                               // alpha is 1 everywhere, and no plane of its own
};

class Film {
 public:
  static constexpr int tile = 32;

  // Of a border whose corner is (x0, y0) in the full frame: tiles are the full frame's, cut off at the
  // border.
  Film(int width, int height, FilmContents contents = {}, int x0 = 0, int y0 = 0);

  [[nodiscard]] int width() const noexcept { return width_; }
  [[nodiscard]] int height() const noexcept { return height_; }
  [[nodiscard]] int tiles_x() const noexcept { return (before_x_ + width_ + tile - 1) / tile; }
  [[nodiscard]] int tile_count() const noexcept {
    return tiles_x() * ((before_y_ + height_ + tile - 1) / tile);
  }
  struct Box {
    int x0, y0, x1, y1;
  };
  [[nodiscard]] Box box(int tile_index) const noexcept;

  // Adds one pass's samples of a tile, row by row; `layers` holds one colour per layer for each. Passes of a
  // block must come in order; tiles in any.
  void add_tile(int tile_index, int pass, const std::vector<PixelSample>& samples,
                std::span<const Color> layers = {});
  void close_block();  // after the last pass of a block (or of the render)

  // Render passes by their public names: Combined, those of PixelSample's features, one per Part, Noise, and
  // Bias.
  // Fixed: no layer may be called so, whether or not the film holds it.
  struct PassName {
    std::string name, channels;  // channels: a letter each, as files name them
  };
  [[nodiscard]] static std::vector<PassName> fixed_passes();
  [[nodiscard]] static bool is_fixed(const std::string& name);
  // 0: the film holds no such pass, fixed or a layer's.
  [[nodiscard]] int channels(const std::string& name) const noexcept;
  // Float, `channels(name)` per pixel, row 0 at the bottom. Each tile is divided by its own number of passes,
  // so an unfinished pass may be looked at; Depth is that of pass 0. Unknown names give an empty vector.
  [[nodiscard]] std::vector<float> image(const std::string& name) const;

  [[nodiscard]] double mean_luminance(const std::string& name) const;  // of a pass in colour
  // Relative standard error of the whole picture, 0.01 = 1 %: the square root of the mean over pixels, but
  // for the worst (kept_by_trim), of relative_noise; < 0: fewer than 4 passes, or black.
  [[nodiscard]] double relative_error() const;
  [[nodiscard]] Surroundings surroundings(int x, int y, double image_mean) const noexcept;
  [[nodiscard]] bool has_samples() const noexcept;     // in some tile
  [[nodiscard]] int finished_passes() const noexcept;  // by every tile
  // Of the sums that pictures are made of, bit for bit; Combined's by its streams, which add up to it.
  [[nodiscard]] std::uint64_t hash() const noexcept;
  [[nodiscard]] std::size_t bytes() const noexcept {
    return 2 * (sums_.size() * sizeof(double) + stream_sums_.size() * sizeof(float));
  }

 private:
  // How a render pass is read from the sums. Those of a part or a feature, Bias and layers have numbers of
  // their own; Combined and Noise are made of what is always there.
  enum class Reading : std::uint8_t { Combined, Mean, Single, Noise, Bias };
  struct Plane {
    PassName pass;
    Reading reading = Reading::Mean;
    int part = -1;                     // of PixelSample
    const Feature* feature = nullptr;  // of PixelSample
    int at = 0;                        // its place among the doubles of a pixel
    [[nodiscard]] int channels() const noexcept { return static_cast<int>(pass.channels.size()); }
  };
  [[nodiscard]] static std::vector<Plane> fixed_planes();
  [[nodiscard]] const Plane* find(const std::string& name) const noexcept;
  void read(const Plane& plane, std::size_t pixel, const std::array<int, stream_count>& passes,
            float* to) const noexcept;

  struct Estimate {
    V3d mean, variance;  // of the mean; in double, as squares of bright lights overflow floats
  };
  [[nodiscard]] int tile_of(int x, int y) const noexcept {
    return ((y + before_y_) / tile) * tiles_x() + (x + before_x_) / tile;
  }
  [[nodiscard]] double sum(std::size_t pixel, int at) const noexcept {
    return sums_[pixel * stride_ + at] + block_[pixel * stride_ + at];
  }
  [[nodiscard]] Streams<V3d> stream_means(std::size_t pixel,
                                          const std::array<int, stream_count>& passes) const noexcept;
  [[nodiscard]] Estimate estimate(std::size_t pixel,
                                  const std::array<int, stream_count>& passes) const noexcept;

  [[nodiscard]] double stream_sum(std::size_t pixel, int at) const noexcept {
    const std::size_t i = pixel * stream_numbers + static_cast<std::size_t>(at);
    return static_cast<double>(stream_sums_[i]) + static_cast<double>(stream_block_[i]);
  }
  int add_planes(FilmContents contents);

  static constexpr int combined_at = 0;                            // among the doubles of a pixel
  static constexpr std::size_t stream_numbers = 3 * stream_count;  // of a pixel: Combined of each stream
  int width_, height_;
  int before_x_, before_y_;  // of the first tile, cut off
  std::vector<Plane> planes_;
  int alpha_at_ = -1;  // among the doubles of a pixel; < 0: it is 1
  int layer_count_ = 0, layers_at_ = 0, stride_;
  Zeros<double> sums_, block_;  // of the closed blocks; of the open one
  // The same of the streams: they tell the noise and no more, for which floats are good enough.
  Zeros<float> stream_sums_, stream_block_;
  bool has_closed_ = false;  // a block: else there are zeros in sums_
  std::vector<std::array<int, stream_count>> tile_passes_;
};

}  // namespace sluice
