// SPDX-License-Identifier: GPL-3.0-or-later
// The words of builders, on top of MaterialCompiler.
#include <cstdlib>

#include "shading/compiler.h"

namespace sluice {

const NodeDescription& NodeReader::node() const noexcept {
  return compiler_.description_.nodes[static_cast<std::size_t>(index_)];
}

Value NodeReader::number(std::string_view input, float if_missing) {
  return compiler_.read_input(index_, input, Value::Type::Number, V3f(if_missing), shift_);
}
Value NodeReader::vector(std::string_view input, const V3f& if_missing) {
  return compiler_.read_input(index_, input, Value::Type::Vector, if_missing, shift_);
}
Value NodeReader::color(std::string_view input, const Color& if_missing) {
  return compiler_.read_input(index_, input, Value::Type::Rgb, if_missing, shift_);
}
bool NodeReader::is_given(std::string_view input) const noexcept {
  return compiler_.find_input(index_, input) != nullptr;
}
bool NodeReader::is_linked(std::string_view input) const noexcept {
  const InputDescription* found = compiler_.find_input(index_, input);
  return found && found->node >= 0;
}
bool NodeReader::output_is_read(std::string_view output) const noexcept {
  for (const NodeDescription& other : compiler_.description_.nodes)
    for (const InputDescription& input : other.inputs)
      if (input.node == index_ && input.output == output) return true;
  return false;
}

std::string NodeReader::option(std::string_view name, std::string_view if_missing) const {
  const auto found = node().options.find(std::string(name));
  return found == node().options.end() ? std::string(if_missing) : found->second;
}
bool NodeReader::flag(std::string_view name, bool if_missing) const {
  return option(name, if_missing ? "1" : "0") == "1";
}
float NodeReader::option_number(std::string_view name, float if_missing) const {
  const std::string text = option(name, "");
  char* end = nullptr;
  const float value = std::strtof(text.c_str(), &end);
  return end == text.c_str() || !std::isfinite(value) ? if_missing : value;
}
int NodeReader::choose(std::string_view name, std::initializer_list<std::string_view> words) {
  const std::string word = option(name, *words.begin());
  int index = 0;
  for (const std::string_view candidate : words) {
    if (candidate == word) return index;
    ++index;
  }
  warn("'" + word + "' as " + std::string(name) + " is not supported; '" + std::string(*words.begin()) +
       "' is used");
  return 0;
}

Value NodeReader::emit(Operation operation, Value::Type type, std::initializer_list<Value> inputs,
                       const OperationOptions& options) {
  Instruction instruction{.operation = operation};
  int k = 0;
  for (const Value& input : inputs) instruction.in[static_cast<std::size_t>(k++)] = input.operand;
  instruction.item = static_cast<std::int16_t>(options.item);
  instruction.choice = static_cast<std::uint8_t>(options.choice);
  instruction.shift = static_cast<std::uint8_t>(shift_);
  instruction.flag = options.flag;
  compiler_.sees_direction_ |= options.sees_direction;
  return compiler_.emit(instruction, type, options.varies, k);
}
Value NodeReader::constant(const V3f& value, Value::Type type) {
  return compiler_.make_constant(value, type);
}

std::optional<V3f> NodeReader::value_of(const Value& value) const noexcept {
  if (value.operand >= 0) return {};
  return compiler_.program_.constants[static_cast<std::size_t>(~value.operand)];
}

int NodeReader::add_texture(const Texture& texture) {
  compiler_.program_.textures.push_back(texture);
  return static_cast<int>(compiler_.program_.textures.size()) - 1;
}
int NodeReader::add_table(Table table) {
  compiler_.program_.tables.push_back(std::move(table));
  return static_cast<int>(compiler_.program_.tables.size()) - 1;
}

namespace {

// Index of the name in the list, adding it; a full list answers with its first entry.
[[nodiscard]] int slot_of(std::vector<std::string>& names, const std::string& name, int limit, bool& full) {
  for (std::size_t k = 0; k < names.size(); ++k)
    if (names[k] == name) return static_cast<int>(k);
  full = static_cast<int>(names.size()) >= limit;
  if (full) return 0;
  names.push_back(name);
  return static_cast<int>(names.size()) - 1;
}

}  // namespace

int NodeReader::uv_slot(const std::string& name) {
  bool full = false;
  const int slot = slot_of(compiler_.material_.needs_.uv_maps, name, max_uv_maps, full);
  if (full)
    warn("more than " + std::to_string(max_uv_maps) + " UV maps in one material; '" + name + "' is left out");
  if (shift_) need_gradients();
  return slot;
}
int NodeReader::color_slot(const std::string& name) {
  bool full = false;
  const int slot = slot_of(compiler_.material_.needs_.color_layers, name, max_color_layers, full);
  if (full)
    warn("more than " + std::to_string(max_color_layers) + " colour attributes in one material; '" + name +
         "' is left out");
  return slot;
}
void NodeReader::need_gradients() noexcept { compiler_.material_.needs_.uv_gradients = true; }

const Image* NodeReader::image() {
  const int index = node().image;
  const bool known = index >= 0 && static_cast<std::size_t>(index) < compiler_.images_.size();
  const Image* found = known ? &compiler_.images_[static_cast<std::size_t>(index)] : nullptr;
  if (found && !found->empty()) return found;
  warn("its image is missing" + (found && !found->name.empty() ? " ('" + found->name + "')" : std::string()) +
       "; magenta is drawn");
  return nullptr;
}
void NodeReader::warn(const std::string& message) { compiler_.warn_node(index_, message); }

Value ShaderReader::own_output() {
  return compiler_.convert(compiler_.build_output(index_, output_, 0), Value::Type::Rgb);
}

void ShaderReader::child(std::string_view input, const Value& weight) {
  const InputDescription* found = compiler_.find_input(index_, input);
  if (found && found->node >= 0) compiler_.build_shader(found->node, found->output, weight);
}

void ShaderReader::add(AddLobes lobes, std::span<const Value> inputs, const Traits& traits,
                       std::string_view normal, int choice) {
  Closure closure{.add = lobes};
  std::size_t k = 0;
  for (const Value& input : inputs) closure.in[k++] = input.operand;
  closure.weight = weight_.operand;
  closure.choice = static_cast<std::uint8_t>(choice);
  closure.transparent = traits.transparent;
  if (!normal.empty() && is_linked(normal)) closure.normal = vector(normal).operand;
  compiler_.program_.closures.push_back(closure);
  Material& material = compiler_.material_;
  material.events_ |= traits.events;
  material.opaque_ &= !traits.transparent;
  material.emits_ |= traits.emits;
  material.transmits_ |= traits.refracts || traits.transmits;
  compiler_.layered_ |= traits.layered;
}

EventMask ShaderReader::glossy_events(const Value& roughness) const noexcept {
  const std::optional<V3f> known = value_of(roughness);
  if (!known) return mask_of(Event::S) | mask_of(Event::G);
  const float threshold = compiler_.program_.specular_threshold;
  return mask_of(known->x <= threshold || known->x * known->x < ggx::smooth_alpha ? Event::S : Event::G);
}

EventMask ShaderReader::refraction_events(const Value& roughness, const Value& ior) const noexcept {
  const std::optional<V3f> known = value_of(ior);
  const bool may_bend_nothing = !known || bends_nothing(known->x) || bends_nothing(1 / known->x);
  return glossy_events(roughness) | (may_bend_nothing ? mask_of(Event::S) : EventMask{0});
}

bool ShaderReader::is_zero(const Value& value) const noexcept {
  const std::optional<V3f> known = value_of(value);
  return known && max_component(*known) <= 0;
}

}  // namespace sluice
