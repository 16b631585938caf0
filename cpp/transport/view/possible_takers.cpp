// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/possible_takers.h"

namespace sluice {

EditSet PossibleTakers::find(const Scene& scene, const SegmentSources& from, EventMask lobes) {
  const Edits& edits = scene.edits();
  const Vertex* far = from.far;
  if (far && far->pass_chance > 0) return edits.could_take(Side::Light);  // what lies behind it is not known
  EditSet all;
  const auto add = [&](EventClass last) {
    const EditSet set = edits.could_take_after(Side::Light, last);
    if (set.empty() || all.empty() || set.data() == all.data()) return void(all = set.empty() ? all : set);
    if (all.data() != members_.data()) members_.assign(all.begin(), all.end()), all = members_;
    for (std::size_t i = 0; i < set.size(); ++i) members_[i] |= set[i];
  };
  if (far) {
    for_each_event(far->bsdf.events() & lobes, [&](Event e) { add(scene.event_class(e, far->hit)); });
    const int light = scene.mesh_light(far->hit.instance);
    if (!is_black(far->bsdf.emission))
      add(light >= 0 ? light_class(scene, light) : scene.event_class(Event::L, far->hit));
  } else {
    for (const int light : scene.infinite_lights()) add(light_class(scene, light));
  }
  for (const LampHit& lamp : from.lamps) add(light_class(scene, lamp.light));
  return all;
}

}  // namespace sluice
