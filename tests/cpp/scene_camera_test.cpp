// SPDX-License-Identifier: GPL-3.0-or-later
// Cameras against Blender's own numbers, depth of field, clipping, footprints, pixel filters.
#include "scene_fixtures.h"

namespace sluice::test {
namespace {

// Made in Blender 3.4.1: random cameras (type, fit, lens, sensor, scale, shift), resolutions, pixel aspects
// and placements, a point in front of each, and bpy_extras.object_utils.world_to_camera_view(scene, camera,
// point); matrices by rows for row vectors, three columns.
struct Row {
  int kind, fit;
  float lens, sensor_width, sensor_height, ortho_scale, shift_x, shift_y;
  int width, height;
  float aspect_x, aspect_y;
  double matrix[12];
  double point[3];
  double x, y, z;
};
constexpr Row blender[] = {
    {0,
     0,
     36.523,
     22.063,
     19.129,
     3.085,
     -0.347,
     -0.079,
     500,
     500,
     1,
     1,
     {-0.0034956059, 0.0076462673, 1.99998236, 0.95548594, -1.15629125, 0.00609071087, 0.385434777,
      0.318496048, -0.000543993665, -1.66799998, 0.219999999, -1.34000003},
     {-5.27968979, -3.61351562, -0.476648897},
     1.11777937,
     0.787389159,
     5.22700024},
    {0,
     1,
     76.031,
     23.869,
     17.577,
     6.389,
     0.186,
     0.284,
     500,
     500,
     1,
     1,
     {0.338335931, -0.40927282, 0.847363293, 0.868945837, -0.209749445, -0.44826147, 0.361195207, 0.887975752,
      0.284670144, 2.06900001, -0.976000011, -0.671999991},
     {0.83869499, -6.59597635, -1.84605038},
     0.804860115,
     0.567166567,
     5.76900005},
    {0,
     2,
     78.832,
     20.144,
     17.255,
     6.934,
     -0.151,
     0.212,
     360,
     640,
     2,
     1,
     {0.425699532, 1.06335473, 1.63952935, -0.272030592, 1.26886392, -0.752319038, -0.480053604,
      -0.0209567137, 0.138236627, -0.458000004, -1.27100003, -0.291999996},
     {5.12827539, -1.52892745, -2.59742165},
     0.0660863966,
     0.230796486,
     5.98999977},
    {1,
     0,
     56.321,
     32.96,
     24.616,
     3.015,
     0.139,
     -0.347,
     360,
     640,
     1,
     1.5,
     {0.733237505, 0.174779356, 0.657126307, -0.661312222, 0.408145458, 0.629351616, -0.15820545, -0.89602983,
      0.414851248, 0.796000004, -1.34200001, -0.86500001},
     {2.27224588, 0.486179769, -1.76736355},
     0.844866693,
     0.582323372,
     2.24600029},
    {0,
     1,
     36.021,
     35.303,
     23.078,
     3.662,
     -0.135,
     -0.258,
     640,
     500,
     1,
     1,
     {-0.312587351, 1.13740444, -1.61511624, 0.0441534221, 1.22988701, 0.857571244, 0.493635952, 0.0327921659,
      -0.072444573, -2.74300003, 1.18400002, 2.37599993},
     {-8.39411736, -0.0948236287, 3.76285243},
     0.467263639,
     0.736251891,
     5.86399984},
    {0,
     2,
     74.267,
     28.209,
     28.98,
     6.344,
     0.254,
     -0.165,
     360,
     640,
     2,
     1,
     {0.817935228, -0.498110354, -0.287868142, -0.133831024, 0.321904182, -0.937265694, 0.559527695,
      0.805148304, 0.196634158, -1.24800003, -1.5, 0.592999995},
     {-4.20453596, -5.74254274, -0.153870538},
     0.234924451,
     0.532370508,
     5.21700001},
    {0,
     0,
     89.803,
     31.429,
     19.908,
     3.451,
     0.333,
     -0.309,
     640,
     360,
     1,
     1,
     {1.85916066, 0.63888675, -0.36789307, -0.336085409, 1.32884765, 0.609270453, 0.14635478, -0.168181375,
      0.447543621, 1.42299998, 0.573000014, 2.82399988},
     {-0.263487756, 1.43179977, -2.26654387},
     -0.0240594298,
     0.165452883,
     5.3390007},
    {1,
     1,
     40.504,
     39.938,
     23.729,
     3.402,
     -0.239,
     -0.049,
     640,
     500,
     1,
     1,
     {0.132934675, -0.398743093, 0.907376587, 0.991113603, 0.0578325912, -0.1197882, -0.00471122237,
      0.915237308, 0.402887672, -1.68599999, -0.338999987, 0.88499999},
     {-2.27838635, -3.7534945, -1.54922366},
     0.466807216,
     0.377229095,
     4.10300016},
    {0,
     2,
     74.062,
     28.343,
     16.71,
     4.275,
     0.313,
     -0.148,
     640,
     360,
     1,
     1.5,
     {1.11541045, -0.0256589651, -1.6598798, 1.15620232, 0.568441033, 0.76816082, 0.153972268, -0.462661922,
      0.110618673, -0.582000017, 2.4059999, 0.924000025},
     {-3.17365074, 7.28205824, 0.0878740251},
     -0.318068027,
     0.181792587,
     5.49499989},
    {0,
     0,
     82.983,
     38.492,
     18.059,
     6.598,
     0.24,
     0.114,
     640,
     500,
     1,
     1.5,
     {0.908459365, -0.0127192633, 0.417779565, 0.262656122, 0.794898987, -0.546943665, -0.325135827,
      0.60660845, 0.725474238, -1.70899999, 1.80799997, 1.80700004},
     {0.293484569, -1.28728616, -0.925411224},
     0.620306075,
     0.175719783,
     4.51100063},
    {0,
     1,
     33.388,
     27.896,
     23.152,
     7.368,
     -0.184,
     0.285,
     360,
     640,
     1,
     1.5,
     {-0.347911924, -0.787083328, 1.80539668, 0.351770282, 1.31061912, 0.639167786, -0.478210926, 0.14290984,
      -0.029851241, 0.81099999, 0.414999992, 1.47899997},
     {5.70165014, -2.34229445, 2.15546918},
     0.867683053,
     0.313728362,
     5.50600052},
    {1,
     2,
     28.112,
     36.197,
     26.093,
     8.145,
     0.04,
     0.303,
     360,
     640,
     1,
     1,
     {0.987932742, 0.105114855, 0.113753237, -0.149055138, 0.445666313, 0.882702708, 0.0420891792,
      -0.889006436, 0.45595625, 1.02900004, -1.01600003, 2.35100007},
     {0.0480806828, 2.36116529, -0.575579524},
     0.222190887,
     0.0825739801,
     4.37799978},
};

struct View {
  CameraDescription camera;
  FrameDescription frame;
};
View view_of(const Row& row) {
  View view;
  view.camera.kind = static_cast<CameraKind>(row.kind);
  view.camera.sensor_fit = static_cast<SensorFit>(row.fit);
  view.camera.lens = row.lens, view.camera.sensor_width = row.sensor_width;
  view.camera.sensor_height = row.sensor_height;
  view.camera.ortho_scale = row.ortho_scale, view.camera.shift_x = row.shift_x;
  view.camera.shift_y = row.shift_y;
  for (int i = 0; i < 12; ++i) view.camera.matrix[i / 3][i % 3] = row.matrix[i];
  view.frame.width = row.width, view.frame.height = row.height;
  view.frame.pixel_aspect_x = row.aspect_x, view.frame.pixel_aspect_y = row.aspect_y;
  return view;
}

TEST(SceneCamera, ProjectsAsBlender) {
  for (const Row& row : blender) {
    const View view = view_of(row);
    const V3d centre(0.25, -4, 1);
    const Camera camera(view.camera, view.frame, centre);
    const V3d point = V3d(row.point[0], row.point[1], row.point[2]) - centre;
    const auto pixel = camera.project(point);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x / row.width, row.x, 2e-6);
    EXPECT_NEAR(pixel->y / row.height, row.y, 2e-6);
    EXPECT_NEAR(camera.depth(point), row.z, 2e-6 * row.z);
    // and back: the ray of that pixel passes through the point
    const Ray made =
        camera.generate(static_cast<float>(pixel->x), static_cast<float>(pixel->y), {0.5f, 0.5f});
    const V3d to = point - made.origin, d(made.direction);
    EXPECT_LT((to - d * to.dot(d)).length(), 1e-5 * row.z);
    EXPECT_NEAR(camera.depth(made.origin), 0.1, 1e-6);
    EXPECT_NEAR(camera.depth(made.origin + d * made.t_max), 1000, 1e-3);
    EXPECT_TRUE(made.from_camera);
  }
}

TEST(SceneCamera, FootprintIsTheDistanceToTheNextPixel) {
  for (const Row& row : blender) {
    const View view = view_of(row);
    const Camera camera(view.camera, view.frame, V3d(0));
    const float x = 0.3f * static_cast<float>(row.width), y = 0.6f * static_cast<float>(row.height);
    const auto at = [&](float dx, float dy) { return camera.generate(x + dx, y + dy, {0, 0}); };
    // area between four neighbouring rays, 50 m away, seen along the ray
    const Ray ray = at(0.5f, 0.5f);
    const double t = 50;
    const auto point = [&](float dx, float dy) {
      const Ray r = at(dx, dy);
      const V3d d(r.direction), n(ray.direction);
      const V3d target = ray.origin + n * t;
      return r.origin + d * ((target - r.origin).dot(n) / d.dot(n));
    };
    const double side = std::sqrt(((point(1, 0) - point(0, 0)).cross(point(0, 1) - point(0, 0))).length());
    EXPECT_NEAR(camera.footprint(ray.origin + V3d(ray.direction) * t) / side, 1, 0.01);
  }
}

TEST(SceneCamera, LensFocusesOnThePlane) {
  for (const int blades : {0, 5, 6}) {
    CameraDescription description;
    description.matrix = rotation(1, 0.3, 0.2) * translation({1, 2, 3});
    description.aperture_radius = 0.3f, description.focus_distance = 7, description.aperture_blades = blades;
    description.aperture_rotation = 0.4f, description.aperture_ratio = 2;
    FrameDescription frame;
    const Camera camera(description, frame, V3d(0));
    Random random(1);
    const Ray centre = [&] {
      CameraDescription pinhole = description;
      pinhole.aperture_radius = 0;
      return Camera(pinhole, frame, V3d(0)).generate(200, 100, {0, 0});
    }();
    const auto at_depth = [&](const Ray& ray, double depth) {
      return ray.origin + V3d(ray.direction) *
                              ((depth - camera.depth(ray.origin)) /
                               (camera.depth(ray.origin + V3d(ray.direction)) - camera.depth(ray.origin)));
    };
    Mean x2, y2, inside;
    for (int i = 0; i < 100000; ++i) {
      const Ray ray = camera.generate(200, 100, random.pair());
      EXPECT_LT((at_depth(ray, 7) - at_depth(centre, 7)).length(), 1e-5);
      const V3d on_lens = at_depth(ray, 0) - camera.position();
      const double x =
          on_lens.dot(V3d(description.matrix[0][0], description.matrix[0][1], description.matrix[0][2])) * 2 /
          0.3;
      const double y =
          on_lens.dot(V3d(description.matrix[1][0], description.matrix[1][1], description.matrix[1][2])) /
          0.3;
      x2.add(x * x), y2.add(y * y);
      EXPECT_LE(x * x + y * y, 1.00001);
    }
    // second moment of a disk, and of a regular polygon of unit circumradius: (2 + cos(2 pi / n)) / 12 · 2
    // per axis
    const double moment = blades == 0 ? 0.25 : (2 + std::cos(2 * std::numbers::pi / blades)) / 12;
    expect_mean(x2, moment, "x²", 1e-4);
    expect_mean(y2, moment, "y²", 1e-4);
  }
}

TEST(SceneCamera, FilterIsBlackmanHarris) {
  FrameDescription frame;
  // Cycles' window is twice as wide (measured against its pictures: tests/blender/test_cycles.py)
  frame.filter_width = 1.5f;
  const PixelFilter filter(frame);
  Random random(2);
  const auto window = [](double x) {
    const double a = 2 * std::numbers::pi * (x / 3 + 0.5);
    return 0.35875 - 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) - 0.01168 * std::cos(3 * a);
  };
  double total = 0, square_sum = 0;
  constexpr int steps = 10000;
  for (int i = 0; i < steps; ++i) {
    const double x = -1.5 + 3 * (i + 0.5) / steps;
    total += window(x), square_sum += window(x) * x * x;
  }
  Mean x, x2, y2, xy;
  for (int i = 0; i < 1000000; ++i) {
    const V2f offset = filter.sample_filter(random.pair());
    ASSERT_LE(std::max(std::abs(offset.x), std::abs(offset.y)), 1.5f);
    x.add(offset.x), x2.add(offset.x * offset.x), y2.add(offset.y * offset.y), xy.add(offset.x * offset.y);
  }
  EXPECT_NEAR(x.value(), 0, 4 * x.error());
  EXPECT_NEAR(xy.value(), 0, 4 * xy.error());
  expect_mean(x2, square_sum / total, "variance", 1e-3);
  expect_mean(y2, square_sum / total, "variance", 1e-3);

  frame.filter_box = true;
  const V2f corner = PixelFilter(frame).sample_filter({0, 0.75f});
  EXPECT_EQ(corner, V2f(-0.5f, 0.25f));
}

}  // namespace
}  // namespace sluice::test
