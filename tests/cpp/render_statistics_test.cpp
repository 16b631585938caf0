// SPDX-License-Identifier: GPL-3.0-or-later
// Passes add up, and the report leaves nothing out.
#include "render/statistics.h"

#include <gtest/gtest.h>

#include <set>

#include "render/report.h"

namespace sluice {
namespace {

// Each counter and term another number.
Counts counts_of(int pass) {
  Counts counts;
  std::uint64_t number = static_cast<std::uint64_t>(pass) * 1000;
  for (const WorkCounter& counter : work_counters) counts.*counter.value = ++number;
  for (const DropCounter& counter : drop_counters) counts.*counter.value = ++number;
  for (const LedgerTerm& term : ledger_terms) counts.ledger.*term.value = static_cast<double>(++number);
  counts.of_edit(pass) = {.matched = 1,
                          .moved = 2,
                          .capped = 3,
                          .energy_in = 4,
                          .energy_out = 5,
                          .shown = 6,
                          .kept = true,
                          .seconds = 7};
  return counts;
}

TEST(Statistics, PassesAddUp) {
  RenderStatistics s;
  const Counts one = counts_of(1), two = counts_of(2);
  s.record({one, 10, 640, 0.5, 1.5});
  s.record({two, 20, 1600, 0.25, 2});
  for (const WorkCounter& counter : work_counters)
    EXPECT_EQ(s.counts.*counter.value, one.*counter.value + two.*counter.value) << counter.name;
  for (const DropCounter& counter : drop_counters)
    EXPECT_EQ(s.counts.*counter.value, one.*counter.value + two.*counter.value) << counter.name;
  for (const LedgerTerm& term : ledger_terms)
    EXPECT_EQ(s.counts.ledger.*term.value, one.ledger.*term.value + two.ledger.*term.value) << term.name;
  EXPECT_EQ(s.seconds_of(Phase::Photons), 0.75);
  EXPECT_EQ(s.seconds_of(Phase::View), 3.5);
  EXPECT_EQ(s.seconds_of(Phase::Compile), 0);
  EXPECT_EQ(s.bytes_per_photon, 80);  // of the last pass
  ASSERT_EQ(s.counts.edits.size(), 3u);
  EXPECT_EQ(s.counts.edits[0].matched, 0u);
  for (const std::size_t e : {1u, 2u}) {
    EXPECT_EQ(s.counts.edits[e].matched, 1u);
    EXPECT_EQ(s.counts.edits[e].seconds, 7);
    EXPECT_TRUE(s.counts.edits[e].kept);
  }
}

TEST(Statistics, APassWithoutPhotonsKeepsTheirSize) {
  RenderStatistics s;
  const Counts none;
  s.record({none, 10, 640, 0, 0});
  s.record({none, 0, 64, 0, 0});
  EXPECT_EQ(s.bytes_per_photon, 64);
}

TEST(Statistics, TheLedgerIsThatOfTheWorstPass) {
  RenderStatistics s;
  Counts good, bad;
  good.ledger = {.emitted = 100, .absorbed = 100};
  bad.ledger = {.emitted = 100, .absorbed = 90};
  for (const Counts* pass : {&good, &bad, &good}) s.record({*pass, 0, 0, 0, 0});
  EXPECT_DOUBLE_EQ(s.worst_ledger_residual, 0.1);
}

// Numbers may not be exchanged between columns either, so each name and member stands once.
TEST(Statistics, CountersAreDistinct) {
  std::set<std::string> names;
  Counters all;
  std::set<const std::uint64_t*> members;
  for (const WorkCounter& counter : work_counters)
    names.insert(counter.name), members.insert(&(all.*counter.value));
  for (const DropCounter& counter : drop_counters)
    names.insert(counter.name), members.insert(&(all.*counter.value));
  EXPECT_EQ(names.size(), sizeof(Counters) / sizeof(std::uint64_t));
  EXPECT_EQ(members.size(), names.size());
}

TEST(Report, TellsOfEverythingDropped) {
  RenderStatistics s;
  s.record({counts_of(1), 0, 0, 0, 0});
  s.threads = 3;
  const std::string report = describe(s);
  EXPECT_NE(
      report.find("dropped: 1009 not finite; clamped: 1010 at shading normals; capped: 1011 by depth, "
                  "1012 by gates, 1013 by alpha layers, 1014 by states, 1015 splits; grazing exits: 1016\n"),
      std::string::npos)
      << report;
  EXPECT_NE(report.find("time: compile 0.00 s, guide 0.00 s, photons 0.00 s, view 0.00 s on 3 threads\n"),
            std::string::npos)
      << report;
}

TEST(Report, HashesHaveSixteenDigits) {
  EXPECT_EQ(hex(0), "0000000000000000");
  EXPECT_EQ(hex(0xfedcba9876543210u), "fedcba9876543210");
}

}  // namespace
}  // namespace sluice
