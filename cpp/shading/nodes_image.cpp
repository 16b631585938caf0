// SPDX-License-Identifier: GPL-3.0-or-later
// Image Texture and Environment Texture.
#include "shading/compiler.h"
#include "shading/texture.h"

namespace sluice {
namespace {

using Type = Value::Type;

// Flag: alpha instead of colour.
Register image(const Instruction& i, const Evaluation& e) noexcept {
  const Texture& texture = e.program.textures[static_cast<std::size_t>(i.item)];
  const V2f uv = project(texture.projection, operand(i, e, 0));
  const Texel texel = sample_texture(texture, uv.x, uv.y);
  return i.flag ? Register(texel.alpha) : texel.color;
}

Register box_image(const Instruction& i, const Evaluation& e) noexcept {
  V3f n = e.point.ns;
  if (e.point.object) {
    const auto& m = e.point.object->object_to_world;
    n = V3f(V3f(m[0][0], m[0][1], m[0][2]).dot(n), V3f(m[1][0], m[1][1], m[1][2]).dot(n),
            V3f(m[2][0], m[2][1], m[2][2]).dot(n));
  }
  const Texel texel = sample_box(e.program.textures[static_cast<std::size_t>(i.item)], operand(i, e, 0), n);
  return i.flag ? Register(texel.alpha) : texel.color;
}

[[nodiscard]] Texture texture_of(NodeReader& n) {
  Texture texture;
  texture.image = n.image();
  const std::string filter = n.option("interpolation", "Linear");
  texture.interpolation = filter == "Closest" ? Interpolation::Closest : Interpolation::Linear;
  if (filter == "Cubic") n.warn("cubic interpolation is not supported; linear is used");
  texture.premultiply = !n.output_is_read("Alpha") &&
                        n.option("alpha_mode", "STRAIGHT") != "CHANNEL_PACKED" &&
                        n.option("alpha_mode", "") != "NONE";
  return texture;
}

Value image_node(NodeReader& n, std::string_view output) {
  Texture texture = texture_of(n);
  const bool alpha = output == "Alpha";
  const Type type = alpha ? Type::Number : Type::Rgb;
  texture.extension = static_cast<Extension>(n.choose("extension", {"REPEAT", "EXTEND", "CLIP", "MIRROR"}));
  const int projection = n.choose("projection", {"FLAT", "BOX", "SPHERE", "TUBE"});
  texture.projection = static_cast<Projection>(projection);
  texture.blend = std::clamp(n.option_number("projection_blend", 0), 0.0f, 1.0f);
  const bool box = texture.projection == Projection::Box;
  const Value where = n.texture_vector("Vector", false);
  return n.emit(box ? box_image : image, type, {where},
                {.item = n.add_texture(texture), .flag = alpha, .varies = box});
}

Value environment_node(NodeReader& n, std::string_view output) {
  Texture texture = texture_of(n);
  texture.projection = n.choose("projection", {"EQUIRECTANGULAR", "MIRROR_BALL"})
                           ? Projection::MirrorBall
                           : Projection::Equirectangular;
  texture.extension = Extension::Repeat;
  const bool alpha = output == "Alpha";
  return n.emit(image, alpha ? Type::Number : Type::Rgb, {n.environment_vector("Vector")},
                {.item = n.add_texture(texture), .flag = alpha});
}

constexpr std::pair<std::string_view, Builder> table[] = {{"TexImage", image_node},
                                                          {"TexEnvironment", environment_node}};

}  // namespace

Builders image_nodes() { return table; }

}  // namespace sluice
