// SPDX-License-Identifier: GPL-3.0-or-later
// When paths split and when they end, the same rules on both sides (design §4): a budget of branches, above which one way stands for
// all, and roulette on the throughput of materials alone, never on gains of edits.
#pragma once
#include <algorithm>

namespace sluice {

inline constexpr int split_budget = 16;  // branches alive at once on one path tree

// One of `ways` (its weight is then `ways`), for u in [0, 1).
[[nodiscard]] inline int pick_one(float u, int ways) noexcept { return std::min(static_cast<int>(u * static_cast<float>(ways)), ways - 1); }

// The chance that a path outlives its next event, the `event`-th of it. Certain for the first three; later never quite, so that no path
// lives for ever (numerics P7).
[[nodiscard]] inline float survival_chance(float throughput, int event) noexcept { return event < 4 ? 1.0f : std::min(0.95f, throughput); }

}  // namespace sluice
