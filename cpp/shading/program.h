// SPDX-License-Identifier: GPL-3.0-or-later
// What a node tree is compiled to: instructions over registers, in order, then closures that read registers
// and add lobes. A node is a builder and one or a few operations in the same nodes_*.cpp. Operations see a
// point and their operands, nothing else.
#pragma once
#include <array>
#include <vector>

#include "base/image.h"
#include "shading/bsdf.h"
#include "shading/surface_point.h"

namespace sluice {

// a number fills all three components, so numbers, vectors and colours mix without conversion
using Register = V3f;
inline constexpr int max_registers = 256;
inline constexpr int max_operands = 8;

template <std::size_t size>
[[nodiscard]] constexpr std::array<std::int16_t, size> no_operands() noexcept {
  std::array<std::int16_t, size> none{};
  none.fill(-1);
  return none;
}

struct Program;
struct Instruction;

struct Evaluation {
  const Program& program;
  const SurfacePoint& point;
  Register* registers;
  float specular_threshold;

  [[nodiscard]] const Register& read(std::int16_t operand) const noexcept;
};

// Reads instruction.in, writes the result.
using Operation = Register (*)(const Instruction&, const Evaluation&) noexcept;

struct Instruction {
  Operation operation;
  // >= 0: register, < 0: constant ~in
  std::array<std::int16_t, max_operands> in = no_operands<max_operands>();
  std::int16_t out = 0;
  std::int16_t item = -1;   // index of an image, table, UV map ... as the operation likes
  std::uint8_t choice = 0;  // which variant of the operation
  std::uint8_t shift = 0;   // 1, 2: evaluated one bump step along the tangent plane's first, second axis
  bool flag = false;
};

struct Closure;
using AddLobes = void (*)(const Closure&, const Evaluation&, const Color& weight, Bsdf&) noexcept;
inline constexpr int max_closure_operands = 28;

struct Closure {
  AddLobes add;
  std::array<std::int16_t, max_closure_operands> in = no_operands<max_closure_operands>();
  std::int16_t weight = 0, normal = no_normal;
  std::uint8_t choice = 0;
  bool transparent = false;  // adds transparency: what eval_transparency asks

  static constexpr std::int16_t no_normal = 0x7fff;  // the point's own
};

enum class Interpolation : std::uint8_t { Closest, Linear };
enum class Extension : std::uint8_t { Repeat, Extend, Clip, Mirror };
enum class Projection : std::uint8_t { Flat, Box, Sphere, Tube, Equirectangular, MirrorBall };

struct Texture {
  const Image* image = nullptr;
  Interpolation interpolation = Interpolation::Linear;
  Extension extension = Extension::Repeat;
  Projection projection = Projection::Flat;
  bool premultiply = false;  // no link reads alpha: transparent texels are black, as in Blender
  float blend = 0;           // of box projection
};

// Values over [low, high], evenly spaced; read with linear interpolation, or stepwise.
struct Table {
  std::vector<std::array<float, 4>> rows;
  float low = 0, high = 1;
  bool constant = false;
};

struct Program {
  std::vector<Instruction> instructions;
  std::vector<Closure> closures;
  std::vector<Register> constants;
  std::vector<Texture> textures;
  std::vector<Table> tables;
  float specular_threshold = 0.1f;
  bool is_folded = false;      // the closures depend on nothing but the side: `folded` is their result
  std::array<Bsdf, 2> folded;  // [front]
};

inline const Register& Evaluation::read(std::int16_t operand) const noexcept {
  return operand >= 0 ? registers[operand] : program.constants[static_cast<std::size_t>(~operand)];
}

void run(const Evaluation& evaluation) noexcept;

// Operand k of an instruction or closure.
template <class Item>
[[nodiscard]] inline const Register& operand(const Item& item, const Evaluation& e, int k) noexcept {
  return e.read(item.in[static_cast<std::size_t>(k)]);
}
template <class Item>
[[nodiscard]] inline float number(const Item& item, const Evaluation& e, int k) noexcept {
  return operand(item, e, k).x;
}

// The closure's shading normal on the side of wo, bent so far that a mirror direction stays above the
// surface.
[[nodiscard]] V3f closure_normal(const Closure& closure, const Evaluation& e) noexcept;

// Event of a lobe by its Blender roughness.
[[nodiscard]] inline Event glossy_event(float roughness, const Evaluation& e) noexcept {
  return roughness <= e.specular_threshold || roughness * roughness < ggx::smooth_alpha ? Event::S : Event::G;
}

}  // namespace sluice
