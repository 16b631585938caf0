// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/effects.h"

#include <algorithm>

#include "edit/edits.h"
#include "shading/material.h"
#include "transport/arrival.h"

namespace sluice {
namespace {

// Lobes of all materials that a ray can meet.
EventMask lobes_in_scene(const Scene& scene) {
  EventMask mask = 0;
  for (std::size_t m = 0; m < scene.materials().size(); ++m)
    if (scene.material_used(m)) mask |= scene.materials()[m].lobe_events();
  return mask;
}

bool has_light_exits(const Edits& edits) {
  for (int e = 0; e < edits.size(); ++e)
    if (edits[e].side == Side::Light && contains(edits.could_take(Side::Light), e) &&
        (!edits[e].exits.empty() || edits[e].is_partial))
      return true;
  return false;
}

// Of enabled edits, by what paths of this scene can spell, and of layers.
void add_reasons_of_edits(const Scene& scene, bool lit, std::vector<Effects::Reason>& reasons) {
  const Edits& edits = scene.edits();
  for (int e = 0; e < edits.size(); ++e) {
    const bool is_possible = lit && contains(edits.could_take(edits[e].side), e);
    const char* why = !lit          ? "the scene has no light"
                      : is_possible ? "some path of this scene can match its expression"
                                    : "no path of this scene can match its expression";
    reasons.push_back({"edit " + edits[e].name, is_possible, why});
  }
  for (const LayerDescription& layer : edits.layers())
    reasons.push_back(
        {"layer " + layer.name, lit, lit ? "every path is asked for it" : "the scene has no light"});
}

}  // namespace

Effects find_effects(const Scene& scene, const TransportSettings& settings) {
  Effects effects;
  const EventMask lobes = lobes_in_scene(scene);
  const bool lit = !scene.lights().empty(), gathers = (lobes & gathering) != 0;
  const auto decide = [&](const char* name, bool& runs, bool wanted, bool possible, const char* why,
                          const char* why_not) {
    runs = wanted && possible;
    effects.reasons.push_back({name, runs, runs ? why : !wanted ? "switched off" : why_not});
  };
  const char* dark = !lit ? "the scene has no light" : "no surface scatters light towards the eye";
  const bool seen = lit && gathers;
  decide("direct", effects.direct, settings.use_direct, lit && lobes != 0, "surfaces are lit by lights",
         dark);
  decide("caustics", effects.caustics, settings.use_caustics,
         seen && (lobes & followed) && settings.max_depth > 1,
         "a specular surface can send light onto others", !seen ? dark : "nothing in the scene is specular");
  decide("edited light", effects.edited, settings.use_edited, seen && has_light_exits(scene.edits()),
         "an enabled light edit has an exit",
         !seen ? dark : "no enabled light edit that light can match has an exit");
  decide("indirect", effects.indirect, settings.use_indirect, seen && settings.max_depth > 1,
         "surfaces light each other", !seen ? dark : "max_depth leaves room for one bounce only");
  effects.lobes_find_lights =
      !std::ranges::all_of(scene.lights(), [](const Light& light) { return is_delta(light); });
  effects.light_edits = !is_empty(scene.edits().could_take(Side::Light));
  effects.view_edits = !is_empty(scene.edits().could_take(Side::View));
  effects.layers = !scene.edits().layers().empty();
  effects.tracks_states = effects.light_edits || effects.view_edits || effects.layers;

  if (effects.caustics) effects.arrivals_at_v |= caustic_arrivals;
  if (effects.edited) effects.arrivals_at_v |= edited_arrivals;
  effects.stored_arrivals = effects.indirect ? (1u << arrival_count) - 1 : effects.arrivals_at_v;
  effects.reasons.push_back(
      {"photons", effects.traces_photons(),
       effects.traces_photons() ? "an effect above reads them" : "no effect above reads them"});
  add_reasons_of_edits(scene, lit, effects.reasons);
  return effects;
}

}  // namespace sluice
