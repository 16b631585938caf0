// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/compiler.h"

#include <algorithm>
#include <cstdlib>

namespace sluice {
namespace {

constexpr int max_nodes = 4096, max_tree_depth = 256, max_instructions = 8192, max_closures = 128;
constexpr int max_shader_visits = 4096;  // a shader that many mixes share is walked once per way to it

[[nodiscard]] Register gray_of(const Instruction& i, const Evaluation& e) noexcept {
  return Register(luminance(operand(i, e, 0)));
}
[[nodiscard]] Register mean_of(const Instruction& i, const Evaluation& e) noexcept {
  const Register& v = operand(i, e, 0);
  return Register((v.x + v.y + v.z) / 3);
}

template <class Entry>
[[nodiscard]] auto find_builder(std::initializer_list<std::span<const Entry>> tables,
                                std::string_view kind) -> decltype(Entry::second) {
  for (const auto& table : tables)
    for (const auto& [name, builder] : table)
      if (name == kind) return builder;
  return nullptr;
}

[[nodiscard]] Builder find_value_builder(std::string_view kind) {
  using Entry = std::pair<std::string_view, Builder>;
  return find_builder<Entry>({input_nodes(), geometry_nodes(), vector_nodes(), math_nodes(), color_nodes(),
                              image_nodes(), procedural_nodes()},
                             kind);
}

}  // namespace

MaterialCompiler::MaterialCompiler(const MaterialDescription& description, std::span<const Image> images,
                                   float specular_threshold, Warnings& warnings)
    : description_(description), images_(images), warnings_(warnings) {
  program_.specular_threshold = specular_threshold;
}

void MaterialCompiler::warn(const std::string& message) {
  if (warned_.insert(message).second) warnings_.push_back({description_.name, message});
}
void MaterialCompiler::warn_node(int node, const std::string& message) {
  warn("node '" + description_.nodes[static_cast<std::size_t>(node)].name + "': " + message);
}

const InputDescription* MaterialCompiler::find_input(int node, std::string_view name) const noexcept {
  for (const InputDescription& input : description_.nodes[static_cast<std::size_t>(node)].inputs)
    if (input.name == name) return &input;
  return nullptr;
}

Value MaterialCompiler::make_constant(const V3f& value, Value::Type type) {
  if (!is_finite(value)) {
    warn("a value that is not a finite number is read as 0");
    return make_constant(V3f(0), type);
  }
  auto& constants = program_.constants;
  const auto at = std::find(constants.begin(), constants.end(), value);
  const auto index = at - constants.begin();
  if (at == constants.end()) constants.push_back(value);
  return {static_cast<std::int16_t>(~index), type};
}

// Instructions whose operands are all constants are run here and now.
Value MaterialCompiler::emit(const Instruction& instruction, Value::Type type, bool varies, int inputs) {
  bool constant = !varies;
  for (int k = 0; k < inputs; ++k) constant &= instruction.in[static_cast<std::size_t>(k)] < 0;
  if (constant) {
    const SurfacePoint nowhere;
    const Register result = instruction.operation(
        instruction, Evaluation{program_, nowhere, nullptr, program_.specular_threshold});
    return make_constant(result, type);
  }
  if (program_.instructions.size() >= max_instructions) {
    overflow_ = true;
    return make_constant(V3f(0.5f), type);
  }
  program_.instructions.push_back(instruction);
  program_.instructions.back().out = static_cast<std::int16_t>(virtual_registers_);
  return {static_cast<std::int16_t>(virtual_registers_++), type};
}

// Blender's implicit conversions: a colour becomes its luminance, a vector the mean of its components.
Value MaterialCompiler::convert(const Value& value, Value::Type type) {
  if (type != Value::Type::Number || value.type == Value::Type::Number) return {value.operand, type};
  Instruction instruction{.operation = value.type == Value::Type::Rgb ? gray_of : mean_of};
  instruction.in[0] = value.operand;
  return emit(instruction, type, false, 1);
}

Value MaterialCompiler::read_input(int node, std::string_view name, Value::Type type, const V3f& if_missing,
                                   int shift) {
  const InputDescription* input = find_input(node, name);
  if (!input) {
    warn_node(node, "input '" + std::string(name) + "' is missing; a default is used");
    return make_constant(if_missing, type);
  }
  if (input->node >= 0) return convert(build_output(input->node, input->output, shift), type);
  const auto& v = input->value;
  return make_constant(type == Value::Type::Number ? V3f(v[0]) : V3f(v[0], v[1], v[2]), type);
}

Value MaterialCompiler::build_output(int node, const std::string& output, int shift) {
  const Value neutral = make_constant(V3f(0.5f), Value::Type::Rgb);
  if (node >= static_cast<int>(description_.nodes.size())) {
    warn("a link comes from a node that does not exist; grey is used");
    return neutral;
  }
  if (const auto known = built_.find({node, output, shift}); known != built_.end()) return known->second;
  const std::string& kind = description_.nodes[static_cast<std::size_t>(node)].kind;
  const Builder builder = find_value_builder(kind);
  Value value = neutral;
  if (!builder) {
    warn_node(node, "nodes of type '" + kind + "' are not supported; grey is used");
  } else if (!open_.insert({node, shift}).second) {
    warn_node(node, "is part of a loop; grey is used");
    return neutral;
  } else if (depth_ >= max_tree_depth) {
    overflow_ = true;
    open_.erase({node, shift});
    return neutral;
  } else {
    ++depth_;
    NodeReader reader(*this, node, shift);
    value = builder(reader, output);
    --depth_;
    open_.erase({node, shift});
  }
  built_[{node, output, shift}] = value;
  return value;
}

void MaterialCompiler::build_shader(int node, const std::string& output, const Value& weight) {
  // an unlinked shader socket is black
  if (node < 0 || node >= static_cast<int>(description_.nodes.size())) return;
  const std::string& kind = description_.nodes[static_cast<std::size_t>(node)].kind;
  if (weight.operand < 0 && max_component(program_.constants[static_cast<std::size_t>(~weight.operand)]) <= 0)
    return;
  if (depth_ >= max_tree_depth || program_.closures.size() >= max_closures ||
      ++shader_visits_ > max_shader_visits) {
    overflow_ = true;
    return;
  }
  using Entry = std::pair<std::string_view, ShaderBuilder>;
  const auto shader = [](std::string_view name) {
    return find_builder<Entry>({shader_nodes(), principled_nodes()}, name);
  };
  ShaderBuilder builder = shader(kind);
  const bool is_value = !builder && find_value_builder(kind);
  if (!builder && !is_value)
    warn_node(node, "nodes of type '" + kind + "' are not supported; a grey diffuse surface is used");
  if (!builder) builder = shader(is_value ? "Emission from value" : "neutral");
  if (!is_value && !open_.insert({node, 0}).second)
    return warn_node(node, "is part of a loop; it is left out");
  ++depth_;
  ShaderReader reader(*this, node, output, weight);
  builder(reader);
  --depth_;
  if (!is_value) open_.erase({node, 0});
}

// Linear scan: a register is free again after its last reader. Closures read at the end.
void MaterialCompiler::allocate_registers() {
  std::vector<int> last_use(static_cast<std::size_t>(virtual_registers_), -1);
  const int end = static_cast<int>(program_.instructions.size());
  const auto use = [&](std::int16_t operand, int when) {
    if (operand >= 0 && operand != Closure::no_normal) last_use[static_cast<std::size_t>(operand)] = when;
  };
  for (int k = 0; k < end; ++k)
    for (const std::int16_t operand : program_.instructions[static_cast<std::size_t>(k)].in) use(operand, k);
  for (const Closure& closure : program_.closures) {
    for (const std::int16_t operand : closure.in) use(operand, end);
    use(closure.weight, end);
    use(closure.normal, end);
  }
  std::vector<std::int16_t> place(last_use.size(), 0), free;
  int used = 0;
  const auto move = [&](std::int16_t& operand) {
    if (operand >= 0 && operand != Closure::no_normal) operand = place[static_cast<std::size_t>(operand)];
  };
  std::vector<Instruction> kept;
  for (int k = 0; k < end; ++k) {
    Instruction instruction = program_.instructions[static_cast<std::size_t>(k)];
    const auto out = static_cast<std::size_t>(instruction.out);
    if (last_use[out] < 0) continue;  // nothing reads it
    std::set<std::int16_t> dying;
    for (const std::int16_t operand : instruction.in)
      if (operand >= 0 && last_use[static_cast<std::size_t>(operand)] == k)
        dying.insert(place[static_cast<std::size_t>(operand)]);
    for (std::int16_t& operand : instruction.in) move(operand);
    free.insert(free.end(), dying.begin(), dying.end());
    if (free.empty()) free.push_back(static_cast<std::int16_t>(used++));
    place[out] = instruction.out = free.back();
    free.pop_back();
    kept.push_back(instruction);
  }
  for (Closure& closure : program_.closures) {
    for (std::int16_t& operand : closure.in) move(operand);
    move(closure.weight);
    move(closure.normal);
  }
  program_.instructions = std::move(kept);
  if (used > max_registers) overflow_ = true;
}

Material MaterialCompiler::compile() {
  if (description_.nodes.size() > max_nodes)
    overflow_ = true;
  else
    build_shader(description_.surface, description_.surface_output,
                 make_constant(V3f(1), Value::Type::Number));
  if (!overflow_) allocate_registers();
  if (overflow_) {
    warn("the node tree is too large (at most " + std::to_string(max_nodes) + " nodes, " +
         std::to_string(max_tree_depth) + " deep); a grey diffuse surface is used");
    MaterialDescription plain = default_material();
    plain.name = description_.name;
    return MaterialCompiler(plain, {}, program_.specular_threshold, warnings_).compile();
  }
  fold();
  material_.program_ = std::make_unique<const Program>(std::move(program_));
  average_emission();
  return std::move(material_);
}

Material compile_material(const MaterialDescription& description, std::span<const Image> images,
                          float specular_threshold, Warnings& warnings) {
  return MaterialCompiler(description, images, specular_threshold, warnings).compile();
}

MaterialDescription default_material() {
  NodeDescription diffuse;
  diffuse.kind = "BsdfDiffuse";
  diffuse.name = "Diffuse BSDF";
  diffuse.inputs = {{"Color", {0.8f, 0.8f, 0.8f, 1}, -1, {}}, {"Roughness", {0, 0, 0, 0}, -1, {}}};
  return {"default", {diffuse}, 0, {}};
}

}  // namespace sluice
