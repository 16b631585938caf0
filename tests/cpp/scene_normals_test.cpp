// SPDX-License-Identifier: GPL-3.0-or-later
// Normals made from polygons, against closed forms; that they are Blender's is tested inside Blender.
#include "scene/normals.h"
#include "scene_fixtures.h"

namespace sluice::test {
namespace {

// Polygons that are the triangles themselves.
MeshDescription with_polygons(MeshDescription mesh, bool smooth = true) {
  PolygonDescription& polygons = mesh.polygons;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    polygons.starts.push_back(3 * i), polygons.sizes.push_back(3), polygons.smooth.push_back(smooth),
        polygons.of_triangles.push_back(i);
    polygons.corners.insert(polygons.corners.end(), mesh.triangles[i].begin(), mesh.triangles[i].end());
  }
  return mesh;
}

// A cube of side 2, six quads.
MeshDescription cube() {
  MeshDescription mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.emplace_back(i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f);
  const std::uint32_t sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (std::uint32_t side = 0; side < 6; ++side) {
    const auto& [a, b, c, d] = sides[side];
    mesh.polygons.starts.push_back(4 * side), mesh.polygons.sizes.push_back(4),
        mesh.polygons.smooth.push_back(1);
    mesh.polygons.corners.insert(mesh.polygons.corners.end(), {a, b, c, d});
    mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({a, c, d});
    mesh.polygons.of_triangles.insert(mesh.polygons.of_triangles.end(), {side, side});
  }
  return mesh;
}

TEST(SceneNormals, OfASphereAreItsPositionsAtAnySize) {
  for (const float size : {1e-6f, 1e-3f, 1.0f, 1e6f}) {
    MeshDescription mesh = with_polygons(sphere(24));
    for (V3f& p : mesh.positions) p *= size;
    const MeshDescription before = mesh;
    make_normals(mesh);
    ASSERT_EQ(mesh.normals.size(), 3 * mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
      const V3f outwards = before.positions[before.triangles[i / 3][i % 3]] / size;
      EXPECT_NEAR(mesh.normals[i].length(), 1, 1e-6);
      EXPECT_GT(mesh.normals[i].dot(outwards.normalized()), 0.9985);  // rings are triangles cut one way
    }
    EXPECT_TRUE(mesh.polygons.corners.empty());
  }
}

// A diagonal across a quad must not count: triangles alone would pull the corner's normal to one side.
TEST(SceneNormals, PolygonsCountByTheirOwnAngles) {
  MeshDescription mesh = cube();
  make_normals(mesh);
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    const V3f corner = mesh.positions[mesh.triangles[i / 3][i % 3]].normalized();
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(mesh.normals[i][axis], corner[axis], 1e-7);
  }
}

TEST(SceneNormals, FlatPolygonsKeepTheirOwnAndCountAtTheOthers) {
  MeshDescription mesh = cube();
  mesh.polygons.smooth = {1, 0, 1, 1, 1, 1};  // the lid is flat
  make_normals(mesh);
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    const bool lid = i / 6 == 1;
    const V3f want = lid ? V3f(0, 0, 1) : mesh.positions[mesh.triangles[i / 3][i % 3]].normalized();
    EXPECT_NEAR((mesh.normals[i] - want).length(), 0, 1e-6);
  }
}

// Two faces at 90° and 45° of angle at the vertex: 2 to 1.
TEST(SceneNormals, AreWeighedByTheAngleAtTheVertex) {
  MeshDescription mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};  // normals +z, +x
  mesh = with_polygons(mesh);
  make_normals(mesh);
  const V3f want = V3f(1, 0, 2).normalized();
  EXPECT_NEAR((mesh.normals[0] - want).length(), 0, 1e-6);
  EXPECT_EQ(mesh.normals[0], mesh.normals[3]);
}

// Far from its mesh's origin a face of a centimetre is still known: Blender's own floats are off by a percent
// there.
TEST(SceneNormals, DoNotSufferFromDistance) {
  MeshDescription mesh = with_polygons(grid(8));
  // exact in float; slope 1 in x
  for (V3f& p : mesh.positions) p = V3f(4096, 8192, 2048) + p / 64 + V3f(0, 0, p.x / 64);
  make_normals(mesh);
  const V3f want = V3f(-1, 0, 1).normalized();
  for (const V3f& n : mesh.normals) EXPECT_NEAR((n - want).length(), 0, 1e-6);
}

void add_polygon(MeshDescription& mesh, const std::vector<std::uint32_t>& corners) {
  PolygonDescription& polygons = mesh.polygons;
  polygons.starts.push_back(static_cast<std::uint32_t>(polygons.corners.size()));
  polygons.sizes.push_back(static_cast<std::uint32_t>(corners.size())), polygons.smooth.push_back(1);
  polygons.corners.insert(polygons.corners.end(), corners.begin(), corners.end());
}

TEST(SceneNormals, OddPolygonsHarmNoOthers) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), infinity}) {
    MeshDescription mesh = with_polygons(grid(4));
    for (V3f& p : mesh.positions) p = V3f(p.z, p.x, p.y);  // faces +x
    mesh.positions.emplace_back(0, bad, 0);
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    add_polygon(mesh, {0, 1, last}), add_polygon(mesh, {2, last, 3, 4}), add_polygon(mesh, {0, 1}),
        add_polygon(mesh, {}), add_polygon(mesh, {3});
    make_normals(mesh);
    for (const V3f& n : mesh.normals) EXPECT_EQ(n, V3f(1, 0, 0));
  }
}

// As in Blender, a polygon without area looks up.
TEST(SceneNormals, WithoutAreaIsUp) {
  MeshDescription mesh;
  mesh.positions = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 2, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};  // +x; on a line, with no angle at vertex 0, half a turn at 1
  mesh = with_polygons(mesh);
  make_normals(mesh);
  EXPECT_NEAR((mesh.normals[0] - V3f(1, 0, 0)).length(), 0, 1e-6);
  EXPECT_NEAR((mesh.normals[1] - V3f(0.25f, 0, 1).normalized()).length(), 0, 1e-6);
  EXPECT_EQ(mesh.normals[5], V3f(0, 1, 0));  // no angle at all: its own position's direction
}

TEST(SceneNormals, NormalsThatAreGivenStay) {
  MeshDescription mesh = with_polygons(grid(1));
  mesh.normals.assign(6, V3f(1, 0, 0));
  make_normals(mesh);
  for (const V3f& n : mesh.normals) EXPECT_EQ(n, V3f(1, 0, 0));
  MeshDescription flat = grid(1);
  make_normals(flat);
  EXPECT_TRUE(flat.normals.empty());
}

TEST(SceneNormals, PolygonsThatDoNotFitAreRefused) {
  const auto refused = [](auto&& breakage) {
    MeshDescription mesh = with_polygons(grid(2));
    breakage(mesh.polygons);
    EXPECT_THROW(check_mesh(mesh), SceneError);
  };
  EXPECT_NO_THROW(check_mesh(with_polygons(grid(2))));
  refused([](auto& p) { p.corners[3] = 9; });
  refused([](auto& p) { p.starts[7] = 22; });
  refused([](auto& p) { p.starts[7] = 0xffffffffu; });
  refused([](auto& p) { p.sizes.pop_back(); });
  refused([](auto& p) { p.smooth.push_back(1); });
  refused([](auto& p) { p.of_triangles[0] = 8; });
  refused([](auto& p) { p.of_triangles.pop_back(); });
}

}  // namespace
}  // namespace sluice::test
