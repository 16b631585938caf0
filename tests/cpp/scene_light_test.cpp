// SPDX-License-Identifier: GPL-3.0-or-later
// Lights: closed forms of irradiance, densities that integrate to 1, light that leaves = light that arrives,
// total flux in watts.
#include "scene_fixtures.h"

namespace sluice::test {
namespace {

LightDescription lamp(LightKind kind, const M44d& matrix) {
  LightDescription light;
  light.names = {"Lamp"};
  light.kind = kind;
  light.matrix = matrix;
  light.power = 10;
  return light;
}

struct Case {
  std::string name;
  SceneDescription description;
};

LightDescription area(AreaShape shape, float spread) {
  LightDescription light = lamp(LightKind::Area, rotation(0.4, 0.2, 0) * translation({0.3, 0.2, 1}));
  light.shape = shape, light.size_x = 0.8f, light.size_y = 0.3f, light.spread = spread;
  return light;
}

// One light each, of every kind and shape, above the origin. No surfaces but the emissive ones.
std::vector<Case> finite_lights() {
  std::vector<Case> cases;
  const auto add_light = [&](const std::string& name, const LightDescription& light) {
    cases.push_back({name, {}});
    cases.back().description.lights.push_back(light);
  };
  const M44d above = rotation(0.4, 0.2, 0) * translation({0.3, 0.2, 1});
  for (const float radius : {0.0f, 0.1f, 0.6f}) {
    LightDescription light = lamp(LightKind::Point, above);
    light.radius = radius;
    add_light("point " + std::to_string(radius), light);
    light.kind = LightKind::Spot, light.spot_angle = 1.2f, light.spot_blend = 0.3f;
    add_light("spot " + std::to_string(radius), light);
    light.spot_angle = 3, light.spot_blend = 1;
    add_light("wide spot " + std::to_string(radius), light);
    light.spot_angle = 4, light.spot_cosine = false;
    add_light("spot without cosine " + std::to_string(radius), light);
  }
  for (const AreaShape shape : {AreaShape::Square, AreaShape::Rectangle, AreaShape::Disk, AreaShape::Ellipse})
    for (const float spread : {pi, 1.2f, 0.2f})
      add_light("area " + std::to_string(static_cast<int>(shape)) + " spread " + std::to_string(spread),
                area(shape, spread));
  const auto add_mesh = [&](const std::string& name, const MeshDescription& mesh, const V3d& scale) {
    Case one{name, {}};
    place(one.description, add(one.description, mesh), scaling(scale) * above,
          add(one.description, glowing({1, 0.5f, 0.25f}, 5)));
    cases.push_back(std::move(one));
  };
  MeshDescription bowl = sphere(10);
  bowl.triangles.resize(bowl.triangles.size() / 2);
  add_mesh("emissive plane", grid(3), {0.4, 0.2, 1});
  add_mesh("emissive ball", sphere(10), {0.3, 0.2, 0.4});
  add_mesh("emissive ball, mirrored", sphere(10), {-0.3, 0.2, 0.4});
  add_mesh("emissive bowl", bowl, {0.3, 0.2, 0.4});
  return cases;
}

// Radiance arriving at `from` along wi, by whatever the ray meets there: no sampling involved.
struct Seen {
  Color radiance{0};
  float pdf = 0;
};
Seen look(const Scene& scene, const V3d& from, const V3f& wi) {
  Seen seen;
  LampHit found[4];
  for (int i = 0; i < intersect_lamps(scene, {from, wi}, found); ++i)
    seen.radiance += found[i].radiance, seen.pdf += pdf_direct(scene, found[i].light, from, wi, nullptr);
  if (const auto hit = scene.intersect({from, wi}); hit && scene.material(*hit).emits()) {
    seen.radiance += scene.material(*hit).average_emission();
    seen.pdf += pdf_direct(scene, scene.mesh_light(hit->instance), from, wi, &*hit);
  }
  return seen;
}

double shadow(const Scene& scene, const V3d& from, const DirectSample& sample) {
  return scene.transmittance({from, sample.wi, sample.distance})->x;
}

double irradiance(const DirectSample& sample, const V3f& normal) {
  const float cosine = sample.wi.dot(normal);
  return cosine > 0 ? static_cast<double>(sample.radiance.x) * cosine / sample.pdf : 0;
}

TEST(SceneLight, DirectSamplesAgreeWithWhatRaysSee) {
  for (const Case& test : finite_lights()) {
    const auto scene = compiled(test.description);
    ASSERT_EQ(scene->lights().size(), 1u) << test.name;
    if (is_delta(scene->lights()[0])) continue;
    Random random(1);
    for (const V3d& from : {V3d(0.1, -0.2, 0), V3d(-0.4, 0.9, 0.3), V3d(0.2, 0.1, 0.35), V3d(3, 4, -2)}) {
      const V3d middle = scene->lights()[0].middle;
      const V3f towards((middle - from).normalized());
      const float reach = scene->lights()[0].reach * 1.01f;
      // uniform directions in the cone around the light
      const float distance = static_cast<float>((middle - from).length()), sine = reach / distance;
      const float cone = sine < 1 ? 1 - std::sqrt(1 - sine * sine) : 2;
      Mean by_rays, total_pdf, by_samples;
      int other_pdf = 0;
      for (int i = 0; i < 60000; ++i) {
        const V3f wi = Frame(towards).to_world(sample_cone(random.pair(), cone)).normalized();
        const Seen seen = look(*scene, from, wi);
        // weighted by a polynomial, so that the samples' places count and not their number alone
        const auto weight = [](const V3f& w) { return 1 + 0.9 * w.x + 0.8 * w.y * w.z; };
        by_rays.add(weight(wi) * seen.radiance.x / cone_pdf(cone));
        total_pdf.add(seen.pdf / cone_pdf(cone));
        const auto sample = sample_direct(*scene, 0, from, random.unit(), random.pair());
        by_samples.add(sample ? weight(sample->wi) * sample->radiance.x / sample->pdf *
                                    shadow(*scene, from, *sample)
                              : 0);
        if (!sample || shadow(*scene, from, *sample) == 0) continue;
        const Seen there = look(*scene, from, sample->wi);
        other_pdf += there.pdf > 0 && std::abs(there.pdf / sample->pdf - 1) > 2e-3;
      }
      EXPECT_LE(other_pdf, 60) << test.name;  // along a silhouette the ray meets the triangle next door
      EXPECT_NEAR(by_rays.value(), by_samples.value(),
                  4 * std::hypot(by_rays.error(), by_samples.error()) + 1e-6 * by_rays.value())
          << test.name << from;
      EXPECT_LE(total_pdf.value(), 1 + 4 * total_pdf.error() + 2e-3) << test.name;
    }
  }
}

TEST(SceneLight, DensityOfDirectionsIsOne) {
  // seen whole and lit in every direction: no sample is lost
  for (const AreaShape shape :
       {AreaShape::Square, AreaShape::Rectangle, AreaShape::Disk, AreaShape::Ellipse}) {
    SceneDescription description;
    description.lights.push_back(area(shape, pi));
    const auto scene = compiled(description);
    Random random(2);
    for (const V3d& from : {V3d(0.3, 0.2, 0.8), V3d(0.1, -0.2, -3)}) {
      Mean total;
      for (int i = 0; i < 1000000; ++i) total.add(look(*scene, from, random.direction()).pdf * 4 * pi);
      expect_mean(total, 1, "density");
    }
  }
}

TEST(SceneLight, PointOnPlane) {
  for (const float radius : {0.0f, 0.5f}) {
    SceneDescription description;
    description.lights.push_back(lamp(LightKind::Point, translation({0, 0, 2})));
    description.lights[0].radius = radius;
    const auto scene = compiled(description);
    Random random(3);
    for (const double x : {0.0, 1.0, 3.0}) {
      Mean mean;
      for (int i = 0; i < 100000; ++i) {
        const auto sample = sample_direct(*scene, 0, V3d(x, 0, 0), random.unit(), random.pair());
        mean.add(sample ? irradiance(*sample, {0, 0, 1}) : 0);
      }
      // a sphere wholly above the horizon lights like its centre: E = P / (4 pi) · cos / d²
      const double d2 = x * x + 4;
      expect_mean(mean, 10 / (4 * std::numbers::pi) * 2 / (d2 * std::sqrt(d2)), "sphere light");
    }
  }
}

TEST(SceneLight, RectangleOnPlane) {
  SceneDescription description;
  // looks down; a corner above the origin
  description.lights.push_back(lamp(LightKind::Area, translation({0.5, 0.25, 1})));
  description.lights[0].shape = AreaShape::Rectangle, description.lights[0].size_x = 1;
  description.lights[0].size_y = 0.5f;
  const auto scene = compiled(description);
  Random random(4);
  Mean mean;
  for (int i = 0; i < 200000; ++i) {
    const auto sample = sample_direct(*scene, 0, V3d(0), random.unit(), random.pair());
    mean.add(sample ? irradiance(*sample, {0, 0, 1}) : 0);
  }
  // form factor from a differential element to a parallel rectangle with one corner on its normal
  const double a = 1, b = 0.5, sa = std::sqrt(1 + a * a), sb = std::sqrt(1 + b * b);
  const double form = (a / sa * std::atan(b / sa) + b / sb * std::atan(a / sb)) / (2 * std::numbers::pi);
  expect_mean(mean, std::numbers::pi * (10 / (4 * 0.5)) * form, "rectangle");
}

TEST(SceneLight, DiskOnPlane) {
  SceneDescription description;
  description.lights.push_back(lamp(LightKind::Area, translation({0, 0, 1})));
  description.lights[0].shape = AreaShape::Disk, description.lights[0].size_x = 3;
  const auto scene = compiled(description);
  Random random(5);
  Mean mean;
  for (int i = 0; i < 200000; ++i) {
    const auto sample = sample_direct(*scene, 0, V3d(0), random.unit(), random.pair());
    mean.add(sample ? irradiance(*sample, {0, 0, 1}) : 0);
  }
  const double r2 = 2.25, radiance = 10 / (4 * std::numbers::pi * r2);
  expect_mean(mean, std::numbers::pi * radiance * r2 / (1 + r2), "disk");
}

TEST(SceneLight, SunOnPlane) {
  for (const float angle : {0.0f, 0.009f, 0.2f, 1.5f}) {
    SceneDescription description;
    description.lights.push_back(lamp(LightKind::Sun, rotation(0.5, 0.2, 0)));
    description.lights[0].power = 3, description.lights[0].angle = angle;
    const auto scene = compiled(description);
    const V3f to_sun(rotation(0.5, 0.2, 0)[2][0], rotation(0.5, 0.2, 0)[2][1], rotation(0.5, 0.2, 0)[2][2]);
    Random random(6);
    Mean mean, seen;
    int at_rim = 0;
    for (int i = 0; i < 400000; ++i) {
      const auto sample = sample_direct(*scene, 0, V3d(0), random.unit(), random.pair());
      mean.add(irradiance(*sample, {0, 0, 1}));
      if (angle == 0) continue;
      const float ratio = pdf_direct(*scene, 0, V3d(0), sample->wi, nullptr) / sample->pdf;
      at_rim += ratio == 0;  // rounded out of the disc
      EXPECT_TRUE(ratio == 0 || std::abs(ratio - 1) < 1e-3f);
      const float cone = 1 - std::cos(0.52f * angle);
      const V3f wi = Frame(to_sun).to_world(sample_cone(random.pair(), cone));
      seen.add(std::max(0.0f, wi.z) * eval_infinite(*scene, 0, wi, false).x / cone_pdf(cone));
    }
    EXPECT_LE(at_rim, 100);
    // mean of the cosine over the disc in the tangent plane: 2 (√(1 + R²) - 1) / R²
    const double r = std::tan(angle / 2.0), factor = angle > 0 ? 2 * (std::sqrt(1 + r * r) - 1) / (r * r) : 1;
    if (angle < 1) {
      expect_mean(mean, 3 * factor * to_sun.z, "sun");
      if (angle > 0) expect_mean(seen, 3 * factor * to_sun.z, "sun's disc", 1e-4);
    } else {
      EXPECT_NEAR(mean.value(), seen.value(), 4 * std::hypot(mean.error(), seen.error()));
    }
  }
}

// Light that leaves = light that arrives: photons crossing a disk on the plane against the irradiance there.
TEST(SceneLight, EmissionAgreesWithDirectLight) {
  for (const Case& test : finite_lights()) {
    const auto scene = compiled(test.description);
    Random random(7);
    Mean flux_by_photons, flux_by_direct, total;
    constexpr float radius = 0.5f;
    const V3d centre = V3d(0.2, -0.3, 0) - scene->centre();
    for (int i = 0; i < 200000; ++i) {
      const auto point = sample_position(*scene, 0, random.unit(), random.pair());
      ASSERT_TRUE(point);
      const auto towards = sample_direction(*scene, 0, *point, random.unit(), random.pair());
      double arrived = 0, emitted = 0;
      if (towards) {
        EXPECT_NEAR(pdf_direction(*scene, 0, *point, towards->direction) / towards->pdf, 1, 1e-4)
            << test.name;
        const Color flux =
            eval_emission(*scene, 0, *point, towards->direction) / (point->pdf_area * towards->pdf);
        emitted = (static_cast<double>(flux.x) + flux.y + flux.z) / 3;
        const double t = (centre.z - point->position.z) / static_cast<double>(towards->direction.z);
        const V3d at = point->position + V3d(towards->direction) * t;
        const bool free = !scene->intersect({point->position, towards->direction, 1e30, point->clearance});
        if (t > 0 && (at - centre).length() < static_cast<double>(radius) && free) arrived = flux.x;
        if (!free) emitted = 0;
      }
      flux_by_photons.add(arrived);
      total.add(emitted);
      const V2f disk = sample_disk(random.pair()) * radius;
      const V3d from = centre + V3d(static_cast<double>(disk.x), static_cast<double>(disk.y), 0);
      const auto sample = sample_direct(*scene, 0, from, random.unit(), random.pair());
      flux_by_direct.add(
          sample ? irradiance(*sample, {0, 0, 1}) * pi * radius * radius * shadow(*scene, from, *sample) : 0);
    }
    EXPECT_NEAR(
        flux_by_photons.value(), flux_by_direct.value(),
        4 * std::hypot(flux_by_photons.error(), flux_by_direct.error()) + 1e-4 * flux_by_direct.value())
        << test.name;
    if (test.name == "emissive bowl") continue;  // it catches some of its light
    // a closed mesh sends half of its light inwards
    const double inside = test.name.starts_with("emissive ball") ? 0.5 : 1;
    expect_mean(total, inside * scene->lights()[0].power, test.name + ": watts", 1e-4);
  }
}

TEST(SceneLight, WorldDensities) {
  SceneDescription description;
  description.world.material = add(description, background({0.5f, 0.6f, 0.7f}, 2));
  const auto scene = compiled(description);
  const int world = scene->world_light();
  ASSERT_GE(world, 0);
  Random random(8);
  Mean irradiated;
  for (int i = 0; i < 200000; ++i) {
    const auto sample = sample_direct(*scene, world, V3d(0), random.unit(), random.pair());
    irradiated.add(irradiance(*sample, {0, 0, 1}));
  }
  expect_mean(irradiated, std::numbers::pi, "constant world");
}

// A world image with a small bright spot: found by its table, and all of it has a density.
TEST(SceneLight, WorldImage) {
  SceneDescription description;
  Image image;
  image.name = "sky", image.width = 64, image.height = 32;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const bool spot = y == 24 && x == 20;
      for (const float c : {spot     ? 500.0f
                            : y > 16 ? 0.4f
                                     : 0.0f,
                            0.3f, 0.2f + 0.01f * static_cast<float>(x), 1.0f})
        image.rgba.push_back(c);
    }
  description.images.push_back(image);
  MaterialDescription sky;
  sky.name = "sky";
  sky.nodes.push_back(
      {"Background", "Background", {{"Color", {}, 1, "Color"}, input("Strength", 2)}, {}, {}, -1});
  sky.nodes.push_back(
      {"TexEnvironment", "Sky", {}, {{"interpolation", "Linear"}, {"projection", "EQUIRECTANGULAR"}}, {}, 0});
  sky.surface = 0;
  description.world.material = add(description, sky);
  description.world.resolution = 128;
  const auto scene = compiled(description);
  const int world = scene->world_light();
  ASSERT_GE(world, 0);
  Random random(10);
  Mean by_table, by_sphere, density, leaving;
  int other_pdf = 0;
  const V3f normal = V3f(0.3f, -0.4f, 1).normalized();
  for (int i = 0; i < 400000; ++i) {
    const auto sample = sample_direct(*scene, world, V3d(0), random.unit(), random.pair());
    ASSERT_TRUE(sample);
    by_table.add(irradiance(*sample, normal));
    other_pdf += std::abs(pdf_direct(*scene, world, V3d(0), sample->wi, nullptr) / sample->pdf - 1) > 1e-3f;
    const auto out = sample_infinite(*scene, world, random.pair());
    leaving.add(std::max(0.0f, -out->direction.dot(normal)) *
                eval_infinite_emission(*scene, world, out->direction).x / out->pdf);
    for (int k = 0; k < 4; ++k) {
      const V3f d = random.direction();
      by_sphere.add(4 * pi * std::max(0.0f, d.dot(normal)) * eval_infinite(*scene, world, d, false).x);
      const float pdf = pdf_direct(*scene, world, V3d(0), d, nullptr);
      EXPECT_GT(pdf, 0);
      density.add(4 * pi * pdf);
    }
  }
  EXPECT_LE(other_pdf, 400);  // rounding across a texel's border
  EXPECT_LT(by_table.error(), 0.2 * by_sphere.error());
  EXPECT_NEAR(by_table.value(), by_sphere.value(), 4 * std::hypot(by_table.error(), by_sphere.error()));
  EXPECT_NEAR(by_table.value(), leaving.value(), 4 * std::hypot(by_table.error(), leaving.error()));
  expect_mean(density, 1, "density");
}

TEST(SceneLight, ChoiceIsADistributionAndMissesNobody) {
  for (const int copies : {1, 3}) {
    SceneDescription description;
    for (int k = 0; k < copies; ++k)
      for (const Case& test : finite_lights()) {
        for (const LightDescription& light : test.description.lights) {
          description.lights.push_back(light);
          description.lights.back().matrix *= translation({2.0 * k, -1.0 * k, 0});
          description.lights.back().power =
              10.0f * std::pow(10.0f, static_cast<float>(description.lights.size() % 5) - 2.0f);
        }
        if (description.lights.size() > 12 && copies == 1) break;
      }
    description.lights.push_back(lamp(LightKind::Sun, rotation(0.5, 0.2, 0)));
    const auto scene = compiled(description);
    const int count = static_cast<int>(scene->lights().size());
    Random random(9);
    for (int i = 0; i < 300; ++i) {
      const V3d from(random.real(-3, 3), random.real(-3, 3), random.real(-1, 2));
      const V3f normal = i % 3 ? random.direction() : V3f(0);
      std::vector<float> trust;
      if (i % 2 && static_cast<std::size_t>(count) <= few_lights) {
        for (int light = 0; light < count; ++light) trust.push_back(light % 3 ? random.real(0.1, 1) : 0);
      }
      double sum = 0;
      for (int light = 0; light < count; ++light) sum += choice_pmf(*scene, from, normal, light, trust);
      EXPECT_TRUE(std::abs(sum - 1) < 1e-5 || sum == 0);
      for (int k = 0; k < 20; ++k) {
        if (const auto choice = choose_light(*scene, from, normal, random.unit(), trust)) {
          ASSERT_GT(choice->pmf, 0);
          ASSERT_FLOAT_EQ(choice->pmf, choice_pmf(*scene, from, normal, choice->light, trust));
          ASSERT_TRUE(trust.empty() || trust[static_cast<std::size_t>(choice->light)] > 0);
          ASSERT_GE(choice->u, 0);
          ASSERT_LT(choice->u, 1);
        }
        const int light = static_cast<int>(random.bits() % static_cast<unsigned>(count));
        const auto sample = sample_direct(*scene, light, from, random.unit(), random.pair());
        const bool lit =
            sample && !is_black(sample->radiance) && (normal == V3f(0) || sample->wi.dot(normal) > 0);
        const bool trusted = trust.empty() || trust[static_cast<std::size_t>(light)] > 0;
        ASSERT_TRUE(!lit || !trusted || choice_pmf(*scene, from, normal, light, trust) > 0) << light;
      }
    }
  }
}

}  // namespace
}  // namespace sluice::test
