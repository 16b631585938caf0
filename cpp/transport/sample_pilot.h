// SPDX-License-Identifier: GPL-3.0-or-later
// The pilot of view samples: half a pass that finds out where noise is.
#pragma once
#include <atomic>

#include "base/threads.h"
#include "transport/pass.h"

namespace sluice {

// Looks at the full frame, also under a border. `first`: of the first pass. Cancelled: one sample everywhere.
[[nodiscard]] SampleMap place_samples(const PassContext& first, ThreadPool& pool, const std::atomic<bool>& cancel);

}  // namespace sluice
