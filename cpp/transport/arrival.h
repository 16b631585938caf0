// SPDX-License-Identifier: GPL-3.0-or-later
// How photons come to a surface, and which of them which estimator reads.
#pragma once
#include <cstdint>

#include "base/event.h"

namespace sluice {

// How light arrived: the last event before the vertex (design §5, the table), L, S, F, D or G. Disjoint and
// complete. Caustics and edited light that were diffuse before are kept apart: their source is as wide as a
// wall, so they are soft, and disks for them may be wide.
enum class Arrival : std::uint8_t { Direct, Caustic, Edited, Indirect, SoftCaustic, SoftEdited };
inline constexpr int arrival_count = 6;
[[nodiscard]] constexpr unsigned bit_of(Arrival a) noexcept { return 1u << static_cast<unsigned>(a); }
inline constexpr unsigned caustic_arrivals = bit_of(Arrival::Caustic) | bit_of(Arrival::SoftCaustic);
inline constexpr unsigned edited_arrivals = bit_of(Arrival::Edited) | bit_of(Arrival::SoftEdited);
inline constexpr unsigned caustic_and_edited_arrivals = caustic_arrivals | edited_arrivals;
inline constexpr unsigned soft_arrivals = bit_of(Arrival::SoftCaustic) | bit_of(Arrival::SoftEdited);

[[nodiscard]] constexpr bool is_edited(Arrival a) noexcept { return edited_arrivals & bit_of(a); }

[[nodiscard]] constexpr Arrival arrival_of(Event last, bool was_diffuse) noexcept {
  switch (last) {
    case Event::L: return Arrival::Direct;
    case Event::S: return was_diffuse ? Arrival::SoftCaustic : Arrival::Caustic;
    case Event::F: return was_diffuse ? Arrival::SoftEdited : Arrival::Edited;
    default: return Arrival::Indirect;
  }
}

}  // namespace sluice
