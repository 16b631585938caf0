// SPDX-License-Identifier: GPL-3.0-or-later
// No lamp starves: photons are shared among lights by what these bring to the picture, in a scene of any
// extent and with any others beside them.
#include "scene_fixtures.h"
#include "transport/guide/pilot.h"
#include "transport/guide/targets.h"
#include "transport/photons/emission.h"
#include "transport/photons/photon_pass.h"
#include "transport/view/view_pass.h"

namespace sluice {
namespace {

constexpr int side = 24;

void add_point(SceneDescription& scene, const V3d& place, float power, const std::string& name) {
  LightDescription& lamp = scene.lights.emplace_back();
  lamp.names = {name}, lamp.power = power, lamp.radius = 0.02f, lamp.matrix = test::translation(place);
}

// A closed box, [-1, 1]³, in one piece: nothing comes in at its edges.
MeshDescription box() {
  MeshDescription mesh;
  mesh.name = "box";
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  for (const auto& [a, b, c, d] : std::vector<std::array<std::uint32_t, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

// A room of 4 m on a ground of any size; the camera looks along it from inside.
SceneDescription room(double ground) {
  SceneDescription scene;
  const int plate = test::add(scene, test::grid()), grey = test::add(scene, test::diffuse(0.6f));
  test::place(scene, test::add(scene, box()), test::scaling({2, 2, 2}), grey, "Room");
  if (ground > 0)
    test::place(scene, plate, test::scaling({ground / 2, ground / 2, 1}) * test::translation({0, 0, -2.5}),
                grey, "Ground");
  scene.camera.matrix = test::rotation(std::numbers::pi / 2, 0, 0) * test::translation({0, -1.6, 0});
  scene.camera.lens = 24;
  scene.frame = {.width = side, .height = side, .x0 = 0, .y0 = 0, .x1 = side, .y1 = side};
  return scene;
}

class Passes {
 public:
  explicit Passes(const SceneDescription& description) : scene_(test::compiled(description)) {}
  [[nodiscard]] Guide guide() { return make_guide(*scene_, settings_, effects_, pool_, cancel_); }
  // Variance of a pass and mean of the indirect light, over the pixels.
  struct Told {
    double variance = 0, mean = 0;
  };
  Told render(const Guide& guide, int passes) {
    std::vector<test::Mean> pixels(side * side);
    for (int pass = 0; pass < passes; ++pass) {
      Film film(side, side);
      PhotonSet photons;
      PhotonPass photon_pass(*scene_, settings_, effects_, pool_.size());
      ViewPass view_pass(*scene_, settings_, effects_, pool_.size());
      // one stream; the radius hardly changes
      const PassContext context{*scene_, settings_, effects_, guide, 4 * pass};
      EXPECT_TRUE(photon_pass.run(context, pool_, cancel_, photons, counts_));
      EXPECT_TRUE(view_pass.run(context, photons, pool_, cancel_, film, lock_, counts_));
      const std::vector<float> image = film.image("Indirect");
      for (std::size_t p = 0; p < pixels.size(); ++p) pixels[p].add(image[3 * p + 1]);
    }
    Told told;
    for (const test::Mean& pixel : pixels)
      told.variance += square(pixel.error()) * passes / (side * side),
          told.mean += pixel.value() / (side * side);
    return told;
  }
  [[nodiscard]] const Scene& scene() const { return *scene_; }

 private:
  std::unique_ptr<const Scene> scene_;
  const TransportSettings settings_{.photons = 4000, .use_direct = false};
  const Effects effects_ = find_effects(*scene_, settings_);
  ThreadPool pool_{2};
  const std::atomic<bool> cancel_{false};
  std::mutex lock_;
  Counts counts_;
};

// What each light brings, from pictures of each alone.
std::vector<float> contributions(const SceneDescription& description, int passes) {
  std::vector<float> found;
  for (const LightDescription& lamp : description.lights) {
    SceneDescription alone = description;
    alone.lights = {lamp};
    Passes one(alone);
    found.push_back(static_cast<float>(one.render(one.guide(), passes).mean));
  }
  return found;
}

// Noise with the guide's shares of lights beside that with shares by true contribution, all else the same.
double noise_beside_the_best(const SceneDescription& description, const std::vector<float>& shares,
                             int passes) {
  Passes all(description);
  const Guide guide = all.guide();
  Guide best = guide;
  best.emission.lights = Distribution(shares);
  const auto ours = all.render(guide, passes), theirs = all.render(best, passes);
  // nothing is lost by either
  EXPECT_NEAR(ours.mean, theirs.mean, 5 * std::sqrt((ours.variance + theirs.variance) / passes));
  return std::sqrt(ours.variance / theirs.variance);
}

TEST(Emission, NoLampStarvesInAnyExtent) {
  for (const double ground : {10.0, 1e3, 1e5}) {
    SceneDescription scene = room(ground);
    add_point(scene, {0, 0, 1.5}, 40, "Lamp");
    add_point(scene, {1.5, 1.5, -1}, 0.5, "Dim");
    for (int i = 0; i < 6; ++i) add_point(scene, {30.0 + i, 0, 1}, 10000, "Floodlight");
    LightDescription& sun = scene.lights.emplace_back();
    sun.names = {"Sun"}, sun.kind = LightKind::Sun, sun.power = 3, sun.matrix = test::rotation(0.3, 0.2, 0);
    std::vector<float> shares = contributions(scene, 2);
    EXPECT_GT(shares[0], 10 * shares[1]);
    for (std::size_t l = 2; l < shares.size(); ++l) EXPECT_EQ(shares[l], 0) << l;  // they cannot come in
    EXPECT_LT(noise_beside_the_best(scene, shares, 16), 1.5) << ground;
  }
}

TEST(Emission, NorAmongAThousand) {
  SceneDescription scene = room(0);
  add_point(scene, {0, 0, 1.5}, 40, "Large");
  test::Random random(1);
  for (int i = 1; i < 1000; ++i)
    add_point(scene, {random.real(-1.9, 1.9), random.real(-1.9, 1.9), random.real(-1.9, 1.9)}, 0.04f,
              "Small " + std::to_string(i));
  // All in one room of grey walls bring what they send out, within some percent.
  std::vector<float> shares;
  for (const LightDescription& lamp : scene.lights) shares.push_back(lamp.power);
  EXPECT_LT(noise_beside_the_best(scene, shares, 16), 1.5);
}

// Every light of a closed room, and one that cannot come in, keeps an eighth of what it could have by its
// flux alone.
TEST(Emission, WhatWasNotMetKeepsItsPart) {
  SceneDescription scene = room(1e4);
  add_point(scene, {0, 0, 1.5}, 40, "Lamp");
  LightDescription& sun = scene.lights.emplace_back();
  sun.names = {"Sun"}, sun.kind = LightKind::Sun, sun.power = 3;
  Passes passes(scene);
  const Guide guide = passes.guide();
  ASSERT_EQ(guide.unmet.size(), 1u);
  EXPECT_EQ(guide.unmet[0].light, 1);
  EXPECT_FLOAT_EQ(guide.unmet[0].share, guide.emission.lights.pmf(1));
  // What is seen lies within the room's own sphere, of radius 2 √3: the sun's flux through a smaller one
  // against the lamp's 40 W.
  const double most = 3 * std::numbers::pi * square(2 * std::sqrt(3.0));
  EXPECT_GT(guide.emission.lights.pmf(1), 0.125 * 0.2);
  EXPECT_LT(guide.emission.lights.pmf(1), 0.125 * most / (most + 40) * 1.05);
}

// Shares need not sum to 1; ways without one are neither drawn nor asked for their density.
TEST(EmissionMixture, DrawsEachWayByItsShareAndAddsUpTheirDensities) {
  const std::vector<float> flat(EmissionHistogram::cells, 1.0f);
  const EmissionMixture mixture({.own = 1, .targets = {2, 0, 3}, .histogram = 4}, EmissionHistogram(flat));
  constexpr int draws = 10000;
  double own = 0, histogram = 0, target[3] = {0, 0, 0};
  for (int i = 0; i < draws; ++i) {
    const auto [way, t, u] = mixture.sample((static_cast<float>(i) + 0.5f) / draws);
    EXPECT_TRUE(u >= 0 && u < 1);
    (way == EmissionMixture::Way::Own      ? own
     : way == EmissionMixture::Way::Target ? target[t]
                                           : histogram) += 1.0 / draws;
  }
  EXPECT_NEAR(own, 0.1, 1e-3);
  EXPECT_NEAR(target[0], 0.2, 1e-3);
  EXPECT_EQ(target[1], 0);
  EXPECT_NEAR(target[2], 0.3, 1e-3);
  EXPECT_NEAR(histogram, 0.4, 1e-3);
  const float pdf =
      mixture.pdf([](float share) { return 10 * share; }, [](float share) { return share * 100; },
                  [](std::size_t t, float share) {
                    EXPECT_NE(t, 1u);
                    return share * (t == 0 ? 1000 : 10000);
                  });
  EXPECT_FLOAT_EQ(pdf, 1 + 40 + 200 + 3000);
}

// What a lamp sends out, and what of it goes into a sphere, is the same however much is aimed there.
TEST(EmissionMixture, MeansDoNotDependOnIt) {
  SceneDescription description = room(0);
  add_point(description, {0, 0, 1.5}, 40, "Lamp");
  const auto scene = test::compiled(description);
  const Target place{V3d(1, 0, 0), 0.3f};
  for (const float own : {1.0f, 0.5f, 0.1f}) {
    const EmissionGuide guide = aim_at(*scene, place, {}, own);
    test::Mean into, all;
    for (std::uint32_t i = 0; i < 40000; ++i) {
      const auto photon = emit_photon(*scene, guide, Sampler(5, i));
      const float flux = photon ? photon->flux.x : 0;
      all.add(flux);
      into.add(photon && aims_at(place, photon->origin, photon->direction, false) ? flux : 0);
    }
    EXPECT_NEAR(all.value(), 40, 4 * all.error() + 1e-3) << own;
    // the lamp is nearly a point, whose flux into a sphere has a closed form
    EXPECT_NEAR(into.value(), flux_into(scene->lights()[0], place), 4 * into.error() + 0.1) << own;
  }
}

TEST(Targets, AreClusteredWhenThereAreMany) {
  test::Random random(3);
  std::vector<Target> spheres;
  for (int i = 0; i < 500; ++i)
    spheres.push_back({V3d(random.real(-10, 10), random.real(-10, 10), random.real(0, 1)),
                       static_cast<float>(random.real(0.01, 0.2))});
  const std::vector<Target> few = clustered(spheres, 32);
  ASSERT_EQ(few.size(), 32u);
  for (const Target& sphere : spheres)
    EXPECT_TRUE(std::ranges::any_of(few, [&](const Target& t) {
      return (t.centre - sphere.centre).length() + sphere.radius <= t.radius * 1.00001;
    }));
  double largest = 0;
  for (const Target& t : few) largest = std::max(largest, static_cast<double>(t.radius));
  EXPECT_LT(largest, 5);  // 20 m over √32 squares, their half diagonal, twice that for chance
  const std::vector<Target> same = clustered(spheres, 500);
  for (std::size_t i = 0; i < spheres.size(); ++i) EXPECT_EQ(same[i].centre, spheres[i].centre);
}

}  // namespace
}  // namespace sluice
