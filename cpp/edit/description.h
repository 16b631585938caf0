// SPDX-License-Identifier: GPL-3.0-or-later
// An edit as the artist describes it (paper §4, Table 1): plain data, one entry, its expression, zero or more
// exits. Knows nothing of scenes, rays or renderers.
#pragma once
#include <string>
#include <vector>

#include "base/colour.h"

namespace sluice {

// The square (±half_size, ±half_size, 0) of an Empty's local XY plane under `matrix` (local to world, row
// vectors). Arrow: image of local +Z. `offset` (m) adds to the distance at which the quad floats in front of
// its plane (design §2).
struct QuadDescription {
  std::string name;
  M44d matrix;
  double half_size = 1;
  double offset = 0;
  int order = 0;  // unique in the scene; decides between quads in one plane
};

struct ExitDescription {
  QuadDescription quad;
  float intensity = 1;  // λ of the paper; factor on energy
  float hue_shift = 0;  // φ of the paper; radians on the hue circle
  // colours what leaves, white light too, and keeps the luminance of white; black: white
  Color tint{1};
  bool keep_brightness = true;  // area_ratio σ on
  // indices into the scene's images; -1: none. Their linear luminance times the number above
  int intensity_texture = -1;
  int hue_shift_texture = -1;
  int normal_map = -1;  // tangent space, n = 2c - 1
};

struct EditDescription {
  QuadDescription entry;   // the edit's name is its entry's
  std::string expression;  // over the path so far; see expression.h
  bool enabled = true;
  bool repeat = false;                   // may act more than once per path
  float amount = 1;                      // how much of the matching light the entry takes
  float feather = 0;                     // width of its soft border, fraction of the half side
  std::vector<ExitDescription> exits;    // none: the light is absorbed
  std::vector<std::string> collections;  // of the entry: F'Collection' matches all edits in it
};

// A picture of the light whose whole path, L to E, matches an expression (paper Fig. 2). A render pass under
// its name.
struct LayerDescription {
  std::string name, expression;
};

}  // namespace sluice
