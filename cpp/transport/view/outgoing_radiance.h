// SPDX-License-Identifier: GPL-3.0-or-later
// Radiance that leaves a point towards several view paths: not yet weighed by any of them.
#pragma once
#include <algorithm>
#include <bit>
#include <vector>

#include "base/colour.h"
#include "edit/state_table.h"
#include "transport/blurred_light.h"

namespace sluice {

struct OutgoingRadiance {
  Color picture{0};
  float bias = 0;  // of the picture's (BlurredLight)
  std::vector<Color> layers;
  // the picture's, by edits that took it on its way: for their statistics
  std::vector<std::pair<std::uint32_t, BlurredLight>> taken;

  void clear(std::size_t layer_count) {
    picture = Color(0), bias = 0;
    layers.assign(layer_count, Color(0));
    taken.clear();
  }
  void add(const BlurredLight& light, ImageSet images) noexcept {
    if (images & sluice::picture) picture += light.radiance, bias += light.bias;
    for (ImageSet left = images >> 1; left; left &= left - 1)
      layers[static_cast<std::size_t>(std::countr_zero(left))] += light.radiance;
  }
  void credit(std::uint32_t edit, const BlurredLight& light) {
    const auto at = std::ranges::find(taken, edit, &std::pair<std::uint32_t, BlurredLight>::first);
    if (at == taken.end())
      taken.emplace_back(edit, light);
    else
      at->second += light;
  }
};

}  // namespace sluice
