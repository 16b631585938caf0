// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/texture.h"

namespace sluice {
namespace {

[[nodiscard]] int place(int x, int size, Extension extension) noexcept {
  if (x >= 0 && x < size) return x;
  if (extension == Extension::Repeat) return ((x % size) + size) % size;
  if (extension == Extension::Mirror) {
    const int k = ((x % (2 * size)) + 2 * size) % (2 * size);
    return k < size ? k : 2 * size - 1 - k;
  }
  return std::clamp(x, 0, size - 1);
}

[[nodiscard]] Texel fetch(const Image& image, int x, int y, Extension extension) noexcept {
  x = place(x, image.width, extension);
  y = place(y, image.height, extension);
  const float* p =
      image.rgba.data() +
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  return {Color(p[0], p[1], p[2]), p[3]};
}

[[nodiscard]] Texel mix_texels(const Texel& a, const Texel& b, float f) noexcept {
  return {a.color + (b.color - a.color) * f, a.alpha + (b.alpha - a.alpha) * f};
}

// Keeps floor() inside int for any finite input.
[[nodiscard]] float wrap_coordinate(float x, Extension extension) noexcept {
  if (!std::isfinite(x)) return 0;
  if (extension == Extension::Repeat) return x - std::floor(x);
  if (extension == Extension::Mirror) return x - 2 * std::floor(x / 2);
  return std::clamp(x, -2.0f, 3.0f);
}

}  // namespace

Texel sample_texture(const Texture& texture, float u, float v) noexcept {
  if (!texture.image) return {Color(1, 0, 1), 1};
  const Image& image = *texture.image;
  if (texture.extension == Extension::Clip) {  // as Cycles: nothing outside, the border's own texels inside
    if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1)) return {Color(0), 0};
    Texture inside = texture;
    inside.extension = Extension::Extend;
    return sample_texture(inside, u, v);
  }
  const float x = wrap_coordinate(u, texture.extension) * static_cast<float>(image.width);
  const float y = wrap_coordinate(v, texture.extension) * static_cast<float>(image.height);
  Texel texel;
  if (texture.interpolation == Interpolation::Closest) {
    texel = fetch(image, static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)), texture.extension);
  } else {
    const float fx = std::floor(x - 0.5f), fy = std::floor(y - 0.5f);
    const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
    const float s = x - 0.5f - fx, t = y - 0.5f - fy;
    const Extension e = texture.extension;
    texel = mix_texels(mix_texels(fetch(image, ix, iy, e), fetch(image, ix + 1, iy, e), s),
                       mix_texels(fetch(image, ix, iy + 1, e), fetch(image, ix + 1, iy + 1, e), s), t);
  }
  if (texture.premultiply) texel.color *= texel.alpha;
  return texel;
}

Texel sample_box(const Texture& texture, const V3f& p, const V3f& normal) noexcept {
  V3f n(std::abs(normal.x), std::abs(normal.y), std::abs(normal.z));
  const float sum = n.x + n.y + n.z;
  n = sum > 0 ? n / sum : V3f(0, 0, 1);
  // Within `limit` of an edge between two sides they are mixed; near a corner all three.
  const float blend = texture.blend, limit = 0.5f * (1 + blend);
  V3f weight(0);
  if (n.x > limit * (n.x + n.y) && n.x > limit * (n.x + n.z))
    weight.x = 1;
  else if (n.y > limit * (n.x + n.y) && n.y > limit * (n.y + n.z))
    weight.y = 1;
  else if (n.z > limit * (n.x + n.z) && n.z > limit * (n.y + n.z))
    weight.z = 1;
  else if (blend > 0) {
    if (n.z < (1 - limit) * (n.y + n.x)) {
      weight.x = std::clamp((n.x / (n.x + n.y) - 0.5f * (1 - blend)) / blend, 0.0f, 1.0f);
      weight.y = 1 - weight.x;
    } else if (n.x < (1 - limit) * (n.y + n.z)) {
      weight.y = std::clamp((n.y / (n.y + n.z) - 0.5f * (1 - blend)) / blend, 0.0f, 1.0f);
      weight.z = 1 - weight.y;
    } else if (n.y < (1 - limit) * (n.x + n.z)) {
      weight.x = std::clamp((n.x / (n.x + n.z) - 0.5f * (1 - blend)) / blend, 0.0f, 1.0f);
      weight.z = 1 - weight.x;
    } else {
      weight = V3f(((2 - limit) * n.x + (limit - 1)) / (2 * limit - 1),
                   ((2 - limit) * n.y + (limit - 1)) / (2 * limit - 1),
                   ((2 - limit) * n.z + (limit - 1)) / (2 * limit - 1));
    }
  } else {
    weight.x = 1;
  }
  Texel out{Color(0), 0};
  const auto add = [&](float w, float u, float v) {
    if (!(w > 0)) return;
    const Texel t = sample_texture(texture, u, v);
    out.color += t.color * w;
    out.alpha += t.alpha * w;
  };
  add(weight.x, normal.x < 0 ? 1 - p.y : p.y, p.z);
  add(weight.y, normal.y > 0 ? 1 - p.x : p.x, p.z);
  add(weight.z, normal.z > 0 ? 1 - p.y : p.y, p.x);
  return out;
}

V2f project(Projection projection, const V3f& v) noexcept {
  const float length = v.length();
  switch (projection) {
    case Projection::Equirectangular: {
      if (!(length > 0)) return V2f(0);
      const float u = -std::atan2(v.y, v.x) / (2 * pi) + 0.5f;
      return {u, std::atan2(v.z, std::sqrt(v.x * v.x + v.y * v.y)) / pi + 0.5f};
    }
    case Projection::MirrorBall: {
      if (!(length > 0)) return V2f(0.5f);
      V3f d = v / length;
      d.y -= 1;
      const float div = 2 * std::sqrt(std::max(-0.5f * d.y, 0.0f));
      return div > 0 ? V2f(0.5f * (d.x / div + 1), 0.5f * (d.z / div + 1)) : V2f(0.5f);
    }
    case Projection::Sphere: {
      if (!(length > 0)) return V2f(0);
      const V3f d = v * 2.0f - V3f(1);  // generated coordinates around the object's middle
      const float r = d.length(), u = d.x == 0 && d.y == 0 ? 0.0f : (1 - std::atan2(d.x, d.y) / pi) / 2;
      return {u, r > 0 ? 1 - std::acos(std::clamp(d.z / r, -1.0f, 1.0f)) / pi : 0.0f};
    }
    case Projection::Tube: {
      const V3f d = v * 2.0f - V3f(1);
      const float r = std::sqrt(d.x * d.x + d.y * d.y);
      return {r > 0 ? (1 - std::atan2(d.x / r, d.y / r) / pi) / 2 : 0.0f, (d.z + 1) * 0.5f};
    }
    default: return {v.x, v.y};
  }
}

}  // namespace sluice
