// SPDX-License-Identifier: GPL-3.0-or-later
// When paths split and when they end, the same rules on both sides (design §4): a budget of branches for the
// whole tree of a path, above which one way stands for all, and roulette on the throughput of materials
// alone, never on gains of edits.
#pragma once
#include <algorithm>

#include "edit/edits.h"

namespace sluice {

// Branches that the exits of one path's tree may make, on the view side the first glass too; a photon's first
// glass adds its lobes beside them (photons/light_tracer.h).
inline constexpr int split_budget = 16;

// What is left of it while a tree is followed.
class SplitBudget {
 public:
  // May a branch become `more` than one? Then they are taken from what is left.
  [[nodiscard]] bool spend(int more) noexcept {
    if (more > left_) return false;
    left_ -= std::max(more, 0);
    return true;
  }

 private:
  int left_ = split_budget - 1;
};

// The ways on behind an entry that took a path: every exit, and straight on with what a partial entry leaves.
struct ExitSplit {
  float taken;  // weight of each exit
  int exits;

  ExitSplit(const Edits& edits, const Crossing& crossing) noexcept
      : taken(edits[crossing.edit].is_partial ? edits.weight(crossing.edit, crossing.uv) : 1),
        exits(taken > 0 ? static_cast<int>(edits[crossing.edit].exits.size()) : 0) {}
  [[nodiscard]] int count() const noexcept { return exits + (taken < 1 ? 1 : 0); }
  template <class Push>
  void for_each(Push&& push) const noexcept {
    for (int exit = 0; exit < exits; ++exit) push(exit, taken);
    if (taken < 1) push(straight_on, 1 - taken);
  }
};

// Calls push(exit, weight) for each, or above the budget for one that stands for all, chosen by weight: then
// false.
template <class Random, class Push>
[[nodiscard]] bool split_path(const Edits& edits, const Crossing& crossing, SplitBudget& budget,
                              Random&& random, Push&& push) noexcept {
  const ExitSplit ways(edits, crossing);
  if (budget.spend(ways.count() - 1)) {
    ways.for_each(push);
    return true;
  }
  const float of_exits = ways.taken * static_cast<float>(ways.exits), all = of_exits + (1 - ways.taken),
              at = random() * all;
  if (at < of_exits)
    push(std::min(static_cast<int>(at / ways.taken), ways.exits - 1), all);
  else
    push(straight_on, all);
  return false;
}

// The chance that a path outlives its next event, the `event`-th of it. Certain for the first three; later
// never quite, so that no path lives for ever (numerics P7). By the greatest channel: by their mean, what is
// left of light in deeply coloured glass would gain in that channel from roulette to roulette, until single
// photons show.
[[nodiscard]] inline float survival_chance(const Color& throughput, int event) noexcept {
  return event < 4 ? 1.0f : std::min(0.95f, max_component(throughput));
}

}  // namespace sluice
