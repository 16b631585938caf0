// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of a pass on their own: random streams, the film.
#include <gtest/gtest.h>

#include <set>

#include "scene_fixtures.h"
#include "transport/counts.h"
#include "transport/film.h"
#include "transport/pass.h"

namespace sluice {
namespace {

// Is there one point in each of the 64 boxes of every shape whose sides are powers of 1/base?
void expect_net(const std::vector<V2f>& points, int base) {
  ASSERT_EQ(points.size(), 64u);
  for (int columns = 1; columns <= 64; columns *= base) {
    std::set<int> boxes;
    for (const V2f& u : points) {
      ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
      boxes.insert(static_cast<int>(u.x * static_cast<float>(columns)) * 64 +
                   static_cast<int>(u.y * 64 / static_cast<float>(columns)));
    }
    EXPECT_EQ(boxes.size(), 64u) << columns << " columns";
  }
}

// Each aligned run of 2^m indices is a (0, m, 2)-net in base 2.
TEST(Sampler, PairsAreStratifiedInEveryElementaryBox) {
  for (const std::uint64_t key : {1ull, 77ull, 0xdeadbeefull})
    for (const std::uint32_t pair : {0u, 3u, 11u}) {
      std::vector<V2f> points;
      for (std::uint32_t i = 64; i < 128; ++i) points.push_back(Sampler(key, i).pair(pair));
      expect_net(points, 2);
    }
}

// Streams are nets in base 4 each, and stratify each other.
TEST(Sampler, StreamsAreNetsAloneAndTogether) {
  for (const std::uint64_t key : {1ull, 77ull, 0xdeadbeefull})
    for (const std::uint32_t pair : {0u, 3u, 11u}) {
      std::vector<V2f> together;
      for (std::uint32_t stream = 0; stream < 4; ++stream) {
        std::vector<V2f> alone;
        for (std::uint32_t i = 0; i < 64; ++i) alone.push_back(Sampler(key, i, stream).pair(pair));
        expect_net(alone, 4);
        together.insert(together.end(), alone.begin(), alone.begin() + 16);
      }
      expect_net(together, 4);
    }
}

// Numerics D9, and §10 "streams": the mean of four streams converges as fast as one sequence should.
TEST(Sampler, StreamsConvergeFasterThanChance) {
  double squares = 0;
  constexpr int trials = 200, passes = 256;
  for (int t = 0; t < trials; ++t) {
    double sum = 0;
    for (std::uint32_t pass = 0; pass < passes; ++pass) {
      const V2f u = Sampler(key_of(9, Purpose::View, static_cast<std::uint64_t>(t)), pass / stream_count,
                            pass % stream_count)
                        .pair(2);
      sum += u.x * u.y;
    }
    squares += square(sum / passes - 0.25);
  }
  const double rmse = std::sqrt(squares / trials), by_chance = std::sqrt(7.0 / 144 / passes);
  EXPECT_LT(rmse, by_chance / 20);
}

TEST(Sampler, NeverReachesOne) {
  EXPECT_LT(to_unit(0xffffffffu), 1.0f);
  EXPECT_EQ(to_unit(0), 0.0f);
}

std::vector<PixelSample> samples_of(const Film& film, int tile, int pass) {
  const Film::Box box = film.box(tile);
  std::vector<PixelSample> samples;
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      PixelSample sample;
      sample.parts[static_cast<std::size_t>((x + y + pass) % part_count)] =
          Color(static_cast<float>(x) / 3, static_cast<float>(y) / 7, 1.0f / static_cast<float>(pass + 1));
      sample.alpha = 1, sample.depth = 2;
      samples.push_back(sample);
    }
  return samples;
}

TEST(Film, PartsSumToCombinedAndTilesMayComeInAnyOrder) {
  Film forward(70, 45), backward(70, 45);
  for (int pass = 0; pass < 10; ++pass) {
    for (int t = 0; t < forward.tile_count(); ++t) forward.add_tile(t, pass, samples_of(forward, t, pass));
    for (int t = backward.tile_count(); t-- > 0;) backward.add_tile(t, pass, samples_of(backward, t, pass));
    if ((pass + 1) % passes_per_block == 0) forward.close_block(), backward.close_block();
  }
  EXPECT_EQ(forward.hash(), backward.hash());
  EXPECT_EQ(forward.finished_passes(), 10);
  const auto combined = forward.image("Combined");
  std::vector<double> sum(70 * 45 * 3, 0.0);
  for (const char* part : {"Direct", "Caustics", "Edited", "Indirect", "Emission"}) {
    const auto image = forward.image(part);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += image[i];
  }
  for (std::size_t p = 0; p < 70 * 45; ++p)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(combined[p * 4 + c], sum[p * 3 + c], 1e-5);
  EXPECT_FLOAT_EQ(forward.image("Depth")[0], 2);
}

// At an edge some samples see the world, 1e10 m away: a mean would lie where nothing is.
TEST(Film, DepthIsThatOfOneSampleOfPassZero) {
  const auto pixel = [](float a, float b) {  // the mean of two samples
    PixelSample mean, first, second;
    first.depth = a, second.depth = b;
    mean += first *= 0.5f;
    return mean += second *= 0.5f, std::vector<PixelSample>{mean};
  };
  Film in_order(1, 1), backward(1, 1);
  for (int pass = 0; pass < 6; ++pass) in_order.add_tile(0, pass, pixel(pass == 0 ? 3 : 1e10f, 1e10f));
  for (int pass = 6; pass-- > 0;) backward.add_tile(0, pass, pixel(pass == 0 ? 3 : 1e10f, 1e10f));
  EXPECT_EQ(in_order.image("Depth")[0], 3.0f);
  EXPECT_EQ(backward.image("Depth")[0], 3.0f);
  EXPECT_EQ(in_order.hash(), backward.hash());
}

// The estimate is the truth on average: pixels of pure noise with a known standard deviation.
TEST(Film, RelativeErrorIsThatOfTheNoise) {
  constexpr int side = 64, passes = 64;
  Film film(side, side);
  test::Random random(6);
  double worst = 0;
  for (int pass = 0; pass < passes; ++pass)
    for (int t = 0; t < film.tile_count(); ++t) {
      auto samples = samples_of(film, t, pass);
      for (PixelSample& s : samples) {
        s.parts.fill(Color(0));
        s.parts[0] = Color(static_cast<float>(1 + 0.5 * (random.real(-1, 1) * std::sqrt(3.0))));
      }
      film.add_tile(t, pass, samples);
    }
  const double expected = 0.5 / std::sqrt(passes) / std::sqrt(1.01);
  worst = std::abs(film.relative_error() / expected - 1);
  EXPECT_LT(worst, 4 * std::sqrt(2.0 / 3) / side / 2)
      << "four standard errors of a variance from 4 streams over 64² pixels";
}

TEST(Ledger, ATermThatIsNoNumberIsTheWorstOfErrors) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ((Ledger{.emitted = 2, .absorbed = 1}).relative_residual(), 0.5);
  EXPECT_EQ((Ledger{.emitted = 2, .absorbed = nan}).relative_residual(), infinity);
  EXPECT_EQ((Ledger{.emitted = nan}).relative_residual(), infinity);
  EXPECT_EQ((Ledger{.emitted = infinity, .absorbed = 1}).relative_residual(), infinity);
  EXPECT_EQ(Ledger{}.relative_residual(), 0);
}

// Numerics D7.
TEST(Film, DoubleSumsDoNotDrift) {
  Film film(1, 1);
  PixelSample sample;
  sample.parts[0] = Color(0.1f);
  for (int pass = 0; pass < 1000000; ++pass) {
    film.add_tile(0, pass, {sample});
    if ((pass + 1) % passes_per_block == 0) film.close_block();
  }
  EXPECT_NEAR(film.image("Direct")[0] / 0.1f, 1, 1e-7);
}

}  // namespace
}  // namespace sluice
