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
  return n.emit(fresnel, Type::Number, {n.number("IOR", 1.45f), has_normal ? n.vector("Normal") : n.constant(0.0f)}, {.flag = has_normal, .varies = true});
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
  return n.emit(output == "Facing" ? layer_facing : layer_fresnel, Type::Number, {n.number("Blend", 0.5f), normal}, {.flag = has_normal, .varies = true});
}

// One lobe of the fits to the CIE 1931 observer (Wyman, Sloan & Shirley 2013).
[[nodiscard]] double lobe(double nm, double mean, double below, double above) noexcept {
  const double t = (nm - mean) * (nm < mean ? below : above);
  return std::exp(-0.5 * t * t);
}

// Planck's law through the observer, in Rec. 709 of luminance 1, as Blender's Blackbody; its end points hold outside 965..12000 K.
Register blackbody(const Instruction& i, const Evaluation& e) noexcept {
  const double kelvin = std::clamp(static_cast<double>(number(i, e, 0)), 965.0, 12000.0);
  V3d xyz(0);
  for (int nm = 380; nm <= 780; nm += 5) {
    const double metres = nm * 1e-9, power = std::pow(metres * 1e6, -5.0) / (std::exp(1.438777e-2 / (metres * kelvin)) - 1);
    xyz.x += power * (0.362 * lobe(nm, 442.0, 0.0624, 0.0374) + 1.056 * lobe(nm, 599.8, 0.0264, 0.0323) - 0.065 * lobe(nm, 501.1, 0.0490, 0.0382));
    xyz.y += power * (0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322));
    xyz.z += power * (1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725));
  }
  Color rgb(static_cast<float>((3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z) / xyz.y),
            static_cast<float>((-0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z) / xyz.y),
            static_cast<float>((0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z) / xyz.y));
  rgb = Color(std::max(0.0f, rgb.x), std::max(0.0f, rgb.y), std::max(0.0f, rgb.z));
  return rgb / luminance(rgb);
}
Value blackbody_node(NodeReader& n, std::string_view) { return n.emit(blackbody, Type::Rgb, {n.number("Temperature", 6500)}); }

constexpr std::pair<std::string_view, Builder> table[] = {
    {"Value", value_node}, {"RGB", rgb_node}, {"Fresnel", fresnel_node}, {"LayerWeight", layer_weight_node}, {"Blackbody", blackbody_node},
};

}  // namespace

Builders input_nodes() { return table; }

}  // namespace sluice
