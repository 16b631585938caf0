// SPDX-License-Identifier: GPL-3.0-or-later
// Which lights v asks, and how often: noise changes, the mean does not.
#include "scene_fixtures.h"
#include "transport/guide/light_probing.h"
#include "transport/guide/pilot.h"
#include "transport/photons/photon_pass.h"
#include "transport/view/view_pass.h"

namespace sluice {
namespace {

// Two lamps over a shiny floor under a sky; a wall hides the second from x < 0.
SceneDescription two_lamps() {
  SceneDescription scene;
  const int plate = test::add(scene, test::grid());
  const auto shiny = test::one_node("shiny", "BsdfPrincipled",
                                    {test::input("Base Color", 0.6f, 0.5f, 0.4f),
                                     test::input("Roughness", 0.4f), test::input("IOR", 1.5f)});
  test::place(scene, plate, test::scaling({4, 4, 1}), test::add(scene, shiny), "Floor");
  test::place(scene, plate, test::scaling({2, 4, 1}) * test::translation({-2, 0, 2.5}),
              test::add(scene, test::diffuse(0.2f)), "Wall");
  for (const double z : {2.0, 6.0}) {
    LightDescription& lamp = scene.lights.emplace_back();
    lamp.names = {z < 3 ? "Near" : "Far"}, lamp.kind = LightKind::Area, lamp.size_x = lamp.size_y = 0.3f;
    lamp.matrix = test::translation({z < 3 ? 0.0 : -1.0, 0, z}), lamp.power = z < 3 ? 20.0f : 200.0f;
  }
  scene.world.material = test::add(scene, test::background({0.5f, 0.6f, 0.7f}, 0.2f));
  scene.camera.matrix = test::translation({0, 0, 2.4});
  scene.frame = {.width = 32, .height = 32, .x0 = 0, .y0 = 0, .x1 = 32, .y1 = 32};
  return scene;
}

TEST(LightTrust, IsThatOfThePlace) {
  const auto scene = test::compiled(two_lamps());
  const TransportSettings settings;
  ThreadPool pool(2);
  std::vector<Hit> seen;
  for (int i = 0; i < 4000; ++i)
    for (const double side : {-1, 1})
      seen.push_back({1, V3d(side * (2 + 0.0001 * i), 0, 0.01), V3f(0, 0, 1), V3f(0), 0, 0, 0, 0});
  const Effects effects = find_effects(*scene, settings);
  const std::atomic<bool> cancel{false};
  const LightTrusts trust = probe_lights({*scene, settings, effects, pool, cancel}, seen, 10);
  const LightTrust dark = trust.at_v(V3d(-2.2, 0, 0.01)), lit = trust.at_v(V3d(2.2, 0, 0.01)),
                   elsewhere = trust.at_v(V3d(0, 3, 0.01));
  EXPECT_NEAR(dark[0] / lit[0], 1, 0.2);    // the near lamp
  EXPECT_LT(dark[1], 0.25f * lit[1]);       // the far one, behind the wall
  EXPECT_GT(dark[1], 0.1f * elsewhere[1]);  // may be there though it was not found
  EXPECT_LT(elsewhere[1], lit[1]);
  EXPECT_GT(elsewhere[1], dark[1]);
}

// Passes of a scene whose samples a map places, each on a film of its own.
class Passes {
 public:
  Passes(const SceneDescription& description, int count)
      : scene_(test::compiled(description)), count_(count) {}

  std::vector<Film> render(const SampleCount& samples) {
    guide_.samples = SampleMap(32, 1, {samples});
    std::vector<Film> films;
    for (int pass = 0; pass < count_; ++pass) {
      Film& film = films.emplace_back(32, 32);
      PhotonSet photons;
      const PassContext context{*scene_, settings_, effects_, guide_, pass};
      EXPECT_TRUE(photon_pass_.run(context, pool_, cancel_, photons, counts_));
      EXPECT_TRUE(view_pass_.run(context, photons, pool_, cancel_, film, lock_, counts_));
    }
    return films;
  }

 private:
  std::unique_ptr<const Scene> scene_;
  int count_;
  const TransportSettings settings_{.photons = 4000};
  const Effects effects_ = find_effects(*scene_, settings_);
  ThreadPool pool_{2};
  const std::atomic<bool> cancel_{false};
  Guide guide_ = make_guide(*scene_, settings_, effects_, pool_, cancel_);
  std::mutex lock_;
  Counts counts_;
  PhotonPass photon_pass_{*scene_, settings_, effects_, pool_.size()};
  ViewPass view_pass_{*scene_, settings_, effects_, pool_.size()};
};

test::Mean whole(const std::vector<Film>& films, const char* part) {
  test::Mean mean;
  for (const Film& film : films) {
    const std::vector<float> image = film.image(part);
    mean.add(std::accumulate(image.begin(), image.end(), 0.0) / static_cast<double>(image.size()));
  }
  return mean;
}

// Squared errors of the means of all numbers, summed up.
double noise(const std::vector<Film>& films, const char* part) {
  std::vector<test::Mean> pixels;
  for (const Film& film : films) {
    const std::vector<float> image = film.image(part);
    pixels.resize(image.size());
    for (std::size_t i = 0; i < image.size(); ++i) pixels[i].add(image[i]);
  }
  double sum = 0;
  for (const test::Mean& pixel : pixels) sum += square(pixel.error());
  return sum;
}

// Means and noise of the direct light, seen by lobes and by next-event estimation, for numbers of samples
// that share an estimate.
TEST(LightSamples, KeepTheMeanAndTakeNoise) {
  Passes passes(two_lamps(), 48);
  const auto one = passes.render({});
  for (const std::uint8_t light_samples : {2, 3, 4}) {
    const auto many = passes.render({.light_samples = light_samples});
    const test::Mean a = whole(one, "Direct"), b = whole(many, "Direct");
    EXPECT_NEAR(a.value(), b.value(), 3.5 * std::hypot(a.error(), b.error())) << int{light_samples};
    EXPECT_LT(b.error() + a.error(), 0.01 * a.value());  // else the line above says nothing
    // the rest is the lobes'
    EXPECT_LT(noise(many, "Direct"), (0.15 + 0.95 / light_samples) * noise(one, "Direct"))
        << int{light_samples};
  }
}

// The same of indirect light, for numbers of gather segments that bundles share. (Several kinds in one
// bundle: oracle/core_render.h.)
TEST(GatherSegments, KeepTheMeanAndTakeNoise) {
  Passes passes(two_lamps(), 96);
  const auto by_turns = passes.render({});
  double before = noise(by_turns, "Indirect");
  for (const std::uint8_t segments : {1, 2, 4}) {
    const auto many = passes.render({.gather_segments = segments});
    for (const char* part : {"Indirect", "Direct"}) {
      const test::Mean a = whole(by_turns, part), b = whole(many, part);
      EXPECT_NEAR(a.value(), b.value(), 3.5 * std::hypot(a.error(), b.error())) << part << int{segments};
      EXPECT_LT(b.error() + a.error(), 0.03 * a.value());
    }
    const double now = noise(many, "Indirect");
    EXPECT_LT(now, 0.6 * before) << int{segments};
    before = now;
  }
}

// A lamp seen straight, in a mirror and through glass.
SceneDescription seen_lamps() {
  SceneDescription scene = two_lamps();
  const int plate = test::add(scene, test::grid());
  const auto mirror = test::one_node(
      "mirror", "BsdfGlossy", {test::input("Color", 0.9f, 0.8f, 0.7f), test::input("Roughness", 0.0f)});
  const auto glass = test::one_node(
      "glass", "BsdfGlass",
      {test::input("Color", 1, 1, 1), test::input("Roughness", 0.0f), test::input("IOR", 1.5f)});
  const auto glowing = test::one_node("glowing", "Emission",
                                      {test::input("Color", 1, 0.8f, 0.6f), test::input("Strength", 5.0f)});
  test::place(scene, plate, test::scaling({0.3, 2, 1}) * test::translation({0.3, 0, 0.1}),
              test::add(scene, mirror), "Mirror");
  test::place(scene, plate, test::scaling({0.3, 2, 1}) * test::translation({-0.6, 0, 0.5}),
              test::add(scene, glass), "Pane");
  test::place(scene, plate, test::scaling({0.4, 0.11, 1}) * test::translation({-0.3, 0.2, 0.3}),
              test::add(scene, glowing), "Lamp");
  return scene;
}

TEST(EmissionSamples, KeepTheMeanAndTakeNoiseFromEmissionAlone) {
  Passes passes(seen_lamps(), 64);
  const auto none = passes.render({.samples = 3}),
             many = passes.render({.samples = 3, .emission_samples = 24});
  const test::Mean a = whole(none, "Emission"), b = whole(many, "Emission");
  EXPECT_NEAR(a.value(), b.value(), 3.5 * std::hypot(a.error(), b.error()));
  EXPECT_LT(b.error() + a.error(), 0.01 * a.value());  // else the line above says nothing
  EXPECT_LT(noise(many, "Emission"), 0.2 * noise(none, "Emission"));
  for (std::size_t pass = 0; pass < many.size(); ++pass)
    for (const char* part : {"Direct", "Caustics", "Indirect", "Normal", "Albedo", "Depth"})
      EXPECT_EQ(many[pass].image(part), none[pass].image(part)) << part;
  const std::vector<float> image = many[0].image("Combined");
  for (std::size_t i = 3; i < image.size(); i += 4) EXPECT_EQ(image[i], 1);  // alpha
}

}  // namespace
}  // namespace sluice
