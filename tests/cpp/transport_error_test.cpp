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

// A film and probes of a picture of which each pixel is one.
struct Picture {
  explicit Picture(int side, int edits = 0) : film(side, side), probes(frame_of(side, side), edits) {}
  // sample_of(pixel, luminance taken by the edit)
  template <class SampleOf>
  void add(int pass, const SampleOf& sample_of) {
    std::vector<std::vector<PixelSample>> tiles(static_cast<std::size_t>(film.tile_count()));
    for (int t = 0; t < film.tile_count(); ++t) {
      const Film::Box box = film.box(t);
      for (int y = box.y0; y < box.y1; ++y)
        for (int x = box.x0; x < box.x1; ++x) {
          TakenLight taken;
          const int pixel = y * film.width() + x;
          tiles[static_cast<std::size_t>(t)].push_back(sample_of(pixel, taken));
          probes.add(pixel, pass, tiles[static_cast<std::size_t>(t)].back(), {&taken, edits_});
        }
      film.add_tile(t, pass, tiles[static_cast<std::size_t>(t)]);
    }
  }
  Film film;
  Probes probes;
  std::size_t edits_ = 0;
};

// Noise of a known deviation in one part, a bias in another whose estimates are noisy themselves, and an edit
// that makes half of the light of the first.
TEST(Probes, TellNoiseFromBiasAndPartsFromEachOther) {
  constexpr int side = 64, passes = 64;
  constexpr double deviation = 0.5, bias = 0.03;
  Picture picture(side, 1);
  picture.edits_ = 1;
  test::Random random(8);
  const auto noise = [&random] { return deviation * std::sqrt(3.0) * random.real(-1, 1); };
  for (int pass = 0; pass < passes; ++pass)
    picture.add(pass, [&](int pixel, TakenLight& taken) {
      PixelSample sample;
      const auto direct = static_cast<float>(0.5 + noise());
      sample.parts[static_cast<std::size_t>(Part::Direct)] = Color(direct);
      sample.parts[static_cast<std::size_t>(Part::Caustics)] = Color(0.5f);
      // above in one half of the picture, below in the other: the mean knows nothing of it
      const double sign = pixel % 2 ? 1 : -1;
      sample.bias[static_cast<std::size_t>(Part::Caustics)] = static_cast<float>(sign * bias + 0.3 * noise());
      taken = {direct / 2, sample.bias[static_cast<std::size_t>(Part::Caustics)] / 2};
      return sample;
    });
  const ErrorShares shares = picture.probes.shares(picture.film);
  const double dark = 1.01, expected = square(deviation) / passes / dark;
  // Four standard errors: of a variance from four streams, of a product of estimates whose noise is known.
  // And what a pixel is relative to is known from two streams, and is noisy itself.
  const double slack = 4 * std::sqrt(2.0 / 3) / side, relative = 2 * deviation / std::sqrt(passes / 2.0);
  EXPECT_NEAR(shares.picture.noise / expected, 1, slack + relative);
  EXPECT_NEAR(shares.parts[static_cast<std::size_t>(Part::Direct)].noise / shares.picture.noise, 1, 1e-6);
  EXPECT_NEAR(shares.edits[0].noise / shares.picture.noise, 0.25, 0.01);
  EXPECT_NEAR(shares.edits[0].bias / shares.picture.bias, 0.25, 0.01);
  EXPECT_EQ(shares.parts[static_cast<std::size_t>(Part::Caustics)].noise, 0);
  const double bias2 = square(bias) / dark, noise_of_bias2 = 0.09 * expected;
  const double bias_slack =
      4 * (noise_of_bias2 + 2 * std::sqrt(bias2 * noise_of_bias2)) / side + relative * bias2;
  EXPECT_LT(bias_slack, bias2 / 2) << "too noisy to tell";
  EXPECT_NEAR(shares.picture.bias, bias2, bias_slack);
  EXPECT_NEAR(shares.parts[static_cast<std::size_t>(Part::Caustics)].bias, bias2, bias_slack);
  EXPECT_EQ(shares.parts[static_cast<std::size_t>(Part::Direct)].bias, 0);
}

// One path in twenty brings twenty times the mean: the pixels that found it are told to be far off, not by
// 100 % of what they show.
TEST(Probes, AreNotRelativeToWhatHasGoneWrong) {
  constexpr int side = 64, passes = 16;
  Picture picture(side);
  test::Random random(10);
  for (int pass = 0; pass < passes; ++pass)
    picture.add(pass, [&](int, TakenLight&) {
      PixelSample sample;
      sample.parts[0] = Color(random.unit() < 0.05f ? 20.0f : 0.0f);
      return sample;
    });
  const double expected = 19.0 / passes / 1.01;
  EXPECT_NEAR(std::sqrt(picture.probes.shares(picture.film).picture.noise / expected), 1, 0.25);
  EXPECT_NEAR(picture.film.relative_error() / std::sqrt(expected), 1, 0.25);
}

// A pixel in a thousand that met one path of many leaves the error of all others as it is, but for its
// neighbours, which are taken for brighter.
TEST(Probes, TheWorstOfAThousandPixelsDoNotCount) {
  constexpr int side = 50;
  Picture quiet(side), with_sparks(side);
  test::Random random(9);
  for (int pass = 0; pass < 8; ++pass) {
    std::vector<float> light(side * side);
    for (float& l : light) l = static_cast<float>(random.real(0.9, 1.1));
    const auto sample = [&](bool sparks) {
      return [&light, sparks, pass](int pixel, TakenLight&) {
        PixelSample s;
        const bool is_spark = sparks && pass == 3 && pixel % 1250 == 617;
        s.parts[0] = Color(is_spark ? 300.0f : light[static_cast<std::size_t>(pixel)]);
        return s;
      };
    };
    quiet.add(pass, sample(false)), with_sparks.add(pass, sample(true));
  }
  EXPECT_NEAR(with_sparks.probes.shares(with_sparks.film).picture.noise /
                  quiet.probes.shares(quiet.film).picture.noise,
              1, 0.03);
  EXPECT_NEAR(with_sparks.film.relative_error() / quiet.film.relative_error(), 1, 0.02);
}

TEST(Probes, AreSilentBeforeAllStreamsHaveAPass) {
  Picture picture(4);
  const auto white = [](int, TakenLight&) {
    PixelSample sample;
    sample.parts[0] = Color(1);
    return sample;
  };
  EXPECT_EQ(picture.probes.shares(picture.film).picture.total(), 0);
  for (int pass = 0; pass < stream_count - 1; ++pass) picture.add(pass, white);
  EXPECT_EQ(picture.probes.shares(picture.film).picture.total(), 0);
  EXPECT_LT(picture.film.relative_error(), 0);
}

}  // namespace
}  // namespace sluice
