// SPDX-License-Identifier: GPL-3.0-or-later
// From a MaterialDescription to a Program, on demand from the surface's shader backwards: what nothing reads
// is never compiled, and what depends on constants only is folded. Each node kind has a builder in a
// nodes_*.cpp; here are the words builders use.
#pragma once
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>

#include "shading/material.h"
#include "shading/program.h"

namespace sluice {

class MaterialCompiler;

struct Value {
  enum class Type : std::uint8_t { Number, Vector, Rgb };
  std::int16_t operand = -1;  // as in Instruction::in
  Type type = Type::Number;
};

struct OperationOptions {
  int item = -1;
  int choice = 0;
  bool flag = false;
  bool varies = false;          // depends on the point, not only on its operands: never folded
  bool sees_direction = false;  // on where one looks from
};

// A builder's view of its node.
class NodeReader {
 public:
  NodeReader(MaterialCompiler& compiler, int index, int shift) noexcept
      : compiler_(compiler), index_(index), shift_(shift) {}

  [[nodiscard]] const NodeDescription& node() const noexcept;
  [[nodiscard]] int shift() const noexcept { return shift_; }
  [[nodiscard]] NodeReader shifted(int shift) const noexcept { return {compiler_, index_, shift}; }

  // An input as a number, vector or colour; what a missing socket means comes with a warning.
  [[nodiscard]] Value number(std::string_view input, float if_missing = 0);
  [[nodiscard]] Value vector(std::string_view input, const V3f& if_missing = V3f(0));
  [[nodiscard]] Value color(std::string_view input, const Color& if_missing = Color(0.5f));
  [[nodiscard]] bool is_given(std::string_view input) const noexcept;  // linked or with a value
  [[nodiscard]] bool is_linked(std::string_view input) const noexcept;
  [[nodiscard]] bool output_is_read(std::string_view output) const noexcept;  // by any node

  [[nodiscard]] std::string option(std::string_view name, std::string_view if_missing) const;
  [[nodiscard]] bool flag(std::string_view name, bool if_missing = false) const;
  [[nodiscard]] float option_number(std::string_view name, float if_missing) const;
  // Index of the option's word in `words`; 0 with a warning if it is none of them.
  [[nodiscard]] int choose(std::string_view name, std::initializer_list<std::string_view> words);

  [[nodiscard]] Value emit(Operation, Value::Type, std::initializer_list<Value> inputs,
                           const OperationOptions& = {});
  [[nodiscard]] Value constant(const V3f& value, Value::Type type = Value::Type::Rgb);
  [[nodiscard]] Value constant(float value) { return constant(V3f(value), Value::Type::Number); }
  // "Vector", or the node's implicit coordinates
  [[nodiscard]] Value texture_vector(std::string_view input, bool generated);
  // likewise: the position, in a world the direction
  [[nodiscard]] Value environment_vector(std::string_view input);
  [[nodiscard]] Value surface_tangent(std::string_view input);  // "Tangent", or Blender's default: around Z
  [[nodiscard]] std::optional<V3f> value_of(const Value& value) const noexcept;  // of constants

  [[nodiscard]] int add_texture(const Texture& texture);
  [[nodiscard]] int add_table(Table table);
  [[nodiscard]] int uv_slot(const std::string& name);
  [[nodiscard]] int color_slot(const std::string& name);
  void need_gradients() noexcept;
  [[nodiscard]] const Image* image();
  void warn(const std::string& message);

 protected:
  MaterialCompiler& compiler_;
  int index_, shift_;
};

using Builder = Value (*)(NodeReader&, std::string_view output);

// A shader node's builder adds closures; weight is what Mix and Add above it leave.
class ShaderReader : public NodeReader {
 public:
  ShaderReader(MaterialCompiler& compiler, int index, std::string output, const Value& weight)
      : NodeReader(compiler, index, 0), output_(std::move(output)), weight_(weight) {}
  [[nodiscard]] const Value& weight() const noexcept { return weight_; }
  [[nodiscard]] Value own_output();  // of a node that makes a colour where a shader is wanted
  void child(std::string_view input, const Value& weight);
  struct Traits {
    EventMask events = 0;
    bool transparent = false, emits = false, refracts = false, transmits = false, layered = false;
  };
  // `inputs`: the closure's operands. `normal`: name of the input that holds it.
  void add(AddLobes lobes, std::span<const Value> inputs, const Traits& traits, std::string_view normal = {},
           int choice = 0);
  void add(AddLobes lobes, std::initializer_list<Value> inputs, const Traits& traits,
           std::string_view normal = {}, int choice = 0) {
    add(lobes, std::span(inputs.begin(), inputs.size()), traits, normal, choice);
  }
  [[nodiscard]] EventMask glossy_events(const Value& roughness) const noexcept;
  // S too where nothing bends
  [[nodiscard]] EventMask refraction_events(const Value& roughness, const Value& ior) const noexcept;
  [[nodiscard]] bool is_zero(const Value& value) const noexcept;  // a constant 0 (or less)

 private:
  std::string output_;
  Value weight_;
};

using ShaderBuilder = void (*)(ShaderReader&);

// One table per nodes_*.cpp, joined by the compiler.
using Builders = std::span<const std::pair<std::string_view, Builder>>;
using ShaderBuilders = std::span<const std::pair<std::string_view, ShaderBuilder>>;
[[nodiscard]] Builders input_nodes();
[[nodiscard]] Builders geometry_nodes();
[[nodiscard]] Builders vector_nodes();
[[nodiscard]] Builders math_nodes();
[[nodiscard]] Builders color_nodes();
[[nodiscard]] Builders image_nodes();
[[nodiscard]] Builders procedural_nodes();
[[nodiscard]] ShaderBuilders shader_nodes();
[[nodiscard]] ShaderBuilders principled_nodes();

class MaterialCompiler {
 public:
  MaterialCompiler(const MaterialDescription& description, std::span<const Image> images,
                   float specular_threshold, Warnings& warnings);
  [[nodiscard]] Material compile();

 private:
  friend class NodeReader;
  friend class ShaderReader;

  [[nodiscard]] const InputDescription* find_input(int node, std::string_view name) const noexcept;
  [[nodiscard]] Value build_output(int node, const std::string& output, int shift);
  [[nodiscard]] Value convert(const Value& value, Value::Type type);
  [[nodiscard]] Value read_input(int node, std::string_view name, Value::Type type, const V3f& if_missing,
                                 int shift);
  [[nodiscard]] Value make_constant(const V3f& value, Value::Type type);
  [[nodiscard]] Value emit(const Instruction& instruction, Value::Type type, bool varies, int inputs);
  void build_shader(int node, const std::string& output, const Value& weight);
  void warn(const std::string& message);
  void warn_node(int node, const std::string& message);
  void allocate_registers();
  void fold();
  void average_emission();

  const MaterialDescription& description_;
  std::span<const Image> images_;
  Warnings& warnings_;
  Program program_;
  Material material_;
  std::map<std::tuple<int, std::string, int>, Value> built_;
  std::set<std::pair<int, int>> open_;  // nodes being built: meeting one again is a loop
  std::set<std::string> warned_;
  int virtual_registers_ = 0, depth_ = 0, shader_visits_ = 0;
  bool layered_ = false, sees_direction_ = false, overflow_ = false;
};

}  // namespace sluice
