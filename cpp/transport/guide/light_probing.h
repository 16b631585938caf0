// SPDX-License-Identifier: GPL-3.0-or-later
// Finds out which lights next-event estimation asks. The bound by which a light is chosen (choose_light)
// knows of no walls: the sky outside of a room would take most samples and bring nothing. Tried out where the
// camera looks, before the first pass; changes noise alone.
#pragma once
#include <span>

#include "transport/guide/pilot_context.h"
#include "transport/guide/visible.h"
#include "transport/light_trust.h"

namespace sluice {

// `seen`: what view paths meet at v and y, ng on the side they came from; `extent`: the size of what is seen
// (m), of which cells are a part. Empty where lights are many or nothing is seen.
[[nodiscard]] LightTrusts probe_lights(const PilotContext& context, std::span<const Hit> seen, double extent);

// Does light come straight from a light to one of these places?
[[nodiscard]] bool is_seen_lit(const PilotContext& context, int light, const SomeHits& places);

}  // namespace sluice
