// SPDX-License-Identifier: GPL-3.0-or-later
// Rays against surfaces: no self-hits, no leaks, no aborts, exact positions (numerics R1, R2, R4), instances
// and visibility.
#include <bit>

#include "scene_fixtures.h"

namespace sluice::test {
namespace {

M44d random_matrix(Random& random, double size, double reach) {
  const auto factor = [&] { return size * std::exp2(random.real(-2, 2)) * (random.unit() < 0.5f ? -1 : 1); };
  return scaling({factor(), factor(), factor()}) *
         rotation(random.real(-3, 3), random.real(-3, 3), random.real(-3, 3)) *
         translation({random.real(-reach, reach), random.real(-reach, reach), random.real(-reach, reach)});
}

// Leaves a convex shape outwards: meets nothing. Enters it: meets another triangle than its own.
struct SelfHits {
  int rays = 0, outside = 0, own = 0, lost = 0;
};
void leave_shape(const Scene& scene, const Bounds& bounds, Random& random, int rays, SelfHits& count) {
  for (int i = 0; i < rays; ++i) {
    const double radius = bounds.diagonal();
    const V3f towards = random.direction();
    V3d target = bounds.middle();
    for (int k = 0; k < 3; ++k) target[k] += 0.3 * (bounds.high[k] - bounds.low[k]) * random.real(-1, 1);
    const auto hit = scene.intersect({target - V3d(towards) * radius, towards});
    if (!hit) continue;
    ++count.rays;
    const V3f d = random.direction();
    const auto next = scene.intersect(ray_from(*hit, d));
    const double cosine = d.dot(hit->ng);
    if (cosine > 0 && next && next->instance == hit->instance) ++count.outside;
    if (cosine < 0 && next && next->instance == hit->instance && next->triangle == hit->triangle) ++count.own;
    if (cosine < -1e-3 && !next) ++count.lost;
  }
}

TEST(SceneRay, ConvexShapesDoNotMeetThemselves) {  // R1
  Random random(1);
  SelfHits count;
  for (int shape = 0; shape < 1000; ++shape) {
    SceneDescription description;
    const double size = std::pow(10.0, random.real(-3, 3));
    place(description, add(description, sphere(3 + shape % 12)),
          random_matrix(random, size, size * random.real(0, 30)));
    const auto scene = compiled(description);
    leave_shape(*scene, scene->geometry_bounds(), random, 1000, count);
  }
  EXPECT_GT(count.rays, 300000);
  EXPECT_EQ(count.outside, 0);
  EXPECT_EQ(count.own, 0);
  EXPECT_LE(count.lost, count.rays / 100000);  // rays into the sliver at a silhouette may leave again at once
}

TEST(SceneRay, PlacedShapesDoNotMeetThemselves) {
  Random random(2);
  SceneDescription description;
  const int mesh = add(description, sphere(20));
  for (int i = 0; i < 64; ++i) {
    const double size = std::pow(10.0, random.real(-1, 1));
    place(description, mesh,
          random_matrix(random, size, 1) * translation({100.0 * (i % 8), 100.0 * (i / 8), 0}));
  }
  const auto scene = compiled(description);
  SelfHits count;
  for (std::uint32_t i = 0; i < scene->instance_count(); ++i) {
    Bounds near = scene->instance_bounds(i);
    leave_shape(*scene, near, random, 4000, count);
  }
  EXPECT_GT(count.rays, 60000);
  EXPECT_EQ(count.outside, 0);
  EXPECT_EQ(count.own, 0);
  // a placed mesh far from the origin is known to its matrix' floats only
  EXPECT_LE(count.lost, count.rays / 1000);
}

TEST(SceneRay, ClosedSphereDoesNotLeakFarFromTheOrigin) {  // R2
  for (const double offset : {0.0, 1e4, 1e6}) {
    SceneDescription description;
    const int mesh = add(description, sphere(24));
    place(description, mesh, scaling({2, 2, 2}) * translation({offset, offset, -offset}));
    place(description, mesh, scaling(V3d(1e-3)), -1, "keeps the origin at 0");
    const auto scene = compiled(description);
    Random random(3);
    int leaks = 0;
    for (int i = 0; i < 700000; ++i) {
      const V3d from =
          V3d(offset, offset, -offset) - scene->centre() + V3d(random.direction()) * random.real(0, 1.5);
      leaks += !scene->intersect({from, random.direction()});
    }
    EXPECT_EQ(leaks, 0) << "at " << offset;
  }
}

TEST(SceneRay, SurvivesRandomBits) {  // R4
  SceneDescription description;
  place(description, add(description, sphere(8)));
  const auto scene = compiled(description);
  Random random(4);
  const auto any = [&] { return std::bit_cast<float>(random.bits()); };
  const auto any_double = [&] {
    return std::bit_cast<double>((std::uint64_t{random.bits()} << 32) | random.bits());
  };
  int hits = 0;
  for (int i = 0; i < 2000000; ++i) {
    Ray ray{V3d(any_double(), any_double(), any_double()), V3f(any(), any(), any()), any_double(),
            V3f(any(), any(), any()), (i & 1) != 0};
    if (i % 3 == 0) ray = {V3d(any(), any(), any()), random.direction(), any(), V3f(0), false};
    if (const auto hit = scene->intersect(ray)) hits += is_finite(hit->position) && std::isfinite(hit->t);
    const Color left = scene->transmittance(ray).value();
    ASSERT_TRUE(is_finite(left));
  }
  EXPECT_GE(hits, 0);
}

TEST(SceneRay, DistanceIsDouble) {
  SceneDescription description;
  place(description, add(description, grid()), scaling({1000, 1000, 1}) * translation({0, 0, 0.5}));
  const auto scene = compiled(description);
  Random random(5);
  for (int i = 0; i < 10000; ++i) {
    const V3d from(random.real(-50, 50), random.real(-50, 50), random.real(1, 700));
    const V3f d = V3f(static_cast<float>(random.real(-1, 1)), static_cast<float>(random.real(-1, 1)), -0.9f)
                      .normalized();
    const auto hit = scene->intersect({from, d});
    ASSERT_TRUE(hit);
    const double t = (0.5 - from.z) / static_cast<double>(d.z);
    EXPECT_NEAR(hit->t, t, 1e-13 * t);
    EXPECT_NEAR(hit->position.z, 0.5, 1e-12);
    EXPECT_EQ(hit->ng, V3f(0, 0, 1));
  }
}

TEST(SceneRay, InstancesAreCopies) {
  Random random(6);
  const MeshDescription mesh = sphere(20);
  SceneDescription placed, copied;
  const int shared = add(placed, mesh);
  for (int i = 0; i < 40; ++i) {
    const M44d matrix = random_matrix(random, 0.3, 4);
    place(placed, shared, matrix);
    place(copied, add(copied, mesh), matrix);
  }
  const auto a = compiled(placed), b = compiled(copied);
  int hits = 0, differ = 0;
  for (int i = 0; i < 200000; ++i) {
    const Ray ray{V3d(random.direction()) * 6.0, random.direction()};
    const auto x = a->intersect(ray), y = b->intersect(ray);
    if (x.has_value() != y.has_value()) {
      ++differ;
      continue;
    }
    if (!x) continue;
    ++hits;
    if (x->instance != y->instance || std::abs(x->t - y->t) > 2e-5)
      ++differ;
    else if (x->triangle == y->triangle)
      differ += x->ng.dot(y->ng) < 0.9999f;
  }
  EXPECT_GT(hits, 5000);
  EXPECT_LE(differ, hits / 1000);  // silhouettes
}

TEST(SceneRay, MirroredObjectsKeepTheirOutside) {
  SceneDescription description;
  const int mesh = add(description, sphere(12));
  place(description, mesh, scaling({-1, 1, 1}));
  const auto scene = compiled(description);
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const V3f d = random.direction();
    const auto hit = scene->intersect({V3d(d) * -3.0, d});
    ASSERT_TRUE(hit);
    EXPECT_GT(hit->ng.dot(V3f(hit->position)), 0);
  }
}

TEST(SceneRay, CameraAndShadowVisibility) {
  SceneDescription description;
  const int mesh = add(description, grid());
  place(description, mesh, translation({0, 0, 3}), -1, "hidden").visible_to_camera = false;
  place(description, mesh, translation({0, 0, 2}), -1, "shadowless").casts_shadow = false;
  place(description, mesh, translation({0, 0, 0}), -1, "plain");
  const auto scene = compiled(description);
  Ray ray{V3d(0.1, 0.2, 5), V3f(0, 0, -1)};
  EXPECT_DOUBLE_EQ(scene->intersect(ray)->t, 2);
  ray.from_camera = true;
  EXPECT_DOUBLE_EQ(scene->intersect(ray)->t, 3);
  ray.from_camera = false;
  ray.origin.z = 2.5;
  ray.t_max = 1;
  EXPECT_EQ(scene->transmittance(ray), Color(1));  // only the shadowless one
  ray.t_max = 3;
  EXPECT_EQ(scene->transmittance(ray), Color(0));
  ray = {V3d(0.1, 0.2, 5), V3f(0, 0, -1), 2.5};
  EXPECT_EQ(scene->transmittance(ray), Color(0));  // hidden from the camera, still a shadow
}

TEST(SceneRay, TransmittanceMultiplies) {
  SceneDescription description;
  const int glass = add(description, see_through({0.5f, 0.25f, 1})), wall = add(description, diffuse(0.5f));
  const int mesh = add(description, grid());
  for (int i = 0; i < 5; ++i)
    place(description, mesh, rotation(0.1 * i, 0.2, 0) * translation({0, 0, 0.5 * i}), glass);
  place(description, mesh, translation({0, 0, 4}), wall);
  const auto scene = compiled(description);
  for (int n = 0; n <= 5; ++n) {
    const Color left = scene->transmittance({V3d(0.1, 0.05, -1), V3f(0, 0, 1), 0.75 + 0.5 * n}).value();
    const Color expected(std::pow(0.5f, static_cast<float>(n)), std::pow(0.25f, static_cast<float>(n)), 1);
    EXPECT_EQ(left, expected) << n;
  }
  EXPECT_EQ(scene->transmittance({V3d(0.1, 0.05, -1), V3f(0, 0, 1), 5.5}), Color(0));
  EXPECT_EQ(scene->transmittance({V3d(0.1, 0.05, -1), V3f(0, 0, 1), 4.5}), Color(1.0f / 32, 1.0f / 1024, 1));
}

// As many as any other segment.
TEST(SceneRay, TransmittanceFollowsSoManyLayers) {
  for (const int layers : {max_alpha_layers - 1, max_alpha_layers}) {
    SceneDescription description;
    const int glass = add(description, see_through(Color(1))), mesh = add(description, grid());
    for (int i = 0; i < layers; ++i) place(description, mesh, translation({0, 0, 0.1 * i}), glass);
    const auto left = compiled(description)->transmittance({V3d(0.1, 0.05, -1), V3f(0, 0, 1), 1000});
    EXPECT_EQ(left.has_value(), layers < max_alpha_layers) << layers;
  }
}

}  // namespace
}  // namespace sluice::test
