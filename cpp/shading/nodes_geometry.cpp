// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes that read the point: coordinates, normals, object and ray facts. Under a bump shift the positions and
// UVs move along the tangent plane; everything else stays.
#include "shading/compiler.h"

namespace sluice {
namespace {

using Type = Value::Type;

// How far the point is moved in world space for this instruction.
[[nodiscard]] V3f offset_of(const Instruction& i, const Evaluation& e) noexcept {
  const SurfacePoint& p = e.point;
  if (!i.shift || !p.object) return V3f(0);
  const Frame frame(p.ns);
  return (i.shift == 1 ? frame.t : frame.b) * p.object->bump_step;
}
[[nodiscard]] V3f position_of(const Instruction& i, const Evaluation& e) noexcept {
  return e.point.position + offset_of(i, e);
}

Register position(const Instruction& i, const Evaluation& e) noexcept { return position_of(i, e); }

Register object_position(const Instruction& i, const Evaluation& e) noexcept {
  V3f p = position_of(i, e);
  if (e.point.object) e.point.object->world_to_object.multVecMatrix(position_of(i, e), p);
  return p;
}

Register generated(const Instruction& i, const Evaluation& e) noexcept {
  const V3f p = object_position(i, e);
  if (!e.point.object) return p;
  const V3f size = e.point.object->texture_size, from = p - e.point.object->texture_origin;
  const auto divide = [](float a, float b) { return b != 0 ? a / b : 0.0f; };
  return {divide(from.x, size.x), divide(from.y, size.y), divide(from.z, size.z)};
}

Register uv_map(const Instruction& i, const Evaluation& e) noexcept {
  const UvPoint& map = e.point.uv[static_cast<std::size_t>(i.item)];
  const V3f offset = offset_of(i, e);
  return {map.uv.x + map.grad_u.dot(offset), map.uv.y + map.grad_v.dot(offset), 0};
}

Register color_layer(const Instruction& i, const Evaluation& e) noexcept {
  return e.point.colors[static_cast<std::size_t>(i.item)];
}

// Normals of the object's space (a covector: the transposed matrix carries it).
[[nodiscard]] V3f to_object_normal(const V3f& n, const Evaluation& e) noexcept {
  if (!e.point.object) return n;
  const auto& m = e.point.object->object_to_world;
  return V3f(m[0][0] * n.x + m[0][1] * n.y + m[0][2] * n.z, m[1][0] * n.x + m[1][1] * n.y + m[1][2] * n.z,
             m[2][0] * n.x + m[2][1] * n.y + m[2][2] * n.z)
      .normalized();
}
Register object_normal(const Instruction&, const Evaluation& e) noexcept {
  return to_object_normal(e.point.ns, e);
}
Register normal(const Instruction&, const Evaluation& e) noexcept { return e.point.ns; }
Register true_normal(const Instruction&, const Evaluation& e) noexcept { return e.point.ng; }
Register incoming(const Instruction&, const Evaluation& e) noexcept { return e.point.wo; }
Register reflection(const Instruction&, const Evaluation& e) noexcept {
  return e.point.object ? e.point.ns * (2 * e.point.ns.dot(e.point.wo)) - e.point.wo : -e.point.wo;
}
Register backfacing(const Instruction&, const Evaluation& e) noexcept {
  return Register(e.point.front ? 0.0f : 1.0f);
}
Register camera_ray(const Instruction&, const Evaluation& e) noexcept {
  return Register(e.point.camera_ray ? 1.0f : 0.0f);
}

// Cycles' radial tangent around an axis of generated coordinates.
Register radial_tangent(const Instruction& i, const Evaluation& e) noexcept {
  const V3f g = generated(i, e) - V3f(0.5f);
  V3f t = i.choice == 0 ? V3f(0, -g.z, g.y) : i.choice == 1 ? V3f(-g.z, 0, g.x) : V3f(-g.y, g.x, 0);
  if (e.point.object) e.point.object->object_to_world.multDirMatrix(V3f(t), t);
  t -= e.point.ns * t.dot(e.point.ns);
  return t.length() > 0 ? t.normalized() : Frame(e.point.ns).t;
}

// Direction of growing u at constant v, orthogonal to n; n is the unflipped normal.
[[nodiscard]] V3f tangent_of(const UvPoint& map, const V3f& n) noexcept {
  V3f t = map.grad_v.cross(n);
  if (t.dot(map.grad_u) < 0) t = -t;
  t -= n * t.dot(n);
  return t.length() > 0 ? t.normalized() : Frame(n).t;
}
Register uv_tangent(const Instruction& i, const Evaluation& e) noexcept {
  return tangent_of(e.point.uv[static_cast<std::size_t>(i.item)], e.point.front ? e.point.ns : -e.point.ns);
}

Register object_fact(const Instruction& i, const Evaluation& e) noexcept {
  if (!e.point.object) return Register(0);
  const ObjectShading& object = *e.point.object;
  switch (i.choice) {
    case 0: return {object.object_to_world[3][0], object.object_to_world[3][1], object.object_to_world[3][2]};
    case 1: return object.color;
    case 2: return Register(static_cast<float>(object.object_index));
    case 3: return Register(static_cast<float>(object.material_index));
    default: return Register(object.random);
  }
}

Value position_node(NodeReader& n, std::string_view output) {
  const auto point = [&](Operation operation, Type type = Type::Vector) {
    return n.emit(operation, type, {}, {.varies = true});
  };
  if (output == "Position") return point(position);
  if (output == "Normal") return point(normal);
  if (output == "True Normal") return point(true_normal);
  if (output == "Incoming")
    return n.emit(incoming, Type::Vector, {}, {.varies = true, .sees_direction = true});
  if (output == "Tangent") return n.emit(radial_tangent, Type::Vector, {}, {.choice = 2, .varies = true});
  if (output == "Backfacing") return point(backfacing, Type::Number);
  if (output == "Pointiness") return n.constant(0.5f);
  n.warn("output '" + std::string(output) + "' is not supported; 0 is used");
  return n.constant(0.0f);
}

Value coordinates_node(NodeReader& n, std::string_view output) {
  const auto point = [&](Operation operation) {
    return n.emit(operation, Type::Vector, {}, {.varies = true});
  };
  if (output == "Generated") return point(generated);
  if (output == "Object") {
    if (n.flag("object")) n.warn("coordinates of another object are not supported; its own are used");
    return point(object_position);
  }
  if (output == "UV") return n.emit(uv_map, Type::Vector, {}, {.item = n.uv_slot(""), .varies = true});
  if (output == "Normal") return point(object_normal);
  if (output == "Reflection")
    return n.emit(reflection, Type::Vector, {}, {.varies = true, .sees_direction = true});
  n.warn("output '" + std::string(output) + "' is not supported; generated coordinates are used");
  return point(generated);
}

Value uv_node(NodeReader& n, std::string_view) {
  return n.emit(uv_map, Type::Vector, {}, {.item = n.uv_slot(n.option("uv_map", "")), .varies = true});
}

Value tangent_node(NodeReader& n, std::string_view) {
  if (n.choose("direction_type", {"RADIAL", "UV_MAP"}) == 1) {
    n.need_gradients();
    return n.emit(uv_tangent, Type::Vector, {}, {.item = n.uv_slot(n.option("uv_map", "")), .varies = true});
  }
  return n.emit(radial_tangent, Type::Vector, {},
                {.choice = n.choose("axis", {"X", "Y", "Z"}), .varies = true});
}

Value object_node(NodeReader& n, std::string_view output) {
  if (output == "Alpha") return n.constant(1.0f);
  constexpr std::array<std::string_view, 5> names{"Location", "Color", "Object Index", "Material Index",
                                                  "Random"};
  for (std::size_t k = 0; k < names.size(); ++k)
    if (names[k] == output)
      return n.emit(object_fact,
                    k == 0   ? Type::Vector
                    : k == 1 ? Type::Rgb
                             : Type::Number,
                    {}, {.choice = static_cast<int>(k), .varies = true});
  n.warn("output '" + std::string(output) + "' is not supported; 0 is used");
  return n.constant(0.0f);
}

Value attribute(NodeReader& n, std::string_view output, const std::string& name) {
  if (output == "Alpha") return n.constant(1.0f);
  const Value color = n.emit(color_layer, output == "Vector" ? Type::Vector : Type::Rgb, {},
                             {.item = n.color_slot(name), .varies = true});
  if (output != "Fac") return color;
  return n.emit(
      [](const Instruction& i, const Evaluation& e) noexcept {
        const Register& c = operand(i, e, 0);
        return Register((c.x + c.y + c.z) / 3);
      },
      Type::Number, {color});
}
Value attribute_node(NodeReader& n, std::string_view output) {
  if (const std::string type = n.option("attribute_type", "GEOMETRY"); type != "GEOMETRY") {
    n.warn("attributes of type " + type + " are not supported; 0 is used");
    return n.constant(0.0f);
  }
  return attribute(n, output, n.option("attribute_name", ""));
}
Value vertex_color_node(NodeReader& n, std::string_view output) {
  return attribute(n, output, n.option("layer_name", ""));
}

Value light_path_node(NodeReader& n, std::string_view output) {
  if (output == "Is Camera Ray")
    return n.emit(camera_ray, Type::Number, {}, {.varies = true, .sees_direction = true});
  n.warn("output '" + std::string(output) + "' is not known here; it reads as 0");
  return n.constant(0.0f);
}

Register tangent_space_normal(const Instruction& i, const Evaluation& e) noexcept {
  const Register& color = operand(i, e, 0);
  const float strength = std::max(0.0f, number(i, e, 1));
  const SurfacePoint& p = e.point;
  const V3f c(2 * color.x - 1, 2 * color.y - 1, 2 * color.z - 1), n = p.front ? p.ns : -p.ns;
  const UvPoint& map = p.uv[static_cast<std::size_t>(i.item)];
  const V3f t = tangent_of(map, n);
  V3f b = n.cross(t);
  if (b.dot(map.grad_v) < 0) b = -b;  // mirrored UVs
  const float z = 1 + (c.z - 1) * std::min(strength, 1.0f);
  const V3f bent = t * (c.x * strength) + b * (c.y * strength) + n * z;
  const V3f result = bent.length() > 0 ? bent.normalized() : n;
  return p.front ? result : -result;
}

Register plain_space_normal(const Instruction& i, const Evaluation& e) noexcept {
  const Register& color = operand(i, e, 0);
  const float strength = std::max(0.0f, number(i, e, 1));
  const SurfacePoint& p = e.point;
  V3f n(2 * color.x - 1, 2 * color.y - 1, 2 * color.z - 1);
  if (i.choice >= 2) n = V3f(n.x, -n.y, -n.z);  // Blender's old axis order
  if (i.choice % 2 == 0 && p.object) {          // object space: normals are carried by the inverse transpose
    const auto& m = p.object->world_to_object;
    n = V3f(m[0][0] * n.x + m[0][1] * n.y + m[0][2] * n.z, m[1][0] * n.x + m[1][1] * n.y + m[1][2] * n.z,
            m[2][0] * n.x + m[2][1] * n.y + m[2][2] * n.z);
  }
  if (!(n.length() > 0)) return p.ns;
  n.normalize();
  if (!p.front) n = -n;
  const V3f result = p.ns + (n - p.ns) * strength;
  return result.length() > 0 ? result.normalized() : p.ns;
}

Value normal_map_node(NodeReader& n, std::string_view) {
  const Value strength = n.number("Strength", 1), color = n.color("Color", Color(0.5f, 0.5f, 1));
  const int space = n.choose("space", {"TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"});
  if (space > 0)
    return n.emit(plain_space_normal, Type::Vector, {color, strength}, {.choice = space - 1, .varies = true});
  n.need_gradients();
  return n.emit(tangent_space_normal, Type::Vector, {color, strength},
                {.item = n.uv_slot(n.option("uv_map", "")), .varies = true});
}

// Mikkelsen 2010 (bump mapping unparametrised surfaces), over the step of the object; operands: three
// heights, strength, distance, normal.
Register bump(const Instruction& i, const Evaluation& e) noexcept {
  const SurfacePoint& p = e.point;
  const V3f n = i.flag ? operand(i, e, 5) : p.ns;
  if (!p.object || !(p.object->bump_step > 0)) return n;
  const Frame frame(p.ns);
  const float scale = number(i, e, 4) / p.object->bump_step * (i.choice ? -1.0f : 1.0f);
  const V3f rx = frame.b.cross(n), ry = n.cross(frame.t);
  const float determinant = frame.t.dot(rx), sign = determinant < 0 ? -1.0f : 1.0f;
  const V3f gradient = rx * (number(i, e, 1) - number(i, e, 0)) + ry * (number(i, e, 2) - number(i, e, 0));
  V3f bent = n * std::abs(determinant) - gradient * (scale * sign);
  if (!(bent.length() > 0) || !is_finite(bent)) return n;
  bent = bent.normalized() * number(i, e, 3) + n * (1 - number(i, e, 3));
  return bent.length() > 0 ? bent.normalized() : n;
}

Value bump_node(NodeReader& n, std::string_view) {
  const bool has_normal = n.is_linked("Normal");
  const Value base = has_normal ? n.vector("Normal") : n.emit(normal, Type::Vector, {}, {.varies = true});
  if (n.shift() || !n.is_linked("Height")) return base;  // no bumps on the way to the height of another bump
  NodeReader along = n.shifted(1), across = n.shifted(2);
  const Value strength = n.number("Strength", 1), distance = n.number("Distance", 1);
  const Value here = n.number("Height"), right = along.number("Height"), up = across.number("Height");
  return n.emit(bump, Type::Vector, {here, right, up, strength, distance, base},
                {.choice = n.flag("invert"), .flag = has_normal, .varies = true});
}

constexpr std::pair<std::string_view, Builder> table[] = {
    {"NewGeometry", position_node},
    {"TexCoord", coordinates_node},
    {"UVMap", uv_node},
    {"Tangent", tangent_node},
    {"ObjectInfo", object_node},
    {"Attribute", attribute_node},
    {"VertexColor", vertex_color_node},
    {"LightPath", light_path_node},
    {"NormalMap", normal_map_node},
    {"Bump", bump_node},
};

}  // namespace

Value NodeReader::texture_vector(std::string_view input, bool from_generated) {
  if (is_given(input)) return vector(input);
  if (from_generated) return emit(generated, Type::Vector, {}, {.varies = true});
  return emit(uv_map, Type::Vector, {}, {.item = uv_slot(""), .varies = true});
}

Value NodeReader::environment_vector(std::string_view input) {
  return is_given(input) ? vector(input) : emit(position, Type::Vector, {}, {.varies = true});
}

Value NodeReader::surface_tangent(std::string_view input) {
  return is_linked(input) ? vector(input)
                          : emit(radial_tangent, Type::Vector, {}, {.choice = 2, .varies = true});
}

Builders geometry_nodes() { return table; }

}  // namespace sluice
