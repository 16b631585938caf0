// SPDX-License-Identifier: GPL-3.0-or-later
// Which lights v asks, and how often: noise changes, the mean does not.
#include "scene_fixtures.h"
#include "transport/light_trust.h"
#include "transport/photon_pass.h"
#include "transport/pilot.h"
#include "transport/view_pass.h"

namespace sluice {
namespace {

// Two lamps over a shiny floor under a sky; a wall hides the second from x < 0.
SceneDescription two_lamps() {
  SceneDescription scene;
  const int plate = test::add(scene, test::grid());
  const auto shiny = test::one_node("shiny", "BsdfPrincipled", {test::input("Base Color", 0.6f, 0.5f, 0.4f), test::input("Roughness", 0.4f), test::input("IOR", 1.5f)});
  test::place(scene, plate, test::scaling({4, 4, 1}), test::add(scene, shiny), "Floor");
  test::place(scene, plate, test::scaling({2, 4, 1}) * test::translation({-2, 0, 2.5}), test::add(scene, test::diffuse(0.2f)), "Wall");
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
    for (const double side : {-1, 1}) seen.push_back({1, V3d(side * (2 + 0.0001 * i), 0, 0.01), V3f(0, 0, 1), V3f(0), 0, 0, 0, 0});
  const auto trust = try_lights(*scene, settings, find_effects(*scene, settings), seen, pool, std::atomic<bool>(false));
  const LightTrust dark = trust.at_v(V3d(-2.2, 0, 0.01)), lit = trust.at_v(V3d(2.2, 0, 0.01)), elsewhere = trust.at_v(V3d(0, 3, 0.01));
  EXPECT_NEAR(dark[0] / lit[0], 1, 0.2);        // the near lamp
  EXPECT_LT(dark[1], 0.25f * lit[1]);           // the far one, behind the wall
  EXPECT_GT(dark[1], 0.1f * elsewhere[1]);      // may be there though it was not found
  EXPECT_LT(elsewhere[1], lit[1]);
  EXPECT_GT(elsewhere[1], dark[1]);
}

// Means and noise of the direct light, seen by lobes and by next-event estimation, for numbers of samples that share an estimate.
TEST(LightSamples, KeepTheMeanAndTakeNoise) {
  const auto scene = test::compiled(two_lamps());
  const TransportSettings settings{.photons = 4000};
  const Effects effects = find_effects(*scene, settings);
  ThreadPool pool(2);
  const std::atomic<bool> cancel{false};
  Guide guide = make_guide(*scene, settings, effects, pool, cancel);
  std::mutex lock;
  Counts counts;
  PhotonPass photon_pass(*scene, settings, effects, pool.size());
  ViewPass view_pass(*scene, settings, effects, pool.size());
  constexpr int passes = 48;
  const auto render = [&](std::uint8_t light_samples) {
    guide.samples = SampleMap(32, 1, {{1, light_samples}});
    std::vector<std::vector<float>> films;
    for (int pass = 0; pass < passes; ++pass) {
      Film film(32, 32);
      PhotonSet photons;
      const PassContext context{*scene, settings, effects, guide, pass};
      EXPECT_TRUE(photon_pass.run(context, pool, cancel, photons, counts));
      EXPECT_TRUE(view_pass.run(context, photons, pool, cancel, film, lock, counts));
      films.push_back(film.image("Direct"));
    }
    return films;
  };
  const auto whole = [](const std::vector<std::vector<float>>& films) {
    test::Mean mean;
    for (const auto& film : films) mean.add(std::accumulate(film.begin(), film.end(), 0.0) / static_cast<double>(film.size()));
    return mean;
  };
  const auto noise = [](const std::vector<std::vector<float>>& films) {
    double sum = 0;
    for (std::size_t i = 0; i < films[0].size(); ++i) {
      test::Mean pixel;
      for (const auto& film : films) pixel.add(film[i]);
      sum += square(pixel.error());
    }
    return sum;
  };
  const auto one = render(1);
  for (const std::uint8_t light_samples : {2, 3, 4}) {
    const auto many = render(light_samples);
    const test::Mean a = whole(one), b = whole(many);
    EXPECT_NEAR(a.value(), b.value(), 3.5 * std::hypot(a.error(), b.error())) << int{light_samples};
    EXPECT_LT(b.error() + a.error(), 0.01 * a.value());  // else the line above says nothing
    EXPECT_LT(noise(many), (0.15 + 0.95 / light_samples) * noise(one)) << int{light_samples};  // the rest is the lobes'
  }
}

}  // namespace
}  // namespace sluice
