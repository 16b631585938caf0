// SPDX-License-Identifier: GPL-3.0-or-later
// Light straight from lights: next-event estimation at v, with what lobe sampling finds of the same light,
// weighed by MIS (design §5), and at y, where it stands alone.
#include <algorithm>

#include "transport/view_path.h"

namespace sluice {
namespace {

// Power heuristic between two ways to make one direction (Veach 1997, §9.2.4): where a lamp is small to a
// wide lobe, next-event estimation is good alone, and the balance heuristic would add the noise of lobes that
// seldom find it.
float mis(float pdf, float other) noexcept { return pdf > 0 ? 1 / (1 + square(other / pdf)) : 0; }

// What a light would add if nothing blocked it, by an event at the vertex.
struct Arrived {
  Event event;
  Color radiance;
};

}  // namespace

// Next-event estimation at v, by as many samples as are worth their time there. The shadow segment runs
// straight through exits and is blocked by every entry that takes q of L. `segments`: how many gather
// segments v sends in the mean; each may find the light too.
void ViewTracer::direct_light(const ViewPath& path, const Vertex& v, float segments) {
  if (bundle_[at_].measures_lights) return measure_lights(path, v, segments);
  const std::uint32_t count = bundle_[at_].light_samples;
  for (std::uint32_t i = 0; i < count; ++i) light_sample(path, v, sampler_.part(i, count), segments);
}

// Two samples that know nothing of each other: how far they lie apart is the variance of their mean.
void ViewTracer::measure_lights(const ViewPath& path, const Vertex& v, float segments) {
  const auto so_far = [this] { return V3d(self().sample.parts[static_cast<std::size_t>(Part::Direct)]); };
  V3d share[2];
  for (std::uint32_t i = 0; i < 2; ++i) {
    const V3d before = so_far();
    light_sample(path, v, sampler_.apart(i), segments);
    share[i] = so_far() - before;
  }
  self().light_variance += (share[0] - share[1]) * (share[0] - share[1]);
}

// A point of a light that the vertex asks, lit from `side`; empty: of none, or of one that sends nothing
// there (outside a spot's cone).
std::optional<ViewTracer::AskedLight> ViewTracer::ask_light(const V3d& place, const V3f& side,
                                                            LightTrust trust, float u,
                                                            const V2f& uv) const noexcept {
  const auto choice = choose_light(scene_, place, side, u, trust);
  if (!choice) return {};
  const auto point = sample_direct(scene_, choice->light, place, choice->u, uv);
  if (!point || !(point->pdf > 0) || is_black(point->radiance)) return {};
  return AskedLight{choice->light, *point, choice->pmf * point->pdf};
}

void ViewTracer::light_sample(const ViewPath& path, const Vertex& v, const Sampler& numbers, float segments) {
  const V3d& place = v.hit.position;
  const auto asked = ask_light(place, lit_side(v.bsdf), guide_->trust.at_v(place),
                               numbers.first(pair_of(path, 2)), numbers.pair(pair_of(path, 3)));
  if (!asked) return;
  const auto& [light, point, pdf_of_one] = *asked;
  const float pdf_light = light_samples() * pdf_of_one;  // of all samples together
  // lobe sampling may find the light too
  const bool has_rival = !point.delta && scene_.lights()[static_cast<std::size_t>(light)].casts_shadow;
  const Bsdf& bsdf = v.bsdf;
  const V3f& wo = v.point.wo;

  // Lobes that end the path are sampled by gather segments, followed ones by the path's extension.
  std::array<Arrived, 3> arrived;
  std::size_t count = 0;
  for_each_event(bsdf.events(), [&](Event e) {
    const Color f = eval(bsdf, wo, point.wi, mask_of(e));
    if (is_black(f)) return;
    const float rival = !has_rival      ? 0
                        : e == Event::S ? pdf(bsdf, wo, point.wi, followed)
                                        : segments * pdf(bsdf, wo, point.wi, gathering);
    arrived[count++] = {e, f * point.radiance * (mis(pdf_light, rival) / pdf_light)};
  });
  if (count == 0) return;
  const std::span all = std::span(arrived).first(count);

  if (effects_.view_edits && is_taken_from_view(path, v, point))
    for (Arrived& at : all)
      if (at.event == Event::S) at.radiance = Color(0);
  const auto way = unblocked(v, light, point);
  if (!way) return;
  for (const Arrived& at : all) {
    const JoinResult to = join_behind(path.joins, way->q, v, at.event);
    if (to.images) add(Part::Direct, path, at.radiance * way->left, to);
  }
}

// Next-event estimation at the gather segment's end y, where it stands alone: what is hidden from it or too
// near, photon density has.
void ViewTracer::straight_light(const ViewPath& path, const Vertex& y, const Sampler& numbers,
                                const Arms& arms) {
  const bool is_kept = arms.begin()->is_kept;
  const V3d& place = y.hit.position;
  const V3f side = side_lit_to_all(scene_.material(y.hit), y.bsdf);
  const auto asked = ask_light(place, side, guide_->trust.at_y(place), numbers.first(pair_of(path, 6)),
                               numbers.pair(pair_of(path, 7)));
  if (!asked) return;
  const auto& [light, point, density] = *asked;
  if (is_too_near(scene_.lights()[static_cast<std::size_t>(light)], point.pdf)) return;
  if (is_kept && std::isfinite(far_end_.width)) {
    if (side == V3f(0) || side.dot(point.wi) > 0) keep_straight_light(*asked);
    return;
  }
  std::array<Arrived, 2> arrived;
  std::size_t count = 0;
  for_each_event(y.bsdf.events() & gathering, [&](Event e) {
    if (const Color f = eval(y.bsdf, y.point.wo, point.wi, mask_of(e)); !is_black(f))
      arrived[count++] = {e, f * point.radiance};
  });
  if (count == 0) return;
  const auto way = unblocked(y, light, point);
  if (!way) return;
  if (is_kept) note_state(way->q);
  for (const Arm& arm : arms)
    for (const Arrived& at : std::span(arrived).first(count)) {
      JoinResult to = join_behind(arm.joins, way->q, y, at.event);
      to.images &= arm.images;
      if (to.images) deliver(path, at.radiance * way->left / density, arm, to);
    }
}

// For all that may see y, by whatever lobes they see.
void ViewTracer::keep_straight_light(const AskedLight& asked) {
  FarEnd& far = far_end_;
  const auto& [light, point, density] = asked;
  const auto way = unblocked(far.y, light, point);
  if (!way) return;
  note_state(way->q);
  far.straight.wi = point.wi, far.straight.arriving = point.radiance * way->left / density;
  for (const Arm& arm : far.arms)
    for_each_event(events_to_all(scene_.material(far.y.hit), far.y.bsdf) & gathering, [&](Event e) {
      JoinResult to = join_behind(arm.joins, way->q, far.y, e);
      to.images &= arm.images;
      if (to.images) far.straight.shares[far.straight.count++] = {arm.index, e, to.q, to.images};
    });
}

// What light in state q becomes that leaves the vertex by an event.
JoinResult ViewTracer::join_behind(ConstraintId joins, StateId q, const Vertex& vertex, Event e) {
  return selection_.asks_state(joins) ? join(q, event_at(joins, vertex, e)) : JoinResult{picture};
}

// What is left of a light's on its way to the vertex, and its state; empty: surfaces or entries take it.
std::optional<ViewTracer::Unblocked> ViewTracer::unblocked(const Vertex& vertex, int light,
                                                           const DirectSample& sample) {
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
  if (!selection_.states().takes_none(way.q)) {
    ++counts.edit_queries;
    const Segment segment{vertex.hit.position, V3d(sample.wi), 0, sample.reach, -1};
    if (scene_.edits().any_taken(selection_.states(), way.q, segment))
      return count_taken(way.q, segment), std::nullopt;
  }
  return way;
}

// Of the entries on the segment that take q, light meets those of the last plane first, there by order.
void ViewTracer::count_taken(StateId q, const Segment& to_light) {
  scene_.edits().entries_crossed(Side::Light, to_light, selection_.states().taking_list(q).members,
                                 crossings_);
  const Crossing* taker = nullptr;
  for (const Crossing& crossing : crossings_)
    if (!taker || crossing.t != taker->t || crossing.group != taker->group) taker = &crossing;
  if (taker) counts.of_edit(taker->edit).kept = true;
}

// Does a view edit take the path that goes on towards a light by a followed lobe? Then the light is not to be
// seen there.
bool ViewTracer::is_taken_from_view(const ViewPath& path, const Vertex& vertex, const DirectSample& light) {
  const StateId state = selection_.states().next(path.state, scene_.event_class(Event::S, vertex.hit));
  if (selection_.states().takes_none(state)) return false;
  ++counts.edit_queries;
  return scene_.edits().any_taken(selection_.states(), state,
                                  {vertex.hit.position, V3d(light.wi), 0, light.reach, -1});
}

// What the world and suns send along a segment that meets nothing.
void ViewTracer::far_emission(const ViewPath& path, const LightSegment& segment, const Arms& arms) {
  for (const int light : scene_.infinite_lights())
    add_emission(path, segment, light, eval_infinite(scene_, light, segment.direction, segment.camera),
                 nullptr, arms);
}

void ViewTracer::surface_emission(const ViewPath& path, const LightSegment& segment, const Vertex& vertex,
                                  const Arms& arms) {
  add_emission(path, segment, scene_.mesh_light(vertex.hit.instance), vertex.bsdf.emission, &vertex.hit,
               arms);
}

// Emission that a path meets: the Emission part, or direct light where next-event estimation could have found
// it too (then MIS).
void ViewTracer::add_emission(const ViewPath& path, const LightSegment& segment, int light, Color radiance,
                              const Hit* hit, const Arms& arms) {
  if (is_black(radiance)) return;
  const bool is_direct = segment.pdf > 0;
  // other samples of the pixel have it
  if (bundle_[at_].seeks == (is_direct ? Seeks::Emission : Seeks::AllButEmission)) return;
  if (is_direct) {
    if (!effects_.direct) return;
    if (light >= 0) {
      // found by next-event estimation alone
      if (!scene_.lights()[static_cast<std::size_t>(light)].casts_shadow) return;
      const float pmf =
          choice_pmf(scene_, segment.origin, segment.normal, light, guide_->trust.at_v(segment.origin));
      radiance *= mis(segment.pdf, segment.light_samples * pmf *
                                       pdf_direct(scene_, light, segment.origin, segment.direction, hit));
    }
  }
  for (const Arm& arm : arms) {
    JoinResult to{picture};
    if (selection_.asks_state(arm.joins)) {
      to =
          join(selection_.states().next(StateTable::light_start,
                                        light >= 0 ? light_class(light) : scene_.event_class(Event::L, *hit)),
               arm.joins);
    }
    to.images &= arm.images;
    if (to.images) add(is_direct ? Part::Direct : Part::Emission, path, radiance * arm.weight, to);
  }
}

}  // namespace sluice
