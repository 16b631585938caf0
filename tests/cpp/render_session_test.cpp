// SPDX-License-Identifier: GPL-3.0-or-later
// A session from start to each of its ends. What it renders is other tests' matter.
#include "render/session.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "scene_fixtures.h"

namespace sluice {
namespace {

constexpr double long_enough = 60;

// A lamp over a floor, seen from above.
SceneDescription lit_floor() {
  SceneDescription scene;
  test::place(scene, test::add(scene, test::grid()), {}, test::add(scene, test::diffuse(0.5f)), "Floor");
  LightDescription lamp;
  lamp.names = {"Lamp"};
  lamp.matrix = test::translation({0, 0, 2});
  lamp.radius = 0.1f;
  scene.lights.push_back(lamp);
  scene.camera.matrix = test::translation({0, 0, 3});
  scene.frame.width = scene.frame.x1 = scene.frame.height = scene.frame.y1 = 16;
  return scene;
}

RenderSettings settings(int passes) {
  RenderSettings s;
  s.passes = passes, s.threads = 1;
  s.transport.photons = 1000;
  return s;
}

TEST(Session, RendersThePassesThatWereAskedFor) {
  Session session;
  EXPECT_EQ(session.progress().state, State::Idle);
  EXPECT_TRUE(session.pictures({"Combined"}).empty());
  session.start(lit_floor(), settings(5));
  ASSERT_TRUE(session.wait(long_enough));
  const Progress end = session.progress();
  EXPECT_EQ(end.state, State::Finished);
  EXPECT_EQ(end.stop_reason, StopReason::Passes);
  EXPECT_EQ(end.pass, 5);
  EXPECT_EQ(end.photons, session.statistics().counts.photon_paths);
  EXPECT_GT(end.accuracy.noise, 0);  // measured after the fourth pass
  EXPECT_FALSE(end.failure);
  const auto pictures = session.pictures({"Combined", "Depth"});
  ASSERT_EQ(pictures.size(), 2u);
  EXPECT_EQ(pictures[0].channels, 4);
  EXPECT_EQ(pictures[0].pixels.size(), 16u * 16 * 4);
  EXPECT_NEAR(pictures[1].pixels[16 * 8 + 8], 3, 1e-3);
  EXPECT_TRUE(session.pictures({"Combined", "no such pass"}).empty());
}

TEST(Session, StopsAtTheError) {
  RenderSettings s = settings(100'000);
  s.error_target = 0.5;
  Session session;
  session.start(lit_floor(), s);
  ASSERT_TRUE(session.wait(long_enough));
  EXPECT_EQ(session.progress().stop_reason, StopReason::Error);
  EXPECT_EQ(session.progress().pass, 2 * stream_count);
}

TEST(Session, StopsAtTheTime) {
  RenderSettings s = settings(1 << 28);
  s.time_limit = 0.2;
  Session session;
  session.start(lit_floor(), s);
  ASSERT_TRUE(session.wait(long_enough));
  EXPECT_EQ(session.progress().state, State::Finished);
  EXPECT_EQ(session.progress().stop_reason, StopReason::Time);
}

TEST(Session, IsCancelled) {
  Session session;
  session.start(lit_floor(), settings(1 << 28));
  EXPECT_FALSE(session.wait(0));
  session.cancel();
  ASSERT_TRUE(session.wait(long_enough));
  EXPECT_EQ(session.progress().state, State::Cancelled);
  EXPECT_EQ(session.progress().stop_reason, StopReason::Cancelled);
}

TEST(Session, FailsWithTheItemAtFault) {
  SceneDescription scene = lit_floor();
  scene.edits.emplace_back();
  scene.edits.back().entry.name = "Entry";
  scene.edits.back().expression = "LS)";
  Session session;
  session.start(scene, settings(1));
  ASSERT_TRUE(session.wait(long_enough));
  const Progress end = session.progress();
  EXPECT_EQ(end.state, State::Failed);
  ASSERT_TRUE(end.failure);
  EXPECT_EQ(end.failure->item, "Entry");
  EXPECT_EQ(end.failure->column, 3);
  EXPECT_TRUE(session.pictures({"Combined"}).empty());
}

// Layers are render passes, so they need names of their own.
TEST(Session, RefusesLayersWithoutANameOfTheirOwn) {
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{""}, {"Depth"}, {"Caustics"}, {"Noise"}, {"Mine", "Mine"}}) {
    SceneDescription scene = lit_floor();
    for (const std::string& name : names) scene.layers.push_back({name, "L.*E"});
    Session session;
    session.start(scene, settings(1));
    ASSERT_TRUE(session.wait(long_enough));
    EXPECT_EQ(session.progress().state, State::Failed) << names.front();
  }
}

TEST(Session, RendersOnce) {
  Session session;
  session.start(lit_floor(), settings(1));
  EXPECT_THROW(session.start(lit_floor(), settings(1)), std::logic_error);
  ASSERT_TRUE(session.wait(long_enough));
  EXPECT_EQ(session.progress().state, State::Finished);
}

// Another session goes on from the same things, and its picture is that of a start.
TEST(Session, StartsFromAnother) {
  Session base, again, anew;
  EXPECT_FALSE(again.start_from(base, lit_floor(), settings(2)));  // it has compiled nothing
  base.start(lit_floor(), settings(1));
  ASSERT_TRUE(base.wait(long_enough));
  ASSERT_TRUE(again.start_from(base, lit_floor(), settings(2)));
  anew.start(lit_floor(), settings(2));
  ASSERT_TRUE(again.wait(long_enough) && anew.wait(long_enough));
  EXPECT_EQ(again.film_hash(), anew.film_hash());
  EXPECT_NE(again.film_hash(), base.film_hash());
}

}  // namespace
}  // namespace sluice
