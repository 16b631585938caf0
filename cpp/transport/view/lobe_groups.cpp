// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/lobe_groups.h"

namespace sluice {
namespace {

// Is it one to all expressions whether light leaves by D or by G?
bool is_same_event(const Scene& scene, const Vertex& vertex) noexcept {
  return scene.event_class(Event::D, vertex.hit) == scene.event_class(Event::G, vertex.hit);
}

}  // namespace

Few<LobeGroup> lobe_groups(PathSelection& selection, const Scene& scene, ConstraintId behind,
                           const Vertex& vertex, ImageSet images) {
  Few<LobeGroup> groups;
  const auto at = [&](Event e) { return constraint_at(selection, scene, behind, vertex, e); };
  const bool is_constrained = selection.constraints().is_constrained(behind);
  const bool has_layers = selection.effects().layers;
  const EventMask kinds = vertex.bsdf.events() & gathering;
  if (!is_constrained && !has_layers) {
    groups.add({gathering, no_constraint, images});
  } else if (!is_constrained && (kinds != gathering || is_same_event(scene, vertex))) {
    groups.add({gathering, at(kinds == mask_of(Event::G) ? Event::G : Event::D), images});
  } else {
    if (!is_constrained && (images & picture)) groups.add({gathering, behind, picture});
    if (!is_constrained) images &= ~picture;
    for_each_event(kinds, [&](Event e) { groups.add({mask_of(e), at(e), images}); });
  }
  return groups;
}

LobeThroughputs lobe_throughputs(PathSelection& selection, const Scene& scene, const ViewPath& path,
                                 const Vertex& v, const BsdfSample& direction) {
  const Effects& effects = selection.effects();
  const auto at = [&](Event e) {
    return effects.tracks_states ? constraint_at(selection, scene, path.constraint, v, e) : path.constraint;
  };
  const auto weight_of = [&](EventMask lobes) {
    return eval(v.bsdf, v.point.wo, direction.wi, lobes) / direction.pdf;
  };
  LobeThroughputs all;
  if ((v.bsdf.events() & gathering) != gathering) {
    all.add({at(direction.event), direction.weight / square(direction.eta), all_images});
    return all;
  }
  const bool is_one = !effects.light_edits && path.hue < 0;  // for the picture
  if (is_one) {
    const bool is_all = !effects.layers || is_same_event(scene, v);
    all.add({at(Event::D), weight_of(gathering), is_all ? all_images : picture});
    if (is_all) return all;
  }
  for (const Event e : {Event::D, Event::G})
    all.add({at(e), weight_of(mask_of(e)), is_one ? ~picture : all_images, mask_of(e)});
  return all;
}

}  // namespace sluice
