// SPDX-License-Identifier: GPL-3.0-or-later
// Gather segments, and the far end y of one that the bundle shares, with the light that leaves it.
#pragma once
#include <array>
#include <cmath>

#include "transport/view/lobe_groups.h"
#include "transport/view/outgoing_radiance.h"

namespace sluice {

// Direct light at a y whose BSDF depends on the viewing direction: stored unscattered, and multiplied by the
// BSDF once per receiving vertex.
struct UnscatteredLight {
  struct Share {
    std::size_t lobe;   // of v, an index into the point's list
    Event event;        // by which it leaves y
    JoinResult joined;  // what becomes of it then
  };
  V3f wi;
  Color arriving;  // radiance / density
  std::array<Share, 2 * LobeThroughputs::max> shares;
  std::size_t count = 0;  // 0: there is no such light
};

// What a gather segment found.
struct GatherSegment {
  Vertex y;
  LobeThroughputs lobes;  // of v
  float pdf;              // of its direction (1/sr)
  double length;
  bool may_share;  // false: there is alpha on the way or at y, of which a shadow ray cannot tell
};

struct GatherPoint {
  GatherSegment segment;  // of its finder
  // Bound on the angle (rad) over which what y sends out changes little; infinite: it is the same to all
  // sides.
  float width;
  // By lobe: light of photons, and direct light where y looks the same from all sides.
  std::array<OutgoingRadiance, LobeThroughputs::max> light;
  UnscatteredLight unscattered;

  [[nodiscard]] bool depends_on_direction() const noexcept { return std::isfinite(width); }
  [[nodiscard]] std::size_t index_of(const LobeThroughput& lobe) const noexcept {
    return static_cast<std::size_t>(&lobe - segment.lobes.begin());
  }
  [[nodiscard]] const OutgoingRadiance& light_of(const LobeThroughput& lobe) const noexcept {
    return light[index_of(lobe)];
  }
};

}  // namespace sluice
