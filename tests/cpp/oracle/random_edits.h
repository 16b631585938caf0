// SPDX-License-Identifier: GPL-3.0-or-later
// Edits drawn at random over the floor of a Stage: any placement, plane-mates, mirrored and skewed quads,
// several exits or none.
#pragma once
#include <algorithm>

#include "oracle/rules.h"
#include "oracle/stage.h"

namespace sluice::oracle {

struct EditKinds {
  std::vector<std::string> expressions;
  // false: exits out of the camera's sight (for the forward oracle), sending light down to the floor
  bool exits_over_floor = true;
  bool hue = true, partial = true, repeat = true;
};

class EditMaker {
 public:
  explicit EditMaker(std::uint64_t seed) : random_(seed) {}

  void add(Stage& stage, const EditKinds& kinds) {
    const std::string& expression =
        kinds
            .expressions[static_cast<std::size_t>(random_.below(static_cast<int>(kinds.expressions.size())))];
    const double half = real(0.2, 0.45);
    const M44d entry = any_place(real(0, 1) < 0.3 ? 0 : real(0.1, 1.2));
    EditDescription& e =
        stage.edit("Edit" + std::to_string(stage.scene.edits.size()), expression, entry, half);
    places_.push_back(entry);
    if (kinds.partial && real(0, 1) < 0.3) e.amount = 0.6f, e.feather = 0.5f;
    e.repeat = kinds.repeat && real(0, 1) < 0.2;
    const int exits = random_.below(6) == 0 ? 0 : 1 + (random_.below(3) == 0);
    for (int i = 0; i < exits; ++i) {
      const M44d at = kinds.exits_over_floor ? any_place(real(0, 1) < 0.3 ? 0 : real(0.1, 1.2)) : beside();
      ExitDescription& x = stage.exit(e, at, half * real(0.7, 1.3));
      places_.push_back(at);
      x.intensity = static_cast<float>(real(0.4, 1));
      if (kinds.hue && real(0, 1) < 0.5) x.hue_shift = static_cast<float>(real(-3, 3));
      x.keep_brightness = real(0, 1) < 0.5;
    }
  }
  // Orders stay unique but say nothing of age any more.
  void shuffle_orders(Stage& stage) {
    std::vector<int*> orders;
    for (EditDescription& e : stage.scene.edits) {
      orders.push_back(&e.entry.order);
      for (ExitDescription& x : e.exits) orders.push_back(&x.quad.order);
    }
    for (std::size_t i = orders.size(); i > 1; --i)
      std::swap(*orders[i - 1], *orders[static_cast<std::size_t>(random_.below(static_cast<int>(i)))]);
  }

 private:
  double real(double low, double high) { return low + (high - low) * random_.unit(); }

  M44d any_place(double z) {
    if (!places_.empty() && real(0, 1) < 0.3) {  // in the plane of another quad, shifted within it
      M44d m = places_[static_cast<std::size_t>(random_.below(static_cast<int>(places_.size())))];
      const double a = real(-0.3, 0.3), b = real(-0.3, 0.3);
      for (int i = 0; i < 3; ++i) m[3][i] += a * m[0][i] + b * m[1][i];
      return m;
    }
    const V3d at(real(-0.5, 0.5), real(-0.5, 0.5), z);
    const V3d up = z == 0 ? V3d(0, 0, 1) : V3d(real(-0.6, 0.6), real(-0.6, 0.6), real(0, 1) < 0.5 ? 1 : -1);
    M44d m = facing(up, at, real(0.7, 1.3), real(0.7, 1.3), real(0, 6));
    if (real(0, 1) < 0.3)  // sheared
      for (int i = 0; i < 3; ++i) m[1][i] += 0.3 * m[0][i];
    if (real(0, 1) < 0.3)  // mirrored
      for (int i = 0; i < 3; ++i) m[0][i] = -m[0][i];
    return m;
  }
  // Left or right of what the camera sees, high, leaning to the floor before it.
  M44d beside() {
    const double side = real(0, 1) < 0.5 ? -1 : 1;
    return facing({side * real(0.3, 0.8), real(-0.2, 0.2), 1},
                  {side * real(1.6, 1.9), real(-0.3, 0.3), real(0.7, 1.2)}, real(0.7, 1.3), real(0.7, 1.3),
                  real(0, 6));
  }

  Random random_;
  std::vector<M44d> places_;
};

}  // namespace sluice::oracle
