// SPDX-License-Identifier: GPL-3.0-or-later
// When paths split and when they end, the same rules on both sides (design §4): a budget of branches, above which one way stands for
// all, and roulette on the throughput of materials alone, never on gains of edits.
#pragma once
#include <algorithm>

#include "edit/gates.h"

namespace sluice {

inline constexpr int split_budget = 16;  // branches alive at once on one path tree

// One of `ways` (its weight is then `ways`), for u in [0, 1).
[[nodiscard]] inline int pick_one(float u, int ways) noexcept { return std::min(static_cast<int>(u * static_cast<float>(ways)), ways - 1); }

// The ways on behind an entry that took a path: every exit, and straight on with what a partial entry leaves. Calls push(exit, weight) for
// each, or above the budget for one that stands for all: then false.
template <class Random, class Push>
[[nodiscard]] bool send_on(const Edits& edits, const Crossing& crossing, int alive, Random&& random, Push&& push) noexcept {
  const Edit& edit = edits[crossing.edit];
  const float taken = edit.is_partial ? edits.weight(crossing.edit, crossing.uv) : 1;
  const int exits = taken > 0 ? static_cast<int>(edit.exits.size()) : 0, copies = exits + (taken < 1 ? 1 : 0);
  if (alive + copies <= split_budget) {
    for (int exit = 0; exit < exits; ++exit) push(exit, taken);
    if (taken < 1) push(straight_on, 1 - taken);
    return true;
  }
  const int chosen = pick_one(random(), copies);
  const auto all = static_cast<float>(copies);
  if (chosen < exits)
    push(chosen, taken * all);
  else
    push(straight_on, (1 - taken) * all);
  return false;
}

// The chance that a path outlives its next event, the `event`-th of it. Certain for the first three; later never quite, so that no path
// lives for ever (numerics P7).
[[nodiscard]] inline float survival_chance(float throughput, int event) noexcept { return event < 4 ? 1.0f : std::min(0.95f, throughput); }

}  // namespace sluice
