// SPDX-License-Identifier: GPL-3.0-or-later
// Which entry takes a path and where it goes on: design §2, numerics P1, P2, P3, P5, P14.
#include <gtest/gtest.h>

#include "edit_scene.h"

namespace sluice {
namespace {

using Random = std::mt19937_64;

TEST(Gates, DeltaIsThatOfTheDesign) {
  // m from the quads, relative to their own centre; w from the scene before re-centring.
  const std::vector<EditDescription> one{edit_at("A", at({1000, 0, 0}), "L", 0)};
  EXPECT_DOUBLE_EQ(Setting(one).edits.delta(), 0x1p-22 * 1001);
  std::vector<EditDescription> wide = one;
  wide[0].exits.push_back(exit_at("X", at({1200, 0, 0})));
  EXPECT_DOUBLE_EQ(Setting(wide).edits.delta(), std::max(0x1p-17 * 101, 0x1p-22 * 1201));
  EXPECT_DOUBLE_EQ(Setting(one, {}, V3d(0), Box({-1e6, 0, 0}, {5, 5, 5})).edits.delta(), 0x1p-22 * 1e6);
}

TEST(Gates, TheFirstPlaneAndThenOrderDecides) {
  std::vector<EditDescription> all{edit_at("far", at({0, 0, -5}), "L", 0), edit_at("late", flat, "L", 7),
                                   edit_at("early", flat, "L", 3), edit_at("other", at({0, 0, 2}), "LD", 1)};
  Setting s(all);
  auto c = s.taken({0.3, 0.2, 10}, {0, 0, -1});
  ASSERT_TRUE(c);
  EXPECT_EQ(c->edit, 2);
  EXPECT_NEAR(c->t, 10 - s.edits.delta(), 1e-12);
  EXPECT_NEAR(c->uv.x, 0.65, 1e-9);
  EXPECT_NEAR(c->uv.y, 0.6, 1e-9);
  EXPECT_EQ(s.taken({0.3, 0.2, -10}, {0, 0, 1})->edit, 0);                 // quads act on both sides
  EXPECT_EQ(s.taken({0.3, 0.2, 10}, {0, 0, -1}, 1e9, c->group)->edit, 0);  // the plane just left
  EXPECT_FALSE(s.taken({0.3, 0.2, 10}, {0, 0, -1}, 9));
  EXPECT_FALSE(s.taken({1.3, 0.2, 10}, {0, 0, -1}));
  EXPECT_EQ(s.edits.first_taken(s.table, s.diffuse, {{0, 0, 10}, {0, 0, -1}})->edit, 3);
  EXPECT_FALSE(s.edits.first_taken(s.table, StateTable::light_start, {{0, 0, 10}, {0, 0, -1}}));
  EXPECT_TRUE(s.edits.any_taken(s.table, s.lit, {{0, 0, 10}, {0, 0, -1}}));
  EXPECT_FALSE(s.edits.any_taken(s.table, s.lit, {{0, 0, 10}, {0, 0, -1}, 0, 9}));
  // Used up, the earlier one lets the later one act.
  EXPECT_EQ(
      s.edits.first_taken(s.table, s.table.next(StateTable::light_start, s.edits.event_class(Event::D, -1)),
                          {{0, 0, 10}, {0, 0, -1}}),
      std::nullopt);
}

bool operator==(const Crossing& a, const Crossing& b) {
  return a.t == b.t && a.uv == b.uv && a.edit == b.edit && a.exit == b.exit && a.group == b.group;
}

// Loop and BVH give the bits of intersect() on each quad.
TEST(Gates, ManyQuadsAgreeWithEachAlone) {
  Random random(8);
  for (const int n : {1, 3, 32, 33, 1000}) {
    std::vector<EditDescription> all;
    for (int i = 0; i < n; ++i) {
      // every fourth lies in one plane with others
      const M44d m = i % 4 == 0
                         ? at({uniform(random, -10, 10), uniform(random, -10, 10), 0})
                         : random_placement(random, random_direction(random) * uniform(random, 0, 10), true);
      all.push_back(edit_at(numbered("e", i), m, i % 5 ? "L" : "LD", n - i));
      all.back().exits.push_back(
          exit_at(numbered("x", i), random_placement(random, random_direction(random) * 8.0), 2000 + i));
    }
    Setting s(all);
    std::vector<Crossing> crossings;
    int hits = 0;
    for (int k = 0; k < 3000; ++k) {
      const V3d o = random_direction(random) * 15.0,
                d = k % 50 == 0 ? V3d(0, 0, o.z > 0 ? -1 : 1)
                                : to_double(to_float(random_direction(random) * 8.0 - o).normalized());
      const double t_max = k % 3 ? 1e9 : 15;
      const int excluded = k % 7 ? -1 : 0;
      std::optional<Crossing> best;
      std::size_t all_crossings = 0;
      for (int e = 0; e < s.edits.size(); ++e) {
        const Quad& entry = s.edits[e].entry;
        for (int x = -1; x < 1; ++x) {
          const Quad& q = s.edits.quad(e, x);
          const auto hit = intersect(q, o, d);
          all_crossings += hit && hit->t > 0 && hit->t <= t_max && q.group != excluded;
        }
        const auto hit = intersect(entry, o, d);
        if (!hit || hit->t <= 0 || hit->t > t_max || entry.group == excluded || e % 5 == 0) continue;
        if (!best || hit->t < best->t || (hit->t == best->t && entry.order < best->order))
          best = Crossing{hit->t, hit->uv, e, QuadId::entry, entry.group, entry.order};
      }
      const Segment segment{o, d, 0, t_max, excluded};
      const auto found = s.edits.first_taken(s.table, s.lit, segment);
      ASSERT_EQ(found.has_value(), best.has_value());
      EXPECT_EQ(s.edits.any_taken(s.table, s.lit, segment), best.has_value());
      if (best) {
        ++hits;
        EXPECT_TRUE(*found == *best);
      }
      s.edits.crossings(Side::Light, segment, {}, crossings);
      EXPECT_EQ(crossings.size(), all_crossings);
      for (std::size_t i = 1; i < crossings.size(); ++i) EXPECT_LE(crossings[i - 1].t, crossings[i].t);
    }
    EXPECT_GT(hits, n > 1 ? n / 3 : -1);  // the first one accepts something else
  }
}

// P3: a stack of coplanar entries that accept nothing costs no query, and none hides the one that accepts.
TEST(Gates, P3CoplanarEntries) {
  std::vector<EditDescription> all;
  for (int i = 0; i < 1000; ++i) all.push_back(edit_at(numbered("e", i), flat, i == 617 ? "L" : "LS", i));
  Setting s(all);
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const V3d p(uniform(random, -0.9, 0.9), uniform(random, -0.9, 0.9), 0), d = random_direction(random);
    if (std::abs(d.z) < 0.01) continue;
    const auto c = s.taken(p - d * 3.0, d);
    ASSERT_TRUE(c);
    EXPECT_EQ(c->edit, 617);
  }
}

// P5: one capture per edge ray, that of the lower order.
TEST(Gates, P5AnEdgeCapturesOnce) {
  Random random(6);
  const V3d x = random_direction(random), z = x.cross(random_direction(random)).normalized(), y = z.cross(x);
  std::vector<EditDescription> two{edit_at("B", placed(-x, -y, z, x * 2.0), "L", 2),
                                   edit_at("A", placed(x, y, z, V3d(0)), "L", 1)};
  for (auto& e : two) e.exits.push_back(exit_at("X", at({0, 0, 50})));
  Setting s(two);
  for (int i = 0; i < 100'000; ++i) {
    const V3d p = s.edits[1].entry.point({1, uniform(random)}), d = random_direction(random);
    if (std::abs(d.dot(z)) < 0.05) continue;
    const auto c = s.taken(p - d * 2.0, d);
    ASSERT_TRUE(c);
    EXPECT_EQ(c->edit, 1);  // closed squares: the edge belongs to both
    // behind the plane nothing is left
    EXPECT_FALSE(s.edits.first_taken(s.table, s.lit, {p - d * 2.0, d, c->t, 1e9, c->group}));
  }
}

// A receiver as a renderer has it: float32 corners, its own tessellation, hit positions in double from the
// hit triangle.
struct Receiver {
  std::vector<V3d> corners;
  double hit(const V3d& o, const V3d& d) const {  // smallest t > 0 over its triangles
    double best = infinity;
    for (std::size_t i = 0; i + 3 <= corners.size(); i += 3) {
      const V3d &a = corners[i], e = corners[i + 1] - a, f = corners[i + 2] - a, n = e.cross(f);
      const double t = n.dot(a - o) / n.dot(d);
      const V3d p = o + d * t - a;
      const double u = p.cross(f).dot(n) / n.dot(n), v = e.cross(p).dot(n) / n.dot(n);
      if (t > 0 && t < best && u >= -1e-9 && v >= -1e-9 && u + v <= 1 + 1e-9) best = t;
    }
    return best;
  }
};

Receiver make_receiver(const V3d& place, const V3d& x, const V3d& y, int cells) {
  Receiver r;
  const auto corner = [&](int i, int j) {
    return to_double(to_float(place + x * (4.0 * i / cells - 2) + y * (4.0 * j / cells - 2)));
  };
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j)
      for (const auto& p : {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j),
                            corner(i + 1, j + 1), corner(i, j + 1)})
        r.corners.push_back(p);
  return r;
}

// P1: all that leaves an exit laid on a receiver lands on it. P2: an entry laid on a receiver is met before
// it, from near and far.
TEST(Gates, P1P2QuadsLaidOnAReceiver) {
  Random random(1);
  int rays = 0;
  for (const double far : {1.0, 1e2, 1e4, 1e5}) {
    for (int i = 0; i < 60; ++i) {
      const V3d place = random_direction(random) * far, x = random_direction(random),
                z = x.cross(random_direction(random)).normalized(), y = z.cross(x);
      const Receiver receiver = make_receiver(place, x, y, 7);
      // Matrices come as float32; the entry lies beside the exit, on the same receiver.
      const auto as_float = [](M44d m) {
        for (int r = 0; r < 4; ++r)
          for (int c = 0; c < 4; ++c) m[r][c] = static_cast<double>(static_cast<float>(m[r][c]));
        return m;
      };
      std::vector<EditDescription> one{
          edit_at("A", as_float(placed(x * 0.5, y * 0.5, z, place + x * 0.7)), "L", 0)};
      one[0].exits.push_back(exit_at("X", as_float(placed(x * 0.5, y * 0.5, z, place - x * 0.7))));
      Box bounds;
      for (const V3d& p : receiver.corners) bounds.extendBy(p);
      Setting s(one, {}, V3d(0), bounds);
      for (int k = 0; k < 300; ++k) {
        V3d d = to_double(to_float(random_direction(random)));
        if (std::abs(d.dot(z)) < 0.05) continue;
        if (d.dot(z) > 0) d = -d;  // towards the receiver
        ++rays;
        const Passage out = *s.edits.forward(0, 0, {uniform(random), uniform(random)}, to_float(d));
        ASSERT_LT(receiver.hit(out.position, d), 1e-3 * far + 1e-2);
        const V3d p = s.edits[0].entry.point({uniform(random), uniform(random)}),
                  o = p - d * (k % 2 ? 1000.0 : uniform(random, 0.5, 3.5));
        const double t = receiver.hit(o, d);
        ASSERT_LT(t, infinity);
        ASSERT_TRUE(s.edits.first_taken(s.table, s.lit, {o, d, 0, t}));
        // Leaving the surface on the arrow's side crosses once; into the other side never.
        const V3d on = o + d * t;
        EXPECT_TRUE(s.edits.first_taken(s.table, s.lit, {on, -d, 0, 1e9}));
        EXPECT_FALSE(s.edits.first_taken(s.table, s.lit, {on, d, 0, 1e9}));
      }
    }
  }
  EXPECT_GT(rays, 50'000);
}

// Design §2: light leaving an exit crosses the plane's entries, all but its own, by order.
TEST(Gates, EditsLaidOnAnExit) {
  std::vector<EditDescription> all{edit_at("A", at({-10, 0, 0}), "L", 0), edit_at("B", flat, "L.*F'A'.*", 5),
                                   edit_at("C", flat, "LF'A'|LD", 2),
                                   edit_at("D", at({0.5, 0.5, 3}), "LF", 1)};
  all[0].exits.push_back(exit_at("XA", flat, 6));
  all[3].exits.push_back(exit_at("XD", at({0, 0, 3}), 9));
  Setting s(all);
  const StateId q = s.table.through(s.lit, 0);
  const Passage out = *s.edits.forward(0, 0, {0.25, 0.5}, {0, 0, -1});
  auto c = s.edits.first_taken_at_exit(s.table, q, 0, 0, out.position);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->edit, 2);
  EXPECT_NEAR(c->uv.x, 0.25, 1e-12);
  EXPECT_EQ(s.edits.first_taken_at_exit(s.table, s.table.through(q, 2), 2, straight_on, out.position)->edit,
            1);
  // the entry's own is not crossed again
  EXPECT_FALSE(s.edits.first_taken_at_exit(s.table, s.diffuse, 2, straight_on, out.position));
  EXPECT_FALSE(s.edits.first_taken_at_exit(s.table, s.lit, 0, 0, out.position));
  EXPECT_FALSE(s.edits.first_taken_at_exit(s.table, q, 0, 0, V3d(1.5, 0, out.position.z)));
  EXPECT_FALSE(s.edits.first_taken_at_exit(s.table, q, 3, 0, V3d(0, 0, 3)));  // another plane

  std::vector<Crossing> crossings;
  s.edits.crossings(Side::Light, {{-0.5, 0, 9}, {0, 0, -1}}, {}, crossings);
  ASSERT_EQ(crossings.size(), 5u);  // D and its exit, then the plane: entries by order, exits
  EXPECT_EQ(crossings[0].edit, 3);
  EXPECT_EQ(crossings[1].exit, 0);
  EXPECT_EQ(crossings[2].edit, 2);
  EXPECT_EQ(crossings[3].edit, 1);
  EXPECT_EQ(crossings[4].edit, 0);
  EXPECT_EQ(crossings[4].exit, 0);
  EXPECT_EQ(crossings[2].t, crossings[4].t);
  s.edits.crossings_at(Side::Light, crossings[2].group, out.position, {}, crossings);
  ASSERT_EQ(crossings.size(), 3u);
  EXPECT_EQ(crossings[0].edit, 2);
  const std::uint64_t only_b[] = {1u << 1};
  s.edits.crossings_at(Side::Light, crossings[2].group, out.position, only_b, crossings);
  ASSERT_EQ(crossings.size(), 1u);
  s.edits.crossings(Side::View, {{-0.5, 0, 9}, {0, 0, -1}}, {}, crossings);
  EXPECT_TRUE(crossings.empty());
}

// P14: an exit in its entry's place changes nothing; going backward undoes going forward.
TEST(Gates, P14IdentityAndReturn) {
  Random random(14);
  for (int i = 0; i < 2000; ++i) {
    const M44d m = random_placement(random, random_direction(random) * 3.0, true);
    std::vector<EditDescription> two{edit_at("same", m, "L", 0), edit_at("moved", m, "L", 1)};
    two[0].exits.push_back(exit_at("XS", m, 2));
    two[1].exits.push_back(exit_at("XM", random_placement(random, random_direction(random) * 5.0, true), 3));
    Setting s(two);
    const V3f d = to_float(random_direction(random));
    const V2d uv(uniform(random), uniform(random));
    const Passage same = *s.edits.forward(0, 0, uv, d);
    EXPECT_NEAR((same.position - s.edits[0].entry.point(uv)).length(), 0, 1e-12);
    EXPECT_NEAR((same.direction - d).length(), 0, 1e-6);
    EXPECT_EQ(same.gain, Color(1));
    const Passage there = *s.edits.forward(1, 0, uv, d), back = *s.edits.backward(1, 0, uv, -there.direction);
    EXPECT_NEAR(there.direction.length(), 1, 1e-6);
    EXPECT_NEAR((back.direction + d).length(), 0, 1e-6);
    EXPECT_NEAR((back.position - s.edits[1].entry.point(uv)).length(), 0, 1e-12);
    EXPECT_EQ(back.gain, Color(1));  // keep_brightness keeps radiance
    // In through the front of the entry, out of the back of the exit.
    const auto side = [](const Quad& q, const V3f& w) { return to_double(w).dot(q.frame.n) > 0; };
    EXPECT_EQ(side(s.edits[1].entry, d), side(s.edits[1].exits[0].quad, there.direction));
    const Passage straight = *s.edits.forward(1, straight_on, uv, d);
    EXPECT_EQ(straight.direction, d);
    EXPECT_EQ(straight.gain, Color(1));
    EXPECT_EQ(straight.group, s.edits[1].entry.group);
  }
}

TEST(Gates, ReCentringMovesNothing) {
  const V3d away(1e6, -2e6, 3e5);
  std::vector<EditDescription> here{edit_at("A", flat, "L", 0)}, there{edit_at("A", at(away), "L", 0)};
  here[0].exits.push_back(exit_at("X", at({7, 0, 0})));
  there[0].exits.push_back(exit_at("X", at(away + V3d(7, 0, 0))));
  Setting a(here), b(there, {}, away);
  const Segment segment{{0.3, 0.2, 10}, {0, 0, -1}};
  const auto ca = a.edits.first_taken(a.table, a.lit, segment),
             cb = b.edits.first_taken(b.table, b.lit, segment);
  ASSERT_TRUE(ca && cb);
  EXPECT_EQ(ca->uv, cb->uv);
  EXPECT_NEAR(cb->t, 10 - b.edits.delta(), 1e-9);
  EXPECT_DOUBLE_EQ(b.edits.delta(), 0x1p-22 * 2'000'001);
}

}  // namespace
}  // namespace sluice
