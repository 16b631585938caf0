// SPDX-License-Identifier: GPL-3.0-or-later
// The core against the forward light tracer (design §5, oracle a) on small scenes: all kinds of lights,
// caustics, edits on light on its way to what the camera sees. Fast form: any deviation of the size that a
// wrong rule makes (numerics §10: 2 to 21 % of the image). SLUICE_FULL=1: every region within 1 %.
#include "oracle/compare.h"
#include "oracle/random_edits.h"

namespace sluice::oracle {
namespace {

Stage under_point_lamp(bool wall = true) {
  Stage s(wall);
  s.lamp("Lamp", LightKind::Point, facing({0, 0, 1}, {0.4, -0.3, 1.5}), 30, {1, 0.8f, 0.6f});
  return s;
}

// A faceted ball of glass, out of the camera's sight; its caustic falls about the origin.
Stage with_glass_ball() {
  Stage s;
  s.lamp("Lamp", LightKind::Point, facing({0, 0, 1}, {1.36, 0, 1.71}), 30);
  s.solid("Ball", sphere(6), {0.8, 0, 0.95}, 0.25, glass({0.95f, 1, 0.9f}, 1.5f));
  return s;
}

TEST(Oracle, no_edit) {
  compare("no edit, point lamp", under_point_lamp(), Which::Forward, lit);
  Stage s;
  s.area("Lamp", {0, 0, 1.8}, 1.6f, 30);
  s.world({0.2f, 0.3f, 0.4f});
  compare("no edit, area lamp and world", s, Which::Forward, lit);
}

TEST(Oracle, direct_light_through_a_gate) {
  Stage s = under_point_lamp();
  auto& e = s.edit("In", "L", facing({0.2, 0.1, 1}, {0.3, 0, 0.8}), 0.3);
  s.exit(e, facing({0, 0, 1}, {-0.2, 0.1, 0.5}, 1, 1.3, 0.4), 0.3).hue_shift = 1;
  s.scene.edits[0].exits[0].tint = {0.8f, 0.4f, 0.1f};
  compare("direct light through a gate", s, Which::Forward, lit);
}

TEST(Oracle, every_kind_of_light) {
  Stage s;
  s.lamp("Spot", LightKind::Spot, facing({0.3, 0, 1}, {0.6, 0, 1.6}), 60, {1, 0.6f, 0.3f}).spot_angle = 1.4f;
  LightDescription& sun = s.lamp("Sun", LightKind::Sun, facing({-0.4, -0.2, 1}, {0, 0, 3}), 0.8f);
  sun.angle = 0.2f;
  s.lamp("Bulb", LightKind::Point, facing({0, 0, 1}, {-0.6, -0.4, 1.2}), 20, {0.4f, 0.6f, 1}).radius = 0.1f;
  s.plate("Tube", facing({1, 0, -0.5}, {-1.4, 0, 1.2}, 0.5, 0.2), glowing({0.3f, 1, 0.5f}, 8));
  s.world({0.1f, 0.1f, 0.15f});
  compare("five lights", s, Which::Forward, lit);
  auto& a = s.edit("A", "L'Sun,Tube'", facing({0, 0, 1}, {0, 0, 0.6}), 0.5);
  s.exit(a, facing({0.3, 0, 1}, {0.2, 0.1, 0.7}, 1, 1, 0.5), 0.4);
  auto& b = s.edit("B", "L'World'|L'Spot'", facing({0, 0, 1}, {0.2, 0, 0.4}), 0.4);
  s.exit(b, facing({0, 0.3, 1}, {-0.2, 0.1, 0.3}), 0.4).intensity = 0.5f;
  compare("five lights, two edits by light", s, Which::Forward, lit);
}

// Most shadow segments to this lamp end at its shade: photons light y instead, and at v it is asked less
// often.
TEST(Oracle, hidden_light) {
  Stage s = under_point_lamp();
  s.area("Sky", {0, 0, 2.2}, 2.4f, 60, {0.5f, 0.7f, 1});
  s.plate("Shade", facing({0, 0, 1}, {0.2, 0, 2}, 1.2, 1.4), painted({0.2f, 0.2f, 0.2f}));
  const auto scene = test::compiled(s.scene);
  const Guide guide =
      make_guide(*scene, s.settings, find_effects(*scene, s.settings), pool(), std::atomic<bool>(false));
  const V3d anywhere(1e6, 0, 0);
  EXPECT_GT(guide.trust.at_y(anywhere)[0], 0);
  EXPECT_EQ(guide.trust.at_y(anywhere)[1], 0);
  EXPECT_LT(guide.trust.at_v(anywhere)[1], 0.5f * guide.trust.at_v(anywhere)[0]);
  compare("lamp behind a shade", s, Which::Forward, lit);
  auto& e = s.edit("In", "L'Sky'", facing({0, 0, 1}, {-0.2, 0, 0.6}), 0.4);
  s.exit(e, facing({0.3, 0, 1}, {0.2, 0.1, 0.7}, 1, 1, 0.5), 0.4).intensity = 2;
  compare("lamp behind a shade, edited", s, Which::Forward, lit);
}

TEST(Oracle, caustic_moved_and_removed) {
  Stage s = with_glass_ball();
  compare("caustic", s, Which::Forward, lit);
  Stage moved = s;
  auto& e = moved.edit("In", "LS+", facing({0, 0, 1}, {0, 0, 0}), 0.45);  // in the floor's own plane
  moved.exit(e, facing({0, 0, 1}, {-0.1, 0.05, 0}, 0.8, 1, 0.6), 0.45).hue_shift = -1;
  compare("caustic moved on the floor", moved, Which::Forward, lit);
  Stage removed = s;
  removed.edit("In", "L.*S", facing({0.3, 0, 1}, {0.3, 0, 0.3}), 0.4).amount = 0.7f;
  removed.scene.edits[0].feather = 0.6f;
  compare("caustic dimmed, soft border", removed, Which::Forward, lit);
}

// 9 to 30 % of caustic light starts LD, not LS.
TEST(Oracle, caustic_of_bounced_light) {
  Stage s = with_glass_ball();
  // the lamp is on its other side of the ball
  s.plate("Screen", facing({-0.7, 0, -0.95}, {1.3, 0, 1.63}, 0.7, 0.7), painted({0.9f, 0.9f, 0.9f}));
  s.scene.lights[0].matrix = facing({0, 0, 1}, {1.0, -0.6, 1.4});
  compare("caustic that starts LD", s, Which::Forward, lit);
  auto& e = s.edit("In", "LDS+", facing({0.5, 0, 1}, {0.3, 0, 0.3}), 0.4);
  s.exit(e, facing({0, 0.1, 1}, {-0.2, 0, 0.4}), 0.5).intensity = 2;
  compare("caustic that starts LD, moved", s, Which::Forward, lit);
}

TEST(Oracle, copies_mirrored_skewed_scaled) {
  Stage s = under_point_lamp();
  auto& e = s.edit("In", "L|LF'Back'", facing({0.2, 0.1, 1}, {0.3, -0.1, 0.8}), 0.25);
  s.exit(e, facing({0.1, 0, 1}, {-0.4, 0.1, 0.5}, -1, 1.3, 0.4), 0.3).keep_brightness = false;
  auto skewed = facing({0, 0.3, 1}, {0.1, 0.3, 0.4});
  for (int i = 0; i < 3; ++i) skewed[1][i] += 0.5 * skewed[0][i];
  s.exit(e, skewed, 0.4).intensity = 0.5f;
  s.exit(e, facing({0.1, 0, -1}, {0.5, 0.1, 0.9}), 0.2);  // its light leaves upwards
  auto& back = s.edit("Back", "LF'In'", facing({0, 0, 1}, {0.5, 0.1, 1.3}), 0.5);
  s.exit(back, facing({0, 0.2, -1}, {-0.2, 0.1, 0.9}), 0.4);
  compare("three exits and one back", s, Which::Forward, lit);
}

// Chains laid on an exit, orders, planes 0.3 δ apart, arrows opposite.
TEST(Oracle, quads_in_one_plane) {
  const auto chain = [](double height, double arrow, bool swapped) {
    Stage s = under_point_lamp(false);
    s.scene.max_gates = 4;
    auto& a = s.edit("A", "L", facing({0.2, 0, 1}, {0.3, 0, 0.9}), 0.3);
    s.exit(a, facing({0, 0, 1}, {0, 0, 0.4}), 0.4).hue_shift = 0.5f;
    auto& b = s.edit("B", "L.*F'A'", facing({0, 0, arrow}, {0.1, 0.1, height}, 1, 1, 0.3), 0.35);
    s.exit(b, facing({0.2, 0, 1}, {-0.3, 0, 0.3}), 0.3).intensity = 0.6f;
    auto& c = s.edit("C", "LF'A'|LF'A'F'B'", facing({0, 0, 1}, {0, -0.1, 0.4}, 1, 1, 1), 0.3);
    s.exit(c, facing({0, 0, 1}, {0.1, 0, 0.4}, 0.7, 0.7), 0.3).hue_shift = 2;
    if (swapped) std::swap(s.scene.edits[1].entry.order, s.scene.edits[2].entry.order);
    return s;
  };
  const Stage plain = chain(0.4, 1, false);
  const double delta = Gates(plain.scene, *test::compiled(plain.scene)).delta();
  compare("quads in one plane", plain, Which::Forward, lit);
  compare("quads in one plane, other order, 0.3 δ apart", chain(0.4 + 0.3 * delta, 1, true), Which::Forward,
          lit);
  compare("quads in one plane, 0.3 δ below", chain(0.4 - 0.3 * delta, 1, false), Which::Forward, lit);
  compare("quads back to back", chain(0.4, -1, false), Which::Forward, lit);
  compare("opposite arrows, planes 0.3 δ apart", chain(0.4 + 2.3 * delta, -1, false), Which::Forward, lit);
}

TEST(Oracle, repeat_up_to_the_cap) {
  Stage s = under_point_lamp();
  s.scene.max_gates = 3;
  auto& e = s.edit("In", "LF*", facing({0, 0, 1}, {0.2, 0, 0.5}), 0.4);
  e.repeat = true;
  // above its own entry: light goes round
  s.exit(e, facing({0, 0.1, 1}, {0.25, 0, 0.7}), 0.4).intensity = 0.8f;
  s.exit(e, facing({0, 0.1, 1}, {-0.2, 0, 0.3}), 0.3).intensity = 0.5f;
  compare("repeat with a cap", s, Which::Forward, lit);
  s.scene.edits[0].repeat = false;
  s.settings.max_depth = 2;
  compare("depth 2", s, Which::Forward, lit);
}

TEST(Oracle, glossy_and_mixed_surfaces) {
  Stage s = under_point_lamp();
  s.scene.materials[0] = mixed(painted({0.5f, 0.3f, 0.2f}), glossy({0.9f, 0.9f, 0.8f}, 0.45f), 0.4f);
  s.scene.materials[1] = mixed(painted({0.3f, 0.5f, 0.9f}), mirror({0.9f, 0.9f, 0.9f}), 0.4f);
  compare("glossy floor, plastic wall", s, Which::Forward, lit);
  auto& e = s.edit("In", "L.*D'Wall'", facing({0, -1, 0.3}, {0, 0.5, 0.6}), 0.6);
  s.exit(e, facing({0.6, 0, 1}, {1.4, 0, 0.6}), 0.5).intensity = 1.5f;
  auto& g = s.edit("Glint", "LS", facing({0, -1, 0.3}, {0, 0.5, 0.5}), 0.5);
  s.exit(g, facing({0.1, -0.3, 1}, {0, 0.2, 0.4}), 0.5).hue_shift = 2;
  // what the glossy lobe sends to the eye
  auto& f = s.edit("Sheen", "LG", facing({0, -0.4, 1}, {0, -0.5, 0.5}), 0.6);
  s.exit(f, facing({0.2, 0, -1}, {1.6, 0, 0.9}), 0.6);
  compare("glossy floor, plastic wall, three edits by lobe", s, Which::Forward, lit);
}

TEST(Oracle, leaf_with_alpha) {
  Stage s;
  s.lamp("Sun", LightKind::Sun, facing({0.3, 0.2, 1}, {0, 0, 3}), 2);
  MaterialDescription clear = test::see_through({0.5f, 1, 0.4f});
  s.plate("Leaf", facing({0, 0, 1}, {0.1, 0, 0.9}, 0.4, 0.4, 0.3),
          mixed(painted({0.2f, 0.6f, 0.2f}), clear, 0.6f));
  // sun through it is no caustic
  auto& spurious = s.edit("Spurious", "LS+|LD'Leaf'S", facing({0, 0, 1}, {0.1, 0, 0.5}), 0.6);
  s.exit(spurious, facing({0, 0, 1}, {1, 0, 0.5}), 0.6);
  auto& e = s.edit("In", "L", facing({0, 0.1, 1}, {-0.1, 0, 0.6}), 0.35);
  s.exit(e, facing({0, 0, 1}, {0.1, 0.1, 0.4}), 0.35);
  compare("leaf with alpha", s, Which::Forward, lit);
}

// Flux through gates inside and outside of glass.
TEST(Oracle, gates_in_glass) {
  Stage s = with_glass_ball();
  auto& in = s.edit("In", "L", facing({0.7, 0, 0.9}, {0.7, -0.5, 0.9}), 0.25);
  // leaves inside of the ball
  s.exit(in, facing({0.4, 0.1, 1}, {0.8, 0, 0.95}, 0.4, 0.4), 0.25).intensity = 3;
  auto& out = s.edit("Out", "LS", facing({0.5, 0, 1}, {0.75, 0, 0.9}), 0.1);  // taken inside
  s.exit(out, facing({0.2, 0, 1}, {-0.2, 0.1, 0.4}, 2, 2), 0.2);
  compare("gates in glass, forward", s, Which::Forward, lit);
}

// Edited light under a virtual lamp at height h: a disk of radius r sees the middle too dark, by 3/4 r² / h²
// at the first order. Three radii on the same photons; without the part that falls with r² the core is the
// oracle.
TEST(Oracle, bias_falls_with_the_square_of_the_radius) {
  Stage s(false);
  s.lamp("Lamp", LightKind::Point, facing({0, 0, 1}, {1.5, 0, 0.8}), 30);
  auto& e = s.edit("In", "L", facing({0, 0, 1}, {1.5, 0, 0.7}), 0.5);
  s.exit(e, facing({0, 0, 1}, {0, 0, 0.15}), 0.5);  // h = 0.25
  s.scene.frame = {40, 40, 1, 1, 0, 0, 40, 40, 1, true};
  s.settings.photons = 16384, s.settings.caustic_radius_range = 1;
  constexpr int side = 5;
  const auto scene = test::compiled(s.scene);
  const auto middle = [](const std::vector<Regions>& batches) {
    std::vector<double> values;
    for (const Regions& r : batches)
      values.push_back(luma(r.mean[side * side / 2][static_cast<std::size_t>(Part::Edited)]));
    return values;
  };
  const Effort effort{
      .seeds = is_full() ? 1024 : 128, .batches = 32, .paths = is_full() ? 320000 : 40000, .side = side};
  const Sample oracle =
      summarise(middle(ask_oracle(s.scene, *scene, s.settings, Which::Forward, effort, 77)));
  std::vector<double> at[3];
  for (int i = 0; i < 3; ++i) {
    // footprints: up to a sixteenth of the picture
    s.settings.caustic_radius_factor = 0.6f * static_cast<float>(1 << i);
    Counts counts;
    at[i] =
        middle(render_core(*scene, s.settings, {.seeds = effort.seeds, .passes = 1}, side, pool(), counts));
  }
  std::vector<double> without, near, far;
  for (std::size_t k = 0; k < at[0].size(); ++k) {
    near.push_back(at[0][k] - at[1][k]), far.push_back(at[1][k] - at[2][k]);
    without.push_back(at[0][k] + near.back() / 3);
  }
  const Sample a = summarise(near), b = summarise(far), core = summarise(without);
  const double ratio = b.mean / a.mean,
               error = ratio * std::sqrt(a.variance / (a.mean * a.mean) + b.variance / (b.mean * b.mean));
  std::printf(
      "bias: %.2f %% and %.2f %% more from one radius to the next, ratio %.2f ± %.2f; without it %.5f, "
      "oracle %.5f, p %.3g\n",
      100 * a.mean / oracle.mean, 100 * b.mean / oracle.mean, ratio, error, core.mean, oracle.mean,
      difference(core, oracle).p());
  EXPECT_NEAR(ratio, 4, 0.4 + 3 * error);  // r⁴ takes a little
  EXPECT_GT(difference(core, oracle).p(), sidak(family, suite_comparisons));
}

TEST(Oracle, random_light_edits) {
  const int count = is_full() ? 6 : 2;
  for (int seed = 1; seed <= count; ++seed) {
    for (const bool ball : {false, true}) {
      Stage s = ball ? with_glass_ball() : under_point_lamp();
      EditMaker maker(static_cast<std::uint64_t>(10 * seed + ball));
      for (int i = 0; i < 2; ++i) maker.add(s, {.expressions = {"L", "LS", "LSS", "LS+", "LF+", "LS*F?"}});
      for (int i = 0; i < 2; ++i)
        maker.add(s, {.expressions = {"LD", "L.*", "L(D|F)+", "L.*D'Wall'", "LD'Floor'"},
                      .exits_over_floor = false});
      maker.shuffle_orders(s);
      // Glass sends a little red light where few of the oracle's paths come: none would say that there is
      // nothing, and with no error.
      const Effort effort{.paths = (ball ? 4 : 1) * Effort{}.paths};
      compare("random light edits " + std::to_string(seed) + (ball ? " with glass" : ""), s, Which::Forward,
              lit, effort);
    }
  }
}

}  // namespace
}  // namespace sluice::oracle
