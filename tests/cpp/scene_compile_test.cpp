// SPDX-License-Identifier: GPL-3.0-or-later
// Bad descriptions: what is refused, what is left out and said, and that nothing crashes (numerics R5, R6,
// R7).
#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include "scene_fixtures.h"

namespace sluice::test {
namespace {

SceneDescription simple() {
  SceneDescription description;
  const int material = add(description, diffuse(0.5f));
  place(description, add(description, grid(2)), {}, material, "Floor");
  LightDescription light;
  light.names = {"Lamp"};
  light.matrix = translation({0, 0, 2});
  description.lights.push_back(light);
  return description;
}

bool mentions(const Warnings& warnings, const std::string& item, const std::string& text) {
  return std::any_of(warnings.begin(), warnings.end(), [&](const Warning& w) {
    return w.item == item && w.message.find(text) != std::string::npos;
  });
}

void expect_refused(const SceneDescription& description, const std::string& item) {
  Warnings warnings;
  try {
    (void)compile(description, warnings, {}, 1);
    ADD_FAILURE() << "accepted: " << item;
  } catch (const SceneError& error) {
    EXPECT_EQ(error.item, item);
    EXPECT_NE(std::string(error.what()), "");
  }
}

TEST(SceneCompile, GoodSceneHasNoWarnings) {
  Warnings warnings;
  const auto scene = compile(simple(), warnings, {}, 1);
  ASSERT_TRUE(scene);
  for (const Warning& w : warnings) ADD_FAILURE() << w.item << ": " << w.message;
  EXPECT_EQ(scene->triangle_count(), 8u);
  EXPECT_EQ(scene->centre(), V3d(0));
}

TEST(SceneCompile, RefusesArraysThatDoNotFit) {
  const auto broken = [](auto&& breakage) {
    SceneDescription description = simple();
    breakage(description);
    return description;
  };
  expect_refused(broken([](auto& d) { d.meshes[0].triangles[3][1] = 99; }), "grid");
  expect_refused(broken([](auto& d) { d.meshes[0].normals.resize(5); }), "grid");
  expect_refused(broken([](auto& d) { d.meshes[0].material_slots.resize(9); }), "grid");
  expect_refused(broken([](auto& d) { d.meshes[0].uv_maps.push_back({"UV", std::vector<V2f>(8)}); }), "grid");
  expect_refused(broken([](auto& d) { d.meshes[0].colors.push_back({"Col", std::vector<Color>(1)}); }),
                 "grid");
  expect_refused(broken([](auto& d) { d.instances[0].mesh = 1; }), "Floor");
  expect_refused(broken([](auto& d) { d.instances[0].mesh = -2; }), "Floor");
  expect_refused(broken([](auto& d) { d.instances[0].materials = {0, 7}; }), "Floor");
  expect_refused(broken([](auto& d) { d.world.material = 1; }), "world");
  expect_refused(broken([](auto& d) { d.frame.width = 0; }), "frame");
  expect_refused(broken([](auto& d) { d.frame.x1 = d.frame.width + 1; }), "frame");
  expect_refused(broken([](auto& d) { d.frame.y1 = d.frame.y0; }), "frame");
  expect_refused(broken([](auto& d) { d.frame.filter_width = std::nanf(""); }), "frame");
  expect_refused(broken([](auto& d) { d.camera.name = "Cam", d.camera.lens = 0; }), "Cam");
  expect_refused(broken([](auto& d) { d.camera.name = "Cam", d.camera.matrix[3][1] = std::nan(""); }), "Cam");
  expect_refused(broken([](auto& d) { d.camera.name = "Cam", d.camera.clip_end = 0.01f; }), "Cam");
  expect_refused(broken([](auto& d) {
                   Image image;
                   image.name = "picture", image.width = 2, image.height = 2, image.rgba.resize(15);
                   d.images.push_back(image);
                 }),
                 "picture");
}

TEST(SceneCompile, DropsTrianglesThatAreNotFiniteByName) {
  SceneDescription description = simple();
  MeshDescription& mesh = description.meshes[0];
  mesh.positions.push_back({std::nanf(""), 0, 0});
  mesh.positions.push_back({0, infinity, 0});
  const auto bad = static_cast<std::uint32_t>(mesh.positions.size() - 2);
  mesh.triangles[2][0] = bad, mesh.triangles[5][2] = bad + 1;
  mesh.triangles[6] = {1, 1, 2};
  mesh.uv_maps.push_back({"UV", std::vector<V2f>(24)});
  for (std::size_t i = 0; i < 24; ++i) mesh.uv_maps[0].corners[i] = V2f(static_cast<float>(i), 0);
  Warnings warnings;
  const auto scene = compile(description, warnings, {}, 1);
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->triangle_count(), 5u);
  EXPECT_TRUE(mentions(warnings, "Floor", "3 of 8 triangles"));
  EXPECT_TRUE(mentions(warnings, "Floor", "2 with vertices that are not finite"));
  EXPECT_TRUE(mentions(warnings, "Floor", "1 without area"));
  EXPECT_TRUE(is_finite(scene->geometry_bounds().low) && is_finite(scene->geometry_bounds().high));
}

TEST(SceneCompile, LeavesOutSingularInstancesByName) {  // R6
  const SceneDescription good = simple();
  SceneDescription bad = good;
  place(bad, 0, scaling({1, 0, 1}), 0, "Flat");
  place(bad, 0, scaling({1, std::nan(""), 1}), 0, "Broken");
  Warnings warnings;
  const auto scene = compile(bad, warnings, {}, 1), reference = compiled(good);
  EXPECT_TRUE(mentions(warnings, "Flat", "left out (and 1 more"));
  EXPECT_EQ(scene->instance_count(), 1u);
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Ray ray{V3d(random.real(-1, 1), random.real(-1, 1), 1), random.direction()};
    const auto a = scene->intersect(ray), b = reference->intersect(ray);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (a) { EXPECT_EQ(a->t, b->t); }
  }
}

TEST(SceneCompile, HugeAndTinyScenes) {  // R3
  for (const double scale : {1e-8, 1e-4, 1e4, 1e8, 1e12}) {
    SceneDescription description;
    place(description, add(description, sphere(16)), scaling(V3d(scale)));
    const auto scene = compiled(description);
    Random random(3);
    int leaks = 0;
    for (int i = 0; i < 20000; ++i) {
      const auto hit = scene->intersect({V3d(random.direction()) * (0.5 * scale), random.direction()});
      leaks += !hit || !(hit->t < 2 * scale);
    }
    EXPECT_EQ(leaks, 0) << scale;
  }
  SceneDescription description = simple();
  place(description, 0, translation({1e17, 0, 0}), 0, "Lost");
  place(description, 0, scaling(V3d(1e16)), 0, "Vast");
  Warnings warnings;
  const auto scene = compile(description, warnings, {}, 1);
  EXPECT_TRUE(mentions(warnings, "Lost", "1e15 m"));
  EXPECT_EQ(scene->instance_count(), 1u);
}

#ifdef __SSE__
TEST(SceneCompile, LeavesTheFloatingPointModeAlone) {  // R12
  const unsigned before = _mm_getcsr() & ~0x3fu;       // without the sticky flags
  const auto scene = compiled(simple());
  (void)scene->intersect({V3d(0, 0, 1), V3f(0, 0, -1)});
  EXPECT_EQ(_mm_getcsr() & ~0x3fu, before);
}
#endif

TEST(SceneCompile, SaysWhatIsMissing) {
  Warnings warnings;
  EXPECT_TRUE(compile({}, warnings, {}, 1));
  EXPECT_TRUE(mentions(warnings, "scene", "no surface"));
  EXPECT_TRUE(mentions(warnings, "scene", "no light"));

  SceneDescription description = simple();
  description.instances[0].materials.clear();
  description.instances[0].matrix = scaling(V3d(1e8));
  warnings.clear();
  EXPECT_TRUE(compile(description, warnings, {}, 1));
  EXPECT_TRUE(mentions(warnings, "Floor", "no material"));
  EXPECT_TRUE(mentions(warnings, "scene", "m large"));
}

TEST(SceneCompile, BadLampsAreOff) {  // R5, R6
  const float bad[] = {std::nanf(""), infinity, -infinity, -1};
  for (const LightKind kind : {LightKind::Point, LightKind::Spot, LightKind::Sun, LightKind::Area})
    for (const float value : bad)
      for (int slot = 0; slot < 3; ++slot) {
        SceneDescription description = simple();
        LightDescription& light = description.lights[0];
        light.kind = kind;
        if (slot == 0) light.power = value;
        if (slot == 1) light.color.y = value;
        if (slot == 2) light.matrix[3][2] = std::isfinite(value) ? std::nan("") : static_cast<double>(value);
        Warnings warnings;
        const auto scene = compile(description, warnings, {}, 1);
        EXPECT_TRUE(scene->lights().empty());
        EXPECT_TRUE(mentions(warnings, "Lamp", "the light is off"));
      }
  SceneDescription description = simple();
  description.lights[0].kind = LightKind::Area, description.lights[0].size_x = 0;
  Warnings warnings;
  EXPECT_TRUE(compile(description, warnings, {}, 1)->lights().empty());
  EXPECT_TRUE(mentions(warnings, "Lamp", "no area"));
}

TEST(SceneCompile, GarbageMeshes) {  // R7
  Random random(2);
  std::size_t hits = 0;
  for (int n = 0; n < 300; ++n) {
    SceneDescription description;
    MeshDescription mesh;
    mesh.name = "garbage";
    const auto number = [&]() -> float {
      const auto kind = random.bits() % 16;
      if (kind == 0) return std::nanf("");
      if (kind == 1) return infinity;
      if (kind == 2) return 1e38f;
      if (kind == 3) return 1e-40f;
      return static_cast<float>(random.real(-1, 1));
    };
    for (int i = 0; i < 30; ++i) mesh.positions.emplace_back(number(), number(), number());
    for (int i = 0; i < 60; ++i)
      mesh.triangles.push_back({random.bits() % 30, random.bits() % 30, random.bits() % 30});
    for (int i = 0; i < 180; ++i) mesh.normals.emplace_back(number(), number(), number());
    place(description, add(description, mesh), scaling(V3d(random.real(0.1, 2))));
    Warnings warnings;
    const auto scene = compile(description, warnings, {}, 1);
    ASSERT_TRUE(scene);
    SurfacePoint point;
    for (int i = 0; i < 200; ++i) {
      const V3f d = random.direction();
      const auto hit = scene->intersect({V3d(random.direction()) * 0.5, d});
      if (!hit) continue;
      ++hits;
      scene->surface_point(*hit, -d, false, point);
      ASSERT_TRUE(is_finite(hit->position) && std::isfinite(hit->t) && is_finite(hit->ng) &&
                  is_finite(point.ns));
      ASSERT_NEAR(hit->ng.length(), 1, 1e-4);
      ASSERT_NEAR(point.ns.length(), 1, 1e-4);
      ASSERT_GE(point.ng.dot(point.wo), 0);
    }
  }
  EXPECT_GT(hits, 1000u);
}

TEST(SceneCompile, CancelStopsEarly) {
  SceneDescription description;
  for (int i = 0; i < 20; ++i) place(description, add(description, sphere(60)), translation({3.0 * i, 0, 0}));
  for (const int polls : {0, 1, 2, 3, 8}) {
    std::atomic<int> asked = 0;
    Warnings warnings;
    EXPECT_FALSE(compile(description, warnings, [&] { return ++asked > polls; }, 2));
    EXPECT_LE(asked, polls + 4);
  }
}

TEST(SceneCompile, EntitiesBearTheirNames) {
  SceneDescription description = simple();
  const int glow = add(description, glowing(Color(1), 3));
  for (int i = 0; i < 3; ++i) place(description, 0, translation({3.0 + 3 * i, 0, 0}), glow, "Leaf");
  place(description, 0, translation({-3, 0, 0}), 0, "Leaf").names = {"Leaf", "Tree"};
  description.world.name = "Sky";
  description.world.material = add(description, background(Color(1), 1));
  const auto scene = compiled(description);
  std::vector<std::vector<std::string>> names;
  for (const Entity& entity : scene->entities()) names.push_back(entity.names);
  EXPECT_EQ(names, (std::vector<std::vector<std::string>>{
                       {"Floor"}, {"Leaf"}, {"Leaf", "Tree"}, {"Lamp"}, {"Sky"}}));
  ASSERT_EQ(scene->lights().size(), 5u);
  for (std::uint32_t i = 1; i <= 3; ++i) { EXPECT_EQ(scene->light_entity(scene->mesh_light(i)), 1); }
  EXPECT_EQ(scene->mesh_light(0), -1);
  EXPECT_EQ(scene->light_entity(scene->world_light()), 4);
  const auto hit = scene->intersect({V3d(-3.1, 0.2, 1), V3f(0, 0, -1)});
  ASSERT_TRUE(hit);
  EXPECT_EQ(scene->entity(*hit), 2);
}

// Edits that are off, and ordinary quads, must not move the origin: that would change bits of an image they
// do not touch.
TEST(SceneCompile, OriginIsMovedOnlyWhereNeeded) {
  SceneDescription description = simple();
  EditDescription edit;
  edit.expression = "L S+";
  edit.entry.name = "Entry", edit.entry.matrix = translation({0.3, 0, 0}), edit.entry.half_size = 0.1;
  description.edits.push_back(edit);
  EXPECT_EQ(compiled(description)->centre(), V3d(0));
  for (auto& instance : description.instances) instance.matrix = translation({1e6, 2e6, 0});
  const auto scene = compiled(description);
  EXPECT_NEAR((scene->centre() - V3d(1e6, 2e6, 0)).length(), 0, 2);
  const auto hit = scene->intersect({V3d(1e6 + 0.25, 2e6 + 0.25, 1) - scene->centre(), V3f(0, 0, -1)});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->position.x + scene->centre().x, 1e6 + 0.25, 1e-9);
}

}  // namespace
}  // namespace sluice::test
