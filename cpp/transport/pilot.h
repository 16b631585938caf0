// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the guide (design §5): what the camera sees, which lights and which aims send useful photons there. Always over the full
// frame, the same for every process; an edit that catches nothing changes nothing here.
#pragma once
#include <atomic>

#include "base/threads.h"
#include "transport/effects.h"
#include "transport/guide.h"
#include "transport/settings.h"

namespace sluice {

[[nodiscard]] Guide make_guide(const Scene& scene, const TransportSettings& settings, const Effects& effects, ThreadPool& pool, const std::atomic<bool>& cancel);

}  // namespace sluice
