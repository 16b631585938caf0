// SPDX-License-Identifier: GPL-3.0-or-later
// Which lights next-event estimation asks. The bound by which a light is chosen (choose_light) knows of no
// walls: the sky outside of a room would take most samples and bring nothing. Tried out where the camera
// looks, before the first pass; changes noise alone.
#pragma once
#include <atomic>
#include <span>

#include "base/threads.h"
#include "transport/effects.h"
#include "transport/guide.h"
#include "transport/settings.h"

namespace sluice {

// `seen`: what view paths meet at v and y, ng on the side they came from; `extent`: the size of what is seen
// (m), of which cells are a part. Empty where lights are many or nothing is seen.
[[nodiscard]] LightTrusts try_lights(const Scene& scene, const TransportSettings& settings,
                                     const Effects& effects, std::span<const Hit> seen, double extent,
                                     ThreadPool& pool, const std::atomic<bool>& cancel);

// Does light come straight from a light to one of so many of these places?
[[nodiscard]] bool is_seen_lit(const Scene& scene, const TransportSettings& settings, int light,
                               std::span<const Hit> seen, std::size_t places);

}  // namespace sluice
