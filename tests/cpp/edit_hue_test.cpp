// SPDX-License-Identifier: GPL-3.0-or-later
// H of design §4; P15 of numerics §1.
#include "edit/hue.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <cstring>
#include <numbers>
#include <random>

namespace sluice {
namespace {

constexpr float third = 2 * std::numbers::pi_v<float> / 3;

bool same_bits(const Color& a, const Color& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

double luma(const Color& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

TEST(Hue, TurnsOnTheHexagon) {
  const Color green = apply_hue({0.5f, 0, 0}, third);
  EXPECT_NEAR(green.x, 0, 1e-6);
  EXPECT_NEAR(green.z, 0, 1e-6);
  EXPECT_NEAR(green.y, 0.5 * 0.2126 / 0.7152, 1e-7);  // brighter green is darker at one luminance
  const Color blue = apply_hue({0.5f, 0, 0}, -third);
  EXPECT_NEAR(blue.z, 0.5 * 0.2126 / 0.0722, 1e-6);
  // A sixth of a turn: red to yellow. Black and white parts stay where the hexagon has them.
  const Color yellow = apply_hue({0.8f, 0.2f, 0.2f}, third / 2);
  EXPECT_NEAR(yellow.x, yellow.y, 1e-6);
  EXPECT_NEAR(yellow.z / yellow.x, 0.25, 1e-6);
}

TEST(Hue, P15ZeroAndGreysAreBitExact) {
  for (const float v : {0.0f, -0.0f, 1e-38f, 1e-20f, 0.18f, 1.0f, 3e5f, 1e38f, -1.0f})
    for (const float angle : {0.0f, 0.1f, 3.0f, -2.0f})
      EXPECT_TRUE(same_bits(apply_hue(Color(v), angle), Color(v)));
  EXPECT_TRUE(same_bits(apply_hue({0.1f, 0.2f, 0.3f}, 0), {0.1f, 0.2f, 0.3f}));
  EXPECT_TRUE(same_bits(apply_hue({-0.1f, 0.2f, 0.3f}, 0), {-0.1f, 0.2f, 0.3f}));
}

// A million colours over eight decades.
TEST(Hue, P15KeepsLuminanceAndComesBack) {
  std::mt19937_64 random(15);
  std::uniform_real_distribution<float> unit(0, 1), turn(-7, 7);
  double worst_luma = 0, worst_return = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const float scale = std::pow(10.0f, 8 * unit(random) - 4);
    Color c(unit(random), unit(random), unit(random));
    if (i % 5 == 0) c[i % 3] = 0;  // the pure ones are the hard ones
    if (i % 15 == 0) c[(i + 1) % 3] = 0;
    c *= scale;
    const float angle = turn(random);
    const Color h = apply_hue(c, angle), back = apply_hue(h, -angle);
    ASSERT_GE(std::min({h.x, h.y, h.z}), 0);
    if (luma(c) > 0) worst_luma = std::max(worst_luma, std::abs(luma(h) / luma(c) - 1));
    worst_return = std::max<double>(worst_return, (back - c).length() / c.length());
  }
  EXPECT_LT(worst_luma, 1e-6);
  EXPECT_LT(worst_return, 2e-6);
}

TEST(Hue, HomogeneousButNotLinear) {
  const Color a(0.3f, 0.1f, 0.05f), b(0.05f, 0.1f, 0.4f);
  const Color twice = apply_hue(a * 4.0f, 1), four = apply_hue(a, 1) * 4.0f;
  EXPECT_NEAR((twice - four).length(), 0, 1e-7);
  EXPECT_GT((apply_hue(a + b, 1) - apply_hue(a, 1) - apply_hue(b, 1)).length(), 0.01);
}

TEST(Hue, WholeTurnsAndTinyAnglesStayInRange) {
  for (const float angle : {2 * std::numbers::pi_v<float>, -2 * std::numbers::pi_v<float>, 1e-30f, -1e-30f,
                            -1e-8f, 1e6f, -1e6f, 1e30f}) {
    const Color h = apply_hue({1, 0, 0}, angle);
    EXPECT_TRUE(is_finite(h) && h.x >= 0 && h.y >= 0 && h.z >= 0) << angle;
    EXPECT_NEAR(luma(h), 0.2126, 1e-6) << angle;
  }
}

TEST(Hue, GarbageStaysWhereItIs) {
  const float nan = std::nanf("");
  EXPECT_TRUE(std::isnan(apply_hue({nan, 1, 2}, 1).x));
  EXPECT_EQ(apply_hue({infinity, 1, 2}, 1).y, 1);
  EXPECT_TRUE(same_bits(apply_hue({1, 0.5f, 2}, nan), {1, 0.5f, 2}));
  const Color negative = apply_hue({-1, 0.5f, 2}, 1);
  EXPECT_TRUE(is_finite(negative) && negative.x >= 0 && negative.y >= 0 && negative.z >= 0);
  EXPECT_TRUE(is_finite(apply_hue({-1, -0.5f, -2}, 1)));
  EXPECT_TRUE(is_finite(apply_hue({1e-45f, 0, 0}, 1)));
  EXPECT_TRUE(is_finite(apply_hue({1e30f, 0, 1e-30f}, 1)));
}

}  // namespace
}  // namespace sluice
