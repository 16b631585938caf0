// SPDX-License-Identifier: GPL-3.0-or-later
// Whatever a file says, settings lie within bounds that the renderer can live with.
#include "render/settings.h"

#include <gtest/gtest.h>

#include <limits>

#include "base/math.h"
#include "base/threads.h"

namespace sluice {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr int least = std::numeric_limits<int>::min(), most = std::numeric_limits<int>::max();

TEST(Settings, WhatIsWithinBoundsStays) {
  RenderSettings s;
  s.passes = 7, s.threads = 1, s.time_limit = 3, s.error_target = 0.02, s.frame = -4;
  TransportSettings& t = s.transport;
  t.photons = 1 << 20, t.pilot_paths = 1 << 17, t.max_depth = 5, t.seed = 9;
  t.caustic_radius_factor = 2, t.caustic_radius_range = 1.5f, t.soft_range = 10;
  const RenderSettings b = bounded(s);
  EXPECT_EQ(b.passes, 7);
  EXPECT_EQ(b.threads, 1);
  EXPECT_EQ(b.frame, -4);
  EXPECT_EQ(b.time_limit, 3);
  EXPECT_EQ(b.error_target, 0.02);
  EXPECT_EQ(b.transport.photons, 1 << 20);
  EXPECT_EQ(b.transport.pilot_paths, 1 << 17);
  EXPECT_EQ(b.transport.max_depth, 5);
  EXPECT_EQ(b.transport.seed, 9u);
  EXPECT_EQ(b.transport.caustic_radius_factor, 2);
  EXPECT_EQ(b.transport.caustic_radius_range, 1.5f);
  EXPECT_EQ(b.transport.soft_range, 10);
}

TEST(Settings, CountsAreClamped) {
  for (const int wild : {least, -1, 0, most}) {
    RenderSettings s;
    s.passes = s.transport.photons = s.transport.pilot_paths = s.transport.max_depth = wild;
    const RenderSettings b = bounded(s);
    for (const int count : {b.passes, b.transport.photons}) {
      EXPECT_GE(count, 1) << wild;
      EXPECT_LE(count, 1 << 28) << wild;
    }
    EXPECT_GE(b.transport.pilot_paths, 1 << 10) << wild;
    EXPECT_LE(b.transport.pilot_paths, 1 << 24) << wild;
    EXPECT_GE(b.transport.max_depth, 1) << wild;
    EXPECT_LE(b.transport.max_depth, 250) << wild;
  }
}

// A pass of few photons is not worth a long pilot.
TEST(Settings, ThePilotIsNoLongerThanAPassUnlessShort) {
  RenderSettings s;
  s.transport.photons = 100, s.transport.pilot_paths = 1 << 16;
  EXPECT_EQ(bounded(s).transport.pilot_paths, TransportSettings::short_pilot);
  s.transport.photons = 50'000;
  EXPECT_EQ(bounded(s).transport.pilot_paths, 50'000);
}

TEST(Settings, ThreadsAreAllOrAFewTimesThem) {
  RenderSettings s;
  for (const int none : {0, -3, least}) {
    s.threads = none;
    EXPECT_EQ(bounded(s).threads, hardware_threads());
  }
  s.threads = most;
  EXPECT_EQ(bounded(s).threads, 4 * hardware_threads());
}

TEST(Settings, FactorsThatAreNoNumbersAreTheDefaults) {
  const TransportSettings defaults;
  for (const float wild : {nan, infinity, -infinity}) {
    RenderSettings s;
    s.transport.caustic_radius_factor = s.transport.caustic_radius_range = s.transport.soft_range = wild;
    const TransportSettings b = bounded(s).transport;
    EXPECT_EQ(b.caustic_radius_factor, defaults.caustic_radius_factor);
    EXPECT_EQ(b.caustic_radius_range, defaults.caustic_radius_range);
    EXPECT_EQ(b.soft_range, defaults.soft_range);
  }
}

TEST(Settings, FactorsAreClamped) {
  RenderSettings s;
  s.transport.caustic_radius_factor = s.transport.caustic_radius_range = s.transport.soft_range = -1;
  TransportSettings b = bounded(s).transport;
  EXPECT_EQ(b.caustic_radius_factor, 0.1f);
  EXPECT_EQ(b.caustic_radius_range, 1);  // never narrower
  EXPECT_EQ(b.soft_range, 1);
  s.transport.caustic_radius_factor = s.transport.caustic_radius_range = s.transport.soft_range = 1e30f;
  b = bounded(s).transport;
  EXPECT_EQ(b.caustic_radius_factor, 100);
  EXPECT_EQ(b.caustic_radius_range, 100);
  EXPECT_EQ(b.soft_range, 100);
}

TEST(Settings, BoundsAreBoundsOfThemselves) {
  RenderSettings s;
  s.passes = s.threads = most, s.transport.photons = 3, s.transport.soft_range = nan;
  const RenderSettings once = bounded(s), twice = bounded(once);
  EXPECT_EQ(once.passes, twice.passes);
  EXPECT_EQ(once.threads, twice.threads);
  EXPECT_EQ(once.transport.pilot_paths, twice.transport.pilot_paths);
  EXPECT_EQ(once.transport.soft_range, twice.transport.soft_range);
}

}  // namespace
}  // namespace sluice
