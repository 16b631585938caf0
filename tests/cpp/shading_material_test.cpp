// SPDX-License-Identifier: GPL-3.0-or-later
// From node trees to lobes: classes, weights, both Principleds, what cannot be drawn, and that nothing ever
// throws or goes black.
#include <gtest/gtest.h>

#include "shading_nodes.h"
#include "shading_statistics.h"

namespace sluice::test {
namespace {

int diffuse(Tree& tree, const V3f& color) {
  const int node = tree.add("BsdfDiffuse");
  tree.set(node, "Color", color).set(node, "Roughness", 0);
  return node;
}
int glass(Tree& tree, float roughness, const std::string& distribution = "GGX") {
  const int node = tree.add("BsdfGlass", {{"distribution", distribution}});
  tree.set(node, "Color", V3f(0.9f)).set(node, "Roughness", roughness).set(node, "IOR", 1.5f);
  return node;
}
int mix(Tree& tree, float factor, int a, int b) {
  const int node = tree.add("MixShader");
  tree.set(node, "Fac", factor).link(node, "Shader", a).link(node, "Shader_001", b);
  return node;
}
int principled_v1(Tree& tree, std::map<std::string, float> values = {}) {
  const int node = tree.add("BsdfPrincipledV1", {{"distribution", "GGX"}});
  for (const char* name : {"Subsurface", "Metallic", "Specular Tint", "Anisotropic", "Anisotropic Rotation",
                           "Sheen", "Sheen Tint", "Clearcoat", "Clearcoat Roughness", "Transmission",
                           "Transmission Roughness", "Emission Strength"})
    values.emplace(name, 0.0f);
  values.emplace("Specular", 0.5f), values.emplace("Roughness", 0.5f), values.emplace("IOR", 1.45f),
      values.emplace("Alpha", 1.0f);
  for (const auto& [name, value] : values) tree.set(node, name, value);
  tree.set(node, "Base Color", V3f(0.8f, 0.4f, 0.2f))
      .set(node, "Subsurface Color", V3f(0.8f))
      .set(node, "Emission", V3f(0));
  return node;
}

TEST(Material, MixWeightsFoldIntoLobes) {
  Tree tree;
  const Material material = tree.compile(
      mix(tree, 0.25f, diffuse(tree, V3f(0.8f)), mix(tree, 0.5f, diffuse(tree, V3f(0.4f)), glass(tree, 0))));
  const Bsdf b = shaded(material);
  ASSERT_EQ(b.count, 4);
  EXPECT_NEAR(b.lobes[0].weight.x, 0.75 * 0.8, 1e-6);
  EXPECT_NEAR(b.lobes[1].weight.x, 0.125 * 0.4, 1e-6);
  EXPECT_NEAR(b.lobes[2].weight.x, 0.125 * 0.9, 1e-6);
  EXPECT_EQ(b.lobes[2].event, Event::S);
  EXPECT_TRUE(b.lobes[2].delta && b.lobes[3].delta);
  EXPECT_EQ(material.lobe_events(), mask_of(Event::D) | mask_of(Event::S));
  EXPECT_TRUE(material.transmits() && material.is_opaque() && !material.emits());
  EXPECT_TRUE(tree.warnings.empty());
}

TEST(Material, RoughnessDecidesTheEvent) {
  for (const auto& [roughness, event, delta] : {std::tuple{0.0f, Event::S, true},
                                                {0.03f, Event::S, true},
                                                {0.05f, Event::S, false},
                                                {0.1f, Event::S, false},
                                                {0.11f, Event::G, false}}) {
    Tree tree;
    const Bsdf b = shaded(tree.compile(glass(tree, roughness), {}, 0.1f));
    ASSERT_EQ(b.count, 2);
    for (int k = 0; k < 2; ++k) {
      EXPECT_EQ(b.lobes[static_cast<std::size_t>(k)].event, event) << roughness;
      EXPECT_EQ(b.lobes[static_cast<std::size_t>(k)].delta, delta) << roughness;
    }
  }
}

// Rough glass of index 1 bends nothing: one direction, which no gather segment can sample by its solid angle.
TEST(Material, WhatBendsNothingIsFollowed) {
  for (const float ior : {1.0f, 1.0005f, 1.5f}) {
    Tree tree;
    const int rough = glass(tree, 0.5f), refraction = tree.add("BsdfRefraction", {{"distribution", "GGX"}}),
              v2 = tree.add("BsdfPrincipled", {{"distribution", "GGX"}});
    tree.at(rough).inputs.back().value = {ior, ior, ior, ior};
    tree.set(refraction, "Color", V3f(0.9f)).set(refraction, "Roughness", 0.5f).set(refraction, "IOR", ior);
    for (const char* name : {"Metallic", "Emission Strength", "Anisotropic", "Anisotropic Rotation",
                             "Sheen Weight", "Sheen Roughness", "Subsurface Weight", "Coat Weight"})
      tree.set(v2, name, 0);
    tree.set(v2, "Base Color", V3f(1))
        .set(v2, "Roughness", 0.5f)
        .set(v2, "IOR", ior)
        .set(v2, "Alpha", 1)
        .set(v2, "Transmission Weight", 1)
        .set(v2, "Coat Roughness", 0.03f);
    tree.set(v2, "Coat IOR", 1.5f)
        .set(v2, "Coat Tint", V3f(1))
        .set(v2, "Specular IOR Level", 0.5f)
        .set(v2, "Specular Tint", V3f(1))
        .set(v2, "Sheen Tint", V3f(1))
        .set(v2, "Emission Color", V3f(1));
    for (const int surface :
         {rough, refraction, v2, principled_v1(tree, {{"Transmission", 1.0f}, {"IOR", ior}})}) {
      const Material material = tree.compile(surface);
      const Bsdf b = shaded(material);
      ASSERT_GT(b.count, 0);
      EventMask seen = 0;
      for (int k = 0; k < b.count; ++k) {
        const Lobe& lobe = b.lobes[static_cast<std::size_t>(k)];
        EXPECT_EQ(lobe.event, lobe.delta ? Event::S : Event::G) << tree.at(surface).kind << ' ' << ior;
        seen |= mask_of(lobe.event);
      }
      EXPECT_EQ((seen & followed) != 0, ior < 1.4f);
      EXPECT_EQ(seen & ~material.lobe_events(), 0) << tree.at(surface).kind << ' ' << ior;
      EXPECT_EQ(material.has_lobes(followed), ior < 1.4f);
    }
  }
}

TEST(Material, GlassKnowsItsSides) {
  Tree tree;
  const Material material = tree.compile(glass(tree, 0));
  SurfacePoint inside;
  inside.front = false;
  const auto out = sample_lobe(shaded(material), 1, V3f(0, 0, 1), V2f(0)),
             in = sample_lobe(shaded(material, inside), 1, V3f(0, 0, 1), V2f(0));
  ASSERT_TRUE(out && in);
  EXPECT_FLOAT_EQ(out->eta, 1.5f);
  EXPECT_FLOAT_EQ(in->eta, 1 / 1.5f);
}

TEST(Material, TransparencyIsNoLobe) {
  Tree tree;
  const int leaf = tree.add("BsdfTransparent");
  tree.set(leaf, "Color", V3f(1, 0.5f, 0.25f));
  const Material material = tree.compile(mix(tree, 0.25f, leaf, diffuse(tree, V3f(0.8f))));
  const Bsdf b = shaded(material);
  EXPECT_EQ(b.count, 1);
  EXPECT_NEAR(b.transparency.y, 0.375, 1e-6);
  EXPECT_EQ(eval_transparency(material, {}), b.transparency);
  EXPECT_FALSE(material.is_opaque());
}

TEST(Material, EmissionAddsUp) {
  Tree tree;
  const int a = tree.add("Emission"), b = tree.add("Emission"), both = tree.add("AddShader");
  tree.set(a, "Color", V3f(1, 0, 0))
      .set(a, "Strength", 3)
      .set(b, "Color", V3f(0, 0.5f, 0))
      .set(b, "Strength", 4)
      .link(both, "Shader", a)
      .link(both, "Shader_001", b);
  const Material material = tree.compile(both);
  EXPECT_EQ(shaded(material).emission, Color(3, 2, 0));
  EXPECT_EQ(material.average_emission(), Color(3, 2, 0));
  EXPECT_TRUE(material.emits() && material.emission_is_constant());
  EXPECT_EQ(material.lobe_events(), 0);
  EXPECT_EQ(eval_background(material, V3f(0, 1, 0), true), Color(3, 2, 0));
}

TEST(Material, PrincipledOfBlender3) {
  Tree tree;
  const Material plain = tree.compile(principled_v1(tree));
  EXPECT_TRUE(tree.warnings.empty()) << tree.warnings.front().message;
  EXPECT_EQ(plain.lobe_events(), mask_of(Event::D) | mask_of(Event::G));
  const Bsdf b = shaded(plain);
  ASSERT_EQ(b.count, 2);  // Burley, and a dielectric of index 1.5 (specular 0.5: 4 %)
  EXPECT_TRUE(std::holds_alternative<Burley>(b.lobes[0].shape));
  const auto& shine = std::get<Reflection>(b.lobes[1].shape);
  EXPECT_NEAR(shine.fresnel.f0.x, 0.04, 1e-6);
  EXPECT_NEAR(shine.fresnel.eta, 1.5, 1e-3);
  EXPECT_NEAR(shine.alpha.x, 0.25, 1e-6);

  Tree metals;
  const Bsdf metal = shaded(metals.compile(principled_v1(metals, {{"Metallic", 1.0f}, {"Roughness", 0.0f}})));
  ASSERT_EQ(metal.count, 1);
  EXPECT_EQ(metal.lobes[0].event, Event::S);
  EXPECT_NEAR(albedo(metal, V3f(0, 0, 1), any_lobe).y, 0.4, 1e-5);  // the base colour at normal incidence

  Tree clear;
  const Material glassy =
      clear.compile(principled_v1(clear, {{"Transmission", 1.0f}, {"Roughness", 0.0f}, {"Alpha", 0.5f}}));
  const Bsdf g = shaded(glassy);
  ASSERT_EQ(g.count, 2);
  EXPECT_NEAR(albedo(g, V3f(0, 0, 1), any_lobe).x, 0.5 * (f0_of_ior(1.45f) + 0.8 * (1 - f0_of_ior(1.45f))),
              1e-5);
  EXPECT_NEAR(g.transparency.x, 0.5, 1e-6);
  EXPECT_EQ(glassy.lobe_events(), mask_of(Event::S));
}

// White in, white out: diffuse under a dielectric coat, Blender 4's layering. Nothing is gained; little is
// lost.
TEST(Material, PrincipledOfBlender4InTheFurnace) {
  for (const float roughness : {0.0f, 0.3f, 0.8f}) {
    Tree tree;
    const int n = tree.add("BsdfPrincipled", {{"distribution", "MULTI_GGX"}});
    for (const char* name :
         {"Metallic", "Transmission Weight", "Emission Strength", "Anisotropic", "Anisotropic Rotation",
          "Sheen Weight", "Sheen Roughness", "Subsurface Weight", "Coat Weight"})
      tree.set(n, name, 0);
    tree.set(n, "Base Color", V3f(1))
        .set(n, "Roughness", roughness)
        .set(n, "IOR", 1.5f)
        .set(n, "Alpha", 1)
        .set(n, "Coat Roughness", 0.03f)
        .set(n, "Coat IOR", 1.5f)
        .set(n, "Coat Tint", V3f(1));
    tree.set(n, "Specular IOR Level", 0.5f)
        .set(n, "Specular Tint", V3f(1))
        .set(n, "Sheen Tint", V3f(1))
        .set(n, "Emission Color", V3f(1));
    const Material material = tree.compile(n);
    for (const double mu : {1.0, 0.6, 0.2}) {
      SurfacePoint point;
      point.wo = direction(mu);
      const Bsdf b = shaded(material, point);
      V3d sum(0);
      for (std::uint32_t k = 0; k < 16384; ++k) {
        const Sampler sampler(1, k);
        if (const auto s = sample(b, point.wo, sampler.pair(0).x, sampler.pair(1), any_lobe))
          sum += V3d(s->weight);
      }
      EXPECT_NEAR(sum.y / 16384, 1, 0.01) << roughness << " at " << mu;
    }
  }
}

TEST(Material, UnknownNodesAreNeutralAndNamed) {
  Tree tree;
  const int hair = tree.add("BsdfHair"), voronoi = tree.add("TexVoronoi"), lambert = tree.add("BsdfDiffuse");
  tree.link(lambert, "Color", voronoi, "Color").set(lambert, "Roughness", 0);
  const Bsdf b = shaded(tree.compile(mix(tree, 0.5f, hair, lambert)));
  ASSERT_EQ(b.count, 2);
  EXPECT_NEAR(b.lobes[0].weight.x, 0.25, 1e-6);
  EXPECT_NEAR(b.lobes[1].weight.x, 0.25, 1e-6);
  ASSERT_EQ(tree.warnings.size(), 2u);
  EXPECT_EQ(tree.warnings[0].item, "Test");
  EXPECT_NE(tree.warnings[0].message.find("BsdfHair"), std::string::npos);
  EXPECT_NE(tree.warnings[1].message.find("TexVoronoi"), std::string::npos);
}

TEST(Material, LoopsAndBrokenLinksWarn) {
  Tree tree;
  const int a = tree.add("Math", {{"operation", "ADD"}}), b = tree.add("Math", {{"operation", "ADD"}}),
            lambert = tree.add("BsdfDiffuse"), shader = tree.add("MixShader");
  tree.link(a, "Value", b, "Value")
      .set(a, "Value_001", 0)
      .link(b, "Value", a, "Value")
      .set(b, "Value_001", 0);
  tree.link(lambert, "Color", a, "Value").link(lambert, "Roughness", 99, "Value");
  tree.set(shader, "Fac", 0.5f).link(shader, "Shader", shader).link(shader, "Shader_001", lambert);
  const Bsdf shade_result = shaded(tree.compile(shader));
  EXPECT_EQ(shade_result.count, 1);
  EXPECT_TRUE(is_finite(shade_result.lobes[0].weight));
  EXPECT_GE(tree.warnings.size(), 3u);
}

TEST(Material, EmptyAndAbsurdTrees) {
  Tree empty;
  EXPECT_EQ(shaded(empty.compile(-1)).count, 0);  // unlinked output: black, as in Blender
  EXPECT_EQ(shaded(Material()).count, 0);
  Tree missing;
  const int node = missing.add("BsdfDiffuse");  // no inputs at all
  EXPECT_NEAR(shaded(missing.compile(node)).lobes[0].weight.x, 0.8, 1e-6);
  EXPECT_EQ(missing.warnings.size(), 2u);
  Tree deep;
  int last = deep.add("Value");
  deep.set(last, "Value", 1);
  for (int k = 0; k < 1000; ++k) {
    const int next = deep.add("Gamma");
    deep.link(next, "Color", last).set(next, "Gamma", 1);
    last = next;
  }
  const int lambert = deep.add("BsdfDiffuse");
  deep.link(lambert, "Color", last).set(lambert, "Roughness", 0);
  EXPECT_EQ(shaded(deep.compile(lambert)).count, 1);
  EXPECT_EQ(deep.warnings.size(), 1u);
  Tree wide;  // 2^60 ways through shared mixes
  int shader = diffuse(wide, V3f(0.5f));
  for (int k = 0; k < 60; ++k) shader = mix(wide, 0.5f, shader, shader);
  EXPECT_GE(shaded(wide.compile(shader)).count, 1);
}

TEST(Material, BadNumbersNeverLeave) {  // R5
  for (const float bad : {std::nanf(""), infinity, -infinity, 1e38f, -1.0f}) {
    for (const char* kind :
         {"BsdfDiffuse", "BsdfGlossy", "BsdfGlass", "BsdfPrincipledV1", "Emission", "BsdfTransparent"}) {
      for (const bool textured : {false, true}) {
        Tree tree;
        const int node = kind == std::string("BsdfPrincipledV1") ? principled_v1(tree) : tree.add(kind);
        const int value = tree.add("Math", {{"operation", "MULTIPLY_ADD"}}), facts = tree.add("NewGeometry");
        tree.link(value, "Value", facts, "Backfacing")
            .set(value, "Value_001", 1)
            .set(value, "Value_002", bad);
        for (const char* input : {"Color", "Roughness", "IOR", "Strength"})
          if (kind != std::string("BsdfPrincipledV1"))
            textured ? tree.link(node, input, value, "Value") : tree.set(node, input, bad);
        if (kind == std::string("BsdfPrincipledV1"))
          for (auto& input : tree.at(node).inputs)
            textured ? void(input = {input.name, {}, value, "Value"}) : input.value.fill(bad);
        const Bsdf b = shaded(tree.compile(node));
        EXPECT_TRUE(is_finite(b.emission) && is_finite(b.transparency));
        for (int k = 0; k < b.count; ++k) {
          const Lobe& lobe = b.lobes[static_cast<std::size_t>(k)];
          EXPECT_TRUE(is_finite(lobe.weight) && is_finite(lobe.albedo)) << kind << bad;
          for (int s = 0; s < 16; ++s) {
            const auto sampled =
                sample_lobe(b, k, V3f(0, 0, 1), Sampler(1, static_cast<std::uint32_t>(s)).pair(0));
            EXPECT_TRUE(!sampled || (is_finite(sampled->wi) && is_finite(sampled->weight))) << kind << bad;
          }
        }
      }
    }
  }
}

TEST(Material, NormalsAreBentBackAboveTheSurface) {
  Tree tree;
  const int node = tree.add("BsdfGlossy", {{"distribution", "GGX"}}), normal = tree.add("CombineXYZ");
  tree.set(node, "Color", V3f(1))
      .set(node, "Roughness", 0)
      .link(node, "Normal", normal, "Vector")
      .set(normal, "X", -1)
      .set(normal, "Y", 0)
      .set(normal, "Z", 0.2f);
  const Material material = tree.compile(node);
  for (const double mu : {0.9, 0.5, 0.1, 0.01}) {
    SurfacePoint point;
    point.wo = direction(mu, 0);
    const Bsdf b = shaded(material, point);
    ASSERT_EQ(b.count, 1);
    const auto s = sample_lobe(b, 0, point.wo, V2f(0.5f));
    ASSERT_TRUE(s) << mu;
    EXPECT_GT(s->wi.z, 0);
  }
}

TEST(Material, FoldedAndComputedProgramsAgree) {
  Tree folded, computed;
  const int a = principled_v1(folded, {{"Clearcoat", 1.0f}, {"Sheen", 0.4f}, {"Transmission", 0.3f}}),
            b = principled_v1(computed, {{"Clearcoat", 1.0f}, {"Sheen", 0.4f}, {"Transmission", 0.3f}});
  // 0.5 that the compiler cannot know
  const int value = computed.add("Math", {{"operation", "ADD"}}), facts = computed.add("NewGeometry");
  computed.link(value, "Value", facts, "Backfacing").set(value, "Value_001", 0.5f);
  for (auto& input : computed.at(b).inputs)
    if (input.name == "Roughness") input = {"Roughness", {}, value, "Value"};
  const Material one = folded.compile(a), two = computed.compile(b);
  for (const double mu : {1.0, 0.3}) {
    SurfacePoint point;
    point.wo = direction(mu);
    const Bsdf x = shaded(one, point), y = shaded(two, point);
    ASSERT_EQ(x.count, y.count);
    for (int k = 0; k < x.count; ++k)
      EXPECT_EQ(x.lobes[static_cast<std::size_t>(k)].albedo, y.lobes[static_cast<std::size_t>(k)].albedo);
    EXPECT_EQ(eval(x, point.wo, direction(0.6, 3), gathering),
              eval(y, point.wo, direction(0.6, 3), gathering));
  }
}

}  // namespace
}  // namespace sluice::test
