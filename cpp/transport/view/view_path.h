// SPDX-License-Identifier: GPL-3.0-or-later
// A path from the eye towards the light, as it is while one branch of a view sample is followed. The light
// side's path is in light_tracer.h.
#pragma once
#include <limits>

#include "transport/vertex.h"
#include "transport/view/join_constraints.h"

namespace sluice {

struct ViewPath {
  // The segment that starts now.
  V3d origin;
  V3f direction;
  V3f clearance{0};
  double t_max = std::numeric_limits<double>::infinity();

  // What light that arrives here is worth to the eye.
  Color weight{1};                          // radiance factor, as far as the last gate that shifts hues
  int hue = -1;                             // that gate, a number of HueGates
  ConstraintId constraint = no_constraint;  // and which light may arrive: the set C
  Color throughput{1};                      // of materials alone, for roulette

  // What it met.
  StateId state = 0;  // of the view edits' automata
  int depth = 0;      // D, S, G events so far
  int gates = 0;
  std::uint64_t signature = 0;  // hash of the things that it met, in order
  bool is_camera = true;        // no event yet: sees what the camera sees

  // The gate that it has just left.
  int excluded_group = -1;  // plane group that the segment starts on
  int own_entry = -1;       // it came backward out of this light edit's entry: the entry's plane comes first
  int at_edit = -1, at_exit = 0;  // it left this exit of a view edit: entries in its plane come first
  int last_edit = -1;             // whose gate it met last

  // The followed lobe that made the direction, for MIS.
  float lobe_pdf = 0;  // of the direction (1/sr); 0: no chance was in it (delta, camera, gate)
  V3d lobe_origin{0};
  V3f lobe_normal{0};  // the side from which lights are chosen there
};

}  // namespace sluice
