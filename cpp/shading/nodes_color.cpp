// SPDX-License-Identifier: GPL-3.0-or-later
// Colours: Mix, ramps, curves, HSV and the rest. Formulas are Blender's (its manual and Cycles' svm nodes
// agree on them).
#include "shading/compiler.h"
#include "shading/tables.h"

namespace sluice {
namespace {

using Type = Value::Type;

[[nodiscard]] Color rgb_to_hsv(const Color& c) noexcept {
  const float high = max_component(c), low = std::min(c.x, std::min(c.y, c.z)), range = high - low;
  if (!(range > 0) || high == 0) return {0, 0, high};
  float h = c.x == high   ? (c.y - c.z) / range
            : c.y == high ? 2 + (c.z - c.x) / range
                          : 4 + (c.x - c.y) / range;
  h /= 6;
  return {h < 0 ? h + 1 : h, range / high, high};
}
[[nodiscard]] Color hsv_to_rgb(const Color& hsv) noexcept {
  const float h = (hsv.x - std::floor(hsv.x)) * 6;
  const auto channel = [&](float offset) {
    const float k = std::fmod(h + offset, 6.0f);
    return hsv.z - hsv.z * hsv.y * std::clamp(std::min(k, 4 - k), 0.0f, 1.0f);
  };
  return {channel(5), channel(3), channel(1)};
}
[[nodiscard]] Color rgb_to_hsl(const Color& c) noexcept {
  const float high = max_component(c), low = std::min(c.x, std::min(c.y, c.z)),
              l = std::min(1.0f, (high + low) / 2);
  const float room = 1 - std::abs(2 * l - 1);
  return {rgb_to_hsv(c).x, room > 0 ? (high - low) / room : 0.0f, l};
}
[[nodiscard]] Color hsl_to_rgb(const Color& hsl) noexcept {
  const Color pure = hsv_to_rgb({hsl.x, 1, 1});
  const float chroma = (1 - std::abs(2 * hsl.z - 1)) * hsl.y;
  return (pure - Color(0.5f)) * chroma + Color(hsl.z);
}

[[nodiscard]] Color mixed(const Color& a, const Color& b, float t) noexcept { return a * (1 - t) + b * t; }

// Blend modes that work on each channel alone.
[[nodiscard]] float blend_channel(int mode, float a, float b, float t) noexcept {
  const float s = 1 - t;
  switch (mode) {
    case 1: return s * a + t * std::min(a, b);  // DARKEN
    case 2: return a * (s + t * b);             // MULTIPLY
    case 3: {                                   // BURN
      const float d = s + t * b;
      return d <= 0 ? 0.0f : std::clamp(1 - (1 - a) / d, 0.0f, 1.0f);
    }
    case 4: return s * a + t * std::max(a, b);       // LIGHTEN
    case 5: return 1 - (s + t * (1 - b)) * (1 - a);  // SCREEN
    case 6: {                                        // DODGE
      const float d = 1 - t * b;
      return a == 0 ? 0.0f : d <= 0 ? 1.0f : std::min(a / d, 1.0f);
    }
    case 7: return a + t * b;                                                             // ADD
    case 8: return a < 0.5f ? a * (s + 2 * t * b) : 1 - (s + 2 * t * (1 - b)) * (1 - a);  // OVERLAY
    case 9: return s * a + t * ((1 - a) * b * a + a * (1 - (1 - b) * (1 - a)));           // SOFT_LIGHT
    case 10: return a + t * (2 * b - 1);                                                  // LINEAR_LIGHT
    case 11: return s * a + t * std::abs(a - b);                                          // DIFFERENCE
    case 12: return std::max(s * a + t * (a + b - 2 * a * b), 0.0f);                      // EXCLUSION
    case 13: return a - t * b;                                                            // SUBTRACT
    case 14: return b != 0 ? s * a + t * a / b : a;                                       // DIVIDE
    default: return s * a + t * b;                                                        // MIX
  }
}
[[nodiscard]] Color blend_hsv(int mode, const Color& a, const Color& b, float t) noexcept {
  Color x = rgb_to_hsv(a);
  const Color y = rgb_to_hsv(b);
  switch (mode) {
    case 15: return y.y != 0 ? mixed(a, hsv_to_rgb({y.x, x.y, x.z}), t) : a;         // HUE
    case 16: return x.y != 0 ? hsv_to_rgb({x.x, (1 - t) * x.y + t * y.y, x.z}) : a;  // SATURATION
    case 17: return y.y != 0 ? mixed(a, hsv_to_rgb({y.x, y.y, x.z}), t) : a;         // COLOR
    default: return hsv_to_rgb({x.x, x.y, (1 - t) * x.z + t * y.z});                 // VALUE
  }
}

Register blend(const Instruction& i, const Evaluation& e) noexcept {
  // t may differ by component (vectors)
  const Color a = operand(i, e, 1), b = operand(i, e, 2), t = operand(i, e, 0);
  Color out = i.choice >= 15
                  ? blend_hsv(i.choice, a, b, t.x)
                  : Color(blend_channel(i.choice, a.x, b.x, t.x), blend_channel(i.choice, a.y, b.y, t.y),
                          blend_channel(i.choice, a.z, b.z, t.z));
  if (!is_finite(out)) out = a;
  return i.flag ? clamp01(out) : out;
}
Register clamp_operand(const Instruction& i, const Evaluation& e) noexcept {
  return clamp01(operand(i, e, 0));
}

[[nodiscard]] int blend_mode(NodeReader& n) {
  return n.choose("blend_type", {"MIX", "DARKEN", "MULTIPLY", "BURN", "LIGHTEN", "SCREEN", "DODGE", "ADD",
                                 "OVERLAY", "SOFT_LIGHT", "LINEAR_LIGHT", "DIFFERENCE", "EXCLUSION",
                                 "SUBTRACT", "DIVIDE", "HUE", "SATURATION", "COLOR", "VALUE"});
}
Value mix_rgb_node(NodeReader& n, std::string_view) {
  const Value factor = n.emit(clamp_operand, Type::Number, {n.number("Fac", 0.5f)});
  return n.emit(blend, Type::Rgb, {factor, n.color("Color1"), n.color("Color2")},
                {.choice = blend_mode(n), .flag = n.flag("use_clamp")});
}
Value mix_node(NodeReader& n, std::string_view) {
  const int type = n.choose("data_type", {"FLOAT", "VECTOR", "RGBA"});
  const bool per_component = type == 1 && n.option("factor_mode", "UNIFORM") == "NON_UNIFORM";
  Value factor = per_component ? n.vector("Factor", V3f(0.5f)) : n.number("Factor", 0.5f);
  if (n.flag("clamp_factor", true)) factor = n.emit(clamp_operand, factor.type, {factor});
  if (type == 0) return n.emit(blend, Type::Number, {factor, n.number("A"), n.number("B")});
  if (type == 1) return n.emit(blend, Type::Vector, {factor, n.vector("A"), n.vector("B")});
  return n.emit(blend, Type::Rgb, {factor, n.color("A"), n.color("B")},
                {.choice = blend_mode(n), .flag = n.flag("clamp_result")});
}

Register ramp(const Instruction& i, const Evaluation& e) noexcept {
  const auto row = read_table(e.program.tables[static_cast<std::size_t>(i.item)], number(i, e, 0));
  return i.flag ? Register(row[3]) : Register(row[0], row[1], row[2]);
}
Value ramp_node(NodeReader& n, std::string_view output) {
  const int table = curve_table(n);
  const Value x = n.number("Fac", 0.5f);
  if (table < 0) return x;
  const bool alpha = output == "Alpha";
  return n.emit(ramp, alpha ? Type::Number : Type::Rgb, {x}, {.item = table, .flag = alpha});
}

Register curves(const Instruction& i, const Evaluation& e) noexcept {
  const Table& table = e.program.tables[static_cast<std::size_t>(i.item)];
  const Register c = operand(i, e, 1);
  return mixed(c, {read_table(table, c.x)[0], read_table(table, c.y)[1], read_table(table, c.z)[2]},
               number(i, e, 0));
}
Value rgb_curve_node(NodeReader& n, std::string_view) {
  const int table = curve_table(n);
  const Value c = n.color("Color");
  return table < 0 ? c : n.emit(curves, Type::Rgb, {n.number("Fac", 1), c}, {.item = table});
}
Value vector_curve_node(NodeReader& n, std::string_view) {
  const int table = curve_table(n);
  const Value v = n.vector("Vector");
  return table < 0 ? v : n.emit(curves, Type::Vector, {n.number("Fac", 1), v}, {.item = table});
}

Register hue_saturation(const Instruction& i, const Evaluation& e) noexcept {
  const Color c = operand(i, e, 4);
  const Color hsv = rgb_to_hsv(c);
  const Color turned = hsv_to_rgb({hsv.x + number(i, e, 0) + 0.5f,
                                   std::clamp(hsv.y * number(i, e, 1), 0.0f, 1.0f), hsv.z * number(i, e, 2)});
  const Color out = mixed(c, turned, number(i, e, 3));
  return {std::max(out.x, 0.0f), std::max(out.y, 0.0f), std::max(out.z, 0.0f)};
}
Value hue_saturation_node(NodeReader& n, std::string_view) {
  return n.emit(hue_saturation, Type::Rgb,
                {n.number("Hue", 0.5f), n.number("Saturation", 1), n.number("Value", 1), n.number("Fac", 1),
                 n.color("Color")});
}

Register bright_contrast(const Instruction& i, const Evaluation& e) noexcept {
  const float slope = 1 + number(i, e, 2), lift = number(i, e, 1) - 0.5f * number(i, e, 2);
  const Color c = operand(i, e, 0) * slope + Color(lift);
  return {std::max(c.x, 0.0f), std::max(c.y, 0.0f), std::max(c.z, 0.0f)};
}
Value bright_contrast_node(NodeReader& n, std::string_view) {
  return n.emit(bright_contrast, Type::Rgb, {n.color("Color"), n.number("Bright"), n.number("Contrast")});
}

Register gamma(const Instruction& i, const Evaluation& e) noexcept {
  Color c = operand(i, e, 0);
  for (int k = 0; k < 3; ++k)
    if (c[k] > 0) c[k] = std::pow(c[k], number(i, e, 1));
  return c;
}
Value gamma_node(NodeReader& n, std::string_view) {
  return n.emit(gamma, Type::Rgb, {n.color("Color"), n.number("Gamma", 1)});
}

Register invert(const Instruction& i, const Evaluation& e) noexcept {
  return mixed(operand(i, e, 1), Color(1) - operand(i, e, 1), number(i, e, 0));
}
Value invert_node(NodeReader& n, std::string_view) {
  return n.emit(invert, Type::Rgb, {n.number("Fac", 1), n.color("Color")});
}

Register gray(const Instruction& i, const Evaluation& e) noexcept {
  return Register(luminance(operand(i, e, 0)));
}
Value gray_node(NodeReader& n, std::string_view) { return n.emit(gray, Type::Number, {n.color("Color")}); }

// Combine and separate in RGB, HSV, HSL (choice 0, 1, 2); separate: item is the component.
Register combine(const Instruction& i, const Evaluation& e) noexcept {
  const Color c(number(i, e, 0), number(i, e, 1), number(i, e, 2));
  return i.choice == 0 ? c : i.choice == 1 ? hsv_to_rgb(c) : hsl_to_rgb(c);
}
Register separate(const Instruction& i, const Evaluation& e) noexcept {
  const Color c = operand(i, e, 0);
  return Register((i.choice == 0 ? c : i.choice == 1 ? rgb_to_hsv(c) : rgb_to_hsl(c))[i.item]);
}
Value combine_color_node(NodeReader& n, std::string_view) {
  return n.emit(combine, Type::Rgb, {n.number("Red"), n.number("Green"), n.number("Blue")},
                {.choice = n.choose("mode", {"RGB", "HSV", "HSL"})});
}
Value combine_rgb_node(NodeReader& n, std::string_view) {
  return n.emit(combine, Type::Rgb, {n.number("R"), n.number("G"), n.number("B")});
}
Value combine_hsv_node(NodeReader& n, std::string_view) {
  return n.emit(combine, Type::Rgb, {n.number("H"), n.number("S"), n.number("V")}, {.choice = 1});
}
[[nodiscard]] int component_of(std::string_view output) noexcept {
  return output == "Red" || output == "R" || output == "H"     ? 0
         : output == "Green" || output == "G" || output == "S" ? 1
                                                               : 2;
}
Value separate_color_node(NodeReader& n, std::string_view output) {
  return n.emit(separate, Type::Number, {n.color("Color")},
                {.item = component_of(output), .choice = n.choose("mode", {"RGB", "HSV", "HSL"})});
}
Value separate_rgb_node(NodeReader& n, std::string_view output) {
  return n.emit(separate, Type::Number, {n.color("Image")}, {.item = component_of(output)});
}
Value separate_hsv_node(NodeReader& n, std::string_view output) {
  return n.emit(separate, Type::Number, {n.color("Color")}, {.item = component_of(output), .choice = 1});
}

constexpr std::pair<std::string_view, Builder> table[] = {
    {"Mix", mix_node},
    {"MixRGB", mix_rgb_node},
    {"ValToRGB", ramp_node},
    {"RGBCurve", rgb_curve_node},
    {"VectorCurve", vector_curve_node},
    {"HueSaturation", hue_saturation_node},
    {"BrightContrast", bright_contrast_node},
    {"Gamma", gamma_node},
    {"Invert", invert_node},
    {"RGBToBW", gray_node},
    {"CombineColor", combine_color_node},
    {"CombineRGB", combine_rgb_node},
    {"CombineHSV", combine_hsv_node},
    {"SeparateColor", separate_color_node},
    {"SeparateRGB", separate_rgb_node},
    {"SeparateHSV", separate_hsv_node},
};

}  // namespace

Builders color_nodes() { return table; }

}  // namespace sluice
