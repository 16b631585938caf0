// SPDX-License-Identifier: GPL-3.0-or-later
// A ray from the camera that meets a gate must start in a pixel that says so, whatever camera it is; and most
// pixels must not.
#include "scene/gates_in_view.h"

#include "edit_scene.h"
#include "scene_fixtures.h"

namespace sluice::test {
namespace {

CameraDescription random_camera(Random& random, bool has_lens) {
  CameraDescription camera;
  camera.kind = random.unit() < 0.6f ? CameraKind::Perspective : CameraKind::Orthographic;
  camera.matrix = rotation(random.real(0, 6), random.real(0, 6), random.real(0, 6)) *
                  translation({random.real(-2, 2), random.real(-2, 2), random.real(-2, 2)});
  camera.lens = static_cast<float>(random.real(12, 90));
  camera.ortho_scale = static_cast<float>(random.real(1, 8));
  camera.shift_x = static_cast<float>(random.real(-0.4, 0.4));
  camera.shift_y = static_cast<float>(random.real(-0.4, 0.4));
  camera.clip_start = camera.kind == CameraKind::Orthographic && random.unit() < 0.3f ? -4 : 0.001f;
  if (has_lens) {
    camera.aperture_radius = static_cast<float>(random.real(0.01, 1));
    camera.focus_distance = static_cast<float>(random.real(0.5, 6));
    camera.aperture_ratio = static_cast<float>(random.real(0.5, 2));
    camera.aperture_blades = random.unit() < 0.5f ? 0 : 5;
  }
  return camera;
}

// One edit of each side at random places: the exit of one, the entry of the other lie within reach of the
// camera, or behind it.
std::vector<EditDescription> random_edits(std::mt19937_64& engine, Random& random) {
  const auto place = [&] { return V3d(random.real(-3, 3), random.real(-3, 3), random.real(-3, 3)); };
  EditDescription light = edit_at("light", at({50, 0, 0}), "L.*", 0),
                  view = edit_at("view", random_placement(engine, place(), true), ".*E", 1);
  light.exits.push_back(exit_at("exit", random_placement(engine, place(), true), 2));
  view.exits.push_back(exit_at("shown", at({60, 0, 0}), 3));
  return {light, view};
}

TEST(GatesInView, NoRayMeetsAGateUnasked) {
  std::mt19937_64 engine(3);
  Random random(5);
  int met = 0, blocks = 0, asked = 0;
  for (int round = 0; round < 400; ++round) {
    FrameDescription frame;
    frame.width = 57, frame.height = 43, frame.pixel_aspect_y = random.unit() < 0.5f ? 1.0f : 1.5f;
    CameraDescription described = random_camera(random, round % 2 == 1);
    if (round % 5 == 0) described.matrix = described.matrix * scaling({1, 1, 3});  // a parent's: it shears
    const Camera camera(described, frame, V3d(0));
    const PixelFilter filter(frame);
    const TestEdits made(random_edits(engine, random));
    const Edits& edits = made.edits;
    const GatesInView gates(edits, camera, filter, frame);
    const int view = edits[0].side == Side::View ? 0 : 1;
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        const V2f offset = filter.sample_filter(random.pair());
        const Ray ray = camera.generate(static_cast<float>(x) + 0.5f + offset.x,
                                        static_cast<float>(y) + 0.5f + offset.y, random.pair());
        for (const Side side : {Side::Light, Side::View}) {
          const bool is_asked = gates.any(side, x, y);
          if (camera.is_invertible()) ++blocks, asked += is_asked;
          const Quad& gate = side == Side::View ? edits[view].entry : edits[1 - view].exits[0].quad;
          const auto hit = intersect(gate, ray.origin, V3d(ray.direction));
          if (!hit || hit->t <= 0) continue;
          ++met;
          ASSERT_TRUE(is_asked) << "round " << round << ", pixel " << x << ' ' << y << ", side "
                                << index(side);
          const auto listed = gates.listed(side, x, y);
          ASSERT_TRUE(listed && listed->size() == 1);
          EXPECT_TRUE(edits.is_crossed((*listed)[0], {ray.origin, V3d(ray.direction), 0, hit->t, -1}));
        }
      }
  }
  EXPECT_GT(met, 10000);
  EXPECT_LT(asked, blocks / 3);
}

// Gates on top of each other: listed while they are few.
TEST(GatesInView, ManyAreNotListed) {
  const FrameDescription frame;
  CameraDescription described;
  for (const int count : {16, 17}) {
    std::vector<EditDescription> edits;
    for (int i = 0; i < count; ++i) {
      edits.push_back(edit_at("edit " + std::to_string(i), at({50, 0, 0}), "L.*", 2 * i));
      edits.back().exits.push_back(exit_at("exit", at({0, 0, -5}), 2 * i + 1));
    }
    const TestEdits made(edits);
    const GatesInView gates(made.edits, Camera(described, frame, V3d(0)), PixelFilter(frame), frame);
    const int x = frame.width / 2, y = frame.height / 2;
    ASSERT_TRUE(gates.any(Side::Light, x, y));
    const auto listed = gates.listed(Side::Light, x, y);
    EXPECT_EQ(listed ? listed->size() : 0u, count == 16 ? 16u : 0u);
  }
}

TEST(GatesInView, NothingIsAskedWithoutEdits) {
  const FrameDescription frame;
  const GatesInView gates(Edits(), Camera(CameraDescription(), frame, V3d(0)), PixelFilter(frame), frame);
  EXPECT_FALSE(gates.any(Side::Light, 0, 0));
  EXPECT_FALSE(gates.any(Side::View, frame.width - 1, frame.height - 1));
}

}  // namespace
}  // namespace sluice::test
