// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/settings.h"

#include <algorithm>
#include <cmath>

#include "base/threads.h"

namespace sluice {

namespace {

float bounded(float x, float low, float instead) noexcept {
  return std::isfinite(x) ? std::clamp(x, low, 100.0f) : instead;
}

}  // namespace

RenderSettings bounded(RenderSettings settings) {
  if (settings.threads <= 0) settings.threads = hardware_threads();
  settings.threads = std::min(settings.threads, 4 * hardware_threads());
  settings.passes = std::clamp(settings.passes, 1, 1 << 28);
  TransportSettings& t = settings.transport;
  const TransportSettings defaults;
  t.photons = std::clamp(t.photons, 1, 1 << 28);
  t.pilot_paths = std::clamp(t.pilot_paths, 1 << 10, 1 << 24);
  t.pilot_paths = std::min(t.pilot_paths, std::max(t.photons, TransportSettings::short_pilot));
  t.max_depth = std::clamp(t.max_depth, 1, 250);
  t.caustic_radius_factor = bounded(t.caustic_radius_factor, 0.1f, defaults.caustic_radius_factor);
  t.caustic_radius_range = bounded(t.caustic_radius_range, 1, defaults.caustic_radius_range);
  t.soft_range = bounded(t.soft_range, 1, defaults.soft_range);
  return settings;
}

}  // namespace sluice
