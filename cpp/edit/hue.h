// SPDX-License-Identifier: GPL-3.0-or-later
// H of design §4 (paper §4.2, H_φ): the hue turns on the HSV hexagon, luminance stays.
#pragma once
#include "base/colour.h"

namespace sluice {

// Homogeneous but not linear: apply it to the colour of one path, never to a sum. Angle 0, black and greys
// come back bit for bit; so does what is not finite. Negative components count as 0.
[[nodiscard]] Color apply_hue(const Color& color, float angle_rad) noexcept;

}  // namespace sluice
