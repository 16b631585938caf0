// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/targets.h"

#include <array>

#include "edit/gates.h"
#include "transport/emission.h"

namespace sluice {
namespace {

std::array<V3d, 4> corners_of(const Quad& quad) { return {quad.point({0, 0}), quad.point({1, 0}), quad.point({0, 1}), quad.point({1, 1})}; }

}  // namespace

// Out there light has met nothing: only entries that take it right after L matter, and those that other such entries send it to.
FarEntries find_far_entries(const Scene& scene) {
  const Edits& edits = scene.edits();
  const Target surfaces = whole_scene(scene);
  FarEntries far{.target = {}, .is_for = std::vector<char>(scene.lights().size(), 0)};
  Bounds bounds;
  for (int e = 0; e < edits.size(); ++e) {
    const Edit& edit = edits[e];
    const auto corners = corners_of(edit.entry);
    const auto is_outside = [&](const V3d& p) { return (p - surfaces.centre).length() > surfaces.radius; };
    if (edit.side != Side::Light || (edit.exits.empty() && !edit.is_partial) || std::ranges::none_of(corners, is_outside)) continue;
    for (const int light : scene.infinite_lights()) {
      if (!contains(edits.takers_after(Side::Light, edits.event_class(Event::L, scene.light_entity(light))), e)) continue;
      far.is_for[static_cast<std::size_t>(light)] = 1;
      for (const V3d& corner : corners) bounds.add(corner);
    }
  }
  if (!bounds.empty()) far.target = Target{bounds.middle(), static_cast<float>(0.5001 * bounds.diagonal())};
  return far;
}

}  // namespace sluice
