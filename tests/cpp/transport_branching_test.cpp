// SPDX-License-Identifier: GPL-3.0-or-later
// Splitting at an entry: every way has its weight, alone or by one that stands for all, and a tree has no
// more branches than its budget allows.
#include "transport/branching.h"

#include <gtest/gtest.h>

#include <map>

#include "edit_scene.h"

using namespace sluice;

namespace {

Edits one_edit(int exits, float amount) {
  EditDescription edit = edit_at("Entry", at({0, 0, 0}), "L.*", 0);
  edit.amount = amount;
  for (int i = 0; i < exits; ++i)
    edit.exits.push_back(exit_at(numbered("Exit ", i), at({2.0 * i + 2, 0, 0}), i + 1));
  Warnings warnings;
  return compile_edits(std::vector{edit}, {}, {}, {}, 16, warnings);
}

Crossing in_the_middle() {
  Crossing crossing{};
  crossing.edit = 0, crossing.uv = V2d(0.5, 0.5);
  return crossing;
}

// Weights by way, of which straight_on is one.
using Weights = std::map<int, double>;

Weights weights_of(int exits, float amount) {
  Weights weights;
  for (int i = 0; i < exits && amount > 0; ++i) weights[i] = amount;
  if (amount < 1) weights[straight_on] = 1 - amount;
  return weights;
}

}  // namespace

TEST(Branching, EveryWayHasItsWeight) {
  for (const int exits : {0, 1, 3, 15})
    for (const float amount : {0.0f, 0.25f, 1.0f}) {
      const Edits edits = one_edit(exits, amount);
      SplitBudget budget;
      Weights found;
      const auto push = [&](int exit, float weight) { found[exit] += weight; };
      EXPECT_TRUE(split_path(edits, in_the_middle(), budget, [] { return 0.5f; }, push));
      EXPECT_EQ(found, weights_of(exits, amount)) << exits << " exits, " << amount;
    }
}

TEST(Branching, OneStandsForAllAboveTheBudget) {
  constexpr int draws = 1 << 16;
  for (const int exits : {17, 40})
    for (const float amount : {0.25f, 1.0f}) {
      const Edits edits = one_edit(exits, amount);
      Weights mean;
      for (int i = 0; i < draws; ++i) {
        SplitBudget budget;
        int pushed = 0;
        const auto push = [&](int exit, float weight) { mean[exit] += weight / draws, ++pushed; };
        const auto random = [i] { return (static_cast<float>(i) + 0.5f) / draws; };
        EXPECT_FALSE(split_path(edits, in_the_middle(), budget, random, push));
        ASSERT_EQ(pushed, 1);
      }
      for (const auto& [way, weight] : weights_of(exits, amount))
        EXPECT_NEAR(mean[way], weight, 2.0 * exits / draws) << way << " of " << exits;
    }
}

TEST(Branching, ATreeHasNoMoreBranchesThanItsBudget) {
  const Edits edits = one_edit(4, 1);
  SplitBudget budget;
  int alive = 1, capped = 0;
  for (int gate = 0; gate < 20; ++gate) {
    --alive;  // the one that is taken
    const auto push = [&](int, float) { ++alive; };
    capped += split_path(edits, in_the_middle(), budget, [] { return 0.5f; }, push) ? 0 : 1;
    ASSERT_LE(alive, split_budget);
  }
  EXPECT_EQ(alive, split_budget);
  EXPECT_EQ(capped, 15);  // five splits add three each
}
