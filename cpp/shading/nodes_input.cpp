// SPDX-License-Identifier: GPL-3.0-or-later
// Constants, Fresnel and Layer Weight, Blackbody.
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

// Blender's Blackbody: luminance 1, Rec. 709, as rendered by Cycles 3.4.1 at 33 temperatures evenly spaced in
// 1 / T from 12000 K down to 965 K, where it stays outside. Between them the colour is almost linear in 1 /
// T: the table is good to 3e-3.
constexpr Color blackbody_rows[] = {
    {0.8263f, 0.9945f, 1.5663f}, {0.9102f, 0.9937f, 1.3274f}, {1.0057f, 0.9872f, 1.1087f},
    {1.1103f, 0.9758f, 0.9164f}, {1.2226f, 0.9592f, 0.7494f}, {1.3413f, 0.9379f, 0.6076f},
    {1.464f, 0.9135f, 0.4878f},  {1.5897f, 0.8869f, 0.3861f}, {1.7191f, 0.8567f, 0.3018f},
    {1.8505f, 0.8248f, 0.2308f}, {1.9831f, 0.7913f, 0.1716f}, {2.1166f, 0.7564f, 0.1225f},
    {2.2509f, 0.7206f, 0.0819f}, {2.3858f, 0.6839f, 0.0482f}, {2.5212f, 0.6465f, 0.0202f},
    {2.6555f, 0.6089f, 0},       {2.7902f, 0.5707f, 0},       {2.9237f, 0.5326f, 0},
    {3.056f, 0.4945f, 0},        {3.1874f, 0.4564f, 0},       {3.3179f, 0.4184f, 0},
    {3.4464f, 0.3808f, 0},       {3.5736f, 0.3435f, 0},       {3.6986f, 0.3067f, 0},
    {3.8218f, 0.2704f, 0},       {3.9432f, 0.2345f, 0},       {4.0621f, 0.1993f, 0},
    {4.1798f, 0.1644f, 0},       {4.2946f, 0.1303f, 0},       {4.4069f, 0.0969f, 0},
    {4.5169f, 0.0642f, 0},       {4.6247f, 0.0321f, 0},       {4.7306f, 0.0005f, 0},
};
Register blackbody(const Instruction& i, const Evaluation& e) noexcept {
  constexpr float hot = 1 / 12000.0f, cold = 1 / 965.0f, last = 32;
  const float kelvin = std::clamp(number(i, e, 0), 965.0f, 12000.0f),
              x = std::clamp((1 / kelvin - hot) / (cold - hot) * last, 0.0f, last);
  const auto row = std::min(static_cast<std::size_t>(x), std::size_t{31});
  return blackbody_rows[row] +
         (blackbody_rows[row + 1] - blackbody_rows[row]) * (x - static_cast<float>(row));
}
Value blackbody_node(NodeReader& n, std::string_view) {
  return n.emit(blackbody, Type::Rgb, {n.number("Temperature", 6500)});
}

constexpr std::pair<std::string_view, Builder> table[] = {
    {"Value", value_node},         {"RGB", rgb_node},
    {"Fresnel", fresnel_node},     {"LayerWeight", layer_weight_node},
    {"Blackbody", blackbody_node},
};

}  // namespace

Builders input_nodes() { return table; }

}  // namespace sluice
