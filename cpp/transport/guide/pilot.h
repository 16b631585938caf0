// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the guide (design §5): what the camera sees, which lights and which directions send useful photons
// there. Always over the full frame, the same for every process. An edit that catches nothing changes nothing
// here, so its picture is that without it, bit for bit; but for one whose entry hangs outside of the sphere
// around all surfaces and may take light from infinity straight: there no photon comes by chance, so some are
// always sent (targets.h, FarEntries).
#pragma once
#include <atomic>

#include "base/threads.h"
#include "transport/effects.h"
#include "transport/guide.h"
#include "transport/settings.h"

namespace sluice {

[[nodiscard]] Guide make_guide(const Scene& scene, const TransportSettings& settings, const Effects& effects,
                               ThreadPool& pool, const std::atomic<bool>& cancel);

}  // namespace sluice
