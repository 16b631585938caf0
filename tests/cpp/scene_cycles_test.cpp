// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps against Cycles. The numbers are irradiances (W/m²) that Cycles 3.4.1 gave on the plane z = 0: pi
// times the radiance of a white diffuse plane, no bounces, box filter, 1024 samples, 32 x 32 pixels over [-2,
// 2]², an orthographic camera looking down. Lamps: 10 W at (0.3, 0.2, 1), rotation (0.4, 0.2, 0); suns 3
// W/m², rotation (0.5, 0.2, 0); a 0.5 m square of strength 5; a world of 0.5 x 2.
#include "scene_fixtures.h"

namespace sluice::test {
namespace {

constexpr int pixels[5][2] = {{18, 17}, {14, 18}, {20, 22}, {10, 9}, {25, 20}};  // x, y

using Irradiances = std::array<double, 5>;

LightDescription lamp(LightKind kind, float radius = 0, float angle = 0, float blend = 0) {
  LightDescription light;
  light.names = {"Lamp"};
  light.kind = kind, light.power = 10;
  light.matrix = rotation(0.4, 0.2, 0) * translation({0.3, 0.2, 1});
  light.radius = radius, light.spot_angle = angle, light.spot_blend = blend;
  return light;
}
LightDescription sun(float angle) {
  LightDescription light = lamp(LightKind::Sun);
  light.matrix = rotation(0.5, 0.2, 0), light.power = 3, light.angle = angle;
  return light;
}
LightDescription area(AreaShape shape, float spread) {
  LightDescription light = lamp(LightKind::Area);
  light.shape = shape, light.size_x = 0.8f, light.size_y = 0.3f, light.spread = spread;
  return light;
}

void compare(const std::string& name, const SceneDescription& description, const Irradiances& cycles,
             double tolerance) {
  const auto scene = compiled(description);
  const double brightest = *std::max_element(cycles.begin(), cycles.end());
  Random random(1);
  for (std::size_t i = 0; i < cycles.size(); ++i) {
    Mean mean;
    for (int k = 0; k < 100000; ++k) {  // over the pixel, as Cycles' box filter
      const V3d from =
          V3d(-2 + 4 * (pixels[i][0] + random.real()) / 32, -2 + 4 * (pixels[i][1] + random.real()) / 32, 0) -
          scene->centre();
      const auto sample = sample_direct(*scene, 0, from, random.unit(), random.pair());
      mean.add(sample ? static_cast<double>(sample->radiance.x) * std::max(0.0f, sample->wi.z) / sample->pdf
                      : 0);
    }
    EXPECT_NEAR(mean.value(), cycles[i], 4 * mean.error() + tolerance * cycles[i] + 5e-4 * brightest)
        << name << " " << i;
  }
}

void compare(const std::string& name, const LightDescription& light, const Irradiances& cycles,
             double tolerance = 0.003) {
  SceneDescription description;
  description.lights.push_back(light);
  compare(name, description, cycles, tolerance);
}

TEST(SceneCycles, PointsAndSpots) {
  compare("point", lamp(LightKind::Point), {0.79232, 0.56837, 0.45827, 0.15326, 0.29946});
  // Cycles 3.4 draws a disk of radius 0.1 where we have a sphere: (r / distance)², at most 1 %
  compare("soft point", lamp(LightKind::Point, 0.1f), {0.78452, 0.56387, 0.45512, 0.15281, 0.29788}, 0.012);
  compare("spot", lamp(LightKind::Spot, 0, 1.2f, 0.3f), {0.69987, 0.52613, 0.41677, 0, 0});
  compare("wide spot", lamp(LightKind::Spot, 0, 3.0f, 1), {0.68282, 0.51639, 0.40554, 0.017733, 0.12618});
  compare("soft spot", lamp(LightKind::Spot, 0.1f, 1.2f, 0.3f), {0.63785, 0.52074, 0.41098, 0, 0}, 0.015);
}

TEST(SceneCycles, Suns) {
  compare("parallel", sun(0), {2.5803, 2.5803, 2.5803, 2.5803, 2.5803});
  compare("soft", sun(0.2f), {2.5738, 2.5738, 2.5738, 2.5738, 2.5739});
  compare("softest", sun(1.5f), {2.1805, 2.1808, 2.1828, 2.1812, 2.1818});
}

TEST(SceneCycles, Areas) {
  compare("square", area(AreaShape::Square, pi), {1.9577, 1.4824, 1.2134, 0.20892, 0.63185});
  compare("square, spread", area(AreaShape::Square, 1.2f), {4.9354, 4.7926, 3.5343, 0, 0});
  compare("rectangle", area(AreaShape::Rectangle, pi), {2.0377, 1.5653, 1.2655, 0.1966, 0.66485});
  compare("rectangle, spread", area(AreaShape::Rectangle, 1.2f), {4.0665, 5.0337, 3.9524, 0, 0});
  compare("disk", area(AreaShape::Disk, pi), {2.0218, 1.5241, 1.2362, 0.20403, 0.62709});
  compare("disk, spread", area(AreaShape::Disk, 1.2f), {4.9454, 4.9147, 3.53, 0, 0});
  compare("ellipse", area(AreaShape::Ellipse, pi), {2.0817, 1.5886, 1.2764, 0.19535, 0.64931});
  compare("ellipse, spread", area(AreaShape::Ellipse, 1.2f), {4.225, 5.1337, 3.8414, 0, 0});
}

TEST(SceneCycles, SurfaceAndWorld) {
  SceneDescription glow;
  const M44d matrix = scaling({0.25, 0.25, 1}) * rotation(0.4, 0.2, 0) * translation({0.3, 0.2, 1});
  place(glow, add(glow, grid()), matrix, add(glow, glowing(Color(1), 5)));
  compare("emissive square", glow, {1.0582, 0.79174, 0.63642, 0.099062, 0.3066}, 0.003);
  SceneDescription world;
  world.world.material = add(world, background({0.5f, 0.6f, 0.7f}, 2));
  compare("world", world, {3.1416, 3.1416, 3.1416, 3.1416, 3.1416}, 0.003);
}

}  // namespace
}  // namespace sluice::test
