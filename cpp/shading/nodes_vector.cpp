// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors: Mapping, Vector Math, Vector Rotate, Vector Transform, XYZ. Blender's conventions; Euler angles
// are XYZ, in radians.
#include "shading/compiler.h"

namespace sluice {
namespace {

using Type = Value::Type;

// Rows of the matrix that turns column vectors by Rz·Ry·Rx.
struct Rotation {
  V3f x, y, z;
  explicit Rotation(const V3f& euler) noexcept {
    const float cx = std::cos(euler.x), sx = std::sin(euler.x), cy = std::cos(euler.y),
                sy = std::sin(euler.y), cz = std::cos(euler.z), sz = std::sin(euler.z);
    x = V3f(cy * cz, sy * sx * cz - cx * sz, sy * cx * cz + sx * sz);
    y = V3f(cy * sz, sy * sx * sz + cx * cz, sy * cx * sz - sx * cz);
    z = V3f(-sy, cy * sx, cy * cx);
  }
  [[nodiscard]] V3f turn(const V3f& v) const noexcept { return {x.dot(v), y.dot(v), z.dot(v)}; }
  [[nodiscard]] V3f turn_back(const V3f& v) const noexcept { return x * v.x + y * v.y + z * v.z; }
};

[[nodiscard]] float safe_divide(float a, float b) noexcept { return b != 0 ? a / b : 0.0f; }
[[nodiscard]] V3f safe_divide(const V3f& a, const V3f& b) noexcept {
  return {safe_divide(a.x, b.x), safe_divide(a.y, b.y), safe_divide(a.z, b.z)};
}
[[nodiscard]] V3f safe_normalize(const V3f& v) noexcept {
  const float length = v.length();
  return length > 0 ? v / length : V3f(0);
}

Register mapping(const Instruction& i, const Evaluation& e) noexcept {
  const V3f v = operand(i, e, 0), location = operand(i, e, 1), scale = operand(i, e, 3);
  const Rotation rotation(operand(i, e, 2));
  switch (i.choice) {
    case 0: return rotation.turn(v * scale) + location;                    // POINT
    case 1: return safe_divide(rotation.turn_back(v - location), scale);   // TEXTURE: the inverse
    case 2: return rotation.turn(v * scale);                               // VECTOR
    default: return safe_normalize(rotation.turn(safe_divide(v, scale)));  // NORMAL
  }
}
Value mapping_node(NodeReader& n, std::string_view) {
  const int choice = n.choose("vector_type", {"POINT", "TEXTURE", "VECTOR", "NORMAL"});
  const Value location = choice < 2 ? n.vector("Location") : n.constant(V3f(0), Type::Vector);
  return n.emit(mapping, Type::Vector,
                {n.vector("Vector"), location, n.vector("Rotation"), n.vector("Scale", V3f(1))},
                {.choice = choice});
}

template <class F>
[[nodiscard]] V3f each(const V3f& a, const V3f& b, const V3f& c, F&& f) noexcept {
  return {f(a.x, b.x, c.x), f(a.y, b.y, c.y), f(a.z, b.z, c.z)};
}

[[nodiscard]] float wrap(float a, float high, float low) noexcept {
  const float range = high - low;
  return range != 0 ? a - range * std::floor((a - low) / range) : low;
}
[[nodiscard]] V3f project(const V3f& a, const V3f& b) noexcept {
  const float length2 = b.dot(b);
  return length2 != 0 ? b * (a.dot(b) / length2) : V3f(0);
}
[[nodiscard]] V3f mirror(const V3f& a, const V3f& b) noexcept {
  const V3f n = safe_normalize(b);
  return a - n * (2 * a.dot(n));
}
[[nodiscard]] V3f bend(const V3f& a, const V3f& b, float ior) noexcept {  // GLSL's refract
  const V3f n = safe_normalize(b);
  const float d = n.dot(a), k = 1 - ior * ior * (1 - d * d);
  return k < 0 ? V3f(0) : a * ior - n * (ior * d + std::sqrt(k));
}

// a, b, c, scale; numbers come back in all three components.
struct VectorWord {
  std::string_view name;
  V3f (*operation)(const V3f& a, const V3f& b, const V3f& c, float scale) noexcept;
};
using V = const V3f&;
constexpr VectorWord vector_words[] = {
    {"ADD", [](V a, V b, V, float) noexcept -> V3f { return a + b; }},
    {"SUBTRACT", [](V a, V b, V, float) noexcept -> V3f { return a - b; }},
    {"MULTIPLY", [](V a, V b, V, float) noexcept -> V3f { return a * b; }},
    {"DIVIDE", [](V a, V b, V, float) noexcept -> V3f { return safe_divide(a, b); }},
    {"MULTIPLY_ADD", [](V a, V b, V c, float) noexcept -> V3f { return a * b + c; }},
    {"CROSS_PRODUCT", [](V a, V b, V, float) noexcept -> V3f { return a.cross(b); }},
    {"PROJECT", [](V a, V b, V, float) noexcept -> V3f { return project(a, b); }},
    {"REFLECT", [](V a, V b, V, float) noexcept -> V3f { return mirror(a, b); }},
    {"REFRACT", [](V a, V b, V, float scale) noexcept -> V3f { return bend(a, b, scale); }},
    {"FACEFORWARD", [](V a, V b, V c, float) noexcept -> V3f { return c.dot(b) < 0 ? a : -a; }},
    {"DOT_PRODUCT", [](V a, V b, V, float) noexcept -> V3f { return V3f(a.dot(b)); }},
    {"DISTANCE", [](V a, V b, V, float) noexcept -> V3f { return V3f((a - b).length()); }},
    {"LENGTH", [](V a, V, V, float) noexcept -> V3f { return V3f(a.length()); }},
    {"SCALE", [](V a, V, V, float scale) noexcept -> V3f { return a * scale; }},
    {"NORMALIZE", [](V a, V, V, float) noexcept -> V3f { return safe_normalize(a); }},
    {"ABSOLUTE",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return std::abs(x); });
     }},
    {"POWER",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float y, float) {
         return x < 0 && y != std::trunc(y) ? 0.0f : std::pow(x, y);
       });
     }},
    {"SIGN",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return x > 0 ? 1.0f : x < 0 ? -1.0f : 0.0f; });
     }},
    {"MINIMUM",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float y, float) { return std::min(x, y); });
     }},
    {"MAXIMUM",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float y, float) { return std::max(x, y); });
     }},
    {"ROUND",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return std::floor(x + 0.5f); });
     }},
    {"FLOOR",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return std::floor(x); });
     }},
    {"CEIL",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return std::ceil(x); });
     }},
    {"FRACTION",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return x - std::floor(x); });
     }},
    {"MODULO",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float y, float) { return y != 0 ? std::fmod(x, y) : 0.0f; });
     }},
    {"WRAP",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float y, float z) { return wrap(x, y, z); });
     }},
    {"SNAP",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float y, float) { return std::floor(safe_divide(x, y)) * y; });
     }},
    {"SINE",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return std::sin(x); });
     }},
    {"COSINE",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return std::cos(x); });
     }},
    {"TANGENT",
     [](V a, V b, V c, float) noexcept -> V3f {
       return each(a, b, c, [](float x, float, float) { return std::tan(x); });
     }},
};

Register vector_math(const Instruction& i, const Evaluation& e) noexcept {
  const V3f v =
      vector_words[i.choice].operation(operand(i, e, 0), operand(i, e, 1), operand(i, e, 2), number(i, e, 3));
  return is_finite(v) ? v : V3f(0);
}
Value vector_math_node(NodeReader& n, std::string_view output) {
  const std::string word = n.option("operation", "ADD");
  int choice = 0;
  for (const VectorWord& known : vector_words) {
    if (known.name == word) break;
    ++choice;
  }
  if (choice == static_cast<int>(std::size(vector_words))) {
    n.warn("operation '" + word + "' is not supported; its first input is passed on");
    return n.vector("Vector");
  }
  const auto optional = [&](std::string_view name) {
    return n.is_given(name) ? n.vector(name) : n.constant(V3f(0), Type::Vector);
  };
  const Value scale = n.is_given("Scale") ? n.number("Scale", 1) : n.constant(1.0f);
  return n.emit(vector_math, output == "Value" ? Type::Number : Type::Vector,
                {n.vector("Vector"), optional("Vector_001"), optional("Vector_002"), scale},
                {.choice = choice});
}

[[nodiscard]] V3f turn_around(const V3f& v, const V3f& axis, float angle) noexcept {  // Rodrigues
  const V3f k = safe_normalize(axis);
  if (k == V3f(0)) return v;
  return v * std::cos(angle) + k.cross(v) * std::sin(angle) + k * (k.dot(v) * (1 - std::cos(angle)));
}
Register vector_rotate(const Instruction& i, const Evaluation& e) noexcept {
  const V3f center = operand(i, e, 1), v = operand(i, e, 0) - center;
  if (i.choice == 4) {
    const Rotation rotation(operand(i, e, 2));
    return (i.flag ? rotation.turn_back(v) : rotation.turn(v)) + center;
  }
  constexpr float axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const V3f axis = i.choice == 0 ? operand(i, e, 2)
                                 : V3f(axes[i.choice - 1][0], axes[i.choice - 1][1], axes[i.choice - 1][2]);
  return turn_around(v, axis, i.flag ? -number(i, e, 3) : number(i, e, 3)) + center;
}
Value vector_rotate_node(NodeReader& n, std::string_view) {
  const int choice = n.choose("rotation_type", {"AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ"});
  const Value axis = choice == 4   ? n.vector("Rotation")
                     : choice == 0 ? n.vector("Axis", V3f(0, 0, 1))
                                   : n.constant(V3f(0), Type::Vector);
  const Value angle = choice == 4 ? n.constant(0.0f) : n.number("Angle");
  return n.emit(vector_rotate, Type::Vector, {n.vector("Vector"), n.vector("Center"), axis, angle},
                {.choice = choice, .flag = n.flag("invert")});
}

// Choice: 0 point, 1 vector, 2 normal. Flag: world to object (else object to world).
Register vector_transform(const Instruction& i, const Evaluation& e) noexcept {
  const V3f v = operand(i, e, 0);
  if (!e.point.object) return v;
  const auto& forward = i.flag ? e.point.object->world_to_object : e.point.object->object_to_world;
  const auto& back = i.flag ? e.point.object->object_to_world : e.point.object->world_to_object;
  V3f out;
  if (i.choice == 0)
    forward.multVecMatrix(v, out);
  else if (i.choice == 1)
    forward.multDirMatrix(v, out);
  else
    out = safe_normalize({back[0][0] * v.x + back[0][1] * v.y + back[0][2] * v.z,
                          back[1][0] * v.x + back[1][1] * v.y + back[1][2] * v.z,
                          back[2][0] * v.x + back[2][1] * v.y + back[2][2] * v.z});
  return out;
}
Value vector_transform_node(NodeReader& n, std::string_view) {
  const std::string from = n.option("convert_from", "WORLD"), to = n.option("convert_to", "OBJECT");
  const Value v = n.vector("Vector");
  if (from == "CAMERA" || to == "CAMERA") n.warn("camera space is not supported; the vector is passed on");
  if (from == to || from == "CAMERA" || to == "CAMERA") return v;
  return n.emit(vector_transform, Type::Vector, {v},
                {.choice = n.choose("vector_type", {"POINT", "VECTOR", "NORMAL"}),
                 .flag = to == "OBJECT",
                 .varies = true});
}

Register combine(const Instruction& i, const Evaluation& e) noexcept {
  return {number(i, e, 0), number(i, e, 1), number(i, e, 2)};
}
Register component(const Instruction& i, const Evaluation& e) noexcept {
  return Register(operand(i, e, 0)[i.choice]);
}
Value combine_xyz_node(NodeReader& n, std::string_view) {
  return n.emit(combine, Type::Vector, {n.number("X"), n.number("Y"), n.number("Z")});
}
Value separate_xyz_node(NodeReader& n, std::string_view output) {
  return n.emit(component, Type::Number, {n.vector("Vector")},
                {.choice = output == "X"   ? 0
                           : output == "Y" ? 1
                                           : 2});
}

constexpr std::pair<std::string_view, Builder> table[] = {
    {"Mapping", mapping_node},
    {"VectorMath", vector_math_node},
    {"VectorRotate", vector_rotate_node},
    {"VectorTransform", vector_transform_node},
    {"CombineXYZ", combine_xyz_node},
    {"SeparateXYZ", separate_xyz_node},
};

}  // namespace

Builders vector_nodes() { return table; }

}  // namespace sluice
