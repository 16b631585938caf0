// SPDX-License-Identifier: GPL-3.0-or-later
// One compiled edit: its entry, its exits, and T = (T_p, T_d, T_s) of paper §4 from the entry to an exit,
// forward with light and backward with view rays. All positions are re-centred: world = position + centre.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/colour.h"
#include "base/image.h"
#include "edit/description.h"
#include "edit/quad.h"
#include "expr/side.h"

namespace sluice {

inline constexpr float max_area_ratio = 1e6f;  // numerics P8: gains of a chain must not overflow

// Its properties are checked: the tint is of luminance 1, exactly white unless it colours; textures are
// indices into the edits' own images.
struct Exit : ExitProperties {
  Quad quad;
  std::string name;
  float area_ratio = 1;      // σ on flux: area of exit / area of entry, <= 1e6; 1 when off
  float radiance_ratio = 1;  // σ area of entry / area of exit: 1 when area_ratio is on
};

// One acting edit. Disabled edits and those that were refused are not here at all.
struct Edit {
  std::string name;
  std::size_t description = 0;  // index into the descriptions
  Side side = Side::Light;
  int order = 0;
  bool repeat = false;
  bool is_partial = false;  // amount or feather leave light to go straight on
  float amount = 1, feather = 0;
  Quad entry;
  std::vector<Exit> exits;
};

// The implicit exit that leads straight on, with what the entry's weight leaves.
inline constexpr int straight_on = -1;

// How a path goes on at the far side of a gate. The gain is without the entry's weight; light has it after H.
struct Passage {
  V3d position;   // on the far quad
  V3f direction;  // unit, of travel
  // tint included; light edit forward: of flux; backward: of radiance; view edit forward: of radiance
  Color gain{1};
  float hue = 0;   // H's angle, radians; 0: none
  int group = -1;  // plane group of the far quad: the next segment excludes it
};

// M_d of the paper for a texel of a normal map: columns t, b, n of an orthogonal turn. Identity where the
// texel is no normal.
[[nodiscard]] QuadFrame normal_map_turn(const Color& texel) noexcept;

// a(u, v) = amount × feather: what the exits get. The straight_on exit gets 1 - a.
[[nodiscard]] float entry_weight(const Edit& edit, const V2d& uv) noexcept;

// From the entry at uv, going in `direction`, out of an exit. Light edits: flux gain. View edits carry
// radiance: intensity alone. Empty (to be counted) where a normal_map leaves |cos| < 1e-3 at the exit of a
// light edit. `images`: those that the exits' textures are numbers of.
[[nodiscard]] std::optional<Passage> pass_forward(const Edit& edit, int exit, const V2d& uv,
                                                  const V3f& direction,
                                                  std::span<const Image> images) noexcept;
// A view ray going in `direction` meets an exit of a light edit at uv from behind: on from the entry.
// Radiance gain.
[[nodiscard]] std::optional<Passage> pass_backward(const Edit& edit, int exit, const V2d& uv,
                                                   const V3f& direction,
                                                   std::span<const Image> images) noexcept;

}  // namespace sluice
