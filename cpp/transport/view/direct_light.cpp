// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/direct_light.h"

namespace sluice {
namespace {

// Power heuristic between two ways to make one direction (Veach 1997, §9.2.4): where a lamp is small to a
// wide lobe, next-event estimation is good alone, and the balance heuristic would add the noise of lobes that
// seldom find it.
float mis(float pdf, float other) noexcept { return pdf > 0 ? 1 / (1 + square(other / pdf)) : 0; }

}  // namespace

void DirectLight::next_event_at_v(const Sample& sample, const ViewPath& path, const Vertex& v,
                                  float segments) {
  if (sample.asked.measures_lights) return measure(sample, path, v, segments);
  const std::uint32_t count = sample.asked.light_samples;
  for (std::uint32_t i = 0; i < count; ++i)
    add_light_sample(sample, path, v, sample.asked.sampler.part(i, count), segments);
}

// Two samples that know nothing of each other: how far they lie apart is the variance of their mean.
void DirectLight::measure(const Sample& sample, const ViewPath& path, const Vertex& v, float segments) {
  const auto so_far = [&] {
    return V3d(sums_.sample(sample.index).parts[static_cast<std::size_t>(Part::Direct)]);
  };
  V3d share[2];
  for (std::uint32_t i = 0; i < 2; ++i) {
    const V3d before = so_far();
    add_light_sample(sample, path, v, sample.asked.sampler.apart(i), segments);
    share[i] = so_far() - before;
  }
  sums_.light_variance(sample.index) += (share[0] - share[1]) * (share[0] - share[1]);
}

// A point of a light, chosen for a place that is lit from `side`; empty: none was, or one that sends nothing
// there (outside a spot's cone).
std::optional<DirectLight::LightSample> DirectLight::sample_light(const V3d& place, const V3f& side,
                                                                  LightTrust trust, float u,
                                                                  const V2f& uv) const noexcept {
  const auto choice = choose_light(scene_, place, side, u, trust);
  if (!choice) return {};
  const auto point = sample_direct(scene_, choice->light, place, choice->u, uv);
  if (!point || !(point->pdf > 0) || is_black(point->radiance)) return {};
  return LightSample{choice->light, *point, choice->pmf * point->pdf};
}

// Empty also where the light is so near that photon density has it.
std::optional<DirectLight::LightSample> DirectLight::sample_light_of_y(
    const Vertex& y, int depth, const Sampler& numbers) const noexcept {
  const V3d& place = y.hit.position;
  auto found =
      sample_light(place, side_lit_to_all(scene_.material(y.hit), y.bsdf), context_.guide->trust.at_y(place),
                   numbers.first(pair_of(Dimension::LightOfY, depth)),
                   numbers.pair(pair_of(Dimension::LightPointOfY, depth)));
  if (found && is_too_near(scene_.lights()[static_cast<std::size_t>(found->light)], found->point.pdf))
    found.reset();
  return found;
}

void DirectLight::add_light_sample(const Sample& sample, const ViewPath& path, const Vertex& v,
                                   const Sampler& numbers, float segments) {
  const V3d& place = v.hit.position;
  const auto found = sample_light(place, lit_side(v.bsdf), context_.guide->trust.at_v(place),
                                  numbers.first(pair_of(Dimension::LightOfV, path.depth)),
                                  numbers.pair(pair_of(Dimension::LightPointOfV, path.depth)));
  if (!found) return;
  const auto& [light, point, pdf_of_one] = *found;
  const float pdf_light = sample.light_samples() * pdf_of_one;  // of all samples together
  // lobe sampling may find the light too
  const bool has_rival = !point.delta && scene_.lights()[static_cast<std::size_t>(light)].casts_shadow;
  const Bsdf& bsdf = v.bsdf;
  const V3f& wo = v.point.wo;

  // Lobes that end the path are sampled by gather segments, followed ones by the path's extension.
  std::array<Scattered, 3> scattered;
  std::size_t count = 0;
  for_each_event(bsdf.events(), [&](Event e) {
    const Color f = eval(bsdf, wo, point.wi, mask_of(e));
    if (is_black(f)) return;
    const float rival = !has_rival      ? 0
                        : e == Event::S ? pdf(bsdf, wo, point.wi, followed)
                                        : segments * pdf(bsdf, wo, point.wi, gathering);
    scattered[count++] = {e, f * point.radiance * (mis(pdf_light, rival) / pdf_light)};
  });
  if (count == 0) return;
  const std::span all = std::span(scattered).first(count);

  if (effects_.view_edits && is_taken_from_view(path, v, point))
    for (Scattered& at : all)
      if (at.event == Event::S) at.radiance = Color(0);
  const auto way = unblocked(v, light, point);
  if (!way) return;
  for (const Scattered& at : all) {
    const JoinResult joined = join_behind(path.constraint, way->q, v, at.event);
    if (joined.images) sums_.add(Part::Direct, sample, path, at.radiance * way->left, joined);
  }
}

// For all that may see y, by whatever lobes they see.
void DirectLight::keep_unscattered(const LightSample& found, const ToGatherPoint& sink) {
  GatherPoint& point = sink.point;
  const Vertex& y = point.segment.y;
  const Material& material = scene_.material(y.hit);
  const V3f side = side_lit_to_all(material, y.bsdf);
  if (side != V3f(0) && !(side.dot(found.point.wi) > 0)) return;
  const auto way = unblocked(y, found.light, found.point);
  if (!way) return;
  sink.note_state(way->q);
  UnscatteredLight& kept = point.unscattered;
  kept.wi = found.point.wi, kept.arriving = found.point.radiance * way->left / found.pdf;
  for (const LobeThroughput& lobe : point.segment.lobes)
    for_each_event(events_to_all(material, y.bsdf) & gathering, [&](Event e) {
      JoinResult joined = join_behind(lobe.constraint, way->q, y, e);
      joined.images &= lobe.images;
      if (joined.images) kept.shares[kept.count++] = {point.index_of(lobe), e, joined};
    });
}

// What light in state q becomes that leaves the vertex by an event.
JoinResult DirectLight::join_behind(ConstraintId constraint, StateId q, const Vertex& vertex, Event event) {
  if (!selection_.asks_state(constraint)) return {picture};
  return sums_.counted(selection_.join(q, constraint_at(selection_, scene_, constraint, vertex, event)));
}

// What is left of a light's radiance on its way to the vertex, and its state; empty: surfaces or entries take
// it.
std::optional<DirectLight::Unblocked> DirectLight::unblocked(const Vertex& vertex, int light,
                                                             const DirectSample& sample) {
  Unblocked way{Color(1), StateTable::light_start};
  if (scene_.lights()[static_cast<std::size_t>(light)].casts_shadow) {
    ++sums_.counts.shadow_rays;
    const auto left = scene_.transmittance(ray_from(vertex.hit, sample.wi, sample.distance));
    if (!left) ++sums_.counts.alpha_capped;
    if (!left || is_black(*left)) return {};
    way.left = *left;
  }
  if (!effects_.tracks_states) return way;
  StateTable& states = selection_.states();
  way.q = states.next(StateTable::light_start, light_class(scene_, light));
  if (way.q == StateTable::dead && effects_.light_edits) {
    ++sums_.counts.states_capped;
    return {};
  }
  if (!states.takes_none(way.q)) {
    ++sums_.counts.edit_queries;
    const Segment segment{vertex.hit.position, V3d(sample.wi), 0, sample.reach, -1};
    if (scene_.edits().any_taken(states, way.q, segment)) return count_taken(way.q, segment), std::nullopt;
  }
  return way;
}

// Of the entries on the segment that take q, light meets those of the last plane first, there by order.
void DirectLight::count_taken(StateId q, const Segment& to_light) {
  scene_.edits().entries_crossed(Side::Light, to_light, selection_.states().taking_list(q).members,
                                 crossings_);
  const Crossing* taker = nullptr;
  for (const Crossing& crossing : crossings_)
    if (!taker || crossing.t != taker->t || crossing.group != taker->group) taker = &crossing;
  if (taker) sums_.counts.of_edit(taker->edit).kept = true;
}

// Does a view edit take the path that goes on towards a light by a followed lobe? Then the light is not to be
// seen there.
bool DirectLight::is_taken_from_view(const ViewPath& path, const Vertex& vertex, const DirectSample& light) {
  StateTable& states = selection_.states();
  const StateId state = states.next(path.state, scene_.event_class(Event::S, vertex.hit));
  if (states.takes_none(state)) return false;
  ++sums_.counts.edit_queries;
  return scene_.edits().any_taken(states, state, {vertex.hit.position, V3d(light.wi), 0, light.reach, -1});
}

void DirectLight::add_infinite_emission(const Sample& sample, const ViewPath& path,
                                        const LightSegment& segment, const LobeThroughputs& lobes) {
  for (const int light : scene_.infinite_lights())
    add_emission(sample, path, segment,
                 {light, eval_infinite(scene_, light, segment.direction, segment.camera)}, lobes);
}

void DirectLight::add_emission(const Sample& sample, const ViewPath& path, const LightSegment& segment,
                               MetEmission emission, const LobeThroughputs& lobes) {
  auto& [light, radiance, hit] = emission;
  if (is_black(radiance)) return;
  const bool is_direct = segment.pdf > 0;
  // other samples of the pixel have it
  if (sample.asked.seeks == (is_direct ? Seeks::Emission : Seeks::AllButEmission)) return;
  if (is_direct) {
    if (!effects_.direct) return;
    if (light >= 0) {
      // found by next-event estimation alone
      if (!scene_.lights()[static_cast<std::size_t>(light)].casts_shadow) return;
      const float pmf = choice_pmf(scene_, segment.origin, segment.normal, light,
                                   context_.guide->trust.at_v(segment.origin));
      radiance *= mis(segment.pdf, sample.light_samples() * pmf *
                                       pdf_direct(scene_, light, segment.origin, segment.direction, hit));
    }
  }
  for (const LobeThroughput& lobe : lobes) {
    JoinResult joined{picture};
    if (selection_.asks_state(lobe.constraint)) {
      const EventClass event = light >= 0 ? light_class(scene_, light) : scene_.event_class(Event::L, *hit);
      joined = sums_.counted(
          selection_.join(selection_.states().next(StateTable::light_start, event), lobe.constraint));
    }
    joined.images &= lobe.images;
    if (joined.images)
      sums_.add(is_direct ? Part::Direct : Part::Emission, sample, path, radiance * lobe.weight, joined);
  }
}

}  // namespace sluice
