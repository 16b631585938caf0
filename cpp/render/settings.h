// SPDX-License-Identifier: GPL-3.0-or-later
// What a render is asked for (design §8, scene.sluice): transport's settings and when to stop. Plain data.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "transport/settings.h"

namespace sluice {

struct RenderSettings {
  TransportSettings transport;
  // beside Combined, by name; empty: all. What nobody asks for takes no memory.
  std::optional<std::vector<std::string>> render_passes;
  int passes = 64;
  int frame = 1;
  bool use_animated_seed = false;  // the frame goes into the seed
  bool use_edits = true;           // false: all edits off at once
  bool explain_edits = false;      // at the end, find what light arrives at their entries
  double time_limit = 0;           // s of rendering, 0 = none
  double error_target = 0;         // error of the picture (accuracy.h; 0.01 = 1 %), 0 = none
  int threads = 0;                 // 0 = all
  std::vector<int> keep_at;        // after so many passes the picture is kept, as it is then
};

// The settings clamped so that every index and radius is meaningful whatever a file says, and with the number
// of threads in place of 0.
[[nodiscard]] RenderSettings bounded(RenderSettings settings);

}  // namespace sluice
