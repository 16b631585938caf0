// SPDX-License-Identifier: GPL-3.0-or-later
// When a render stops, and how long that will take.
#include "render/progress.h"

#include <gtest/gtest.h>

#include <limits>

#include "base/enum_names.h"
#include "transport/film.h"

namespace sluice {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

RenderSettings settings(int passes, double time_limit = 0, double error_target = 0) {
  RenderSettings s;
  s.passes = passes, s.time_limit = time_limit, s.error_target = error_target;
  return s;
}

TEST(Stop, AfterTheLastPass) {
  EXPECT_EQ(stop_after({.passes = 15}, settings(16)), StopReason::None);
  EXPECT_EQ(stop_after({.passes = 16}, settings(16)), StopReason::Passes);
  EXPECT_EQ(stop_after({.passes = 1}, settings(1)), StopReason::Passes);
}

// With the pass whose end is nearest to the limit.
TEST(Stop, AtTheTime) {
  const RenderSettings s = settings(1000, 10);
  EXPECT_EQ(stop_after({.passes = 9, .seconds = 8.9, .last_pass_seconds = 1}, s), StopReason::None);
  EXPECT_EQ(stop_after({.passes = 9, .seconds = 9.4, .last_pass_seconds = 1}, s), StopReason::None);
  EXPECT_EQ(stop_after({.passes = 9, .seconds = 9.6, .last_pass_seconds = 1}, s), StopReason::Time);
  EXPECT_EQ(stop_after({.passes = 1, .seconds = 7, .last_pass_seconds = 7}, s), StopReason::Time);
}

TEST(Stop, AtTheErrorIfItIsKnownWell) {
  const RenderSettings s = settings(1000, 0, 0.01);
  constexpr int enough = 2 * stream_count;
  EXPECT_EQ(stop_after({.passes = enough, .relative_error = 0.01}, s), StopReason::Error);
  EXPECT_EQ(stop_after({.passes = enough, .relative_error = 0}, s), StopReason::Error);
  EXPECT_EQ(stop_after({.passes = enough, .relative_error = 0.011}, s), StopReason::None);
  EXPECT_EQ(stop_after({.passes = enough, .relative_error = -1}, s), StopReason::None);
  EXPECT_EQ(stop_after({.passes = enough, .relative_error = nan}, s), StopReason::None);
  EXPECT_EQ(stop_after({.passes = stream_count, .relative_error = 0.001}, s), StopReason::None);
}

TEST(Stop, LimitsThatAreNoneStopNothing) {
  for (const double none : {0.0, -1.0, nan}) {
    const RenderSettings s = settings(1000, none, none);
    EXPECT_EQ(stop_after({.passes = 100, .seconds = 1e9, .last_pass_seconds = 1e7, .relative_error = 0}, s),
              StopReason::None);
  }
}

TEST(Stop, TheErrorIsMeasuredWhenStreamsAreEqual) {
  for (int pass = 1; pass < 20; ++pass) EXPECT_EQ(measures_error_after(pass), pass % stream_count == 0);
}

TEST(SecondsLeft, AreThoseToTheNearestStop) {
  Progress now;
  now.passes = 100;
  EXPECT_LT(seconds_left(now, settings(100)), 0);  // nothing is known before the first pass
  now.pass = 20, now.seconds = 40;
  EXPECT_DOUBLE_EQ(seconds_left(now, settings(100)), 160);
  EXPECT_DOUBLE_EQ(seconds_left(now, settings(100, 50)), 10);
  EXPECT_DOUBLE_EQ(seconds_left(now, settings(100, 1000)), 160);
  EXPECT_DOUBLE_EQ(seconds_left(now, settings(100, 30)), 0);  // it ends with this pass
  // Twice the error takes four times the passes.
  now.accuracy.pass = 20, now.accuracy.noise = 0.02;
  EXPECT_NEAR(seconds_left(now, settings(100, 0, 0.01)), 120, 1e-6);
  EXPECT_DOUBLE_EQ(seconds_left(now, settings(100, 0, 0.05)), 0);
  EXPECT_DOUBLE_EQ(seconds_left(now, settings(100, 0, 0.001)), 160);
  // Half the bias takes eight times the passes.
  now.accuracy.noise = 0, now.accuracy.bias = 0.02, now.passes = 1000;
  EXPECT_NEAR(seconds_left(now, settings(1000, 0, 0.01)), 40 * (8 - 1), 1e-6);
  now.accuracy.noise = -1, now.passes = 100;
  EXPECT_DOUBLE_EQ(seconds_left(now, settings(100, 0, 0.01)), 160);
}

TEST(Names, AreFoundAgain) {
  EXPECT_EQ(value_named<State>("rendering"), State::Rendering);
  EXPECT_EQ(value_named<State>(name_of(State::Failed)), State::Failed);
  EXPECT_EQ(value_named<StopReason>("time"), StopReason::Time);
  EXPECT_EQ(value_named<State>("Rendering"), std::nullopt);
  EXPECT_EQ(value_named<State>(""), std::nullopt);
}

}  // namespace
}  // namespace sluice
