// SPDX-License-Identifier: GPL-3.0-or-later
// Images in memory, and the only door to OpenImageIO (image.cpp). Files are untrusted: kind by magic bytes,
// size checked first.
#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "base/colour.h"
#include "base/error.h"

namespace sluice {

enum class ColorSpace : std::uint8_t { Linear, SRGB, NonColor };
[[nodiscard]] constexpr const char* name_of(ColorSpace value) noexcept {
  switch (value) {
    case ColorSpace::Linear: return "Linear";
    case ColorSpace::SRGB: return "SRGB";
    case ColorSpace::NonColor: return "NonColor";
  }
  return nullptr;
}

// Pixels as float RGBA, row 0 at the bottom (v = 0), decoded to linear unless NonColor; straight
// (unassociated) alpha as Blender shows it.
struct Image {
  std::string name;
  int width = 0, height = 0;
  std::vector<float> rgba;    // 4 * width * height; empty: missing, drawn as a magenta placeholder
  std::size_t sanitised = 0;  // texels that were NaN, Inf or (colours, alpha) negative, made 0 on load

  [[nodiscard]] bool empty() const noexcept { return rgba.empty(); }
};

// Reads EXR, PNG, JPEG or HDR. Throws SceneError(name, ...) for a missing, oversized or foreign file; never
// follows URLs.
[[nodiscard]] Image load_image(const std::string& name, const std::string& path, ColorSpace space);

// Takes pixels the host has decoded (float RGBA, row 0 at the bottom).
[[nodiscard]] Image make_image(std::string name, int width, int height, std::vector<float> rgba,
                               ColorSpace space);

// Bilinear at (u, v) in [0, 1]², clamped at the border, row 0 at v = 0: the lookup of exits' textures (design
// §8). Linear RGB.
[[nodiscard]] Color sample_clamped(const Image& image, float u, float v) noexcept;

// Writes linear RGB (row 0 at the bottom): .exr as 32-bit floats with the header's strings, .png encoded as
// sRGB with 8 bits. Throws std::runtime_error.
void write_image(const std::string& path, int width, int height, std::span<const float> rgb,
                 const std::map<std::string, std::string>& header = {});

}  // namespace sluice
