// SPDX-License-Identifier: GPL-3.0-or-later
// The door to files: what is written comes back, what is foreign, broken, huge or oddly named does not get
// in.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/image.h"

namespace sluice::test {
namespace {

class ImageFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("sluice_image_test_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
               "_" + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] std::string file(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  std::filesystem::path folder_;
};

TEST_F(ImageFiles, ExrKeepsEveryBit) {
  std::vector<float> rgb;
  for (int k = 0; k < 3 * 5 * 4; ++k)
    rgb.push_back(std::ldexp(1.0f + 0.37f * static_cast<float>(k), k % 20 - 10));
  write_image(path("a.exr"), 5, 4, rgb, {{"sluice:seed", "7"}});
  const Image image = load_image("a", path("a.exr"), ColorSpace::Linear);
  ASSERT_EQ(image.width, 5);
  ASSERT_EQ(image.height, 4);
  for (std::size_t k = 0; k < 20; ++k)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(image.rgba[4 * k + c], rgb[3 * k + c]);
  EXPECT_EQ(image.rgba[3], 1);
}

TEST_F(ImageFiles, PngIsSrgbBothWays) {
  const std::vector<float> rgb{0, 0.5f, 1, 0.2140411f, 2, 0.01f};
  write_image(path("a.png"), 1, 2, rgb);
  const Image image = load_image("a", path("a.png"), ColorSpace::SRGB);
  const std::vector<float> wanted{0, 0.5f, 1, 0.2140411f, 1, 0.01f};
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(image.rgba[4 * k + c], wanted[3 * k + c], 0.005);
  const Image raw = load_image("a", path("a.png"), ColorSpace::NonColor);
  EXPECT_NEAR(raw.rgba[4], 0.5, 0.5 / 255);  // 0.214 linear is 0.5 encoded: row 1 is the upper one
}

TEST_F(ImageFiles, ForeignBrokenAndOddlyNamedFilesAreRefused) {
  const auto refuses = [](const std::string& at) {
    try {
      static_cast<void>(load_image("texture", at, ColorSpace::SRGB));
      return false;
    } catch (const SceneError& error) {
      return error.item == "texture" && !std::string(error.what()).empty();
    }
  };
  EXPECT_TRUE(refuses(path("missing.png")));
  EXPECT_TRUE(refuses(folder_.string()));
  EXPECT_TRUE(refuses(file("a.png", "P6 1 1 255 abc")));  // a PNM by another name
  EXPECT_TRUE(refuses(file("b.tif", std::string("II*\0\0\0\0\0", 8))));
  EXPECT_TRUE(refuses(file("c.png", "\x89PNG\r\n\x1a\n and nothing more")));
  EXPECT_TRUE(refuses(file("d.exr", std::string("\x76\x2f\x31\x01\x02\0\0\0", 8))));
  EXPECT_TRUE(refuses(file("e.jpg", "\xff\xd8\xff\xe0")));
  // a bomb: sizes are read before memory is taken
  EXPECT_TRUE(refuses(file("f.hdr", "#?RADIANCE\n\n-Y 99999 +X 99999\n")));
  EXPECT_TRUE(refuses(file("g.png", "")));
  EXPECT_TRUE(refuses(path("a.exr?x=1")));
  EXPECT_TRUE(refuses("http://example.org/a.png"));
  EXPECT_TRUE(refuses("a\n.png"));
  EXPECT_TRUE(refuses("/dev/zero"));
}

TEST_F(ImageFiles, TruncationNeverPasses) {
  write_image(path("whole.png"), 64, 64, std::vector<float>(3 * 64 * 64, 0.3f));
  std::ifstream in(path("whole.png"), std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  int refused = 0;
  for (std::size_t cut = 8; cut + 20 < bytes.size(); cut += 7) {
    try {
      const Image image = load_image("cut", file("cut.png", bytes.substr(0, cut)), ColorSpace::SRGB);
      EXPECT_EQ(image.rgba.size(), 4u * 64 * 64);
    } catch (const SceneError&) { ++refused; }
  }
  EXPECT_GT(refused, 0);
}

TEST(Images, PixelsAreChecked) {
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  const Image color = make_image("x", 2, 1, {nan, -1, inf, 1, 0.5f, 0.5f, 0.5f, 1}, ColorSpace::Linear);
  EXPECT_EQ(color.sanitised, 1u);
  EXPECT_EQ((std::vector<float>(color.rgba.begin(), color.rgba.begin() + 4)),
            (std::vector<float>{0, 0, 0, 1}));
  const Image direction = make_image("x", 1, 1, {-0.5f, 0.5f, 1, 1}, ColorSpace::NonColor);
  EXPECT_EQ(direction.sanitised, 0u);
  EXPECT_EQ(direction.rgba[0], -0.5f);
  EXPECT_THROW(static_cast<void>(make_image("x", 2, 2, {1, 2, 3}, ColorSpace::Linear)), SceneError);
  EXPECT_THROW(static_cast<void>(make_image("x", 20000, 1, std::vector<float>(80000), ColorSpace::Linear)),
               SceneError);
  EXPECT_THROW(static_cast<void>(make_image("x", 0, 0, {}, ColorSpace::Linear)), SceneError);
  EXPECT_NEAR(make_image("x", 1, 1, {0.5f, 0.04f, 1, 0.5f}, ColorSpace::SRGB).rgba[0], 0.2140411, 1e-6);
}

TEST(Images, ClampedLookup) {
  const Image image =
      make_image("x", 2, 2, {0, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1}, ColorSpace::Linear);
  EXPECT_EQ(sample_clamped(image, 0.5f, 0.5f), Color(0.5f, 0.5f, 0));
  EXPECT_EQ(sample_clamped(image, 0, 1), Color(0, 1, 0));
  EXPECT_EQ(sample_clamped(image, 2, -1), Color(1, 0, 0));
  EXPECT_EQ(sample_clamped(Image{}, 0.5f, 0.5f), Color(1, 0, 1));
}

}  // namespace
}  // namespace sluice::test
