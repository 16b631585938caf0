// SPDX-License-Identifier: GPL-3.0-or-later
// What one view sample brings to the film, and the render passes that are made of it. A new pass is a member
// of PixelSample with a row in `features` (without it nothing compiles), and the line that records it; sums,
// the film's layout and the passes that the host registers follow from the table.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "base/colour.h"

namespace sluice {

// The five parts of Combined, one per estimator of design §5.
enum class Part : std::uint8_t { Direct, Caustics, Edited, Indirect, Emission };
inline constexpr int part_count = 5;
[[nodiscard]] constexpr const char* name_of(Part part) noexcept {
  switch (part) {
    case Part::Direct: return "Direct";
    case Part::Caustics: return "Caustics";
    case Part::Edited: return "Edited";
    case Part::Indirect: return "Indirect";
    case Part::Emission: return "Emission";
  }
  return nullptr;
}
static_assert(name_of(Part{part_count - 1}) && !name_of(Part{part_count}), "part_count counts the parts");

// One view sample, or the mean of a pass's samples of one pixel.
struct PixelSample {
  std::array<Color, part_count> parts;  // radiance, W/m²/sr
  // luminance by which each part is expected to be too bright, as far as kernels of photons blur it
  std::array<float, part_count> bias{};
  float alpha = 0;  // 0 where the world is seen
  // along the view axis (m); the world: 1e10, as Blender has it. No mean: between two things there is nothing
  float depth = 0;
  V3f normal{0};    // shading normal at the first hit
  Color albedo{0};  // directional albedo there

  PixelSample() noexcept { parts.fill(Color(0)); }  // Imath's vectors start undefined
  [[nodiscard]] Color combined() const noexcept {
    Color sum = parts[0];
    for (std::size_t i = 1; i < part_count; ++i) sum += parts[i];
    return sum;
  }
  [[nodiscard]] float total_bias() const noexcept {
    float sum = 0;
    for (const float b : bias) sum += b;
    return sum;
  }
  void operator+=(const PixelSample& o) noexcept;
  PixelSample& operator*=(float factor) noexcept;
};

// A member of PixelSample beside its parts.
struct Feature {
  std::string_view name;      // of its render pass; empty: it is Combined's fourth channel
  std::string_view channels;  // a letter each, as files name them
  float PixelSample::*number = nullptr;
  V3f PixelSample::*vector = nullptr;
  bool is_mean = true;  // false: of the first sample that has one
};
inline constexpr Feature features[] = {
    {.name = "", .channels = "A", .number = &PixelSample::alpha},
    {.name = "Depth", .channels = "Z", .number = &PixelSample::depth, .is_mean = false},
    {.name = "Normal", .channels = "XYZ", .vector = &PixelSample::normal},
    {.name = "Albedo", .channels = "RGB", .vector = &PixelSample::albedo},
};

// Numbers of a PixelSample: of its parts, their bias, and its features.
[[nodiscard]] constexpr std::size_t count_numbers() noexcept {
  std::size_t numbers = 4 * part_count;
  for (const Feature& feature : features) numbers += feature.channels.size();
  return numbers;
}
static_assert(sizeof(PixelSample) == count_numbers() * sizeof(float), "each member has a row");

inline void PixelSample::operator+=(const PixelSample& o) noexcept {
  for (std::size_t i = 0; i < part_count; ++i) parts[i] += o.parts[i], bias[i] += o.bias[i];
  for (const Feature& f : features)
    if (f.vector)
      this->*f.vector += o.*f.vector;
    else if (f.is_mean)
      this->*f.number += o.*f.number;
    else if (this->*f.number == 0)
      this->*f.number = o.*f.number;
}
inline PixelSample& PixelSample::operator*=(float factor) noexcept {
  for (Color& part : parts) part *= factor;
  for (float& b : bias) b *= factor;
  for (const Feature& f : features)
    if (f.vector)
      this->*f.vector *= factor;
    else if (f.is_mean)
      this->*f.number *= factor;
  return *this;
}

}  // namespace sluice
