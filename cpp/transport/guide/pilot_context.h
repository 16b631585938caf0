// SPDX-License-Identifier: GPL-3.0-or-later
// All that the pilot's steps read beside each other's results.
#pragma once
#include <atomic>

#include "base/threads.h"
#include "scene/scene.h"
#include "transport/effects.h"
#include "transport/settings.h"

namespace sluice {

struct PilotContext {
  const Scene& scene;
  const TransportSettings& settings;
  const Effects& effects;
  ThreadPool& pool;
  const std::atomic<bool>& cancel;
};

}  // namespace sluice
