// SPDX-License-Identifier: GPL-3.0-or-later
// A pass is a pure function of its index: the same bits alone or after others, for any number of threads; and
// its ledger closes.
#include "edit_scene.h"
#include "scene_fixtures.h"
#include "transport/guide/light_probing.h"
#include "transport/guide/pilot.h"
#include "transport/photons/photon_pass.h"
#include "transport/view/view_pass.h"

namespace sluice {
namespace {

// A lamp over a floor with a glass ball, and an edit that moves its caustic.
SceneDescription small_world(const std::string& expression = "LS+") {
  SceneDescription scene;
  test::place(scene, test::add(scene, test::grid(2)), test::scaling({3, 3, 1}),
              test::add(scene, test::diffuse(0.7f)), "Floor");
  auto glass =
      test::one_node("glass", "BsdfGlass",
                     {test::input("Color", 1, 1, 1), test::input("Roughness", 0), test::input("IOR", 1.5f)});
  test::place(scene, test::add(scene, test::sphere(24)), test::translation({0, 0, 1.2}),
              test::add(scene, glass), "Ball");
  LightDescription lamp;
  lamp.names = {"Lamp"};
  lamp.matrix = test::translation({1, 0.5, 4});
  lamp.power = 300, lamp.radius = 0.1f;
  scene.lights.push_back(lamp);
  EditDescription edit;
  edit.expression = expression;
  edit.entry = quad("Entry", at({0, 0, 0}), 0, 0.9);
  edit.exits.push_back({{.intensity = 0.8f, .hue_shift = 1}, quad("Exit", at({1.8, 0, 0}), 1, 0.9)});
  scene.edits.push_back(edit);
  scene.camera.matrix = test::translation({0, 0, 8});
  scene.frame = {.width = 48, .height = 40, .x0 = 0, .y0 = 0, .x1 = 48, .y1 = 40};
  return scene;
}

struct Renderer {
  explicit Renderer(const Scene& the_scene, int threads)
      : scene(the_scene),
        effects(find_effects(scene, settings)),
        pool(threads),
        guide(make_guide(scene, settings, effects, pool, cancel)),
        photon_pass(scene, settings, effects, threads),
        view_pass(scene, settings, effects, threads) {}

  // The hash of that pass's own film.
  std::uint64_t pass_hash(int pass) {
    std::vector<std::string> layers;
    for (const LayerDescription& layer : scene.edits().layers()) layers.push_back(layer.name);
    Film film(48, 40, {.layers = layers});
    const PassContext context{scene, settings, effects, guide, pass};
    EXPECT_TRUE(photon_pass.run(context, pool, cancel, photons, counts));
    EXPECT_TRUE(view_pass.run(context, photons, pool, cancel, film, lock, counts));
    return film.hash();
  }

  // One photon that leaves a light, and what it leaves behind.
  std::pair<std::optional<EmittedPhoton>, std::vector<Photon>> light_path(std::uint32_t path) {
    LightTracer tracer(scene, settings, effects, 1);
    const Sampler sampler(7, path);
    std::pair<std::optional<EmittedPhoton>, std::vector<Photon>> out{
        emit_photon(scene, guide.emission, sampler), {}};
    if (out.first) tracer.trace(*out.first, 1, sampler, path, out.second);
    return out;
  }

  const Scene& scene;
  TransportSettings settings{.photons = 8000};
  Effects effects;
  ThreadPool pool;
  std::atomic<bool> cancel{false};
  Guide guide;
  PhotonPass photon_pass;
  ViewPass view_pass;
  PhotonSet photons;
  Counts counts;
  std::mutex lock;
};

TEST(Pass, IsAPureFunctionOfItsIndex) {
  SceneDescription description = small_world();
  description.layers = {{"Moved", "L.*F.*E"}, {"Straight", "L D E"}, {"Rest", "L.*E"}};
  const auto scene = test::compiled(std::move(description));
  Renderer in_order(*scene, 2), alone(*scene, 1), backward(*scene, 3);
  std::vector<std::uint64_t> hashes;
  for (int pass = 0; pass < 6; ++pass) hashes.push_back(in_order.pass_hash(pass));
  EXPECT_EQ(alone.pass_hash(4), hashes[4]);
  for (int pass = 6; pass-- > 0;)
    EXPECT_EQ(backward.pass_hash(pass), hashes[static_cast<std::size_t>(pass)]) << pass;
  EXPECT_EQ(in_order.guide.hash(), backward.guide.hash());
  EXPECT_NE(hashes[0], hashes[1]);
}

TEST(Pass, LedgerCloses) {
  for (const char* expression : {"LS+", "L", "L.*", "L.*D"}) {
    const auto scene = test::compiled(small_world(expression));
    Renderer renderer(*scene, 2);
    (void)renderer.pass_hash(0);
    const Ledger& ledger = renderer.counts.ledger;
    EXPECT_GT(ledger.emitted, 0);
    EXPECT_LT(std::abs(ledger.residual()), 1e-6 * ledger.emitted) << expression;
    EXPECT_GT(renderer.counts.edits[0].matched, 0u) << expression;
  }
}

// A pane between a floor and a ceiling: what one path brings through it and back from it differs by Fresnel's
// factor, not by chance.
TEST(LightPath, BothWaysAtTheFirstGlassAreFollowed) {
  SceneDescription description;
  const int sheet = test::add(description, test::grid(1)), grey = test::add(description, test::diffuse(0.5f));
  const int glass = test::add(
      description,
      test::one_node("glass", "BsdfGlass",
                     {test::input("Color", 1, 1, 1), test::input("Roughness", 0), test::input("IOR", 1.5f)}));
  test::place(description, sheet, test::scaling({9, 9, 1}), grey, "Floor");
  test::place(description, sheet, test::scaling({9, 9, 1}) * test::translation({0, 0, 3}), grey, "Ceiling");
  test::place(description, sheet, test::scaling({1, 1, 1}) * test::translation({0, 0, 1}), glass, "Pane");
  LightDescription lamp;
  lamp.matrix = test::translation({0, 0, 2});
  description.lights.push_back(lamp);
  const auto scene = test::compiled(description);
  Renderer renderer(*scene, 1);
  int met = 0;
  for (std::uint32_t path = 0; path < 2000; ++path) {
    auto [emitted, photons] = renderer.light_path(path);
    ASSERT_TRUE(emitted);
    std::erase_if(photons, [](const Photon& photon) {
      return photon.arrival != Arrival::Caustic || photon.depth != 1;
    });
    if (photons.empty()) continue;
    ++met;
    ASSERT_EQ(photons.size(), 2u);
    const bool first_is_above = photons[0].position.z > photons[1].position.z;
    const Photon &above = photons[first_is_above ? 0 : 1], &below = photons[first_is_above ? 1 : 0];
    EXPECT_GT(above.position.z - below.position.z, 2.9f);
    const double cosine = std::abs(unpack_direction(above.wi).z),
                 inside = std::sqrt(1 - (1 - cosine * cosine) / square(1.5));
    const double s = (cosine - 1.5 * inside) / (cosine + 1.5 * inside),
                 p = (1.5 * cosine - inside) / (1.5 * cosine + inside), fresnel = (s * s + p * p) / 2;
    EXPECT_NEAR(above.flux().x / (above.flux().x + below.flux().x), fresnel, 2e-4 + 1e-3 * fresnel);
  }
  EXPECT_GT(met, 200);
}

// What roulette leaves of light in a deeply coloured room is not brighter than what the lamp sent: else
// single photons show.
TEST(LightPath, RouletteGainsInNoChannel) {
  SceneDescription description;
  const auto red = test::one_node("red", "BsdfDiffuse",
                                  {test::input("Color", 0.9f, 0.05f, 0.05f), test::input("Roughness", 0)});
  test::place(description, test::add(description, test::sphere(12)), test::scaling({2, 2, 2}),
              test::add(description, red), "Room");
  description.lights.emplace_back();
  const auto scene = test::compiled(description);
  Renderer renderer(*scene, 1);
  int deep = 0;
  for (std::uint32_t path = 0; path < 500; ++path) {
    const auto [emitted, photons] = renderer.light_path(path);
    ASSERT_TRUE(emitted);
    for (const Photon& photon : photons) {
      ASSERT_LE(max_component(photon.flux()), 1.001f * max_component(emitted->flux));
      deep += photon.depth >= 7;
    }
  }
  EXPECT_GT(deep, 100);
}

// A floor and a ceiling that multiply light by 1e20 soon make it infinite: it ends there, and the ledger
// still closes.
TEST(Pass, LightThatNoNumberHoldsIsBookedAsCapped) {
  SceneDescription description = small_world();
  description.edits.clear();
  description.materials[0] = test::diffuse(1e20f);
  description.instances[1] = description.instances[0];
  description.instances[1].matrix = test::scaling({3, 3, 1}) * test::translation({0, 0, 5});
  const auto scene = test::compiled(description);
  Renderer renderer(*scene, 2);
  (void)renderer.pass_hash(0);
  const Ledger& ledger = renderer.counts.ledger;
  EXPECT_GT(renderer.counts.non_finite, 0u);
  EXPECT_GT(ledger.capped, 1e20);
  EXPECT_LT(std::abs(ledger.residual()), 1e-9 * ledger.capped);
}

// Above the split budget one exit stands for all: which one is chance, not light that the edit adds or takes.
TEST(Pass, TheChoiceOfAnExitIsBookedAsSampling) {
  SceneDescription description = small_world("L");
  description.instances.pop_back();
  EditDescription& edit = description.edits[0];
  edit.exits.clear();
  double intensities = 0;
  for (int i = 0; i < split_budget + 4; ++i) {
    edit.exits.push_back(
        {{.intensity = i == 3 ? 5.0f : 0.01f}, quad(numbered("Exit ", i), at({1.8, 0, 0}), 1 + i, 0.9)});
    intensities += static_cast<double>(edit.exits.back().intensity);
  }
  const auto scene = test::compiled(description);
  Renderer renderer(*scene, 2);
  (void)renderer.pass_hash(0);
  const Ledger& ledger = renderer.counts.ledger;
  const EditCounts& count = renderer.counts.edits[0];
  EXPECT_GT(renderer.counts.split_capped, 100u);
  EXPECT_NEAR(ledger.removed - ledger.added, count.energy_in * (1 - intensities), 1e-5 * count.energy_in);
  // this pass had luck, good or bad
  EXPECT_GT(std::abs(count.energy_out - count.energy_in * intensities), 1e-3 * count.energy_in);
  EXPECT_LT(ledger.relative_residual(), 1e-6);
}

// A normal map that turns light into the plane of the exit: lost by a limit, not by the artist.
TEST(Pass, CopiesThatGrazeTheirExitAreBookedAsCapped) {
  SceneDescription description = small_world("L");
  description.instances.pop_back();
  description.lights[0] = {};
  description.lights[0].names = {"Sun"}, description.lights[0].kind = LightKind::Sun;
  description.lights[0].power = 2;
  description.images.push_back(make_image("Grazing", 1, 1, {1, 0.5f, 0.50025f, 1}, ColorSpace::NonColor));
  description.edits[0].exits[0].normal_map = 0;
  const auto scene = test::compiled(description);
  Renderer renderer(*scene, 2);
  (void)renderer.pass_hash(0);
  const Ledger& ledger = renderer.counts.ledger;
  EXPECT_GT(renderer.counts.grazing_dropped, 100u);
  EXPECT_EQ(ledger.removed, 0);
  EXPECT_GE(ledger.capped, renderer.counts.edits[0].energy_in * (1 - 1e-9));
  EXPECT_LT(ledger.relative_residual(), 1e-6);
}

// What lamps emit, by photons, is what their panel says: 300 W white.
TEST(Pass, EmitsTheLampsWatts) {
  const auto scene = test::compiled(small_world());
  Renderer renderer(*scene, 2);
  double sum = 0, squares = 0;
  constexpr int passes = 24;
  for (int pass = 0; pass < passes; ++pass) {
    renderer.counts = {};
    (void)renderer.pass_hash(pass);
    sum += renderer.counts.ledger.emitted, squares += square(renderer.counts.ledger.emitted);
  }
  const double mean = sum / passes, error = std::sqrt((squares / passes - mean * mean) / (passes - 1));
  EXPECT_NEAR(mean, 300, 4 * error + 1e-3);
  EXPECT_LT(error, 3);
}

TEST(Pass, AnEditThatMatchesNothingChangesNoBit) {
  SceneDescription plain = small_world(), unmatched = small_world("LSSSSSSSSSD'Nobody'S+"),
                   disabled = small_world();
  plain.edits.clear();
  disabled.edits[0].enabled = false;
  const auto a = test::compiled(plain), b = test::compiled(unmatched), c = test::compiled(disabled);
  Renderer none(*a, 2), without_match(*b, 2), off(*c, 1);
  for (int pass = 0; pass < 2; ++pass) {
    const std::uint64_t hash = none.pass_hash(pass);
    EXPECT_EQ(without_match.pass_hash(pass), hash);
    EXPECT_EQ(off.pass_hash(pass), hash);
  }
}

// A sun's photons start just outside the surfaces; an entry that hovers far above them still gets all of its
// light.
TEST(Pass, SunsReachEntriesOutsideTheScene) {
  for (const double height : {1.0, 4.0, 60.0}) {
    SceneDescription description = small_world("L");
    description.instances.pop_back();
    LightDescription& sun = description.lights[0];
    sun = {};
    sun.names = {"Sun"}, sun.kind = LightKind::Sun, sun.power = 2;
    description.edits[0].entry = quad("Entry", at({0.3, 0.2, height}), 0, 0.5);
    const auto scene = test::compiled(description);
    Renderer renderer(*scene, 2);
    double sum = 0, squares = 0;
    constexpr int passes = 12;
    for (int pass = 0; pass < passes; ++pass) {
      renderer.counts = {};
      (void)renderer.pass_hash(pass);
      sum += renderer.counts.edits[0].energy_in, squares += square(renderer.counts.edits[0].energy_in);
    }
    const double mean = sum / passes, error = std::sqrt((squares / passes - mean * mean) / (passes - 1));
    EXPECT_NEAR(mean, 2.0, 4 * error + 1e-4) << "2 W/m² through 1 m² at " << height << " m";
    EXPECT_LT(error, 0.05);
  }
}

// Nobody sees the light that it sends away, and the pilot need not find it: the chance that it has later is
// never 0.
TEST(Pass, EntriesOutsideTheSceneAreNeverForgotten) {
  SceneDescription description = small_world("L");
  description.instances.pop_back();
  description.lights[0] = {};
  description.lights[0].names = {"Sun"}, description.lights[0].kind = LightKind::Sun;
  description.lights[0].power = 2;
  description.edits[0].entry = quad("Entry", at({9, 0.2, 1}), 0, 0.5);
  description.edits[0].exits[0].quad.matrix = at({0, 0, -3});
  const auto scene = test::compiled(description);
  Renderer renderer(*scene, 2);
  test::Mean energy;
  for (int pass = 0; pass < 12; ++pass) {
    renderer.counts = {};
    (void)renderer.pass_hash(pass);
    energy.add(renderer.counts.edits[0].energy_in);
  }
  test::expect_mean(energy, 2.0, "2 W/m² through 1 m² beside the floor");
  EXPECT_LT(energy.error(), 0.05);
}

// Bit for bit the picture of no edit: within the surfaces' sphere always, outside of it where its expression
// asks for more than L.
TEST(Pass, EntriesThatTakeNoLightFromInfinityGetNoTarget) {
  SceneDescription description = small_world();
  description.lights[0] = {};
  description.lights[0].names = {"Sun"}, description.lights[0].kind = LightKind::Sun;
  description.lights[0].power = 2;
  const auto guide = [&](const V3d& place, const std::string& expression) {
    description.edits[0].entry = quad("Entry", at(place), 0, 0.5);
    description.edits[0].expression = expression;
    const auto scene = test::compiled(description);
    return Renderer(*scene, 1).guide.hash();
  };
  const std::uint64_t without = guide({0, 0, -1}, "L'Nobody'");
  EXPECT_EQ(guide({9, 0, 1}, "LS"), without);
  EXPECT_EQ(guide({0, 0, -1}, "L"), without);  // in the floor's shade
  EXPECT_NE(guide({9, 0, 1}, "L"), without);
}

// A lamp behind a wall is trusted little, but for one that casts no shadow: no wall hides it.
TEST(Pass, LampsWithoutShadowsAreTrustedBehindWalls) {
  SceneDescription description = small_world();
  ThreadPool pool(1);
  description.edits.clear(), description.instances.pop_back();
  test::place(description, description.instances[0].mesh, test::translation({0, 0, 5}), 0, "Wall");
  LightDescription& hidden = description.lights.emplace_back(description.lights[0]);
  hidden.names = {"Hidden"}, hidden.matrix = test::translation({0, 0, 5.5});
  for (const bool casts_shadow : {true, false}) {
    description.lights[1].casts_shadow = casts_shadow;
    const auto scene = test::compiled(description);
    const TransportSettings settings;
    const Hit floor{1, V3d(0, 0, 0.01), V3f(0, 0, 1), V3f(0), 0, 0, 0, 0};
    const Effects effects = find_effects(*scene, settings);
    const std::atomic<bool> cancel{false};
    const LightTrusts trust =
        probe_lights({*scene, settings, effects, pool, cancel}, std::vector<Hit>(64, floor), 10);
    EXPECT_NEAR(trust.at_v(floor.position)[0], 1, 0.2);
    if (casts_shadow)
      EXPECT_LT(trust.at_v(floor.position)[1], 0.1);
    else
      EXPECT_NEAR(trust.at_v(floor.position)[1], 1, 0.2);
  }
}

// A pixel that shows another place through a view edit is not empty: alpha, depth and albedo are that
// place's.
TEST(Pass, ViewEditsKeepAlphaAndDepth) {
  SceneDescription description = small_world();
  description.instances.pop_back();
  description.edits[0] = {};
  description.edits[0].expression = "E";
  description.edits[0].entry = quad("Entry", at({0, 0, 5}), 0, 9);
  description.edits[0].exits.push_back({{}, quad("Exit", at({0, 0, 4}), 1, 9)});
  const auto scene = test::compiled(description);
  Renderer renderer(*scene, 1);
  renderer.settings.transparent_film = true;
  Film film(48, 40);
  const PassContext context{*scene, renderer.settings, renderer.effects, renderer.guide, 0};
  ASSERT_TRUE(
      renderer.photon_pass.run(context, renderer.pool, renderer.cancel, renderer.photons, renderer.counts));
  ASSERT_TRUE(renderer.view_pass.run(context, renderer.photons, renderer.pool, renderer.cancel, film,
                                     renderer.lock, renderer.counts));
  const std::size_t middle = 20 * 48 + 24;
  EXPECT_EQ(film.image("Combined")[4 * middle + 3], 1.0f);
  EXPECT_LT(film.image("Depth")[middle], 20.0f);
  EXPECT_NEAR(film.image("Albedo")[3 * middle], 0.7f, 1e-3f);
}

TEST(Pass, NothingRunsThatNothingCalls) {
  SceneDescription scene = small_world();
  scene.edits.clear();
  scene.instances.pop_back();  // the ball
  const auto compiled = test::compiled(scene);
  TransportSettings settings;
  settings.use_indirect = false;
  const Effects effects = find_effects(*compiled, settings);
  EXPECT_TRUE(effects.direct);
  EXPECT_FALSE(effects.caustics || effects.edited || effects.indirect || effects.traces_photons());
}

}  // namespace
}  // namespace sluice
