// SPDX-License-Identifier: GPL-3.0-or-later
// The second half of a pass: one view sample per pixel of the border, tile by tile, added to the film.
#pragma once
#include <atomic>
#include <mutex>

#include "base/threads.h"
#include "transport/view_path.h"

namespace sluice {

class ViewPass {
 public:
  ViewPass(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads);

  // Adds the pass to `film`, which covers the border; `film_lock` is held while a tile is added. False: cancelled, some tiles are missing.
  [[nodiscard]] bool run(const PassContext& context, const PhotonSet& photons, ThreadPool& pool, const std::atomic<bool>& cancel, Film& film,
                         std::mutex& film_lock, Counts& counts);

 private:
  std::vector<ViewTracer> tracers_;  // per thread
  std::vector<std::vector<PixelSample>> samples_;
  std::vector<std::vector<Color>> layers_;
  std::vector<Counts> tile_counts_;
};

}  // namespace sluice
