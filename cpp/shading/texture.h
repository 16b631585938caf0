// SPDX-License-Identifier: GPL-3.0-or-later
// Lookups in images: filtering, what lies outside [0, 1]², and the projections that turn vectors into (u, v).
#pragma once
#include "shading/program.h"

namespace sluice {

struct Texel {
  Color color;
  float alpha;
};

// Colour as the Image Texture node gives it; magenta where the image is missing. Row 0 lies at v = 0.
[[nodiscard]] Texel sample_texture(const Texture& texture, float u, float v) noexcept;

// Box projection (Cycles' svm_node_tex_image_box): weights of the three sides by the object-space normal.
[[nodiscard]] Texel sample_box(const Texture& texture, const V3f& p, const V3f& normal) noexcept;

// Blender's conventions. Equirectangular: u = 1/2 along +X, growing towards -Y; v = 1 along +Z.
[[nodiscard]] V2f project(Projection projection, const V3f& v) noexcept;

}  // namespace sluice
