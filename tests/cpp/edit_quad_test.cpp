// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of quads: design §2 and the assertions of numerics §1, named after them.
#include <gtest/gtest.h>

#include "edit/quad_set.h"
#include "edit_scene.h"

namespace sluice {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low = 0, double high = 1) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// A quad in place: floated, in its plane group, alone unless others are given.
Quad lone_quad(const QuadDescription& d, double delta = 0, const V3d& centre = V3d(0)) {
  auto q = make_quad(d, centre, 1);
  Quad* list[] = {&*q};
  place_quads(list, delta, 100);
  return *q;
}

TEST(Quad, CornersAreWhereDesignSays) {
  const Quad q = lone_quad(quad("q", placed({2, 0, 0}, {0, 3, 0}, {0, 0, 1}, {10, 20, 30}), 0, 0.5));
  EXPECT_EQ(q.point({0, 0}), V3d(9, 18.5, 30));   // (-s, -s)
  EXPECT_EQ(q.point({1, 0}), V3d(11, 18.5, 30));  // u along local X
  EXPECT_EQ(q.point({0, 1}), V3d(9, 21.5, 30));
  EXPECT_DOUBLE_EQ(q.area, 6);
}

TEST(Quad, FloatsOnTheSideOfItsArrow) {
  const M44d up = at({0, 0, 5}), down = placed({1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 5});
  EXPECT_DOUBLE_EQ(lone_quad(quad("q", up, 0), 0.25).point({0.5, 0.5}).z, 5.25);
  EXPECT_DOUBLE_EQ(lone_quad(quad("q", down, 0), 0.25).point({0.5, 0.5}).z, 4.75);
  QuadDescription bumpy = quad("q", up, 0);
  bumpy.offset = 0.5;
  EXPECT_DOUBLE_EQ(lone_quad(bumpy, 0.25).point({0.5, 0.5}).z, 5.75);
}

// P14: frames are orthonormal; a mirrored quad has a mirrored frame; components survive the way from frame to
// frame.
TEST(Quad, P14FramesOfAnyAffineQuad) {
  Random random(14);
  int mirrored = 0;
  for (int i = 0; i < 20'000; ++i) {
    const M44d m = random_placement(random, V3d(0), true);
    const Quad q = lone_quad(quad("q", m, 0));
    const QuadFrame& f = q.frame;
    for (const V3d& axis : {f.t, f.b, f.n}) EXPECT_NEAR(axis.length(), 1, 1e-14);
    EXPECT_NEAR(f.t.dot(f.b), 0, 1e-14);
    EXPECT_NEAR(f.t.dot(f.n), 0, 1e-14);
    EXPECT_NEAR(f.b.dot(f.n), 0, 1e-14);
    const V3d x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]), z(m[2][0], m[2][1], m[2][2]);
    EXPECT_NEAR(f.t.dot(x), x.length(), 1e-12);
    EXPECT_GT(f.n.dot(z), 0);
    EXPECT_GT(f.b.dot(y), 0);
    const bool is_mirror = x.cross(y).dot(z) < 0;
    EXPECT_NEAR(f.t.cross(f.b).dot(f.n), is_mirror ? -1 : 1, 1e-12);
    mirrored += is_mirror;
    const V3d d = random_direction(random);
    EXPECT_NEAR((f.to_world(f.to_local(d)) - d).length(), 0, 1e-14);
  }
  EXPECT_GT(mirrored, 5000);
}

// P11: (u, v) of a point and back; (u, v) always in [0, 1]².
TEST(Quad, P11RoundTrip) {
  Random random(11);
  for (const double distance : {0.0, 1e2, 1e4}) {
    for (int i = 0; i < 20'000; ++i) {
      const Quad q =
          lone_quad(quad("q", random_placement(random, random_direction(random) * distance, true), 0));
      const V2d uv(uniform(random), uniform(random));
      const V3d p = q.point(uv), d = random_direction(random);
      if (std::abs(d.dot(q.frame.n)) < 0.05) continue;
      const auto hit = intersect(q, p - d * 3.0, d);
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->t, 3, 1e-9);
      EXPECT_NEAR(hit->uv.x, uv.x, 1e-6);
      EXPECT_NEAR(hit->uv.y, uv.y, 1e-6);
      EXPECT_TRUE(hit->uv.x >= 0 && hit->uv.x <= 1 && hit->uv.y >= 0 && hit->uv.y <= 1);
    }
  }
}

// P13: t of grazing rays; below |n·d| = 1e-6 a miss; garbage in, no garbage out.
TEST(Quad, P13GrazingRays) {
  Random random(13);
  for (const double angle : {0.1, 1e-2, 1e-3, 1e-5}) {
    for (int i = 0; i < 20'000; ++i) {
      const Quad q = lone_quad(quad("q", random_placement(random, V3d(0)), 0));
      const double phi = uniform(random, 0, 6.283);
      const V3d along = q.frame.t * std::cos(phi) + q.frame.b * std::sin(phi);
      const V3d exact = along * std::cos(angle) - q.frame.n * std::sin(angle);
      const V3d d(static_cast<float>(exact.x), static_cast<float>(exact.y), static_cast<float>(exact.z));
      const V3d p = q.point({uniform(random, 0.2, 0.8), uniform(random, 0.2, 0.8)});
      const double t = 1e-4 / angle;  // far enough, and still over the quad's middle whatever float does to d
      const auto hit = intersect(q, p - d * t, d);
      ASSERT_TRUE(hit) << angle;
      EXPECT_NEAR(hit->t / t, 1, angle >= 1e-3 ? 2e-4 : 1e-2);
    }
  }
  const Quad q = lone_quad(quad("q", at(V3d(0)), 0));
  EXPECT_FALSE(intersect(q, {0, 0, 1e-9}, {1, 0, -0.9e-6}));
  EXPECT_TRUE(intersect(q, {0, 0, 1e-9}, {1, 0, -1.1e-6}));
  const double bad[] = {std::nan(""), INFINITY, -INFINITY, 1e308, -1e308, 0, 1e-308};
  for (const double a : bad)
    for (const double b : bad)
      for (const double c : bad)
        if (const auto hit = intersect(q, {a, b, 1}, {c, a, b})) {
          EXPECT_TRUE(hit->uv.x >= 0 && hit->uv.x <= 1 && hit->uv.y >= 0 && hit->uv.y <= 1);
        }
}

// P10: collapsed and broken quads are refused.
TEST(Quad, P10DegenerateQuadsAreRefused) {
  const auto refused = [](const V3d& x, const V3d& y, double extent, double half = 1) {
    return !make_quad(quad("q", placed(x, y, {0, 0, 1}, V3d(0)), 0, half), V3d(0), extent);
  };
  EXPECT_FALSE(refused({1, 0, 0}, {0, 1, 0}, 10));
  EXPECT_FALSE(refused({1, 0, 0}, {1, 1e-3, 0}, 10));
  EXPECT_TRUE(refused({1, 0, 0}, {2, 0, 0}, 10));
  EXPECT_TRUE(refused({1, 0, 0}, {0, 0, 0}, 10));
  EXPECT_TRUE(refused({0, 0, 0}, {0, 0, 0}, 0));
  EXPECT_TRUE(refused({1, 0, 0}, {0, 1, 0}, 10, 0));
  EXPECT_FALSE(refused({1e-6, 0, 0}, {0, 1e-6, 0}, 1));   // area 4e-12
  EXPECT_TRUE(refused({1e-6, 0, 0}, {0, 0.9e-7, 0}, 1));  // 0.36e-12
  EXPECT_TRUE(refused({std::nan(""), 0, 0}, {0, 1, 0}, 1));
  EXPECT_TRUE(refused({INFINITY, 0, 0}, {0, 1, 0}, 1));
  EXPECT_TRUE(refused({1e200, 0, 0}, {0, 1e200, 0}, 1));
  QuadDescription offset = quad("q", at(V3d(0)), 0);
  offset.offset = std::nan("");
  EXPECT_FALSE(make_quad(offset, V3d(0), 1));
  offset = quad("q", placed({1, 0, 0}, {0, 1, 0}, {0, 0, std::nan("")}, V3d(0)), 0);
  EXPECT_FALSE(make_quad(offset, V3d(0), 1));
  // flattened in Z only: still a square
  EXPECT_TRUE(make_quad(quad("q", placed({1, 0, 0}, {0, 1, 0}, V3d(0), V3d(0)), 0), V3d(0), 1));
}

// P5: rays at the edge that two quads share, coplanar or meeting at an angle, turned and far away: one of
// them is met, always.
TEST(Quad, P5SharedEdges) {
  Random random(5);
  int edge_rays = 0, both = 0;
  for (int i = 0; i < 300; ++i) {
    const V3d place = random_direction(random) * (i % 3 == 0 ? 1e4 : 5.0);
    const V3d x = random_direction(random), z = x.cross(random_direction(random)).normalized(),
              y = z.cross(x);
    // The neighbour lies beyond the edge u = 1, in its own orientation: u and v run any way.
    const M44d a = placed(x, y, z, place);
    const int turn = i % 4;
    const V3d nx = turn == 0 ? x : turn == 1 ? y : turn == 2 ? -x : -y, ny = z.cross(nx);
    const M44d b = placed(nx, ny, z, place + x * 2.0);
    auto qa = make_quad(quad("a", a, 0), V3d(0), 10), qb = make_quad(quad("b", b, 1), V3d(0), 10);
    Quad* both_quads[] = {&*qa, &*qb};
    ASSERT_EQ(place_quads(both_quads, 1e-3, place.length() + 10), 1);
    for (int k = 0; k < 3000; ++k) {
      const V3d p = qa->point({1, uniform(random)}), d = random_direction(random);
      if (std::abs(d.dot(z)) < 0.05) continue;
      const V3d o = p - d * uniform(random, 0.1, 5);
      const auto ha = intersect(*qa, o, d), hb = intersect(*qb, o, d);
      ++edge_rays;
      ASSERT_TRUE(ha || hb) << "a ray fell through the edge";
      if (ha && hb) {
        EXPECT_EQ(ha->t, hb->t);  // one plane, one t: order decides
        ++both;
      }
    }
  }
  EXPECT_GT(edge_rays, 500'000);
  EXPECT_GT(both, 1000);  // closed squares: the edge belongs to both
}

int groups_of(std::vector<QuadDescription> descriptions, double delta, std::vector<Quad>* out = nullptr) {
  std::vector<Quad> quads;
  for (const auto& d : descriptions) quads.push_back(*make_quad(d, V3d(0), 10));
  std::vector<Quad*> list;
  for (Quad& q : quads) list.push_back(&q);
  const int groups = place_quads(list, delta, 100);
  if (out) *out = quads;
  return groups;
}

// Design §2: quads in one plane are ordered, not measured.
TEST(Quad, PlaneGroups) {
  const double delta = 1e-4;
  const auto lifted = [&](double by, const V3d& place = V3d(0)) { return at(place + V3d(0, 0, by * delta)); };
  EXPECT_EQ(groups_of({quad("a", lifted(0), 0), quad("b", lifted(0), 1)}, delta), 1);
  EXPECT_EQ(groups_of({quad("a", lifted(0), 0), quad("b", lifted(0.3), 1)}, delta), 1);
  EXPECT_EQ(
      groups_of({quad("a", lifted(-0.3), 0), quad("b", lifted(0), 1), quad("c", lifted(0.3), 2)}, delta), 1);
  EXPECT_EQ(groups_of({quad("a", lifted(0), 0), quad("b", lifted(0.6), 1)}, delta), 2);
  // far apart in one plane
  EXPECT_EQ(groups_of({quad("a", lifted(0), 0), quad("b", lifted(0, {50, -30, 0}), 1)}, delta), 1);
  // Arrows opposite: floated apart by 2 delta they are two planes; with their own planes 2 delta apart they
  // are one.
  const M44d down = placed({1, 0, 0}, {0, 1, 0}, {0, 0, -1}, V3d(0)),
             down_up = placed({1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 2 * delta});
  EXPECT_EQ(groups_of({quad("a", lifted(0), 0), quad("b", down, 1)}, delta), 2);
  EXPECT_EQ(groups_of({quad("a", lifted(0), 0), quad("b", down_up, 1)}, delta), 1);
  // Tilted so that it leaves the other's slab; an offset takes a quad out of its plane.
  EXPECT_EQ(groups_of({quad("a", lifted(0), 0),
                       quad("b", placed({1, 0, 1e-3}, {0, 1, 0}, {-1e-3, 0, 1}, V3d(0)), 1)},
                      delta),
            2);
  QuadDescription offset = quad("b", lifted(0), 1);
  offset.offset = delta;
  EXPECT_EQ(groups_of({quad("a", lifted(0), 0), offset}, delta), 2);
}

TEST(Quad, OnePlaneOneT) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const double delta = 1e-4;
    const V3d x = random_direction(random), z = x.cross(random_direction(random)).normalized(),
              y = z.cross(x);
    std::vector<QuadDescription> descriptions;
    for (int k = 0; k < 5; ++k) {
      const double phi = uniform(random, 0, 6.28);
      const V3d tx = x * std::cos(phi) + y * std::sin(phi);
      descriptions.push_back(quad(
          "q",
          placed(tx, z.cross(tx), z, x * uniform(random, -1, 1) + z * (delta * uniform(random, -0.2, 0.2))),
          10 - k));
    }
    std::vector<Quad> quads;
    ASSERT_EQ(groups_of(descriptions, delta, &quads), 1);
    // The plane is that of the lowest order, the last one here; nobody moved by more than delta.
    EXPECT_NEAR(quads[4].plane_offset,
                quads[4].frame.n.dot(V3d(descriptions[4].matrix[3][0], descriptions[4].matrix[3][1],
                                         descriptions[4].matrix[3][2])) +
                    delta,
                1e-13);
    for (int k = 0; k < 200; ++k) {
      const V3d o = random_direction(random) * 5.0, d = (x * uniform(random, -0.3, 0.3) - o).normalized();
      double t = 0;
      for (const Quad& q : quads)
        if (const auto hit = intersect(q, o, d)) {
          if (t != 0) { EXPECT_EQ(hit->t, t); }
          t = hit->t;
          EXPECT_NEAR((q.point(hit->uv) - (o + d * t)).length(), 0, 1e-12);
        }
    }
  }
}

// Spheres (alone up to 32 quads) and boxes are of floats: rays at the corners, edges and middles of quads,
// from near, from far and along their boxes' sides, find whatever each quad finds alone, however small or far
// away the quads are and however long the way to them.
TEST(QuadSet, SpheresAndBoxesLoseNothing) {
  Random random(9);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  int found = 0;
  for (const auto& [size, place, count] : {std::tuple{1.0, 0.0, 3},
                                           {1.0, 1e5, 20},
                                           {1e-6, 0.0, 60},
                                           {1e-6, 1.0, 20},
                                           {1e-6, 1e5, 60},
                                           {1.0, 0.0, 60},
                                           {1.0, 1.0, 300},
                                           {1.0, 1e5, 300},
                                           {1e4, 0.0, 20},
                                           {1e4, 1.0, 60},
                                           {1e4, 1e5, 300}}) {
    const V3d middle = random_direction(random) * (place * size);
    std::vector<Quad> quads;
    for (int i = 0; i < count; ++i) {
      const bool is_flat = i % 3 == 0;  // along the axes: boxes without thickness
      const double half = size * std::pow(10, uniform(random, -4, 0));
      const M44d turn = is_flat ? placed({1, 0, 0}, {0, i % 2 ? 1.0 : 0.0, i % 2 ? 0.0 : 1.0},
                                         {0, i % 2 ? 0.0 : -1.0, i % 2 ? 1.0 : 0.0}, V3d(0))
                                : random_placement(random, V3d(0));
      M44d m = turn;
      for (int axis = 0; axis < 3; ++axis) m[3][axis] = middle[axis] + size * uniform(random, -1, 1);
      quads.push_back(*make_quad(quad("q", m, i, half), V3d(0), 0));
    }
    const double far = 1e3 * size, scale = 2 * (middle.length() + far);
    std::vector<Quad*> list;
    for (Quad& q : quads) list.push_back(&q);
    place_quads(list, 0x1p-22 * scale, scale);
    QuadSet set;
    for (int i = 0; i < count; ++i) set.add(quads[static_cast<std::size_t>(i)], {i, QuadId::entry});
    set.build();
    std::vector<Crossing> crossings;
    for (int k = 0; k < 20'000; ++k) {
      const Quad& aim = quads[random() % quads.size()];
      const V3d p = aim.point({0.5 * static_cast<double>(k % 3), 0.5 * static_cast<double>(k / 3 % 3)});
      V3d d = to_double(to_float(random_direction(random)));
      if (k % 5 == 0) d[k / 5 % 3] = 0;
      if (k % 50 == 0) d = k % 100 ? V3d(1, 0, 0) : V3d(0, 0, -1);
      // as long as many mirrors leave a direction in floats
      d *= uniform(random, 1 - 3e-6, 1 + 3e-6) / d.length();
      const double way = (k % 2 ? far : size) * uniform(random, 0, 1);
      const V3d o = p - d * way;
      const double t_min = k % 7 == 0 ? -infinity : 0, t_max = k % 4 == 0 ? way : infinity;
      set.all({o, d, t_min, t_max}, {}, crossings = {});
      std::size_t alone = 0;
      for (const Quad& q : quads)
        if (const auto hit = intersect(q, o, d)) alone += hit->t > t_min && hit->t <= t_max;
      ASSERT_EQ(crossings.size(), alone) << size << ' ' << place << ' ' << k;
      EXPECT_EQ(set.any({o, d, t_min, t_max}), alone > 0);
      found += static_cast<int>(alone);
    }
  }
  EXPECT_GT(found, 100'000);
}

// Ways from round a place to one point: the quads in the cone answer for all. Also where all quads lie close
// together, far from the ways' ends.
TEST(QuadSet, ConesLoseNothing) {
  Random random(10);
  int found = 0, spared = 0;
  for (const auto& [count, size] : {std::pair{2, 1.0}, {20, 1.0}, {300, 1.0}, {300, 0.01}}) {
    std::vector<Quad> quads;
    for (int i = 0; i < count; ++i)
      quads.push_back(*make_quad(quad("q", random_placement(random, random_direction(random) * size), i,
                                      size * std::pow(10, uniform(random, -3, -1))),
                                 V3d(0), 0));
    std::vector<Quad*> list;
    for (Quad& q : quads) list.push_back(&q);
    place_quads(list, 0x1p-22, 4);
    QuadSet set;
    for (int i = 0; i < count; ++i) set.add(quads[static_cast<std::size_t>(i)], {i, QuadId::entry});
    set.build();
    for (int k = 0; k < 20'000; ++k) {
      const V3d end = 2.0 * random_direction(random), way = size * random_direction(random) - end,
                from = end + way * uniform(random, 1, 2);
      const double radius = way.length() * std::pow(10, uniform(random, -3, 0.3));
      const Segment axis{from, (end - from).normalized(), 0, (end - from).length()};
      std::vector<std::uint32_t> in_cone;
      ASSERT_TRUE(set.in_cone(axis, radius, {}, quads.size(), in_cone));
      spared += count - static_cast<int>(in_cone.size());
      for (int side = 0; side < 8; ++side) {
        const V3d other = from + random_direction(random) * (radius * (side % 2 ? 1 : uniform(random, 0, 1))),
                  to = end - other;
        const Segment segment{other, to.normalized(), 0, to.length()};
        const bool is_met = set.any(segment);
        found += is_met;
        ASSERT_EQ(set.any_of(in_cone, segment), is_met) << count << ' ' << k;
      }
    }
  }
  EXPECT_GT(found, 10'000);
  EXPECT_GT(spared, 1'000'000);
}

TEST(QuadSet, ConesStopAtTheMost) {
  QuadSet set;
  std::vector<Quad> quads;
  for (int i = 0; i < 50; ++i) quads.push_back(*make_quad(quad("q", at({0, 0, 0.01 * i}), i, 1), V3d(0), 0));
  std::vector<Quad*> list;
  for (Quad& q : quads) list.push_back(&q);
  place_quads(list, 0x1p-22, 4);
  for (int i = 0; i < 50; ++i) set.add(quads[static_cast<std::size_t>(i)], {i, QuadId::entry});
  set.build();
  std::vector<std::uint32_t> in_cone;
  EXPECT_FALSE(set.in_cone({V3d(0, 0, -1), V3d(0, 0, 1), 0, 2}, 0.1, {}, 8, in_cone));
  EXPECT_LT(in_cone.size(), 20u);
  in_cone.clear();
  EXPECT_TRUE(set.in_cone({V3d(0, 0, -1), V3d(0, 0, 1), 0, 2}, 0.1, {}, 50, in_cone));
  EXPECT_EQ(in_cone.size(), 50u);
}

}  // namespace
}  // namespace sluice
