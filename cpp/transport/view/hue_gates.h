// SPDX-License-Identifier: GPL-3.0-or-later
// Gates that shift hues, as view paths met them. H acts on the colour of one path's light, so it cannot be
// part of a path's weight: each contribution goes through the gates on its own, from the light's end to the
// eye's (design §4).
#pragma once
#include <vector>

#include "edit/hue.h"

namespace sluice {

class HueGates {
 public:
  void clear() noexcept { gates_.clear(); }

  // A gate that shifts by `angle` (radians), behind which the path's weight is counted anew. `weight`: of the
  // path from the gate `towards_eye` (-1: the eye) to here.
  [[nodiscard]] int add(const Color& weight, float angle, int towards_eye) {
    gates_.push_back({weight, angle, towards_eye});
    return static_cast<int>(gates_.size()) - 1;
  }
  // Light that comes out of a gate towards the eye (-1: none), as the eye sees it.
  [[nodiscard]] Color to_eye(Color radiance, int gate) const noexcept {
    for (; gate >= 0; gate = gates_[static_cast<std::size_t>(gate)].towards_eye)
      radiance = apply_hue(radiance, gates_[static_cast<std::size_t>(gate)].angle) *
                 gates_[static_cast<std::size_t>(gate)].weight;
    return radiance;
  }

 private:
  struct Gate {
    Color weight;
    float angle;
    int towards_eye;
  };
  std::vector<Gate> gates_;  // of all branches of a sample
};

}  // namespace sluice
