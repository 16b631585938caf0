// SPDX-License-Identifier: GPL-3.0-or-later
// What a gate does to what it carries: gains, textures, normal maps. Design §4, numerics P8, P10, P12.
#include <gtest/gtest.h>

#include <algorithm>

#include "edit_scene.h"

namespace sluice {
namespace {

using Random = std::mt19937_64;

TEST(Gains, GainsOfFluxAndRadiance) {
  std::vector<EditDescription> all{edit_at("A", flat, "L", 0), edit_at("V", at({0, 0, 9}), "SE", 1)};
  all[0].exits = {exit_at("keep", at({10, 0, 0}), 2, 3), exit_at("off", at({20, 0, 0}), 3, 3)};
  all[0].exits[0].intensity = all[0].exits[1].intensity = 0.5f;
  all[0].exits[1].keep_brightness = false;
  all[0].exits[1].hue_shift = 1;
  all[1].exits = all[0].exits;
  Setting s(all);
  const V2d uv(0.5, 0.5);
  EXPECT_FLOAT_EQ(s.edits.forward(0, 0, uv, {0, 0, -1})->gain.x, 0.5f * 9);  // σ = 9 keeps brightness
  EXPECT_FLOAT_EQ(s.edits.backward(0, 0, uv, {0, 0, 1})->gain.x, 0.5f);
  EXPECT_FLOAT_EQ(s.edits.forward(0, 1, uv, {0, 0, -1})->gain.x, 0.5f);  // off keeps flux
  EXPECT_FLOAT_EQ(s.edits.backward(0, 1, uv, {0, 0, 1})->gain.x, 0.5f / 9);
  EXPECT_FLOAT_EQ(s.edits.forward(1, 0, uv, {0, 0, -1})->gain.x, 0.5f);  // view edits carry radiance
  EXPECT_FLOAT_EQ(s.edits.forward(1, 1, uv, {0, 0, -1})->gain.x, 0.5f);
  EXPECT_EQ(s.edits.forward(0, 1, uv, {0, 0, -1})->hue, 1);
  EXPECT_TRUE(s.edits[0].side == Side::Light && s.edits[1].side == Side::View);
  // P10: σ · A_in = A_out.
  EXPECT_NEAR(s.edits[0].exits[0].area_ratio * s.edits[0].entry.area / s.edits[0].exits[0].quad.area, 1,
              1e-5);
}

TEST(Gains, NumbersAreClamped) {
  std::vector<EditDescription> all{edit_at("A", at({0, 0, 0}), "L", 0, 1e-3)};
  all[0].amount = 2;
  all[0].feather = std::nanf("");
  all[0].exits = {exit_at("X", at({10, 0, 0}), 2, 10)};
  all[0].exits[0].intensity = 1e6f;
  all[0].exits[0].hue_shift = infinity;
  Setting s(all);
  EXPECT_EQ(s.warnings.size(), 5u);  // the four, and σ = 1e8
  const Passage p = *s.edits.forward(0, 0, {0.5, 0.5}, {0, 0, 1});
  EXPECT_FLOAT_EQ(p.gain.x, max_intensity * max_area_ratio);
  EXPECT_EQ(p.hue, 0);
  EXPECT_EQ(s.edits.weight(0, {0, 0}), 1);
  // what the clamp took is gone on both sides
  EXPECT_NEAR(s.edits.backward(0, 0, {0.5, 0.5}, {0, 0, 1})->gain.x, max_intensity * 0.01, 1);
}

// A tint colours white light and leaves it as bright; forward and backward, on light and view edits, the
// same.
TEST(Gains, TintsKeepTheLuminanceOfWhite) {
  std::vector<EditDescription> all{edit_at("A", flat, "L", 0), edit_at("V", at({0, 0, 9}), "SE", 1)};
  all[0].exits = all[1].exits = {exit_at("X", at({10, 0, 0}))};
  const V2d uv(0.5, 0.5);
  const auto gains = [&](const Color& tint, std::size_t warned = 0) {
    for (EditDescription& e : all) e.exits[0].intensity = 0.3f, e.exits[0].tint = tint;
    Setting s(all);
    EXPECT_EQ(s.warnings.size(), 2 * warned);
    const Color gain = s.edits.forward(0, 0, uv, {0, 0, -1})->gain;
    EXPECT_EQ(gain, s.edits.backward(0, 0, uv, {0, 0, 1})->gain);
    EXPECT_EQ(gain, s.edits.forward(1, 0, uv, {0, 0, -1})->gain);
    return gain;
  };
  const float least = std::numeric_limits<float>::denorm_min(), most = std::numeric_limits<float>::max();
  for (const Color& tint : {Color(1, 0.4f, 0.1f), Color(0.02f, 0, 0.01f), Color(0, 0, 1), Color(least, 0, 0),
                            Color(most, most, 0), Color(most, 100, 0)}) {
    const Color gain = gains(tint);
    EXPECT_NEAR(luminance(gain), 0.3f, 1e-6f);
    EXPECT_NEAR(double{gain.x} * double{tint.y}, double{gain.y} * double{tint.x},
                1e-6 * double{gain.x} * double{tint.y})
        << "another colour";
  }
  EXPECT_FLOAT_EQ(gains({0, 0, 0.5f}).z, 0.3f / 0.0722f);
  for (const Color& grey : {Color(1), Color(0.3f), Color(0), Color(least), Color(most)})
    EXPECT_EQ(gains(grey), Color(0.3f));
  // What is no colour is white, and said; below zero counts as zero.
  for (const float bad : {std::nanf(""), infinity, -infinity}) EXPECT_EQ(gains({1, bad, 0}, 1), Color(0.3f));
  EXPECT_EQ(gains({0, -1, 2}, 1), gains({0, 0, 1}));
  EXPECT_EQ(gains(Color(-1), 1), Color(0.3f));
}

TEST(Gains, AmountAndFeather) {
  std::vector<EditDescription> all{edit_at("A", flat, "L", 0), edit_at("B", flat, "L", 1)};
  all[0].amount = all[1].amount = 0.5f;
  all[1].feather = 0.4f;
  Setting s(all);
  EXPECT_TRUE(s.edits[0].is_partial);
  EXPECT_EQ(s.edits.weight(0, {0, 0.3}), 0.5f);
  EXPECT_EQ(s.edits.weight(1, {0, 0.5}), 0);
  EXPECT_EQ(s.edits.weight(1, {0.5, 1}), 0);
  EXPECT_FLOAT_EQ(s.edits.weight(1, {0.1, 0.5}), 0.25f);  // half of the border: half of the way
  EXPECT_FLOAT_EQ(s.edits.weight(1, {0.2, 0.5}), 0.5f);
  EXPECT_EQ(s.edits.weight(1, {0.5, 0.5}), 0.5f);
}

Image image(int width, int height, std::vector<Color> texels) {
  std::vector<float> rgba;
  for (const Color& c : texels) rgba.insert(rgba.end(), {c.x, c.y, c.z, 1});
  return make_image("image", width, height, rgba, ColorSpace::NonColor);
}

TEST(Gains, TexturesOfExits) {
  std::vector<EditDescription> all{edit_at("A", flat, "L", 0)};
  all[0].exits = {exit_at("X", at({10, 0, 0}))};
  ExitDescription& x = all[0].exits[0];
  x.intensity = 2;
  x.hue_shift = 3;
  x.intensity_texture = 1;
  x.hue_shift_texture = 2;
  const std::vector<Image> images{image(1, 1, {Color(9)}), image(2, 1, {Color(0), Color(1)}),
                                  image(1, 2, {Color(1, 0, 0), Color(0, 1, 0)})};
  Setting s(all, {}, V3d(0), {}, 8, images);
  const auto gain = [&](double u) { return s.edits.forward(0, 0, {u, 0.5}, {0, 0, -1})->gain.x; };
  EXPECT_FLOAT_EQ(gain(0), 0);
  EXPECT_FLOAT_EQ(gain(0.5), 1);
  EXPECT_FLOAT_EQ(gain(1), 2);
  EXPECT_FLOAT_EQ(s.edits.forward(0, 0, {0, 0}, {0, 0, -1})->hue, 3 * 0.2126f);  // row 0 at v = 0
  EXPECT_FLOAT_EQ(s.edits.forward(0, 0, {0, 1}, {0, 0, -1})->hue, 3 * 0.7152f);

  // Broken texels count 0; a missing image leaves the number alone, with a warning naming exit and image.
  for (const float bad : {std::nanf(""), -5.0f}) {
    Setting broken(all, {}, V3d(0), {}, 8,
                   std::vector<Image>{images[0], image(1, 1, {Color(bad)}), image(1, 1, {Color(bad)})});
    const Passage p = *broken.edits.forward(0, 0, {0.5, 0.5}, {0, 0, -1});
    EXPECT_EQ(p.gain.x, 0);
    EXPECT_TRUE(std::isfinite(p.hue));
  }
  Setting huge(all, {}, V3d(0), {}, 8, std::vector<Image>{images[0], image(1, 1, {Color(1e9f)}), images[2]});
  EXPECT_EQ(huge.edits.forward(0, 0, {0.5, 0.5}, {0, 0, -1})->gain.x, max_intensity);
  Image missing;
  missing.name = "gobo.png";
  Setting without(all, {}, V3d(0), {}, 8, std::vector<Image>{images[0], missing, images[2]});
  EXPECT_FLOAT_EQ(without.edits.forward(0, 0, {0, 0}, {0, 0, -1})->gain.x, 2);
  const bool said = std::any_of(without.warnings.begin(), without.warnings.end(), [](const Warning& w) {
    return w.item == "X" && w.message.find("gobo.png") != std::string::npos;
  });
  EXPECT_TRUE(said);
}

TEST(Gains, NormalMapTurnsTheExit) {
  std::vector<EditDescription> all{edit_at("A", flat, "L", 0), edit_at("V", at({0, 0, 5}), "SE", 0)};
  all[0].exits = all[1].exits = {exit_at("X", at({10, 0, 0}))};
  all[0].exits[0].normal_map = all[1].exits[0].normal_map = 0;
  const double tilt = 0.5;
  const Color texel(static_cast<float>(0.5 + 0.5 * std::sin(tilt)), 0.5f,
                    static_cast<float>(0.5 + 0.5 * std::cos(tilt)));
  Setting s(all, {}, V3d(0), {}, 8, std::vector<Image>{image(1, 1, {texel})});
  const V2d uv(0.5, 0.5);
  // Straight through becomes tilted against local X: n' = (sin, 0, cos), d' = -n'.
  const Passage p = *s.edits.forward(0, 0, uv, {0, 0, -1});
  EXPECT_NEAR(p.direction.x, -std::sin(tilt), 1e-6);
  EXPECT_NEAR(p.direction.z, -std::cos(tilt), 1e-6);
  EXPECT_EQ(p.gain.x, 1);  // flux
  const Passage back = *s.edits.backward(0, 0, uv, -p.direction);
  EXPECT_NEAR(back.direction.z, 1, 1e-6);
  EXPECT_NEAR(back.gain.x, 1 / std::cos(tilt), 1e-6);  // radiance: |cos in| / |cos out|
  // Grazing at the exit: dropped on both sides alike, on light edits.
  EXPECT_FALSE(s.edits.forward(0, 0, uv, to_float(V3d(std::cos(tilt), 0, std::sin(tilt)))));
  EXPECT_FALSE(s.edits.backward(0, 0, uv, to_float(V3d(1, 0, 0.5e-3))));
  EXPECT_TRUE(s.edits.backward(0, 0, uv, to_float(V3d(1, 0, 2e-3))));
  EXPECT_TRUE(s.edits.forward(1, 0, uv, to_float(V3d(std::cos(tilt), 0, std::sin(tilt)))));
}

// P12: every texel of 8 bits gives an orthogonal turn; texels that are no normal turn nothing.
TEST(Gains, P12NormalMapsAreOrthogonal) {
  double worst = 0;
  for (int code = 0; code < 1 << 24; ++code) {
    const QuadFrame m =
        normal_map_turn(Color(static_cast<float>(code & 255), static_cast<float>((code >> 8) & 255),
                              static_cast<float>(code >> 16)) /
                        255.0f);
    worst = std::max({worst, std::abs(m.t.dot(m.b)), std::abs(m.t.dot(m.n)), std::abs(m.b.dot(m.n)),
                      std::abs(m.t.dot(m.t) - 1), std::abs(m.b.dot(m.b) - 1), std::abs(m.n.dot(m.n) - 1),
                      std::abs(m.t.cross(m.b).dot(m.n) - 1)});
  }
  EXPECT_LT(worst, 1e-6);
  const float half = 128 / 255.0f;
  for (const Color& none :
       {Color(0), Color(half, half, 0), Color(0.5f), Color(1, 1, 0), Color(std::nanf(""), 0, 1)}) {
    const QuadFrame m = normal_map_turn(none);
    EXPECT_EQ(m.t, V3d(1, 0, 0));
    EXPECT_EQ(m.b, V3d(0, 1, 0));
    EXPECT_EQ(m.n, V3d(0, 0, 1));
  }
  EXPECT_EQ(normal_map_turn({0.5f, 0.5f, 1}).t, V3d(1, 0, 0));
}

// A hundred gates: lengths do not drift.
TEST(Gains, P12DirectionsStayUnit) {
  Random random(12);
  std::vector<EditDescription> all{edit_at("A", random_placement(random, V3d(0)), "L", 0)};
  all[0].exits = {exit_at("X", random_placement(random, V3d(5, 0, 0)))};
  all[0].exits[0].normal_map = 0;
  Setting s(all, {}, V3d(0), {}, 8, std::vector<Image>{image(1, 1, {Color(0.7f, 0.6f, 0.9f)})});
  V3f d(0, 0, 1);
  for (int i = 0; i < 100'000; ++i)
    if (const auto p = s.edits.forward(0, 0, {0.5, 0.5}, d)) d = p->direction;
  EXPECT_NEAR(d.length(), 1, 2e-7);
}

}  // namespace
}  // namespace sluice
