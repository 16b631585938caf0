// SPDX-License-Identifier: GPL-3.0-or-later
// The only file that includes OpenImageIO (2.4 to 3.1). Its global limits are left alone: inside Blender the
// library is shared with the host, so sizes are checked here, between opening and reading (numerics §5).
#include "base/image.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace sluice {
namespace {

constexpr int max_side = 16384;
constexpr std::size_t max_bytes = std::size_t{1} << 30;  // of float RGBA

// The plug-in that reads the file, by its first bytes; empty for foreign files.
[[nodiscard]] std::string_view format_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 10> head{};
  file.read(head.data(), head.size());
  const std::string_view bytes(head.data(), static_cast<std::size_t>(file.gcount()));
  const auto starts = [&](std::string_view magic) { return bytes.substr(0, magic.size()) == magic; };
  if (starts("\x76\x2f\x31\x01")) return "openexr";
  if (starts("\x89PNG\r\n\x1a\n")) return "png";
  if (starts("\xff\xd8\xff")) return "jpeg";
  if (starts("#?RADIANCE") || starts("#?RGBE")) return "hdr";
  return {};
}

// OpenImageIO reads "name?key=value" as arguments and may open URLs: such names never reach it.
void check_path(const std::string& name, const std::string& path) {
  for (const char c : path)
    if (c == '?' || c == ':' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      throw SceneError(
          name,
          "the path of the image holds a character that is not allowed ('?', ':' or a control character)");
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw SceneError(name, "there is no file at '" + path + "'");
}

void check_size(const std::string& name, int width, int height) {
  if (width < 1 || height < 1 || width > max_side || height > max_side ||
      std::size_t{16} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height) > max_bytes)
    throw SceneError(name, "an image of " + std::to_string(width) + " x " + std::to_string(height) +
                               " pixels is too large; at most " + std::to_string(max_side) +
                               " a side and 64 million pixels");
}

[[nodiscard]] float to_linear(float x) noexcept {
  return x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f);
}
[[nodiscard]] float to_srgb(float x) noexcept {
  return x <= 0.0031308f ? x * 12.92f : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
}

// Replaces what no later arithmetic could stand. Non-colour texels may be negative: they are directions or
// heights.
void sanitise(Image& image, ColorSpace space) noexcept {
  for (std::size_t k = 0; k < image.rgba.size(); k += 4) {
    bool bad = false;
    for (std::size_t c = 0; c < 4; ++c) {
      float& x = image.rgba[k + c];
      const bool negative = x < 0 && (c == 3 || space != ColorSpace::NonColor);
      if (!std::isfinite(x) || negative) {
        x = 0;
        bad = true;
      }
    }
    image.sanitised += bad;
  }
}

// Spreads 1 to 4 file channels to RGBA, first row at the bottom.
[[nodiscard]] std::vector<float> to_rgba(const std::vector<float>& from, int width, int height,
                                         int channels) {
  const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height),
             n = static_cast<std::size_t>(channels);
  std::vector<float> rgba(4 * w * h);
  for (std::size_t y = 0; y < h; ++y)
    for (std::size_t x = 0; x < w; ++x) {
      const float* p = from.data() + n * ((h - 1 - y) * w + x);
      float* q = rgba.data() + 4 * (y * w + x);
      for (std::size_t c = 0; c < 3; ++c) q[c] = n >= 3 ? p[c] : p[0];
      q[3] = n == 4 ? p[3] : n == 2 ? p[1] : 1.0f;
    }
  return rgba;
}

}  // namespace

Image load_image(const std::string& name, const std::string& path, ColorSpace space) {
  check_path(name, path);
  const std::string_view format = format_of(path);
  if (format.empty()) throw SceneError(name, "'" + path + "' is none of EXR, PNG, JPEG, HDR");
  const auto input = OIIO::ImageInput::create(std::string(format));
  if (!input) throw SceneError(name, "this build of OpenImageIO cannot read " + std::string(format));
  OIIO::ImageSpec spec, wishes;
  wishes.attribute("oiio:UnassociatedAlpha", 1);  // PNG as stored
  if (!input->open(path, spec, wishes))
    throw SceneError(name, "'" + path + "' cannot be read: " + input->geterror());
  check_size(name, spec.width, spec.height);
  if (spec.nchannels < 1 || spec.depth > 1) throw SceneError(name, "'" + path + "' is not a flat image");
  const int channels = std::min(spec.nchannels, 4);
  std::vector<float> pixels(static_cast<std::size_t>(channels) * static_cast<std::size_t>(spec.width) *
                            static_cast<std::size_t>(spec.height));
  if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, pixels.data()))
    throw SceneError(name, "'" + path + "' is broken: " + input->geterror());
  std::vector<float> rgba = to_rgba(pixels, spec.width, spec.height, channels);
  if (format == "openexr")  // EXR's alpha is associated
    for (std::size_t k = 0; k < rgba.size(); k += 4)
      if (const float alpha = rgba[k + 3]; alpha > 0 && alpha < 1)
        for (std::size_t c = 0; c < 3; ++c) rgba[k + c] /= alpha;
  return make_image(name, spec.width, spec.height, std::move(rgba), space);
}

Image make_image(std::string name, int width, int height, std::vector<float> rgba, ColorSpace space) {
  check_size(name, width, height);
  if (rgba.size() != std::size_t{4} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    throw SceneError(name, "an image of " + std::to_string(width) + " x " + std::to_string(height) +
                               " pixels needs four floats a pixel");
  Image image{std::move(name), width, height, std::move(rgba), 0};
  sanitise(image, space);
  if (space == ColorSpace::SRGB)
    for (std::size_t k = 0; k < image.rgba.size(); k += 4)
      for (std::size_t c = 0; c < 3; ++c) image.rgba[k + c] = to_linear(image.rgba[k + c]);
  return image;
}

Color sample_clamped(const Image& image, float u, float v) noexcept {
  if (image.empty()) return Color(1, 0, 1);
  const float x = std::clamp(u, 0.0f, 1.0f) * static_cast<float>(image.width) - 0.5f,
              y = std::clamp(v, 0.0f, 1.0f) * static_cast<float>(image.height) - 0.5f;
  const float fx = std::floor(x), fy = std::floor(y);
  const auto texel = [&](int i, int j) {
    const auto column = static_cast<std::size_t>(std::clamp(i, 0, image.width - 1)),
               row = static_cast<std::size_t>(std::clamp(j, 0, image.height - 1));
    const float* p = image.rgba.data() + 4 * (row * static_cast<std::size_t>(image.width) + column);
    return Color(p[0], p[1], p[2]);
  };
  const int i = static_cast<int>(fx), j = static_cast<int>(fy);
  const float s = x - fx, t = y - fy;
  return (texel(i, j) * (1 - s) + texel(i + 1, j) * s) * (1 - t) +
         (texel(i, j + 1) * (1 - s) + texel(i + 1, j + 1) * s) * t;
}

void write_image(const std::string& path, int width, int height, std::span<const float> rgb,
                 const std::map<std::string, std::string>& header) {
  const bool png = path.ends_with(".png");
  if (!png && !path.ends_with(".exr"))
    throw std::runtime_error("images are written as .exr or .png, not '" + path + "'");
  const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
  if (rgb.size() != 3 * w * h) throw std::runtime_error("'" + path + "': three floats a pixel are needed");
  std::vector<float> rows(rgb.size());
  for (std::size_t y = 0; y < h; ++y)
    for (std::size_t k = 0; k < 3 * w; ++k) {
      const float x = rgb[(h - 1 - y) * 3 * w + k];
      rows[y * 3 * w + k] =
          png ? std::clamp(to_srgb(std::isfinite(x) ? std::max(x, 0.0f) : 0.0f), 0.0f, 1.0f) : x;
    }
  const auto output = OIIO::ImageOutput::create(png ? "png" : "openexr");
  if (!output) throw std::runtime_error("this build of OpenImageIO cannot write '" + path + "'");
  OIIO::ImageSpec spec(width, height, 3, png ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT);
  for (const auto& [key, value] : header) spec.attribute(key, value);
  if (!output->open(path, spec) || !output->write_image(OIIO::TypeDesc::FLOAT, rows.data()) ||
      !output->close())
    throw std::runtime_error("'" + path + "' cannot be written: " + output->geterror());
}

}  // namespace sluice
