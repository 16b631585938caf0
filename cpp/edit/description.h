// SPDX-License-Identifier: GPL-3.0-or-later
// An edit as the artist describes it (paper §4, Table 1): plain data, one entry, its expression, zero or more
// exits. Knows nothing of scenes, rays or renderers.
#pragma once
#include <limits>
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
  int order =
      0;  // decides between quads in one plane; of equal ones (copies) the first described comes first
};

// What an exit does to the light that it sends on. A property stands as a member here and as a row of
// for_each_property(), by which it is read from the host and checked; T uses it (gate.cpp).
struct ExitProperties {
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

// How a property is checked.
struct NumberRule {
  float low, high;  // clamped to these
  float if_no_number;
};
struct TintRule {};
struct SwitchRule {};
struct TextureRule {
  bool is_light = false;  // negative pixels count as 0
};

inline constexpr float max_intensity = 1e4f;  // numerics P8: gains of a chain must not overflow

// Calls visit(name, member, rule) for each property.
template <class Visit>
void for_each_property(ExitProperties& exit, const Visit& visit) {
  // All members by name: one that is missing here does not compile.
  auto& [intensity, hue_shift, tint, keep_brightness, intensity_texture, hue_shift_texture, normal_map] =
      exit;
  using Limits = std::numeric_limits<float>;
  visit("intensity", intensity, NumberRule{0, max_intensity, 1});
  visit("hue_shift", hue_shift, NumberRule{Limits::lowest(), Limits::max(), 0});
  visit("tint", tint, TintRule{});
  visit("keep_brightness", keep_brightness, SwitchRule{});
  visit("intensity_texture", intensity_texture, TextureRule{.is_light = true});
  visit("hue_shift_texture", hue_shift_texture, TextureRule{});
  visit("normal_map", normal_map, TextureRule{});
}

struct ExitDescription : ExitProperties {
  QuadDescription quad;
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
