// SPDX-License-Identifier: GPL-3.0-or-later
// Direct light and emission that is met: next-event estimation (at v, and at y where it stands alone), and what lobe sampling finds of
// the same light, weighed by MIS (design §5).
#include <algorithm>

#include "transport/view_path.h"

namespace sluice {
namespace {

// Balance heuristic between two ways to make one direction.
float mis(float pdf, float other) noexcept { return pdf > 0 ? pdf / (pdf + other) : 0; }

}  // namespace

// Next-event estimation at v, or at the gather segment's end y, where it stands alone. The shadow segment runs straight through exits
// and is blocked by every entry that takes q of L. `chance`: that v sends a gather segment, which may find the light too.
void ViewTracer::direct_light(const ViewPath& path, const Vertex& vertex, const Arms& arms, Part part, float chance) {
  const Sampler& numbers = arms.begin()->far ? bundle_[at_].turn : sampler_;  // at a shared y: points of the bundle's sequence
  if (part != Part::Direct) return light_sample(path, vertex, arms, part, {numbers, 0});
  if (bundle_[at_].measures_lights) return measure_lights(path, vertex, arms, chance);
  const std::uint32_t count = bundle_[at_].light_samples;
  for (std::uint32_t i = 0; i < count; ++i) light_sample(path, vertex, arms, part, {numbers.part(i, count), chance});
}

// Two samples that know nothing of each other: how far they lie apart is the variance of their mean.
void ViewTracer::measure_lights(const ViewPath& path, const Vertex& vertex, const Arms& arms, float chance) {
  const auto so_far = [this] { return V3d(self().sample.parts[static_cast<std::size_t>(Part::Direct)]); };
  V3d share[2];
  for (std::uint32_t i = 0; i < 2; ++i) {
    const V3d before = so_far();
    light_sample(path, vertex, arms, Part::Direct, {sampler_.apart(i), chance});
    share[i] = so_far() - before;
  }
  self().light_variance += (share[0] - share[1]) * (share[0] - share[1]);
}

void ViewTracer::light_sample(const ViewPath& path, const Vertex& vertex, const Arms& arms, Part part, const LightTry& one) {
  const bool at_v = part == Part::Direct;
  const std::uint32_t first_pair = at_v ? 2 : 6;
  const Bsdf& bsdf = vertex.bsdf;
  const V3f& wo = vertex.point.wo;
  const V3d& place = vertex.hit.position;
  const LightTrust trust = at_v ? guide_->trust.at_v(place) : guide_->trust.at_y(place);
  const auto choice = choose_light(scene_, place, lit_side(bsdf), one.numbers.first(pair_of(path, first_pair)), trust);
  if (!choice) return;
  const auto sample = sample_direct(scene_, choice->light, place, choice->u, one.numbers.pair(pair_of(path, first_pair + 1)));
  if (!sample || !(sample->pdf > 0) || is_black(sample->radiance)) return;  // black: outside a spot's cone
  const float pdf_light = (at_v ? light_samples() : 1) * choice->pmf * sample->pdf;  // of all samples together
  const Light& light = scene_.lights()[static_cast<std::size_t>(choice->light)];
  if (!at_v && is_too_near(light, sample->pdf)) return;  // without a rival: photon density has it
  const bool has_rival = at_v && !sample->delta && light.casts_shadow;  // lobe sampling may find the light too

  // Lobes that end the path are sampled by the gather segment, followed ones by the path's extension.
  struct Arrived {
    Event event;
    Color radiance;
  };
  std::array<Arrived, 3> arrived;
  int count = 0;
  for_each_event(at_v ? bsdf.events() : static_cast<EventMask>(bsdf.events() & gathering), [&](Event e) {
    const Color f = eval(bsdf, wo, sample->wi, mask_of(e));
    if (is_black(f)) return;
    const float rival = !has_rival ? 0 : e == Event::S ? pdf(bsdf, wo, sample->wi, followed) : one.chance * pdf(bsdf, wo, sample->wi, gathering);
    const float weight = mis(pdf_light, rival);
    arrived[static_cast<std::size_t>(count++)] = {e, f * sample->radiance * (weight / pdf_light)};
  });
  if (count == 0) return;

  if (at_v && effects_.view_edits && is_taken_from_view(path, vertex, *sample))
    for (Arrived& at : std::span(arrived).first(static_cast<std::size_t>(count)))
      if (at.event == Event::S) at.radiance = Color(0);
  const auto way = unblocked(vertex, choice->light, *sample);
  if (!way) return;
  if (FarEnd* far = arms.begin()->far) note_state(way->q, *far);
  for (const Arm& arm : arms) {
    for (int i = 0; i < count; ++i) {
      const Arrived& at = arrived[static_cast<std::size_t>(i)];
      Joined to = asks_state(arm.joins) ? join(way->q, event_at(arm.joins, vertex, at.event)) : Joined{picture};
      to.images &= arm.images;
      if (to.images) deliver(part, path, at.radiance * way->left, arm, to);
    }
  }
}

// What is left of a light's on its way to the vertex, and its state; empty: surfaces or entries take it.
std::optional<ViewTracer::Unblocked> ViewTracer::unblocked(const Vertex& vertex, int light, const DirectSample& sample) {
  Unblocked way{Color(1), StateTable::light_start};
  if (scene_.lights()[static_cast<std::size_t>(light)].casts_shadow) {
    ++counts.shadow_rays;
    const auto left = scene_.transmittance(ray_from(vertex.hit, sample.wi, sample.distance));
    if (!left) ++counts.alpha_capped;
    if (!left || is_black(*left)) return {};
    way.left = *left;
  }
  if (!effects_.words) return way;
  way.q = light_state(light);
  if (way.q == StateTable::dead && effects_.light_edits) {
    ++counts.states_capped;
    return {};
  }
  if (!states_.takes_none(way.q)) {
    ++counts.edit_queries;
    const Segment segment{vertex.hit.position, V3d(sample.wi), 0, sample.reach, -1};
    if (scene_.edits().any_taken(states_, way.q, segment)) return count_taken(way.q, segment), std::nullopt;
  }
  return way;
}

// Of the entries on the segment that take q, light meets those of the last plane first, there by order.
void ViewTracer::count_taken(StateId q, const Segment& to_light) {
  scene_.edits().entries_crossed(Side::Light, to_light, states_.taking_list(q).members, crossings_);
  const Crossing* taker = nullptr;
  for (const Crossing& crossing : crossings_)
    if (!taker || crossing.t != taker->t || crossing.group != taker->group) taker = &crossing;
  if (taker) counts.of_edit(taker->edit).kept = true;
}

// Does a view edit take the path that goes on towards a light by a followed lobe? Then the light is not to be seen there.
bool ViewTracer::is_taken_from_view(const ViewPath& path, const Vertex& vertex, const DirectSample& light) {
  const StateId state = states_.next(path.state, scene_.event_class(Event::S, vertex.hit));
  if (states_.takes_none(state)) return false;
  ++counts.edit_queries;
  return scene_.edits().any_taken(states_, state, {vertex.hit.position, V3d(light.wi), 0, light.reach, -1});
}

// What the world and suns send along a segment that meets nothing.
void ViewTracer::far_emission(const ViewPath& path, const LightSegment& segment, const Arms& arms) {
  for (const int light : scene_.infinite_lights())
    add_emission(path, segment, light, eval_infinite(scene_, light, segment.direction, segment.camera), nullptr, arms);
}

void ViewTracer::surface_emission(const ViewPath& path, const LightSegment& segment, const Vertex& vertex, const Arms& arms) {
  add_emission(path, segment, scene_.mesh_light(vertex.hit.instance), vertex.bsdf.emission, &vertex.hit, arms);
}

// Emission that a path meets: the Emission part, or direct light where next-event estimation could have found it too (then MIS).
void ViewTracer::add_emission(const ViewPath& path, const LightSegment& segment, int light, Color radiance, const Hit* hit, const Arms& arms) {
  if (is_black(radiance)) return;
  const bool is_direct = segment.pdf > 0;
  if (is_direct) {
    if (!effects_.direct) return;
    if (light >= 0) {
      if (!scene_.lights()[static_cast<std::size_t>(light)].casts_shadow) return;  // found by next-event estimation alone
      const float pmf = choice_pmf(scene_, segment.origin, segment.normal, light, guide_->trust.at_v(segment.origin));
      radiance *= mis(segment.pdf, segment.light_samples * pmf * pdf_direct(scene_, light, segment.origin, segment.direction, hit));
    }
  }
  for (const Arm& arm : arms) {
    Joined to{picture};
    if (asks_state(arm.joins)) {
      to = join(states_.next(StateTable::light_start, light >= 0 ? light_class(light) : scene_.event_class(Event::L, *hit)), arm.joins);
    }
    to.images &= arm.images;
    if (to.images) add(is_direct ? Part::Direct : Part::Emission, path, radiance * arm.weight, to);
  }
}

}  // namespace sluice
