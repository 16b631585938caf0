// SPDX-License-Identifier: GPL-3.0-or-later
// Procedural textures: Checker, Gradient, Noise, Wave. Value for value Blender's.
#include "shading/compiler.h"
#include "shading/noise.h"

namespace sluice {
namespace {

using Type = Value::Type;

// Blender nudges lookups so that faces at whole coordinates do not flicker.
[[nodiscard]] V3f nudged(const V3f& p) noexcept { return (p + V3f(1e-6f)) * 0.999999f; }

Register checker(const Instruction& i, const Evaluation& e) noexcept {
  const V3f p = nudged(operand(i, e, 0) * number(i, e, 1));
  const auto odd = [](float x) { return std::isfinite(x) && std::fmod(std::abs(std::floor(x)), 2.0f) == 1; };
  return Register((odd(p.x) == odd(p.y)) == odd(p.z) ? 1.0f : 0.0f);
}
Register choose_color(const Instruction& i, const Evaluation& e) noexcept {
  return number(i, e, 0) == 1 ? operand(i, e, 1) : operand(i, e, 2);
}

Value checker_node(NodeReader& n, std::string_view output) {
  const Value factor =
      n.emit(checker, Type::Number, {n.texture_vector("Vector", true), n.number("Scale", 5)});
  return output == "Fac" || output == "Factor"
             ? factor
             : n.emit(choose_color, Type::Rgb, {factor, n.color("Color1"), n.color("Color2")});
}

Register gradient(const Instruction& i, const Evaluation& e) noexcept {
  const V3f p = operand(i, e, 0);
  const float sphere = std::max(0.999999f - p.length(), 0.0f), x = std::clamp(p.x, 0.0f, 1.0f);
  float value = 0;
  switch (i.choice) {
    case 0: value = p.x; break;
    case 1: value = square(std::max(p.x, 0.0f)); break;
    case 2: value = x * x * (3 - 2 * x); break;
    case 3: value = 0.5f * (p.x + p.y); break;
    case 4: value = sphere; break;
    case 5: value = sphere * sphere; break;
    default: value = std::atan2(p.y, p.x) / (2 * pi) + 0.5f;
  }
  return Register(std::clamp(value, 0.0f, 1.0f));
}
Value gradient_node(NodeReader& n, std::string_view output) {
  const int choice = n.choose("gradient_type", {"LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL",
                                                "QUADRATIC_SPHERE", "RADIAL"});
  return n.emit(gradient, output == "Color" ? Type::Rgb : Type::Number, {n.texture_vector("Vector", true)},
                {.choice = choice});
}

// Operands: vector, scale, detail, roughness, distortion, lacunarity. Flag: colour (three values) instead of
// one.
Register noise_texture(const Instruction& i, const Evaluation& e) noexcept {
  V3f p = operand(i, e, 0) * number(i, e, 1);
  const float detail = number(i, e, 2), roughness = number(i, e, 3), distortion = number(i, e, 4),
              lacunarity = number(i, e, 5);
  if (distortion != 0) {
    const V3f q = p;
    p += V3f(noise::signed_perlin(q + noise::offset(0)), noise::signed_perlin(q + noise::offset(1)),
             noise::signed_perlin(q + noise::offset(2))) *
         distortion;
  }
  const float value = noise::fractal(p, detail, roughness, lacunarity);
  if (!i.flag) return Register(value);
  return {value, noise::fractal(p + noise::offset(3), detail, roughness, lacunarity),
          noise::fractal(p + noise::offset(4), detail, roughness, lacunarity)};
}
Value noise_node(NodeReader& n, std::string_view output) {
  if (n.option("noise_dimensions", "3D") != "3D")
    n.warn("only noise of three dimensions is supported; it is used");
  if (n.option("noise_type", "FBM") != "FBM" || !n.flag("normalize", true))
    n.warn("only normalised fBM noise is supported; it is used");
  const bool color = output == "Color";
  // Blender 4.0 added the socket
  const Value lacunarity = n.is_given("Lacunarity") ? n.number("Lacunarity", 2) : n.constant(2.0f);
  return n.emit(noise_texture, color ? Type::Rgb : Type::Number,
                {n.texture_vector("Vector", true), n.number("Scale", 5), n.number("Detail", 2),
                 n.number("Roughness", 0.5f), n.number("Distortion"), lacunarity},
                {.flag = color});
}

// Choice: profile (0 sine, 1 saw, 2 triangle) + 4 * direction (0-2 axis, 3 diagonal or spherical). Flag:
// rings.
Register wave(const Instruction& i, const Evaluation& e) noexcept {
  const V3f p = nudged(operand(i, e, 0) * number(i, e, 1));
  const int direction = i.choice / 4, profile = i.choice % 4;
  float n;
  if (i.flag) {
    V3f r = p;
    if (direction < 3) r[direction] = 0;
    n = r.length() * 20;
  } else {
    n = direction < 3 ? p[direction] * 20 : (p.x + p.y + p.z) * 10;
  }
  n += number(i, e, 6);
  if (const float distortion = number(i, e, 2); distortion != 0)
    n += distortion * (noise::fractal(p * number(i, e, 4), number(i, e, 3), number(i, e, 5), 2) * 2 - 1);
  if (profile == 0) return Register(0.5f + 0.5f * std::sin(n - pi / 2));
  n /= 2 * pi;
  return Register(profile == 1 ? n - std::floor(n) : std::abs(n - std::floor(n + 0.5f)) * 2);
}
Value wave_node(NodeReader& n, std::string_view output) {
  const bool rings = n.choose("wave_type", {"BANDS", "RINGS"}) == 1;
  const int direction = rings ? n.choose("rings_direction", {"X", "Y", "Z", "SPHERICAL"})
                              : n.choose("bands_direction", {"X", "Y", "Z", "DIAGONAL"});
  const int profile = n.choose("wave_profile", {"SIN", "SAW", "TRI"});
  return n.emit(
      wave, output == "Color" ? Type::Rgb : Type::Number,
      {n.texture_vector("Vector", true), n.number("Scale", 5), n.number("Distortion"), n.number("Detail", 2),
       n.number("Detail Scale", 1), n.number("Detail Roughness", 0.5f), n.number("Phase Offset")},
      {.choice = profile + 4 * direction, .flag = rings});
}

constexpr std::pair<std::string_view, Builder> table[] = {
    {"TexChecker", checker_node},
    {"TexGradient", gradient_node},
    {"TexNoise", noise_node},
    {"TexWave", wave_node},
};

}  // namespace

Builders procedural_nodes() { return table; }

}  // namespace sluice
