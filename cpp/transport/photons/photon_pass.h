// SPDX-License-Identifier: GPL-3.0-or-later
// The first half of a pass: light paths are traced in chunks of fixed size, their photons sorted into maps.
// The result does not depend on the number of threads: chunks are put together in index order.
#pragma once
#include <atomic>

#include "base/threads.h"
#include "transport/pass.h"
#include "transport/photons/photon_set.h"
#include "transport/photons/light_tracer.h"

namespace sluice {

class PhotonPass {
 public:
  PhotonPass(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads);

  // Traces settings.photons paths and fills `photons`. False: cancelled, the result is of no use.
  [[nodiscard]] bool run(const PassContext& context, ThreadPool& pool, const std::atomic<bool>& cancel,
                         PhotonSet& photons, Counts& counts);

 private:
  PhotonStates states_;
  std::vector<LightTracer<>> tracers_;  // per thread
  std::vector<std::vector<Photon>> chunks_;
  std::vector<Counts> chunk_counts_;
};

}  // namespace sluice
