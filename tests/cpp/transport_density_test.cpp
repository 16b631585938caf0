// SPDX-License-Identifier: GPL-3.0-or-later
// Stored photons, their map, and what is estimated with it: densities, and how wide.
#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "scene_fixtures.h"
#include "transport/photons/density.h"
#include "scene/camera.h"
#include "transport/guide.h"
#include "transport_fixtures.h"

namespace sluice {
namespace {

const std::atomic<bool> never = false;  // cancelled

TEST(Photon, DirectionsComeBackWithinFiveThousandthsOfADegree) {
  test::Random random(1);
  float worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const V3f d = random.direction();
    const V3f back = unpack_direction(pack_direction(d));
    EXPECT_NEAR(back.length(), 1, 1e-6);
    worst = std::max(worst, (back - d).length());
  }
  for (const V3f& axis :
       {V3f(1, 0, 0), V3f(-1, 0, 0), V3f(0, 1, 0), V3f(0, -1, 0), V3f(0, 0, 1), V3f(0, 0, -1)})
    worst = std::max(worst, (unpack_direction(pack_direction(axis)) - axis).length());
  EXPECT_LT(worst, 5e-3 * pi / 180);
}

TEST(Photon, FluxKeepsSixteenBitsOfTheLargestChannel) {
  test::Random random(2);
  for (int i = 0; i < 100000; ++i) {
    const auto scale = static_cast<float>(std::pow(10.0, random.real(-25, 25)));
    const Color flux(random.unit() * scale, random.unit() * scale, random.unit() * scale);
    Photon photon;
    photon.set_flux(flux);
    const Color back = photon.flux();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(back[c], flux[c], max_component(flux) * 0x1p-16f) << flux;
  }
  Photon black;
  black.set_flux(Color(0));
  EXPECT_EQ(black.flux(), Color(0));
}

TEST(Photon, KeepsItsState) {
  Photon photon;
  for (const std::uint32_t q : {0u, 1u, 0x123456u, 0x7fffffu}) {
    photon.q = q;
    EXPECT_EQ(photon.q, q);
  }
}

std::vector<std::vector<Photon>> random_photons(test::Random& random, int chunks, int each, const V3d& centre,
                                                double spread) {
  std::vector<std::vector<Photon>> all(static_cast<std::size_t>(chunks));
  for (auto& chunk : all)
    for (int i = 0; i < each; ++i) {
      Photon photon;
      photon.position =
          V3f(centre + V3d(random.real(-1, 1), random.real(-1, 1), random.real(-0.1, 0.1)) * spread);
      photon.q = random.bits() & 0x7fffffu;
      photon.arrival = static_cast<Arrival>(random.bits() & 3u);
      chunk.push_back(photon);
    }
  return all;
}

// Numerics D5: also with cells far smaller than the scene and far from the origin.
TEST(PhotonMap, FindsWhatBruteForceFinds) {
  ThreadPool pool(2);
  for (const auto& [spread, radius, cell] : {std::tuple{1.0, 0.1f, 0.2f},
                                             {1.0, 0.5f, 0.05f},
                                             {1e4, 500.0f, 1000.0f},
                                             {1.0, 0.02f, 0.2f},
                                             {1e6, 1e-7f, 2e-7f}}) {
    test::Random random(3);
    const auto chunks = random_photons(random, 5, 400, V3d(spread * 3, 0, -spread), spread);
    PhotonMap map;
    map.build(chunks, 0b0101, cell, pool, never);
    for (int query = 0; query < 500; ++query) {
      const V3f p = chunks[0][static_cast<std::size_t>(query % 400)].position +
                    V3f(random.direction() * radius * random.unit());
      std::multiset<std::uint32_t> found, expected;
      map.query(p, radius, [&](const Photon& photon) { found.insert(photon.q); });
      for (const auto& chunk : chunks)
        for (const Photon& photon : chunk) {
          const V3f d = photon.position - p;
          if ((static_cast<unsigned>(photon.arrival) & 1) == 0 &&
              d.x * d.x + (d.y * d.y + d.z * d.z) < radius * radius)
            expected.insert(photon.q);
        }
      ASSERT_EQ(found, expected) << spread << ' ' << query;
    }
  }
}

// By their own reach, from one that holds everything to a millionth of it, alike and mixed.
TEST(PhotonMap, FindsThePhotonsWhoseReachHoldsThePlace) {
  ThreadPool pool(2);
  for (const auto& [spread, least, most] : {std::tuple{1.0, 0.05f, 0.05f},
                                            {1.0, 1e-3f, 0.7f},
                                            {1e4, 3.0f, 4000.0f},
                                            {1e6, 2.0f, 3e5f},
                                            {1e-3, 1e-9f, 1e-3f}}) {
    test::Random random(8);
    auto chunks = random_photons(random, 5, 400, V3d(spread, 0, -spread), spread);
    const float decades = std::log(most / least);
    const auto reach_of = [&, least = least](const Photon& photon) {
      return least * std::exp(decades * static_cast<float>(photon.q & 0xffffu) / 65535.0f);
    };
    PhotonMap map;
    map.build_by_reach(chunks, 0b0101, reach_of, pool, never);
    std::size_t count = 0;
    for (int query = 0; query < 500; ++query) {
      const Photon& near = chunks[0][static_cast<std::size_t>(query % 400)];
      const V3f p = near.position + V3f(random.direction() * reach_of(near) * random.unit());
      const Reaches some =
          query % 3 ? Reaches{least * 0.99f, most * 1.01f} : Reaches{least * 0.99f, reach_of(near)};
      std::multiset<std::uint32_t> found, expected;
      map.query(p, some, V3f(1.0001f), [&](const Photon& photon, float per_reach2) {
        EXPECT_NEAR(per_reach2 * square(reach_of(photon)), 1, 1e-5);
        if (reach_of(photon) <= some.max) found.insert(photon.q);
      });
      for (const auto& chunk : chunks)
        for (const Photon& photon : chunk) {
          const float per_reach2 = 1 / square(reach_of(photon));
          if ((static_cast<unsigned>(photon.arrival) & 1) == 0 && reach_of(photon) <= some.max &&
              (photon.position - p).length2() * per_reach2 < 1)
            expected.insert(photon.q);
        }
      ASSERT_EQ(found, expected) << spread << ' ' << query;
      count += found.size();
    }
    EXPECT_GT(count, 200u);
  }
}

TEST(PhotonMap, OrderDoesNotDependOnThreads) {
  test::Random random(4);
  const auto chunks = random_photons(random, 7, 300, V3d(0), 1);
  std::vector<std::vector<std::uint32_t>> orders;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    PhotonMap map;
    map.build(chunks, 0b1111, 0.2f, pool, never);
    orders.emplace_back();
    map.query(V3f(0), 0.7f, [&](const Photon& photon) { orders.back().push_back(photon.q); });
  }
  EXPECT_GT(orders[0].size(), 100u);
  EXPECT_EQ(orders[0], orders[1]);
  EXPECT_EQ(orders[0], orders[2]);
}

// At whatever moment: keys that a build before left must not be counted in a smaller table (sanitizers and
// checked vectors see it).
TEST(PhotonMap, ACancelledBuildLeavesItEmpty) {
  test::Random random(5);
  const auto chunks = random_photons(random, 1000, 400, V3d(0), 1);
  ThreadPool pool(1);
  PhotonMap map;
  for (int microseconds = 0; microseconds < 1000; microseconds += 20) {
    map.build(chunks, 0b1111, 0.01f, pool, never);
    ASSERT_EQ(map.size(), 400'000u);
    std::atomic<bool> cancelled = false;
    std::thread host([&] {
      const auto begin = std::chrono::steady_clock::now();
      while (std::chrono::steady_clock::now() - begin < std::chrono::microseconds(microseconds)) {}
      cancelled = true;
    });
    map.build(chunks, 0b1111, 0.01f, pool, cancelled);
    host.join();
    std::size_t found = 0;
    map.query(V3f(0), 0.1f, [&](const Photon&) { ++found; });
    EXPECT_TRUE(map.size() == 400'000u || (map.size() == 0 && found == 0)) << map.size();
  }
}

// One radius for all photons, or kernels that are their own, by their states: as far as blurs as much, or a
// little further or less far.
enum class Kernel { Even, Round };
float reach_of(const Photon& photon, float radius) {
  return std::sqrt(1.5f) * radius * (1 + 0.2f * static_cast<float>((photon.q + 1) % 3 - 1.0f));
}

void build(PhotonMap& map, Kernel kernel, PhotonMap::Chunks chunks, float radius, ThreadPool& pool) {
  if (kernel == Kernel::Even)
    map.build(chunks, ~0u, 2 * radius, pool, never);
  else
    map.build_by_reach(
        chunks, ~0u, [radius](const Photon& photon) { return reach_of(photon, radius); }, pool, never);
}

template <class Ask, class Found>
Sum density(const PhotonMap& map, Kernel kernel, float radius, const SumRule& rule, Ask&& ask,
            Found&& found) {
  const Vertex floor = test::white_floor();
  const Receiver receiver(floor, gathering);
  if (kernel == Kernel::Even) return estimate_density(map, receiver, radius, rule, ask, found);
  return estimate_density(map, receiver, Reaches{0.9f * radius, 1.5f * radius}, rule, ask, found);
}

// What a kernel makes of a square lattice of photons on z = 0, each of flux 1 for its cell, seen by a white
// diffuse floor at the origin: the sum of the weights, that of their products with x², and that of their
// squares.
struct KernelSums {
  double all = 0, blur = 0, squares = 0;
};
KernelSums sums_of(Kernel kernel, float radius, float step) {
  const V3f up(0, 0, 1);
  std::vector<std::vector<Photon>> chunks(1);
  for (int i = -400; i <= 400; ++i)
    for (int j = -400; j <= 400; ++j) {
      Photon photon;
      photon.position = V3f(static_cast<float>(i) * step, static_cast<float>(j) * step, 0);
      photon.normal = photon.wi = pack_direction(up);
      photon.set_flux(Color(step * step));
      photon.arrival = Arrival::Caustic, photon.q = 3;
      chunks[0].push_back(photon);
    }
  ThreadPool pool(1);
  PhotonMap map;
  build(map, kernel, chunks, radius, pool);
  KernelSums sums;
  const auto found = [&](const Photon& photon, const Color& radiance, float, bool) {
    const double weight = radiance.x * pi;
    sums.all += weight, sums.blur += weight * square(photon.position.x), sums.squares += square(weight);
  };
  const auto ask = [](std::uint32_t) { return SumAnswer(); };
  EXPECT_EQ(density(map, kernel, radius, {}, ask, found).photons, 0u);
  return sums;
}

TEST(Density, KernelsKeepLightAndBlurAlikeAndTheRoundOneHasLessNoise) {
  const float radius = 0.3f, step = 0.002f;
  const KernelSums even = sums_of(Kernel::Even, radius, step), round = sums_of(Kernel::Round, radius, step);
  for (const KernelSums& sums : {even, round}) {
    EXPECT_NEAR(sums.all, 1, 2e-3);
    EXPECT_NEAR(sums.blur, square(radius) / 4, 2e-3 * square(radius) / 4);
  }
  EXPECT_NEAR(round.squares / even.squares, 8.0 / 9, 3e-3);
}

// Wherever photons lie and however far they reach, receivers all over the floor get what they carry. Exact
// but for the receivers' lattice.
TEST(Density, WidthsOfAllKindsKeepLight) {
  ThreadPool pool(1);
  const float step = 0.01f;
  for (const bool sums : {false, true}) {
    test::Random random(9);
    std::vector<std::vector<Photon>> chunks(1);
    double carried = 0, received = 0;
    for (std::uint32_t i = 0; i < 40; ++i) {
      Photon photon;
      photon.position = V3f(random.unit() - 0.5f, random.unit() - 0.5f, 0);
      photon.normal = photon.wi = pack_direction(V3f(0, 0, 1));
      photon.set_flux(Color(random.unit()));
      photon.arrival = Arrival::Caustic, photon.q = i;
      carried += photon.flux().x;
      chunks[0].push_back(photon);
    }
    const auto reach = [](const Photon& photon) {
      return 0.1f * std::exp2(static_cast<float>(photon.q % 8) / 2.5f);
    };
    PhotonMap map;
    map.build_by_reach(chunks, ~0u, reach, pool, never);
    for (int x = -150; x <= 150; ++x)
      for (int y = -150; y <= 150; ++y) {
        const Vertex v = test::white_floor(V3d(x, y, 0) * step);
        const auto found = [&](const Photon&, const Color& radiance, float, bool) { received += radiance.x; };
        received += estimate_density(
                        map, Receiver(v, gathering), Reaches{0.09f, 0.8f}, {sums, 10, false},
                        [](std::uint32_t) { return SumAnswer(); }, found)
                        .radiance.x;
      }
    EXPECT_NEAR(received * pi * square(step) / carried, 1, 1e-3) << sums;
  }
}

// What is added up at once is what would have been found one by one, in a corner where some photons lie on
// the wall. Of the states 0 to 3 one is not in the sum, one is handed over as well.
void expect_the_same_sum(Kernel kernel, float radius, int depth, bool asks) {
  test::Random random(7);
  auto chunks = random_photons(random, 6, 5000, V3d(0), 1);
  std::uint32_t number = 0;
  for (auto& chunk : chunks)
    for (Photon& photon : chunk) {
      const bool on_floor = random.unit() < 0.8f;
      photon.position = on_floor ? V3f(photon.position.x, photon.position.y, 0.01f * random.unit())
                                 : V3f(0.1f, photon.position.y, std::abs(photon.position.x));
      photon.wi = pack_direction(V3f(0, 0, 1));
      photon.normal = pack_direction(on_floor ? V3f(0.1f * random.unit(), 0, 1).normalized() : V3f(-1, 0, 0));
      photon.set_flux(Color(random.unit(), random.unit(), random.unit()));
      photon.depth = static_cast<std::uint8_t>(random.bits() & 15u);
      photon.q = 4 * number++ + (random.bits() & 3u), photon.met_gate = random.unit() < 0.2f;
    }
  ThreadPool pool(1);
  PhotonMap map;
  build(map, kernel, chunks, radius, pool);
  const auto ask = [](std::uint32_t q) { return SumAnswer{q % 4 != 1, q % 4 == 1 || q % 4 == 2}; };
  std::set<std::uint32_t> summed, handed_over;
  V3d expected(0);
  double bias = 0;
  density(map, kernel, radius, {}, ask, [&](const Photon& photon, const Color& radiance, float share, bool) {
    const bool may_be = !photon.met_gate && photon.depth <= depth,
               is_summed = may_be && (!asks || ask(photon.q).is_summed);
    if (is_summed) expected += V3d(radiance), summed.insert(photon.q), bias += share * luminance(radiance);
    if (!may_be || (asks && ask(photon.q).is_handed_over)) handed_over.insert(photon.q);
  });
#if defined(__AVX2__)
  const bool sums_lanes = true;
#else
  const bool sums_lanes = false;
#endif
  std::set<std::uint32_t> found;
  const Sum sum = density(map, kernel, radius, {true, depth, asks}, ask,
                          [&](const Photon& photon, const Color&, float, bool is_summed) {
                            found.insert(photon.q);
                            EXPECT_EQ(is_summed, sums_lanes && summed.contains(photon.q));
                          });
  if (!sums_lanes) {
    EXPECT_EQ(sum.photons, 0u);
    return;
  }
  EXPECT_GT(summed.size(), 10u);
  EXPECT_GT(handed_over.size(), 10u);
  EXPECT_EQ(sum.photons, summed.size());
  EXPECT_EQ(found, handed_over);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum.radiance[c] / expected[c], 1, 1e-5);
  EXPECT_NEAR(sum.bias, bias, 1e-4 * luminance(expected));
}
TEST(Density, SumsAreThoseOfTheirPhotons) {
  for (const float radius : {0.1f, 0.3f})
    for (const int depth : {3, 7})
      for (const bool asks : {false, true})
        for (const Kernel kernel : {Kernel::Even, Kernel::Round})
          expect_the_same_sum(kernel, radius, depth, asks);
}

// What a receiver looks for holds every photon whose kernel holds the receiver, near the camera and beside
// the picture, in pictures of few pixels and of many; radii follow the footprint there, in scenes of any
// size.
TEST(Disks, ReceiversLookAsFarAsKernelsReach) {
  for (const auto& [kind, lens, pixels, scale] : {std::tuple{CameraKind::Perspective, 50.0f, 1920, 1.0},
                                                  {CameraKind::Perspective, 50.0f, 32, 1e4},
                                                  {CameraKind::Perspective, 5.0f, 64, 1e-3},
                                                  {CameraKind::Perspective, 1.0f, 64, 1.0},
                                                  {CameraKind::Orthographic, 50.0f, 64, 1.0}}) {
    CameraDescription camera;
    camera.kind = kind, camera.lens = lens, camera.ortho_scale = static_cast<float>(2 * scale);
    FrameDescription frame;
    frame.width = pixels, frame.height = pixels / 2;
    const Camera placed(camera, frame, V3d(0));
    const TransportSettings settings;
    const DiskBounds bounds(placed, frame, settings);
    test::Random random(10);
    int held = 0;
    for (int i = 0; i < 20000; ++i) {
      const V3f p(random.direction() * static_cast<float>(scale * std::pow(10.0, random.real(-2, 2))));
      const bool soft = random.unit() < 0.5f;
      const float needed =
                      static_cast<float>(placed.footprint(V3d(p))) * std::pow(10.0f, random.unit() * 3 - 1),
                  shrunk = std::pow(0.1f, random.unit());
      const float reach = bounds.reach(p, soft, random.unit() < 0.8f ? &needed : nullptr, shrunk);
      const V3f v = p + random.direction() * reach * random.unit();
      const Reaches reaches = bounds.around(v, shrunk);
      ASSERT_TRUE(std::isfinite(reach) && reach > 0);
      EXPECT_LE(reaches.min, reach) << p << v;
      EXPECT_GE(reaches.max, reach) << p << v;
      held += reaches.max < 4 * reach;
    }
    EXPECT_GT(held, 1000);
  }
}

// Edges of cells leave no trace: where lookups are spread over a cell, their mean passes evenly from one
// cell's radius to the next one's.
TEST(RadiusCache, LookupsPassEvenlyFromCellToCell) {
  RadiusCache disks;
  disks.levels.emplace_back(1.0);
  disks.levels.emplace_back(3.0);
  disks.levels[0].at({0.5, 0.5, 0.5}) = 1, disks.levels[0].at({1.5, 0.5, 0.5}) = 2;
  disks.levels[1].at({1.5, 1.5, 1.5}) = 5;
  test::Random random(6);
  for (const double x : {0.5, 0.75, 1.0, 1.25, 1.5}) {
    double sum = 0;
    for (int i = 0; i < 20000; ++i) sum += *disks.find({x, 0.5, 0.5}, {random.real(-0.5, 0.5), 0, 0});
    EXPECT_NEAR(sum / 20000, 0.5 + x, 0.015) << x;
  }
  EXPECT_EQ(*disks.find({0.5, 0.5, 0.9}, {0, 0, 0.5}), 1);  // off the surface: its own cell answers
  EXPECT_EQ(*disks.find({2.5, 0.5, 0.5}, V3d(0)), 5);       // a larger one
  EXPECT_EQ(disks.find({4, 0.5, 0.5}, V3d(0)), nullptr);
}

}  // namespace
}  // namespace sluice
