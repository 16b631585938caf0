// SPDX-License-Identifier: GPL-3.0-or-later
// Image lookups: filtering, what lies outside, projections, alpha, missing files.
#include <gtest/gtest.h>

#include "shading/texture.h"
#include "shading_nodes.h"

namespace sluice::test {
namespace {

// 2 x 2: bottom row red, green; top row blue, white with alpha 0.5.
Image corners() {
  return make_image("corners", 2, 2, {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 0.5f}, ColorSpace::Linear);
}

TEST(Texture, FiltersAndRows) {
  const Image image = corners();
  Texture t{.image = &image, .interpolation = Interpolation::Closest};
  EXPECT_EQ(sample_texture(t, 0.25f, 0.25f).color, Color(1, 0, 0));
  EXPECT_EQ(sample_texture(t, 0.75f, 0.25f).color, Color(0, 1, 0));
  EXPECT_EQ(sample_texture(t, 0.25f, 0.75f).color, Color(0, 0, 1));  // row 0 is v = 0
  t.interpolation = Interpolation::Linear;
  EXPECT_EQ(sample_texture(t, 0.25f, 0.25f).color, Color(1, 0, 0));  // texel centres are exact
  const Texel middle = sample_texture(t, 0.5f, 0.5f);
  EXPECT_EQ(middle.color, Color(0.5f, 0.5f, 0.5f));
  EXPECT_FLOAT_EQ(middle.alpha, 0.875f);
}

TEST(Texture, OutsideFollowsTheExtension) {
  const Image image = corners();
  const auto at = [&](Extension e, float u, float v) {
    return sample_texture({.image = &image, .interpolation = Interpolation::Closest, .extension = e}, u, v);
  };
  EXPECT_EQ(at(Extension::Repeat, 1.25f, -0.75f).color, Color(1, 0, 0));
  EXPECT_EQ(at(Extension::Extend, 7, -3).color, Color(0, 1, 0));
  EXPECT_EQ(at(Extension::Mirror, 1.25f, 0.25f).color, Color(0, 1, 0));
  EXPECT_EQ(at(Extension::Mirror, -0.25f, 0.25f).color, Color(1, 0, 0));
  EXPECT_EQ(at(Extension::Clip, 1.01f, 0.25f).alpha, 0);
  EXPECT_EQ(at(Extension::Clip, 0.99f, 0.25f).color, Color(0, 1, 0));
  for (const float bad : {infinity, -infinity, std::nanf(""), 3e38f, -3e38f})
    for (const auto e : {Extension::Repeat, Extension::Extend, Extension::Clip, Extension::Mirror})
      for (const auto i : {Interpolation::Closest, Interpolation::Linear})
        EXPECT_TRUE(is_finite(
            sample_texture({.image = &image, .interpolation = i, .extension = e}, bad, 0.3f).color));
  const Texture linear{.image = &image};
  EXPECT_EQ(sample_texture(linear, 0, 0.25f).color, Color(0.5f, 0.5f, 0));  // repeats across the seam
}

TEST(Texture, Projections) {
  const auto equirectangular = [](const V3f& v) { return project(Projection::Equirectangular, v); };
  EXPECT_NEAR(equirectangular({1, 0, 0}).x, 0.5, 1e-6);
  EXPECT_NEAR(equirectangular({0, -1, 0}).x, 0.75, 1e-6);
  EXPECT_NEAR(equirectangular({0, 1, 0}).x, 0.25, 1e-6);
  EXPECT_NEAR(equirectangular({0, 0, 5}).y, 1, 1e-6);
  EXPECT_NEAR(equirectangular({0, 0, -5}).y, 0, 1e-6);
  // towards the camera that took it: the middle
  const V2f ball = project(Projection::MirrorBall, {0, -1, 0});
  EXPECT_NEAR(ball.x, 0.5, 1e-6);
  EXPECT_NEAR(ball.y, 0.5, 1e-6);
  for (const auto p :
       {Projection::Equirectangular, Projection::MirrorBall, Projection::Sphere, Projection::Tube})
    EXPECT_TRUE(std::isfinite(project(p, V3f(0)).x));
}

TEST(Texture, BoxTakesTheSideThatFacesTheNormal) {
  const Image image = corners();
  Texture t{.image = &image, .interpolation = Interpolation::Closest, .projection = Projection::Box};
  EXPECT_EQ(sample_box(t, {0.9f, 0.25f, 0.75f}, {1, 0, 0}).color, Color(0, 0, 1));   // (y, z)
  EXPECT_EQ(sample_box(t, {0.75f, 0.9f, 0.25f}, {0, -1, 0}).color, Color(0, 1, 0));  // (x, z)
  EXPECT_EQ(sample_box(t, {0.75f, 0.25f, 0.9f}, {0, 0, -1}).color, Color(0, 0, 1));  // (y, x)
  t.blend = 0.5f;
  const V3f n = V3f(1, 0.7f, 0.5f).normalized();
  EXPECT_NEAR(sample_box(t, {0.25f, 0.25f, 0.25f}, n).alpha, 1, 1e-5);  // weights sum to 1
}

TEST(Texture, AlphaIsStraightOnlyWhenItIsRead) {
  const Image images[] = {make_image("half", 1, 1, {0.8f, 0.4f, 0.2f, 0.5f}, ColorSpace::Linear)};
  Tree alone;
  const int image = alone.add("TexImage", {{"extension", "REPEAT"}});
  alone.at(image).image = 0;
  EXPECT_EQ(alone.value(image, "Color", {}, images), Color(0.4f, 0.2f, 0.1f));
  Tree both;
  const int again = both.add("TexImage"), mixed = both.add("MixRGB", {{"blend_type", "MIX"}});
  both.at(again).image = 0;
  both.link(mixed, "Fac", again, "Alpha").link(mixed, "Color2", again, "Color").set(mixed, "Color1", V3f(0));
  EXPECT_EQ(both.value(mixed, "Color", {}, images), Color(0.4f, 0.2f, 0.1f));
}

TEST(Texture, MissingImagesAreMagentaAndSaid) {
  Tree tree;
  const int image = tree.add("TexImage");
  tree.at(image).image = 7;
  EXPECT_EQ(tree.value(image, "Color"), Color(1, 0, 1));
  ASSERT_EQ(tree.warnings.size(), 1u);
  EXPECT_NE(tree.warnings[0].message.find("magenta"), std::string::npos);
}

TEST(Texture, WorldsLookAlongTheDirection) {
  const Image images[] = {corners()};
  Tree tree;
  const int image = tree.add("TexEnvironment", {{"interpolation", "Closest"}}),
            background = tree.add("Background");
  tree.at(image).image = 0;
  tree.link(background, "Color", image, "Color").set(background, "Strength", 2);
  const Material world = tree.compile(background, images);
  EXPECT_EQ(eval_background(world, V3f(0, -1, -0.1f).normalized(), true), Color(0, 2, 0));  // u = 0.75, below
  EXPECT_EQ(eval_background(world, V3f(0, 1, 0.1f).normalized(), true), Color(0, 0, 2));
  EXPECT_FALSE(world.emission_is_constant());
}

}  // namespace
}  // namespace sluice::test
