// SPDX-License-Identifier: GPL-3.0-or-later
// Lists of lobes: choice, mixed densities, sides, η², layers seen from both ends of a path.
#include <gtest/gtest.h>

#include "shading_nodes.h"
#include "shading_statistics.h"

namespace sluice::test {
namespace {

Bsdf start(const V3f& ng = {0, 0, 1}) {
  Bsdf b;
  b.ng = ng;
  return b;
}
Reflection gloss(float alpha) { return {.alpha = {alpha, alpha}, .tangent = V3f(0), .fresnel = {}}; }

Bsdf plastic(const V3f& wo) {
  Bsdf b = start();
  const V3f n(0, 0, 1);
  add_lobe(b, Event::D, Color(0.6f, 0.3f, 0.2f), n, Lambert{}, wo);
  add_lobe(b, Event::G, Color(0.2f), n, gloss(0.2f), wo);
  add_lobe(b, Event::D, Color(0.1f, 0.2f, 0.1f), n, Translucent{}, wo);
  return b;
}

TEST(Bsdf, MixedSamplesFollowTheMixedDensity) {
  const V3f wo = direction(0.6);
  const Bsdf b = plastic(wo);
  for (const EventMask mask : {gathering, mask_of(Event::D), mask_of(Event::G)}) {
    constexpr int samples = 400'000;
    Cells above, below{.below = true};
    std::vector<double> counts(2 * above.count() + 1, 0.0);
    Uniform random{std::uint64_t{mask} << 33};
    for (int k = 0; k < samples; ++k) {
      const float u = random.next();
      const auto s = sample(b, wo, u, random.pair(), mask);
      if (!s)
        ++counts.back();
      else
        ++counts[(s->wi.z > 0 ? 0 : above.count()) + above.cell_of(wo, s->wi)];
      if (s) { ASSERT_NEAR(s->pdf / pdf(b, wo, s->wi, mask), 1, 1e-3); }
    }
    const auto density = [&](const V3f& i) { return static_cast<double>(pdf(b, wo, i, mask)); };
    std::vector<double> expected = above.integrate(wo, density), low = below.integrate(wo, density);
    expected.insert(expected.end(), low.begin(), low.end());
    double sum = 0;
    for (double& p : expected) sum += p, p *= samples;
    expected.push_back(std::max(0.0, 1 - sum) * samples);
    EXPECT_GT(chi2_p(counts, expected), 0.003) << int{mask};
  }
}

// The light of each event is what its lobes alone scatter, whatever else is in the mask.
TEST(Bsdf, WeightsAreUnbiasedForEachEvent) {
  const V3f wo = direction(0.5);
  const Bsdf b = plastic(wo);
  V3d by_event[2] = {V3d(0), V3d(0)}, squares[2] = {V3d(0), V3d(0)};
  constexpr int samples = 200'000;
  Uniform random{1};
  for (int k = 0; k < samples; ++k) {
    const float u = random.next();
    if (const auto s = sample(b, wo, u, random.pair(), gathering)) {
      by_event[s->event == Event::G] += V3d(s->weight);
      squares[s->event == Event::G] += V3d(s->weight) * V3d(s->weight);
    }
  }
  const double diffuse[] = {0.7, 0.5, 0.3};
  for (int c = 0; c < 3; ++c) {
    const double mean = by_event[0][c] / samples,
                 error = std::sqrt((squares[0][c] / samples - mean * mean) / samples);
    EXPECT_NEAR(mean, diffuse[c], 4 * error + 1e-6);
  }
  EXPECT_NEAR(by_event[1].y / samples, albedo(b, wo, mask_of(Event::G)).y, 0.005);
}

TEST(Bsdf, DeltaLobesCarryTheirWeight) {
  const V3f wo = direction(0.4);
  Bsdf b = start();
  const Fresnel fresnel{.kind = Fresnel::Kind::Dielectric, .eta = 1.5f};
  add_lobe(b, Event::S, Color(1), V3f(0, 0, 1),
           Reflection{.alpha = {0, 0}, .tangent = V3f(0), .fresnel = fresnel}, wo);
  add_lobe(b, Event::S, Color(1), V3f(0, 0, 1), Refraction{.alpha = 0, .eta = 1.5f, .fresnel = fresnel}, wo);
  ASSERT_EQ(b.count, 2);
  const float f = fresnel_dielectric(wo.z, 1.5f);
  const auto first = sample(b, wo, 0.5f * f, V2f(0), any_lobe),
             second = sample(b, wo, 0.5f + 0.5f * f, V2f(0), any_lobe);
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(first->delta);
  EXPECT_NEAR(first->weight.y, 1, 1e-5);
  EXPECT_NEAR(first->pdf, f, 1e-6);
  EXPECT_EQ(first->eta, 1);
  EXPECT_NEAR(second->weight.y, 1, 1e-5);
  EXPECT_EQ(second->eta, 1.5f);
  EXPECT_LT(second->wi.z, 0);
  EXPECT_TRUE(is_black(eval(b, wo, second->wi, any_lobe)));
  EXPECT_EQ(pdf(b, wo, second->wi, any_lobe), 0);
  const auto alone = sample_lobe(b, 1, wo, V2f(0));
  EXPECT_NEAR(alone->weight.y, 1 - f, 1e-6);
  EXPECT_FALSE(sample(b, wo, 0.5f, V2f(0), gathering));
}

// Through rough glass: eval is radiance, f(wi -> wo) / η_o² = f(wo -> wi) / η_i²; weights are flux, 1 / eta²
// apart.
TEST(Bsdf, RadianceScalesAtRefraction) {
  const float eta = 1.5f;
  const auto glass = [](float index, const V3f& ng, const V3f& wo) {
    Bsdf b = start(ng);
    add_lobe(
        b, Event::G, Color(1), ng,
        Refraction{.alpha = 0.2f, .eta = index, .fresnel = {.kind = Fresnel::Kind::Dielectric, .eta = index}},
        wo);
    return b;
  };
  Uniform random{3};
  for (int k = 0; k < 1000; ++k) {
    const V3f wo = direction(0.3 + 0.65 * random.next());
    const Bsdf out = glass(eta, V3f(0, 0, 1), wo);
    const auto s = sample(out, wo, 0, random.pair(), gathering);
    if (!s || s->wi.z > -0.05f) continue;
    EXPECT_NEAR(s->weight.y * s->pdf / (eval(out, wo, s->wi, gathering).y * eta * eta), 1, 1e-3);
    const Bsdf in = glass(1 / eta, V3f(0, 0, -1), s->wi);
    const float there = eval(out, wo, s->wi, gathering).y / -s->wi.z,
                back = eval(in, s->wi, wo, gathering).y / wo.z;
    EXPECT_NEAR(there * eta * eta / back, 1, 2e-3);
  }
}

TEST(Bsdf, TheTrueSurfaceDecidesTheSide) {
  // a bent normal: directions with wi·n > 0 exist below the surface
  const V3f wo = direction(0.5, 0), n = V3f(0.6f, 0, 0.8f);
  Bsdf b = start();
  add_lobe(b, Event::D, Color(1), n, Lambert{}, wo);
  const V3f below = V3f(0.95f, 0, -0.1f).normalized();
  ASSERT_GT(below.dot(n), 0);
  EXPECT_TRUE(is_black(eval(b, wo, below, gathering)));
  EXPECT_EQ(pdf(b, wo, below, gathering), 0);
  Uniform random{4};
  for (int k = 0; k < 2000; ++k) {
    const auto s = sample(b, wo, 0, random.pair(), gathering);
    EXPECT_TRUE(!s || s->wi.z >= 0);
  }
  const V3f wi = direction(0.7, 2);
  EXPECT_NEAR(adjoint_factor(b, 0, wo, wi), std::abs(wo.dot(n) * wi.z / (wo.z * wi.dot(n))), 1e-5);
}

TEST(Bsdf, LobeListIsBounded) {
  Bsdf b = start();
  for (int k = 0; k < 20; ++k)
    add_lobe(b, Event::D, Color(0.01f * static_cast<float>(k)), V3f(0, 0, 1), Lambert{}, V3f(0, 0, 1));
  EXPECT_EQ(b.count, max_lobes);
  // the strongest stay
  for (int k = 0; k < b.count; ++k) EXPECT_GE(b.lobes[static_cast<std::size_t>(k)].weight.x, 0.115f);
}

// Blender 4's plastic loses what its surface reflects towards the eye. A photon does not know the eye yet:
// its weight must be the one with which the eye path through the same two directions would count.
TEST(Bsdf, CoatingsAreReadOnTheEyesSide) {
  Tree tree;
  const int n = tree.add("BsdfPrincipled", {{"distribution", "GGX"}});
  tree.set(n, "Base Color", V3f(0.7f))
      .set(n, "Roughness", 0.4f)
      .set(n, "IOR", 1.8f)
      .set(n, "Coat Weight", 0.8f)
      .set(n, "Coat Tint", V3f(0.9f, 0.5f, 0.4f))
      .set(n, "Coat IOR", 1.5f);
  for (const char* name : {"Metallic", "Transmission Weight", "Emission Strength", "Anisotropic",
                           "Anisotropic Rotation", "Sheen Weight", "Sheen Roughness", "Subsurface Weight"})
    tree.set(n, name, 0);
  tree.set(n, "Alpha", 1)
      .set(n, "Coat Roughness", 0.3f)
      .set(n, "Specular IOR Level", 0.5f)
      .set(n, "Specular Tint", V3f(1))
      .set(n, "Sheen Tint", V3f(1))
      .set(n, "Emission Color", V3f(1));
  const Material material = tree.compile(n);
  EXPECT_TRUE(tree.warnings.empty());
  const auto only_diffuse = [](const Bsdf& b, const V3f& wo, const V3f& wi) {
    return eval(b, wo, wi, mask_of(Event::D));
  };
  for (const double mu : {0.9, 0.4}) {
    SurfacePoint eye, light;
    eye.wo = direction(mu, 0);
    light.wo = direction(0.6, 2);
    light.photon = true;
    // f(light -> eye)
    const Color forward = only_diffuse(shaded(material, eye), eye.wo, light.wo) / light.wo.z;
    const Color photon = only_diffuse(shaded(material, light), light.wo, eye.wo) / eye.wo.z;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(photon[c] / forward[c], 1, 1e-4);
    EXPECT_LT(forward.y, 0.7f / pi);
    Uniform random{8};
    const Bsdf b = shaded(material, light);
    for (int k = 0; k < 200; ++k) {
      const float u = random.next();
      const auto s = sample(b, light.wo, u, random.pair(), mask_of(Event::D));
      EXPECT_TRUE(!s ||
                  std::abs(s->weight.y * s->pdf / eval(b, light.wo, s->wi, mask_of(Event::D)).y - 1) < 1e-3);
    }
  }
}

}  // namespace
}  // namespace sluice::test
