// SPDX-License-Identifier: GPL-3.0-or-later
// What a hit tells the material: normals, layers, gradients, object coordinates.
#include "scene_fixtures.h"

namespace sluice::test {
namespace {

TEST(SceneSurface, SmoothNormalsOfASphere) {
  MeshDescription mesh = sphere(12);
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) mesh.normals.push_back(mesh.positions[corner]);
  // an ellipsoid, turned, mirrored: its normal at p is M^-T p_local
  const M44d matrix = scaling({-2, 1, 0.5}) * rotation(0.3, 1, 2) * translation({1, 2, 3});
  SceneDescription description;
  place(description, add(description, mesh), matrix);
  const auto scene = compiled(description);
  Random random(1);
  int hits = 0;
  SurfacePoint point;
  for (int i = 0; i < 20000; ++i) {
    const V3f d = random.direction();
    const V3d from =
        V3d(1, 2, 3) - scene->centre() - V3d(d) * 5.0 + V3d(random.direction()) * random.real(0, 1.5);
    const auto hit = scene->intersect({from, d});
    if (!hit) continue;
    ++hits;
    scene->surface_point(*hit, -d, false, point);
    EXPECT_TRUE(point.front);
    EXPECT_GT(point.ng.dot(point.wo), 0);
    EXPECT_GT(point.ns.dot(point.wo), 0);
    EXPECT_GT(point.ns.dot(point.ng), 0);
    if (point.ns.dot(point.wo) < 0.02f) continue;
    const V3d local = (hit->position + scene->centre()) * matrix.inverse();
    const M44d to_normal = matrix.inverse().transposed();
    V3d normal;
    to_normal.multDirMatrix(local, normal);
    EXPECT_GT(normal.normalized().dot(V3d(point.ns)), 0.999);
    // from inside both normals turn
    const auto back = scene->intersect(ray_from(*hit, d));
    if (!back) continue;
    scene->surface_point(*back, -d, false, point);
    EXPECT_FALSE(point.front);
    EXPECT_GE(point.ng.dot(point.wo), 0);
    EXPECT_GT(point.ns.dot(point.wo), 0);
  }
  EXPECT_GT(hits, 5000);
}

TEST(SceneSurface, FilledAsTheMaterialNeeds) {
  MeshDescription mesh = grid(4);
  mesh.uv_maps = {{"First", {}}, {"Second", {}}};
  mesh.colors = {{"Paint", {}}};
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) {
      const V3f p = mesh.positions[corner];
      mesh.uv_maps[0].corners.emplace_back(p.x, p.y);
      mesh.uv_maps[1].corners.emplace_back(0.5f + 2 * p.x - p.y, 3 * p.y);
      mesh.colors[0].corners.emplace_back(p.x, p.y, 0.25f);
    }
  MaterialDescription material;  // an image laid by "Second" with a normal map, tinted by "Paint"
  material.name = "layers";
  material.nodes.push_back(
      {"BsdfDiffuse",
       "BSDF",
       {{"Color", {}, 1, "Color"}, {"Roughness", {}, -1, {}}, {"Normal", {}, 2, "Normal"}},
       {},
       {},
       -1});
  material.nodes.push_back(
      {"Attribute", "Paint", {}, {{"attribute_name", "Paint"}, {"attribute_type", "GEOMETRY"}}, {}, -1});
  material.nodes.push_back({"NormalMap",
                            "Normal Map",
                            {{"Strength", {1, 1, 1, 1}, -1, {}}, {"Color", {0.6f, 0.5f, 1, 1}, -1, {}}},
                            {{"space", "TANGENT"}, {"uv_map", "Second"}},
                            {},
                            -1});
  material.surface = 0;
  SceneDescription description;
  const M44d matrix = scaling({2, 0.5, 1}) * rotation(0.2, 0.7, -0.4) * translation({5, 1, 0});
  InstanceDescription& instance =
      place(description, add(description, mesh), matrix, add(description, material));
  instance.color = {0.1f, 0.2f, 0.3f}, instance.random = 0.75f, instance.object_index = 7;
  const auto scene = compiled(description);
  const MaterialNeeds& needs = scene->materials()[0].needs();
  ASSERT_EQ(needs.uv_maps, std::vector<std::string>{"Second"});
  ASSERT_EQ(needs.color_layers, std::vector<std::string>{"Paint"});
  ASSERT_TRUE(needs.uv_gradients);
  const auto uv_of = [](const V3d& local) { return V2d(0.5 + 2 * local.x - local.y, 3 * local.y); };
  Random random(2);
  SurfacePoint point;
  for (int i = 0; i < 200; ++i) {
    const V3d local(random.real(-0.9, 0.9), random.real(-0.9, 0.9), 0);
    const V3d world = local * matrix;
    V3d up;
    matrix.multDirMatrix(V3d(0, 0, 1), up);
    const auto hit = scene->intersect({world + up - scene->centre(), V3f(-up.normalized())});
    ASSERT_TRUE(hit);
    scene->surface_point(*hit, V3f(up.normalized()), true, point);
    EXPECT_TRUE(point.camera_ray);
    EXPECT_NEAR((V3d(point.position) - world).length(), 0, 1e-5);
    EXPECT_NEAR((V2d(point.uv[0].uv) - uv_of(local)).length(), 0, 1e-5);
    EXPECT_NEAR((V3d(point.colors[0]) - V3d(local.x, local.y, 0.25)).length(), 0, 1e-5);
    // gradients: a step along the surface changes uv by grad · step
    V3d step;
    const V3d local_step(0.01, -0.02, 0);
    matrix.multDirMatrix(local_step, step);
    const V2d change = uv_of(local + local_step) - uv_of(local);
    EXPECT_NEAR(V3d(point.uv[0].grad_u).dot(step), change.x, 1e-5);
    EXPECT_NEAR(V3d(point.uv[0].grad_v).dot(step), change.y, 1e-5);
    ASSERT_NE(point.object, nullptr);
    EXPECT_EQ(point.object->color, V3f(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(point.object->object_index, 7);
    EXPECT_NEAR((V3d(point.position * point.object->world_to_object) - local).length(), 0, 1e-5);
  }
}

TEST(SceneSurface, SlotsChooseMaterials) {
  MeshDescription mesh = grid(1);
  mesh.material_slots = {0, 5};  // a slot that is gone: the last one
  SceneDescription description;
  const int red = add(description, diffuse(0.1f)), glow = add(description, glowing(Color(1), 2));
  InstanceDescription& instance = place(description, add(description, mesh), {}, red);
  instance.materials = {red, glow};
  const auto scene = compiled(description);
  const auto lower = scene->intersect({V3d(0.5, -0.5, 1), V3f(0, 0, -1)}),
             upper = scene->intersect({V3d(-0.5, 0.5, 1), V3f(0, 0, -1)});
  ASSERT_TRUE(lower && upper);
  EXPECT_FALSE(scene->material(*lower).emits());
  EXPECT_TRUE(scene->material(*upper).emits());
  EXPECT_EQ(scene->instance_materials(0).size(), 2u);
  ASSERT_EQ(scene->lights().size(), 1u);
  EXPECT_NEAR(scene->lights()[0].power, 2 * pi * 2 * 2, 1e-4);  // both sides of half of the square
}

}  // namespace
}  // namespace sluice::test
