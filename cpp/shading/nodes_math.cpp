// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers: Math, Map Range, Clamp, Float Curve. Each operation is Blender's, with its "safe" answers outside
// the domain (0).
#include "shading/compiler.h"
#include "shading/tables.h"

namespace sluice {
namespace {

using Type = Value::Type;

[[nodiscard]] float safe_divide(float a, float b) noexcept { return b != 0 ? a / b : 0.0f; }
[[nodiscard]] float safe_power(float a, float b) noexcept {
  return a < 0 && b != std::trunc(b) ? 0.0f : std::pow(a, b);
}
[[nodiscard]] float fraction(float a) noexcept { return a - std::floor(a); }
[[nodiscard]] float wrap(float a, float high, float low) noexcept {
  const float range = high - low;
  return range != 0 ? a - range * std::floor((a - low) / range) : low;
}
[[nodiscard]] float pingpong(float a, float b) noexcept {
  return b != 0 ? std::abs(fraction((a - b) / (b * 2)) * b * 2 - b) : 0.0f;
}
[[nodiscard]] float smooth_min(float a, float b, float k) noexcept {
  if (k == 0) return std::min(a, b);
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * h * k * (1.0f / 6);
}

struct MathWord {
  std::string_view name;
  float (*operation)(float, float, float) noexcept;
};
constexpr MathWord math_words[] = {
    {"ADD", [](float a, float b, float) noexcept -> float { return a + b; }},
    {"SUBTRACT", [](float a, float b, float) noexcept -> float { return a - b; }},
    {"MULTIPLY", [](float a, float b, float) noexcept -> float { return a * b; }},
    {"DIVIDE", [](float a, float b, float) noexcept -> float { return safe_divide(a, b); }},
    {"MULTIPLY_ADD", [](float a, float b, float c) noexcept -> float { return a * b + c; }},
    {"POWER", [](float a, float b, float) noexcept -> float { return safe_power(a, b); }},
    {"LOGARITHM",
     [](float a, float b, float) noexcept -> float {
       return a > 0 && b > 0 ? safe_divide(std::log(a), std::log(b)) : 0.0f;
     }},
    {"SQRT", [](float a, float, float) noexcept -> float { return std::sqrt(std::max(a, 0.0f)); }},
    {"INVERSE_SQRT", [](float a, float, float) noexcept -> float { return a > 0 ? 1 / std::sqrt(a) : 0.0f; }},
    {"ABSOLUTE", [](float a, float, float) noexcept -> float { return std::abs(a); }},
    {"EXPONENT", [](float a, float, float) noexcept -> float { return std::exp(a); }},
    {"MINIMUM", [](float a, float b, float) noexcept -> float { return std::min(a, b); }},
    {"MAXIMUM", [](float a, float b, float) noexcept -> float { return std::max(a, b); }},
    {"LESS_THAN", [](float a, float b, float) noexcept -> float { return a < b ? 1.0f : 0.0f; }},
    {"GREATER_THAN", [](float a, float b, float) noexcept -> float { return a > b ? 1.0f : 0.0f; }},
    {"SIGN", [](float a, float, float) noexcept -> float { return a > 0   ? 1.0f
                                                                  : a < 0 ? -1.0f
                                                                          : 0.0f; }},
    {"COMPARE",
     [](float a, float b, float c) noexcept -> float {
       return a == b || std::abs(a - b) <= std::max(c, 1e-7f) ? 1.0f : 0.0f;
     }},
    {"SMOOTH_MIN", [](float a, float b, float c) noexcept -> float { return smooth_min(a, b, c); }},
    {"SMOOTH_MAX", [](float a, float b, float c) noexcept -> float { return -smooth_min(-a, -b, c); }},
    {"ROUND", [](float a, float, float) noexcept -> float { return std::floor(a + 0.5f); }},
    {"FLOOR", [](float a, float, float) noexcept -> float { return std::floor(a); }},
    {"CEIL", [](float a, float, float) noexcept -> float { return std::ceil(a); }},
    {"TRUNC", [](float a, float, float) noexcept -> float { return std::trunc(a); }},
    {"FRACT", [](float a, float, float) noexcept -> float { return fraction(a); }},
    {"MODULO", [](float a, float b, float) noexcept -> float { return b != 0 ? std::fmod(a, b) : 0.0f; }},
    {"FLOORED_MODULO",
     [](float a, float b, float) noexcept -> float { return b != 0 ? a - std::floor(a / b) * b : 0.0f; }},
    {"WRAP", [](float a, float b, float c) noexcept -> float { return wrap(a, b, c); }},
    {"SNAP", [](float a, float b, float) noexcept -> float { return std::floor(safe_divide(a, b)) * b; }},
    {"PINGPONG", [](float a, float b, float) noexcept -> float { return pingpong(a, b); }},
    {"SINE", [](float a, float, float) noexcept -> float { return std::sin(a); }},
    {"COSINE", [](float a, float, float) noexcept -> float { return std::cos(a); }},
    {"TANGENT", [](float a, float, float) noexcept -> float { return std::tan(a); }},
    {"ARCSINE",
     [](float a, float, float) noexcept -> float { return std::asin(std::clamp(a, -1.0f, 1.0f)); }},
    {"ARCCOSINE",
     [](float a, float, float) noexcept -> float { return std::acos(std::clamp(a, -1.0f, 1.0f)); }},
    {"ARCTANGENT", [](float a, float, float) noexcept -> float { return std::atan(a); }},
    {"ARCTAN2", [](float a, float b, float) noexcept -> float { return std::atan2(a, b); }},
    {"SINH", [](float a, float, float) noexcept -> float { return std::sinh(a); }},
    {"COSH", [](float a, float, float) noexcept -> float { return std::cosh(a); }},
    {"TANH", [](float a, float, float) noexcept -> float { return std::tanh(a); }},
    {"RADIANS", [](float a, float, float) noexcept -> float { return a * (pi / 180); }},
    {"DEGREES", [](float a, float, float) noexcept -> float { return a * (180 / pi); }},
};

[[nodiscard]] float finite(float x) noexcept { return std::isfinite(x) ? x : 0.0f; }

Register math(const Instruction& i, const Evaluation& e) noexcept {
  const float x = finite(math_words[i.choice].operation(number(i, e, 0), number(i, e, 1), number(i, e, 2)));
  return Register(i.flag ? std::clamp(x, 0.0f, 1.0f) : x);
}

Value math_node(NodeReader& n, std::string_view) {
  const std::string word = n.option("operation", "ADD");
  int choice = 0;
  for (const MathWord& known : math_words) {
    if (known.name == word) break;
    ++choice;
  }
  if (choice == static_cast<int>(std::size(math_words))) {
    n.warn("operation '" + word + "' is not supported; its first input is passed on");
    return n.number("Value");
  }
  const auto optional = [&](std::string_view name) {
    return n.is_given(name) ? n.number(name) : n.constant(0.0f);
  };
  return n.emit(math, Type::Number, {n.number("Value"), optional("Value_001"), optional("Value_002")},
                {.choice = choice, .flag = n.flag("use_clamp")});
}

// Map Range: value, from min, from max, to min, to max, steps. Choice: 0 linear, 1 stepped, 2 smooth, 3
// smoother.
[[nodiscard]] float map_range(int choice, float x, float a, float b, float c, float d, float steps) noexcept {
  if (choice >= 2) {  // smooth steps clamp by nature
    if (a == b) return 0;
    float t = std::clamp((x - a) / (b - a), 0.0f, 1.0f);
    t = choice == 2 ? t * t * (3 - 2 * t) : t * t * t * (t * (t * 6 - 15) + 10);
    return c + t * (d - c);
  }
  float t = safe_divide(x - a, b - a);
  if (choice == 1) t = steps > 0 ? std::floor(t * (steps + 1)) / steps : 0.0f;
  return c + t * (d - c);
}

Register map_number(const Instruction& i, const Evaluation& e) noexcept {
  const float c = number(i, e, 3), d = number(i, e, 4);
  const float x =
      finite(map_range(i.choice, number(i, e, 0), number(i, e, 1), number(i, e, 2), c, d, number(i, e, 5)));
  return Register(i.flag ? std::clamp(x, std::min(c, d), std::max(c, d)) : x);
}
Register map_vector(const Instruction& i, const Evaluation& e) noexcept {
  Register out;
  for (int k = 0; k < 3; ++k) {
    const float c = operand(i, e, 3)[k], d = operand(i, e, 4)[k];
    const float x = finite(map_range(i.choice, operand(i, e, 0)[k], operand(i, e, 1)[k], operand(i, e, 2)[k],
                                     c, d, operand(i, e, 5)[k]));
    out[k] = i.flag ? std::clamp(x, std::min(c, d), std::max(c, d)) : x;
  }
  return out;
}

Value map_range_node(NodeReader& n, std::string_view) {
  const int choice = n.choose("interpolation_type", {"LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"});
  const OperationOptions options{.choice = choice, .flag = n.flag("clamp") && choice < 2};
  if (n.option("data_type", "FLOAT") == "FLOAT_VECTOR") {
    const Value steps = choice == 1 ? n.vector("Steps", V3f(4)) : n.constant(V3f(4), Type::Vector);
    return n.emit(map_vector, Type::Vector,
                  {n.vector("Vector"), n.vector("From Min"), n.vector("From Max", V3f(1)), n.vector("To Min"),
                   n.vector("To Max", V3f(1)), steps},
                  options);
  }
  const Value steps = choice == 1 ? n.number("Steps", 4) : n.constant(4.0f);
  return n.emit(map_number, Type::Number,
                {n.number("Value"), n.number("From Min"), n.number("From Max", 1), n.number("To Min"),
                 n.number("To Max", 1), steps},
                options);
}

Register clamp(const Instruction& i, const Evaluation& e) noexcept {
  float low = number(i, e, 1), high = number(i, e, 2);
  if (i.flag && low > high) std::swap(low, high);
  return Register(std::min(std::max(number(i, e, 0), low), high));
}
Value clamp_node(NodeReader& n, std::string_view) {
  return n.emit(clamp, Type::Number, {n.number("Value"), n.number("Min"), n.number("Max", 1)},
                {.flag = n.choose("clamp_type", {"MINMAX", "RANGE"}) == 1});
}

Register float_curve(const Instruction& i, const Evaluation& e) noexcept {
  const Table& curve = e.program.tables[static_cast<std::size_t>(i.item)];
  const float x = number(i, e, 1);
  return Register(x + (read_table(curve, x)[0] - x) * number(i, e, 0));
}
Value float_curve_node(NodeReader& n, std::string_view) {
  const int table = curve_table(n);
  const Value x = n.number("Value");
  return table < 0 ? x : n.emit(float_curve, Type::Number, {n.number("Factor", 1), x}, {.item = table});
}

constexpr std::pair<std::string_view, Builder> table[] = {
    {"Math", math_node},
    {"MapRange", map_range_node},
    {"Clamp", clamp_node},
    {"FloatCurve", float_curve_node},
};

}  // namespace

Builders math_nodes() { return table; }

}  // namespace sluice
