// SPDX-License-Identifier: GPL-3.0-or-later
// What light arrives at an entry, by kind, whether its edit takes it or not: for artists whose expression
// finds nothing. Traces light paths of its own, which are no part of the image.
#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "transport/effects.h"
#include "transport/settings.h"

namespace sluice {

struct Arrivals {
  struct Kind {
    std::string expression;  // that takes it
    double share;            // of the energy that comes from its side
  };
  std::uint64_t probed = 0, crossed = 0;  // paths
  std::uint64_t taken = 0;                // paths that another edit took right before
  std::string taker;                      // the one that took most
  // the commonest first, few; of the side from which more energy comes
  std::vector<Kind> kinds;
};

// Per edit of the scene; nothing for view edits. On one thread, of a render on `threads`.
[[nodiscard]] std::vector<Arrivals> find_arrivals(const Scene& scene, const TransportSettings& settings,
                                                  const Effects& effects, int threads,
                                                  const std::atomic<bool>& cancel);

}  // namespace sluice
