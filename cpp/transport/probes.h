// SPDX-License-Identifier: GPL-3.0-or-later
// Where the error of a picture lies: which estimator and which edit makes how much of its noise, and how much
// kernels blur. Planes of all that would be many times the film, so it is summed up at a few thousand pixels
// alone, the probes: one in each block of the picture, at a place of chance in it. They are a fair sample of
// all pixels.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "scene/description.h"
#include "transport/blurred_light.h"
#include "transport/film.h"

namespace sluice {

// Which pixels of a frame's border are probes: a pure function of both.
class ProbeGrid {
 public:
  static constexpr int max_probes = 4096;

  explicit ProbeGrid(const FrameDescription& frame) noexcept;
  // Of the full frame's pixel; < 0: it is none.
  [[nodiscard]] int index_of(int x, int y) const noexcept;
  // A probe's pixel, from the corner of the border.
  [[nodiscard]] std::pair<int, int> pixel_of(int probe) const noexcept;
  [[nodiscard]] int size() const noexcept { return blocks_x_ * blocks_y_; }

 private:
  int x0_, y0_, x1_, y1_, side_, blocks_x_, blocks_y_;
};

// Means of squares over pixels: of relative_noise() and relative_bias().
struct ErrorSquares {
  double noise = 0, bias = 0;
  [[nodiscard]] double total() const noexcept { return noise + bias; }
};

struct ErrorShares {
  ErrorSquares picture;
  std::array<ErrorSquares, part_count> parts;
  std::vector<ErrorSquares> edits;  // of the light that each took on its way
};

class Probes {
 public:
  Probes(const FrameDescription& frame, int edits);

  [[nodiscard]] const ProbeGrid& grid() const noexcept { return grid_; }
  // Adds one pass's mean of a probe's pixel; `of_edits`: what each edit took of it.
  void add(int probe, int pass, const PixelSample& sample, std::span<const TakenLight> of_edits) noexcept;
  // Of the picture in the film, which has had the same passes. Black pictures and fewer passes than streams
  // tell nothing: all is 0.
  [[nodiscard]] ErrorShares shares(const Film& film) const;
  [[nodiscard]] std::size_t bytes() const noexcept {
    return probes_.size() * sizeof(Probe) + edits_.size() * sizeof(TakenLight);
  }

 private:
  // Sums of one stream.
  struct Stream {
    std::array<V3d, part_count> parts{V3d(0), V3d(0), V3d(0), V3d(0), V3d(0)};
    std::array<double, part_count> bias{};
    int passes = 0;
  };
  using Probe = Streams<Stream>;
  struct Measured;
  [[nodiscard]] Measured measure(const Probe& probe, const Surroundings& place) const noexcept;
  [[nodiscard]] static Streams<V3d> pixel_of(const Probe& probe) noexcept;
  [[nodiscard]] ErrorSquares measure_edit(std::size_t probe, std::size_t edit,
                                          const Surroundings& place) const noexcept;

  ProbeGrid grid_;
  std::vector<Probe> probes_;
  std::size_t edit_count_;
  std::vector<TakenLight> edits_;  // by probe, then stream, then edit
};

}  // namespace sluice
