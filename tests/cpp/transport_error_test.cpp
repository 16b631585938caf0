// SPDX-License-Identifier: GPL-3.0-or-later
// What is told of a picture's error without a reference: the bias of kernels, and probes.
#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <set>

#include "scene_fixtures.h"
#include "transport/photons/density.h"
#include "transport/probes.h"
#include "transport_fixtures.h"

namespace sluice {
namespace {

const std::atomic<bool> never = false;  // cancelled

// A lattice of photons on z = 0 whose flux makes a density of x, and what the kernel makes of it.
class Lattice {
 public:
  template <class DensityOf>
  explicit Lattice(const DensityOf& density_of) {
    std::vector<std::vector<Photon>> chunks(1);
    for (int i = -150; i <= 150; ++i)
      for (int j = -80; j <= 80; ++j) {
        Photon photon;
        photon.position = V3f((static_cast<float>(i) + 0.5f) * step, static_cast<float>(j) * step, 0);
        photon.normal = photon.wi = pack_direction(V3f(0, 0, 1));
        photon.set_flux(Color(square(step) * static_cast<float>(density_of(photon.position.x))));
        photon.arrival = Arrival::Caustic;
        chunks[0].push_back(photon);
      }
    ThreadPool pool(1);
    even_.build(chunks, ~0u, 2 * radius, pool, never);
    round_.build_by_reach(chunks, ~0u, [](const Photon&) { return radius; }, pool, never);
  }
  // What is seen there (radiant exitance) and how much too bright it is said to be.
  [[nodiscard]] std::pair<double, double> at(double x, bool is_round) const {
    const Vertex v = test::white_floor({x, 0, 0});
    double seen = 0, bias = 0;
    const auto found = [&](const Photon&, const Color& radiance, float share, bool) {
      seen += radiance.x, bias += static_cast<double>(share * radiance.x);
    };
    const auto ask = [](std::uint32_t) { return SumAnswer(); };
    const SumRule one_by_one;
    if (is_round)
      (void)estimate_density(round_, Receiver(v, gathering), Reaches{radius / 2, radius * 2}, one_by_one, ask,
                             found);
    else
      (void)estimate_density(even_, Receiver(v, gathering), radius, one_by_one, ask, found);
    return {seen * pi, bias * pi};
  }

  static constexpr float radius = 0.5f, step = 0.01f;

 private:
  PhotonMap even_, round_;
};

// Where the density is a parabola, E's bias is known: its curvature times a quarter (even) or a sixth
// (Epanechnikov's) of r².
TEST(Bias, OfASmoothDensityIsToldAQuarterTooLarge) {
  const Lattice lattice([](double x) { return 1 + 2 * x * x; });
  for (const bool is_round : {false, true}) {
    const auto [seen, bias] = lattice.at(0, is_round);
    const double known = 2 * square(Lattice::radius) / (is_round ? 6 : 4);
    EXPECT_NEAR(seen - 1, known, 0.05 * known) << is_round;
    EXPECT_NEAR(bias / known, bias_per_difference * 3 / 4, 0.1) << is_round;
  }
}

// Across a step the root mean square of the bias is told a fifth too small.
TEST(Bias, OfAStepIsToldAFifthTooSmall) {
  const Lattice lattice([](double x) { return x > 0 ? 1.0 : 0.0; });
  for (const bool is_round : {false, true}) {
    double known = 0, told = 0;
    for (int i = -60; i < 60; ++i) {
      const double x = (i + 0.25) * static_cast<double>(Lattice::step);
      const auto [seen, bias] = lattice.at(x, is_round);
      known += square(seen - (x > 0 ? 1 : 0)), told += square(bias);
    }
    EXPECT_NEAR(std::sqrt(told / known), bias_per_difference / 2.15, 0.06) << is_round;
  }
}

FrameDescription frame_of(int width, int height, int x0 = 0, int y0 = 0) {
  return {
      .width = x0 + width, .height = y0 + height, .x0 = x0, .y0 = y0, .x1 = x0 + width, .y1 = y0 + height};
}

TEST(Probes, EachBlockOfThePictureHasOne) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, {64, 64}, {65, 64}, {960, 540}, {4000, 3}, {7, 3001}}) {
    const ProbeGrid grid(frame_of(width, height, 13, 5));
    EXPECT_LE(grid.size(), ProbeGrid::max_probes);
    std::map<int, int> found;
    for (int y = 0; y < height + 20; ++y)
      for (int x = 0; x < width + 20; ++x)
        if (const int probe = grid.index_of(x, y); probe >= 0) ++found[probe];
    ASSERT_EQ(static_cast<int>(found.size()), grid.size()) << width << " × " << height;
    EXPECT_EQ(found.rbegin()->first, grid.size() - 1);
    for (const auto& [probe, count] : found) EXPECT_EQ(count, 1) << probe;
    if (width * height <= ProbeGrid::max_probes) { EXPECT_EQ(grid.size(), width * height); }
  }
}

// Noise of a known deviation in one part, a bias in another whose estimates are noisy themselves, and an edit
// that makes half of the light of the first.
TEST(Probes, TellNoiseFromBiasAndPartsFromEachOther) {
  constexpr int side = 64, passes = 64;
  constexpr double deviation = 0.5, bias = 0.03;
  Probes probes(frame_of(side, side), 1);
  test::Random random(8);
  const auto noise = [&random] { return deviation * std::sqrt(3.0) * random.real(-1, 1); };
  for (int pass = 0; pass < passes; ++pass)
    for (int probe = 0; probe < side * side; ++probe) {
      PixelSample sample;
      const auto direct = static_cast<float>(0.5 + noise());
      sample.parts[static_cast<std::size_t>(Part::Direct)] = Color(direct);
      sample.parts[static_cast<std::size_t>(Part::Caustics)] = Color(0.5f);
      // above in one half of the picture, below in the other: the mean knows nothing of it
      const double sign = probe % 2 ? 1 : -1;
      sample.bias[static_cast<std::size_t>(Part::Caustics)] = static_cast<float>(sign * bias + 0.3 * noise());
      const float taken = direct / 2;
      probes.add(probe, pass, sample, {&taken, 1});
    }
  const ErrorShares shares = probes.shares(1);
  const double dark = 1.01, expected = square(deviation) / passes / dark;
  // four standard errors: of a variance from four streams, of a product of estimates whose noise is known
  const double slack = 4 * std::sqrt(2.0 / 3) / side;
  EXPECT_NEAR(shares.picture.noise / expected, 1, slack + 0.01);
  EXPECT_NEAR(shares.parts[static_cast<std::size_t>(Part::Direct)].noise / expected, 1, slack + 0.01);
  EXPECT_NEAR(shares.edits[0] / expected, 0.25, slack);
  EXPECT_EQ(shares.parts[static_cast<std::size_t>(Part::Caustics)].noise, 0);
  const double bias2 = square(bias) / dark, noise_of_bias2 = 0.09 * expected;
  const double bias_slack = 4 * (noise_of_bias2 + 2 * std::sqrt(bias2 * noise_of_bias2)) / side;
  EXPECT_LT(bias_slack, bias2 / 2) << "too noisy to tell";
  EXPECT_NEAR(shares.picture.bias, bias2, bias_slack);
  EXPECT_NEAR(shares.parts[static_cast<std::size_t>(Part::Caustics)].bias, bias2, bias_slack);
  EXPECT_EQ(shares.parts[static_cast<std::size_t>(Part::Direct)].bias, 0);
}

// A pixel in a thousand that met one path of many leaves the error of all others as it is.
TEST(Probes, TheWorstOfAThousandPixelsDoNotCount) {
  constexpr int side = 50;
  Probes quiet(frame_of(side, side), 0), with_sparks(frame_of(side, side), 0);
  test::Random random(9);
  for (int pass = 0; pass < 8; ++pass)
    for (int probe = 0; probe < side * side; ++probe) {
      PixelSample sample;
      sample.parts[0] = Color(static_cast<float>(random.real(0.9, 1.1)));
      quiet.add(probe, pass, sample, {});
      if (pass == 3 && probe % 1250 == 17) sample.parts[0] = Color(1e6f);
      with_sparks.add(probe, pass, sample, {});
    }
  EXPECT_NEAR(with_sparks.shares(1).picture.noise / quiet.shares(1).picture.noise, 1, 0.02);
}

TEST(Probes, AreSilentBeforeAllStreamsHaveAPass) {
  Probes probes(frame_of(4, 4), 0);
  PixelSample sample;
  sample.parts[0] = Color(1);
  for (int pass = 0; pass < stream_count - 1; ++pass)
    for (int probe = 0; probe < 16; ++probe) probes.add(probe, pass, sample, {});
  EXPECT_EQ(probes.shares(1).picture.total(), 0);
  EXPECT_EQ(Probes(frame_of(4, 4), 0).shares(0).picture.total(), 0);
}

}  // namespace
}  // namespace sluice
