// SPDX-License-Identifier: GPL-3.0-or-later
// What a material may ask about the point it shades. The scene fills it at a hit: the members up to `object`
// always, `uv` and `colors` as far as Material::needs() names them, in that order. Knows no meshes and no
// rays.
#pragma once
#include <Imath/ImathMatrix.h>

#include <array>

#include "base/colour.h"
#include "base/math.h"

namespace sluice {

inline constexpr int max_uv_maps = 4;       // per material
inline constexpr int max_color_layers = 4;  // per material

// One per instance, owned by the scene; points refer to it. Coordinates that are affine in the position come
// from here.
struct ObjectShading {
  Imath::M44f object_to_world, world_to_object;  // row vectors, the artist's coordinates
  V3f texture_origin{0}, texture_size{1};        // "generated" = (p_object - origin) / size
  Color color{1};                                // Object Info
  float random = 0;
  int object_index = 0, material_index = 0;
  // world length over which Bump takes differences: about 2^-11 of the object's diagonal
  float bump_step = 1e-3f;
};

struct UvPoint {
  V2f uv{0};
  // surface gradients in world space (1/m): moving by dp on the triangle changes u by grad_u·dp
  V3f grad_u{0}, grad_v{0};
};

struct SurfacePoint {
  V3f position{0};  // world, the artist's coordinates (not re-centred)
  V3f ng{0, 0, 1};  // unit geometric normal, flipped so that dot(ng, wo) > 0
  V3f ns{0, 0, 1};  // unit shading normal, on the side of ng and never below the surface as seen from wo
  V3f wo{0, 0, 1};
  // the ray hit the side that the true, unflipped normal points to: light entering glass goes in
  bool front = true;
  bool camera_ray = true;  // Light Path
  // a light path: flux flows from wo to wi (decides which side a coating's loss is read on)
  bool photon = false;
  const ObjectShading* object = nullptr;  // null: a world
  std::array<UvPoint, max_uv_maps> uv;
  std::array<Color, max_color_layers> colors;
};

}  // namespace sluice
