// SPDX-License-Identifier: GPL-3.0-or-later
// Which light edits could take light that comes along a segment towards the eye? Most segments are asked
// nothing at all, and the others only the entries of those edits.
#pragma once
#include <span>
#include <vector>

#include "edit/edits.h"
#include "scene/scene.h"
#include "transport/vertex.h"

namespace sluice {

// Where light starts that comes along a segment: what is at its far end (null: nothing, so light from
// infinity), and lamps on the way.
struct SegmentSources {
  const Vertex* far;
  std::span<const LampHit> lamps;
};

[[nodiscard]] inline EventClass light_class(const Scene& scene, int light) noexcept {
  return scene.edits().event_class(Event::L, scene.light_entity(light));
}

// False: no light edit takes light from there.
[[nodiscard]] inline bool may_be_taken(const Scene& scene, const SegmentSources& from) noexcept {
  return !from.far || !from.lamps.empty() || scene.may_be_taken_from(from.far->hit) ||
         from.far->pass_chance > 0;
}

class PossibleTakers {
 public:
  // Edits that may take light whose last event was one of these lobes at the far end, or the emission of a
  // source. The set lives until the next call.
  [[nodiscard]] EditSet find(const Scene& scene, const SegmentSources& from, EventMask lobes);

 private:
  std::vector<std::uint64_t> members_;
};

}  // namespace sluice
