// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/progress.h"

#include <algorithm>

#include "base/math.h"
#include "transport/film.h"

namespace sluice {

bool measures_error_after(int passes) noexcept { return passes % stream_count == 0; }

StopReason stop_after(const Pace& pace, const RenderSettings& settings) noexcept {
  // An error from one pass of each stream is too rough to stop by.
  if (settings.error_target > 0 && pace.passes >= 2 * stream_count && pace.relative_error >= 0 &&
      pace.relative_error <= settings.error_target)
    return StopReason::Error;
  // Another pass of that length would end further from the limit than this one did.
  if (settings.time_limit > 0 && pace.seconds + pace.last_pass_seconds / 2 > settings.time_limit)
    return StopReason::Time;
  return pace.passes >= settings.passes ? StopReason::Passes : StopReason::None;
}

double seconds_left(const Progress& now, const RenderSettings& settings) noexcept {
  if (now.pass == 0) return -1;
  double left = now.seconds / now.pass * (now.passes - now.pass);
  if (settings.time_limit > 0) left = std::min(left, std::max(0.0, settings.time_limit - now.seconds));
  const double needed = passes_to(settings.error_target, now.accuracy);
  if (needed >= 0) left = std::min(left, now.seconds / now.pass * std::max(0.0, needed - now.pass));
  return left;
}

}  // namespace sluice
