// SPDX-License-Identifier: GPL-3.0-or-later
// The colour of a glowing body, as Blender's Blackbody node has it. Materials ask for it by that node, the
// host for the nodes of lamps.
#pragma once
#include "base/colour.h"

namespace sluice {

// Rec. 709 of luminance 1. Below 965 K and above 12000 K it stays as it is there.
[[nodiscard]] Color blackbody(float kelvin) noexcept;

}  // namespace sluice
