// SPDX-License-Identifier: GPL-3.0-or-later
// Each lobe shape alone: its sampler against its density (chi², numerics §7 and R8), weights, reciprocity,
// energy (R9).
#include <gtest/gtest.h>

#include "shading/energy.h"
#include "shading_statistics.h"

namespace sluice::test {
namespace {

struct Case {
  std::string name;
  LobeShape shape;
  Cells cells;
};

Reflection reflection(float ax, float ay) {
  return {.alpha = {ax, ay}, .tangent = V3f(1, 0, 0), .fresnel = {}};
}
Fresnel dielectric(float eta) { return {.kind = Fresnel::Kind::Dielectric, .eta = eta}; }

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"Lambert", Lambert{}, {}});
  all.push_back({"Translucent", Translucent{}, {.below = true}});
  all.push_back({"OrenNayar", OrenNayar{0.7f}, {}});
  all.push_back({"Burley", Burley{0.6f}, {}});
  all.push_back({"DisneySheen", DisneySheen{}, {}});
  all.push_back({"Velvet", Velvet{0.5f}, {}});
  all.push_back({"Sheen", Sheen{0.4f}, {}});
  for (const float a : {1e-3f, 1e-2f, 0.1f, 0.4f, 1.0f}) {
    all.push_back({"Reflection " + std::to_string(a), reflection(a, a), {.alpha = {a, a}}});
    Reflection kept = reflection(a, a);
    kept.multiple = Color(1);
    all.push_back({"Reflection, energy kept " + std::to_string(a), kept, {.alpha = {a, a}}});
    for (const float eta : {1.5f, 1 / 1.5f, 1.1f}) {
      const Refraction glass{.alpha = a, .eta = eta, .fresnel = dielectric(eta)};
      all.push_back({"Refraction " + std::to_string(a) + ", eta " + std::to_string(eta),
                     glass,
                     {.alpha = {a, a}, .eta = eta, .below = true}});
    }
  }
  all.push_back({"Reflection, stretched", reflection(0.05f, 0.4f), {.alpha = {0.05f, 0.4f}}});
  return all;
}

double pdf_of(const LobeShape& shape, const V3f& o, const V3f& i) {
  return std::visit([&](const auto& s) { return static_cast<double>(pdf_shape(s, o, i)); }, shape);
}
Color eval_of(const LobeShape& shape, const V3f& o, const V3f& i) {
  return std::visit([&](const auto& s) { return eval_shape(s, o, i); }, shape);
}
bool sample_of(const LobeShape& shape, const V3f& o, const V2f& u, ShapeSample& out) {
  return std::visit([&](const auto& s) { return sample_shape(s, o, u, out); }, shape);
}
Color albedo_of(const LobeShape& shape, float mu) {
  return std::visit([&](const auto& s) { return albedo_shape(s, mu); }, shape);
}

// What sample_shape's weights sum to: the albedo, by an independent way.
Color measured_albedo(const LobeShape& shape, const V3f& o, int samples, std::uint64_t seed) {
  V3d sum(0);
  for (int k = 0; k < samples; ++k) {
    ShapeSample s;
    if (sample_of(shape, o, Sampler(seed, static_cast<std::uint32_t>(k)).pair(0), s)) sum += V3d(s.weight);
  }
  return Color(sum / samples);
}

constexpr double cosines[] = {0.98, 0.7, 0.3, 0.06};

TEST(Lobes, SamplesFollowTheirDensity) {
  const std::vector<Case> all = cases();
  const double runs = static_cast<double>(all.size() * std::size(cosines));
  const double significance = 1 - std::pow(1 - 0.01, 1 / runs);  // Šidák
  constexpr int samples = 200'000;
  std::uint64_t run = 0;
  for (const Case& c : all)
    for (const double mu : cosines) {
      const V3f o = direction(mu);
      Uniform random{++run << 40};
      std::vector<double> counts(c.cells.count() + 1, 0.0);
      for (int k = 0; k < samples; ++k) {
        ShapeSample s;
        ++counts[sample_of(c.shape, o, random.pair(), s) ? c.cells.cell_of(o, s.i) : c.cells.count()];
      }
      std::vector<double> expected =
          c.cells.integrate(o, [&](const V3f& i) { return pdf_of(c.shape, o, i); });
      double sum = 0;
      for (double& p : expected) sum += p, p *= samples;
      // a density integrates to 1 or, where samples fail, to less
      EXPECT_LT(sum, 1 + 2e-3) << c.name << " at " << mu;
      expected.push_back(std::max(0.0, 1 - sum) * samples);
      EXPECT_GT(chi2_p(counts, expected), significance)
          << c.name << " at cosine " << mu << ", failed " << counts.back() / samples << ", missing density "
          << 1 - sum;
    }
}

TEST(Lobes, WeightIsValueOverDensity) {
  Uniform random{99};
  for (const Case& c : cases())
    for (const double mu : cosines)
      for (int k = 0; k < 200; ++k) {
        const V3f o = direction(mu);
        ShapeSample s;
        if (!sample_of(c.shape, o, random.pair(), s)) continue;
        ASSERT_NEAR(s.i.length(), 1, 1e-5) << c.name;
        // A direction read back from float costs 1e-7 / alpha of the half vector.
        const double tolerance = c.cells.alpha.x > 0 ? std::max(1e-3, 2e-5 / c.cells.alpha.x) : 1e-4;
        const double p = pdf_of(c.shape, o, s.i);
        // half vectors of nearly equal indices: 10 times less exact
        if (c.cells.eta == 1.1f && c.cells.alpha.x < 5e-3) continue;
        EXPECT_NEAR(p / s.pdf, 1, tolerance) << c.name << " at " << mu;
        const double value = s.weight.y * s.pdf;
        EXPECT_NEAR(eval_of(c.shape, o, s.i).y, value, tolerance * value) << c.name << " at " << mu;
      }
}

// f(o, i) = f(i, o); across an interface f(i -> o) / η_o² = f(o -> i) / η_i² (Veach 1997, eq. 5.14), which in
// the flux convention (f·eta², eta = η_i / η_o) reads: back·eta² = forward.
TEST(Lobes, AreReciprocal) {
  Uniform random{5};
  for (const Case& c : cases())
    for (int k = 0; k < 300; ++k) {
      const V3f o = direction(0.05 + 0.9 * random.next(), 6.28 * random.next());
      ShapeSample s;
      if (!sample_of(c.shape, o, random.pair(), s) || std::abs(s.i.z) < 0.02f || c.cells.alpha.x == 1e-3f)
        continue;
      const double forward = eval_of(c.shape, o, s.i).y / std::abs(s.i.z);
      double back;
      if (const auto* r = std::get_if<Refraction>(&c.shape)) {
        const Refraction other{.alpha = r->alpha, .eta = 1 / r->eta, .fresnel = dielectric(1 / r->eta)};
        back = eval_shape(other, -s.i, -o).y / o.z * r->eta * r->eta;
      } else if (s.i.z < 0) {
        back = eval_of(c.shape, -s.i, -o).y / o.z;
      } else {
        back = eval_of(c.shape, s.i, o).y / o.z;
      }
      EXPECT_NEAR(back, forward, 1e-30 + forward * (c.cells.alpha.x > 0 ? 2e-4 / c.cells.alpha.x : 1e-4))
          << c.name;
    }
}

TEST(Lobes, TabledAlbedosAreWhatIsScattered) {
  std::uint64_t seed = 0;
  for (const Case& c : cases())
    for (const double mu : cosines) {
      const Color measured = measured_albedo(c.shape, direction(mu), 1 << 14, ++seed),
                  table = albedo_of(c.shape, static_cast<float>(mu));
      // stated in energy.h
      const bool coarse = (c.cells.eta > 0 && c.cells.eta < 1) || c.cells.alpha.x != c.cells.alpha.y;
      EXPECT_NEAR(table.y, measured.y, coarse ? 0.1 : 0.02) << c.name << " at " << mu;
      // Burley's diffuse is known to reflect more than it gets at grazing angles: Cycles' does too.
      EXPECT_LT(measured.y, std::holds_alternative<Burley>(c.shape) ? 1.15 : 1.02) << c.name << " at " << mu;
    }
}

TEST(Lobes, WhiteFurnaceKeepsAllEnergy) {
  for (const float roughness : {0.05f, 0.2f, 0.37f, 0.5f, 0.77f, 1.0f})
    for (const double mu : {1.0, 0.83, 0.5, 0.21, 0.07}) {
      Reflection mirror = reflection(roughness * roughness, roughness * roughness);
      mirror.multiple = Color(1);
      EXPECT_NEAR(measured_albedo(mirror, direction(mu), 1 << 15, 3).y, 1, 0.01)
          << "mirror, roughness " << roughness << ", cosine " << mu;
      for (const float eta : {1.33f, 1.5f, 2.0f, 1 / 1.5f}) {
        const float a = roughness * roughness;
        const Reflection r{.alpha = {a, a}, .tangent = V3f(0), .fresnel = dielectric(eta), .balanced = true};
        const Refraction t{.alpha = a, .eta = eta, .fresnel = dielectric(eta), .balanced = true};
        const float sum =
            measured_albedo(r, direction(mu), 1 << 15, 3).y + measured_albedo(t, direction(mu), 1 << 15, 4).y;
        EXPECT_NEAR(sum, 1, eta > 1 ? 0.02 : 0.06)
            << "glass, roughness " << roughness << ", eta " << eta << ", cosine " << mu;
      }
    }
}

// A coloured metal between its single scattering and white: Kulla & Conty's series, for a constant
// reflectance F: E F + F² E_avg / (1 - F (1 - E_avg)) (1 - E).
TEST(Lobes, ColouredFurnaceFollowsTheSeries) {
  const float a = 0.64f, roughness = 0.8f;
  Reflection metal = reflection(a, a);
  metal.fresnel.f0 = Color(0.9f, 0.5f, 0.1f);
  metal.multiple = multiple_reflectance(metal.fresnel, metal.alpha);
  const float mean = energy::mean_reflecting(roughness);
  for (const double mu : {0.9, 0.4}) {
    const Color measured = measured_albedo(metal, direction(mu), 1 << 15, 8);
    Reflection white = reflection(a, a);
    const float e = measured_albedo(white, direction(mu), 1 << 15, 8).y;
    for (int k = 0; k < 3; ++k) {
      const float f = metal.fresnel.f0[k], expected = f * e + f * f * mean / (1 - f * (1 - mean)) * (1 - e);
      EXPECT_NEAR(measured[k], expected, 0.005);
    }
  }
}

TEST(Lobes, ReflectedAndTransmittedSumToOne) {  // R9
  Uniform random{21};
  for (int k = 0; k < 1'000'000; ++k) {
    const float eta = k % 2 ? 1.5f : 1 / 1.5f;
    const V3f o = direction(std::max(1e-4f, random.next()));
    ShapeSample r, t;
    ASSERT_TRUE(sample_shape(Reflection{.alpha = {0, 0}, .tangent = V3f(0), .fresnel = dielectric(eta)}, o,
                             V2f(0), r));
    const Refraction glass{.alpha = 0, .eta = eta, .fresnel = dielectric(eta)};
    const bool passes = sample_shape(glass, o, V2f(0), t);
    const double sum = static_cast<double>(r.weight.y) + (passes ? t.weight.y : 0);
    ASSERT_NEAR(sum, 1, 1e-6) << "cosine " << o.z << ", eta " << eta;
    if (passes) {  // Snell
      ASSERT_NEAR(std::hypot(t.i.x, t.i.y) * eta, std::hypot(o.x, o.y), 1e-5);
      ASSERT_LT(t.i.z, 0);
    }
  }
}

TEST(Lobes, MirrorAndNarrowestLobeAgree) {  // R8: 0.999e-3 is a mirror, 1.001e-3 is not
  for (const double mu : {0.95, 0.5, 0.2}) {
    const V3f o = direction(mu);
    const Reflection smooth{.alpha = {0.999e-3f, 0.999e-3f}, .tangent = V3f(0), .fresnel = dielectric(1.5f)};
    const Reflection rough{.alpha = {1.001e-3f, 1.001e-3f}, .tangent = V3f(0), .fresnel = dielectric(1.5f)};
    EXPECT_TRUE(is_delta(smooth));
    EXPECT_FALSE(is_delta(rough));
    EXPECT_NEAR(measured_albedo(rough, o, 1 << 12, 1).y / measured_albedo(smooth, o, 1, 1).y, 1, 0.02);
    const Refraction clear{.alpha = 0.999e-3f, .eta = 1.5f, .fresnel = dielectric(1.5f)},
        frosted{.alpha = 1.001e-3f, .eta = 1.5f, .fresnel = dielectric(1.5f)};
    EXPECT_NEAR(measured_albedo(frosted, o, 1 << 12, 1).y / measured_albedo(clear, o, 1, 1).y, 1, 0.02);
  }
}

TEST(Fresnel, KnownValues) {
  EXPECT_NEAR(fresnel_dielectric(1, 1.5f), 0.04, 1e-6);
  EXPECT_NEAR(fresnel_dielectric(1, 1 / 1.5f), 0.04, 1e-6);
  EXPECT_EQ(fresnel_dielectric(0.7f, 1 / 1.5f), 1);  // sin = 0.714 > 1 / 1.5
  const float brewster = std::cos(std::atan(1.5f));  // r_p = 0: half of r_s
  EXPECT_NEAR(fresnel_dielectric(brewster, 1.5f), 0.5 * square((1.5 * 1.5 - 1) / (1.5 * 1.5 + 1)), 1e-6);
  EXPECT_NEAR(f0_of_ior(ior_of_f0(0.3f)), 0.3, 1e-6);
  const Fresnel gold = metal_fresnel(Color(1, 0.7f, 0.3f), Color(1));  // tint 1: plain Schlick
  EXPECT_NEAR(eval_fresnel(gold, 0.5f).y, 0.7 + 0.3 * std::pow(0.5, 5), 1e-6);
  const Fresnel tinted = metal_fresnel(Color(0.5f), Color(0.2f));  // F(1/7) = tint · Schlick(1/7)
  const double schlick = 0.5 + 0.5 * std::pow(6.0 / 7, 5);
  EXPECT_NEAR(eval_fresnel(tinted, 1.0f / 7).x, 0.2 * schlick, 1e-5);
}

}  // namespace
}  // namespace sluice::test
