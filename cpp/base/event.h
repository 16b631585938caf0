// SPDX-License-Identifier: GPL-3.0-or-later
// Kinds of path events (design §1, the paper's interactions), the alphabet that expressions and lobes share.
#pragma once
#include <cstdint>

namespace sluice {

// D diffuse, S followed (delta, or roughness <= specular_threshold), G glossy, F gate of an edit. A path
// starts at L and ends at E.
enum class Event : std::uint8_t { L, E, D, S, G, F };
inline constexpr int event_count = 6;

// A set of lobe kinds, to ask a BSDF for some of its lobes only.
using EventMask = std::uint8_t;
[[nodiscard]] constexpr EventMask mask_of(Event e) noexcept {
  return static_cast<EventMask>(1u << static_cast<unsigned>(e));
}
inline constexpr EventMask gathering = mask_of(Event::D) | mask_of(Event::G);  // lobes that end a view path
inline constexpr EventMask followed = mask_of(Event::S);                       // lobes that extend it
inline constexpr EventMask any_lobe = gathering | followed;
inline constexpr EventMask any_event = (1u << event_count) - 1;

// Events with equal signature (the set of symbols of a scene's expressions that match them) share a class.
using EventClass = std::uint16_t;

}  // namespace sluice
