// SPDX-License-Identifier: GPL-3.0-or-later
// The pilot of view samples: the second half of a pass, less dense, that finds out where noise is.
#pragma once
#include <atomic>

#include "base/threads.h"
#include "transport/photons/photon_set.h"
#include "transport/pass.h"

namespace sluice {

// Looks at the full frame, also under a border. `first`, `photons`: of the first pass. (That its samples are
// placed by what its own photons show is no bias: whatever these are, the mean of a pixel's samples has the
// same expectation for any number of them.) Cancelled: one sample everywhere.
[[nodiscard]] SampleMap place_samples(const PassContext& first, const PhotonSet& photons, ThreadPool& pool,
                                      const std::atomic<bool>& cancel);

}  // namespace sluice
