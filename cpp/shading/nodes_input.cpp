// SPDX-License-Identifier: GPL-3.0-or-later
// Constants, Fresnel and Layer Weight, Blackbody.
#include "shading/blackbody.h"
#include "shading/compiler.h"

namespace sluice {
namespace {

using Type = Value::Type;

Value value_node(NodeReader& n, std::string_view) { return n.number("Value"); }
Value rgb_node(NodeReader& n, std::string_view) { return n.color("Color"); }

[[nodiscard]] float facing(const Instruction& i, const Evaluation& e) noexcept {
  return e.point.wo.dot(i.flag ? operand(i, e, 1) : e.point.ns);
}

Register fresnel(const Instruction& i, const Evaluation& e) noexcept {
  const float ior = std::max(number(i, e, 0), 1e-5f);
  return Register(fresnel_dielectric(std::abs(facing(i, e)), e.point.front ? ior : 1 / ior));
}
Value fresnel_node(NodeReader& n, std::string_view) {
  const bool has_normal = n.is_linked("Normal");
  return n.emit(fresnel, Type::Number,
                {n.number("IOR", 1.45f), has_normal ? n.vector("Normal") : n.constant(0.0f)},
                {.flag = has_normal, .varies = true, .sees_direction = true});
}

// Cycles' svm_node_layer_weight.
Register layer_fresnel(const Instruction& i, const Evaluation& e) noexcept {
  const float eta = std::max(1 - number(i, e, 0), 1e-5f);
  return Register(fresnel_dielectric(std::abs(facing(i, e)), e.point.front ? 1 / eta : eta));
}
Register layer_facing(const Instruction& i, const Evaluation& e) noexcept {
  float blend = std::clamp(number(i, e, 0), 0.0f, 1 - 1e-5f);
  blend = blend < 0.5f ? 2 * blend : 0.5f / (1 - blend);
  return Register(1 - std::pow(std::abs(facing(i, e)), blend));
}
Value layer_weight_node(NodeReader& n, std::string_view output) {
  const bool has_normal = n.is_linked("Normal");
  const Value normal = has_normal ? n.vector("Normal") : n.constant(0.0f);
  return n.emit(output == "Facing" ? layer_facing : layer_fresnel, Type::Number,
                {n.number("Blend", 0.5f), normal},
                {.flag = has_normal, .varies = true, .sees_direction = true});
}

Register blackbody_at(const Instruction& i, const Evaluation& e) noexcept {
  return blackbody(number(i, e, 0));
}
Value blackbody_node(NodeReader& n, std::string_view) {
  return n.emit(blackbody_at, Type::Rgb, {n.number("Temperature", 6500)});
}

constexpr std::pair<std::string_view, Builder> table[] = {
    {"Value", value_node},         {"RGB", rgb_node},
    {"Fresnel", fresnel_node},     {"LayerWeight", layer_weight_node},
    {"Blackbody", blackbody_node},
};

}  // namespace

Builders input_nodes() { return table; }

}  // namespace sluice
