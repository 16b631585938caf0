// SPDX-License-Identifier: GPL-3.0-or-later
// Colours are linear Rec.709 (Blender's scene-linear default).
#pragma once
#include "base/math.h"

namespace sluice {

using Color = V3f;

[[nodiscard]] inline float luminance(const Color& c) noexcept {
  return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}
[[nodiscard]] inline bool is_black(const Color& c) noexcept { return c.x == 0 && c.y == 0 && c.z == 0; }

}  // namespace sluice
