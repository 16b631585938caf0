// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh lights asked by how they face a point: few samples lost, less variance; and which of them count as
// lamps that are seen from outside. That densities agree with samples is scene_light_test.cpp's.
#include "scene_fixtures.h"

namespace sluice::test {
namespace {

TEST(Facings, MeshesAreAskedWhereTheyFace) {
  // A ball hides half of itself: of samples by area alone every second one is lost. Also mirrored, and with
  // normals that look in.
  MeshDescription ball = sphere(32), inside_out = ball;
  for (auto& corners : inside_out.triangles) std::swap(corners[0], corners[1]);
  struct Lamp {
    MeshDescription mesh;
    double side;  // of the normals that look out
    double mirrored;
  };
  for (const Lamp& lamp : {Lamp{ball, 1, 1}, Lamp{ball, 1, -1}, Lamp{inside_out, -1, 1}}) {
    SceneDescription description;
    place(description, add(description, lamp.mesh), scaling({lamp.mirrored, 1, 1}),
          add(description, glowing({1, 1, 1}, 5)));
    // a lamp is small
    place(description, add(description, grid()), scaling({20, 20, 1}) * translation({0, 0, -20}),
          add(description, glowing({0, 0, 0}, 0)));
    const auto scene = compiled(description);
    Random random(5);
    for (const V3d& from : {V3d(10, 0, 0), V3d(-2, 3, 1), V3d(1, 1.2, -1)}) {
      Mean lost, value, square_of, by_area, square_by_area;
      for (int i = 0; i < 20000; ++i) {
        const auto sample = sample_direct(*scene, 0, from, random.unit(), random.pair());
        const double arrives = sample ? sample->radiance.x / sample->pdf *
                                            scene->transmittance({from, sample->wi, sample->distance})->x
                                      : 0;
        lost.add(arrives == 0), value.add(arrives), square_of.add(arrives * arrives);
        const auto point = sample_position(*scene, 0, random.unit(), random.pair());
        const V3d to = from - point->position;
        const double by_chance =
            std::max(0.0, V3d(point->normal).dot(to.normalized()) * lamp.side) / to.length2();
        by_area.add(by_chance), square_by_area.add(square(by_chance));
      }
      EXPECT_LT(lost.value(), 0.25) << from;
      const auto variance = [](const Mean& squares, const Mean& of) {
        return squares.value() / square(of.value()) - 1;
      };
      EXPECT_LT(variance(square_of, value), variance(square_by_area, by_area) / 3) << from;
    }
    Mean out;
    for (int i = 0; i < 20000; ++i) {
      const auto point = sample_position(*scene, 0, random.unit(), random.pair());
      const auto direction = sample_direction(*scene, 0, *point, random.unit(), random.pair());
      out.add(direction->direction.dot(V3f(point->position)) > 0);
    }
    EXPECT_NEAR(out.value(), 0.8, 4 * out.error());
  }
}

// A glowing mesh, and a large dark plane at the height.
int front_of(const MeshDescription& mesh, double height) {
  SceneDescription description;
  place(description, add(description, mesh), scaling({1, 1, 1}), add(description, glowing({1, 1, 1}, 5)));
  place(description, add(description, grid()), scaling({20, 20, 1}) * translation({0, 0, height}),
        add(description, glowing({0, 0, 0}, 0)));
  return std::get<MeshLight>(compiled(description)->lights()[0].kind).facings.front();
}

TEST(Facings, LampsAreClosedAndNothingIsInThem) {
  MeshDescription ball = sphere(8), inside_out = ball, bowl = ball, card = grid();
  for (auto& corners : inside_out.triangles) std::swap(corners[0], corners[1]);
  bowl.triangles.resize(bowl.triangles.size() / 2);
  const auto one_side = card.triangles;
  for (const auto& corners : one_side) card.triangles.push_back({corners[1], corners[0], corners[2]});
  EXPECT_EQ(front_of(ball, -5), 1);
  EXPECT_EQ(front_of(inside_out, -5), -1);
  EXPECT_EQ(front_of(bowl, -5), 0);
  EXPECT_EQ(front_of(card, -5), 0);
  EXPECT_EQ(front_of(grid(), -5), 0);
  EXPECT_EQ(front_of(ball, 0.5), 1) << "small beside the scene";
  SceneDescription lantern, room;
  for (SceneDescription* scene : {&lantern, &room})
    place(*scene, add(*scene, ball), scaling({1, 1, 1}), add(*scene, glowing({1, 1, 1}, 5)));
  place(lantern, add(lantern, grid()), scaling({4, 4, 1}), add(lantern, glowing({0, 0, 0}, 0)));
  for (const SceneDescription& scene : {lantern, room})
    EXPECT_EQ(std::get<MeshLight>(compiled(scene)->lights()[0].kind).facings.front(), 0);
}

}  // namespace
}  // namespace sluice::test
