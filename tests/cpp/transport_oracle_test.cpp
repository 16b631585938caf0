// SPDX-License-Identifier: GPL-3.0-or-later
// The core against the oracles of design §5 on small scenes. Fast form: any deviation of the size that a wrong rule makes (numerics
// §10: 2 to 21 % of the image). SLUICE_FULL=1: every region within 1 %.
#include "oracle/compare.h"

namespace sluice::oracle {
namespace {

TEST(Oracle, no_edit_point_lamp) {
  Stage s;
  s.lamp("Lamp", LightKind::Point, facing({0, 0, 1}, {0.4, -0.3, 1.5}), 30);
  compare("no edit, point lamp", s, Which::Forward, lit);
}

TEST(Oracle, no_edit_area_lamp) {
  Stage s;
  s.area("Lamp", {0, 0, 1.8}, 1.6f, 30);
  s.world({0.2f, 0.3f, 0.4f});
  compare("no edit, area lamp and world, forward", s, Which::Forward, lit);
  compare("no edit, area lamp and world, from the eye", s, Which::Eye, everything);
}

TEST(Oracle, direct_through_a_gate) {
  Stage s;
  s.lamp("Lamp", LightKind::Point, facing({0, 0, 1}, {0.4, -0.3, 1.5}), 30);
  auto& e = s.edit("In", "L", facing({0.2, 0.1, 1}, {0.3, 0, 0.8}), 0.3);
  s.exit(e, facing({0, 0, 1}, {-0.2, 0.1, 0.5}, 1, 1.3, 0.4), 0.3).hue_shift = 1;
  compare("direct through a gate", s, Which::Forward, lit);
}

}  // namespace
}  // namespace sluice::oracle
