// SPDX-License-Identifier: GPL-3.0-or-later
// The second half of a pass: view samples of the pixels of the border, as many as the guide says, traced in
// bundles, tile by tile, and added to the film.
#pragma once
#include <atomic>
#include <deque>
#include <mutex>
#include <span>
#include <vector>

#include "base/threads.h"
#include "transport/probes.h"
#include "transport/photons/photon_set.h"
#include "transport/view/view_tracer.h"

namespace sluice {

// The means of a pass's samples of a tile's pixels, row by row.
struct TileSamples {
  std::vector<PixelSample> samples;
  std::vector<Color> layers;  // one after the other for each pixel
  // Pixels that are probes, with what each edit took of theirs.
  struct Probed {
    int probe;
    std::size_t pixel;
  };
  std::vector<Probed> probed;
  std::vector<int> place_of;      // by pixel: in `probed`, < 0: it is not there
  std::vector<TakenLight> edits;  // one after the other for each of these
  void add(std::size_t pixel, const PixelSample& sample, std::span<const Color> of_layers);
  void add_probed(int probe, std::size_t pixel, std::span<const TakenLight> of_edits);
  void scale(std::size_t pixel, float factor);
};

class ViewPass {
 public:
  ViewPass(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads);

  // Adds the pass to `film`, which covers the border, and to the probes, if there are some; `film_lock` is
  // held while a tile is added. False: cancelled, some tiles are missing.
  [[nodiscard]] bool run(const PassContext& context, const PhotonSet& photons, ThreadPool& pool,
                         const std::atomic<bool>& cancel, Film& film, std::mutex& film_lock, Counts& counts,
                         Probes* probes = nullptr);

 private:
  [[nodiscard]] static bool sample_tile(const PassContext& context, Film::Box box, const ProbeGrid* grid,
                                        ViewTracer& tracer, TileSamples& tile,
                                        const std::atomic<bool>& cancel);

  std::deque<ViewTracer> tracers_;  // per thread; they cannot be moved
  std::vector<TileSamples> tiles_;
  std::vector<Counts> tile_counts_;
};

}  // namespace sluice
