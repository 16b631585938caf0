// SPDX-License-Identifier: GPL-3.0-or-later
// The estimators of design §5 at v, the view path's vertex with gathering lobes: direct light (next-event estimation, MIS with lobe
// sampling), caustics and edited light (photon density at v), indirect light (one gather segment to y; next-event estimation and photon
// density there), and the emission that paths and gather segments meet.
#include <algorithm>

#include "transport/view_path.h"

namespace sluice {
namespace {

// Balance heuristic between two ways to make one direction.
float mis(float pdf, float other) noexcept { return pdf > 0 ? pdf / (pdf + other) : 0; }

template <class Do>
void for_each_event(EventMask events, Do&& act) {
  for (const Event e : {Event::D, Event::G, Event::S})
    if (events & mask_of(e)) act(e);
}

}  // namespace

// Next-event estimation at v, or at the gather segment's end y, where it stands alone. The shadow segment runs straight through exits
// and is blocked by every entry that takes q of L.
void ViewTracer::direct_light(const ViewPath& path, const Vertex& vertex, const Arms& arms, Part part) {
  const bool at_v = part == Part::Direct;
  const std::uint32_t first_pair = at_v ? 2 : 6;
  const Bsdf& bsdf = vertex.bsdf;
  const V3f& wo = vertex.point.wo;
  const auto choice = choose_light(scene_, vertex.hit.position, lit_side(bsdf), first(path, first_pair), at_v ? guide_->trust.at_v : guide_->trust.at_y);
  if (!choice) return;
  const auto sample = sample_direct(scene_, choice->light, vertex.hit.position, choice->u, pair(path, first_pair + 1));
  if (!sample || !(sample->pdf > 0)) return;
  const float pdf_light = choice->pmf * sample->pdf;
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
    const EventMask group = e == Event::S ? followed : gathering;
    const float weight = has_rival ? mis(pdf_light, pdf(bsdf, wo, sample->wi, group)) : 1;
    arrived[static_cast<std::size_t>(count++)] = {e, f * sample->radiance * (weight / pdf_light)};
  });
  if (count == 0) return;

  Color visible(1);
  if (light.casts_shadow) {
    ++counts.shadow_rays;
    const auto left = scene_.transmittance(ray_from(vertex.hit, sample->wi, sample->distance));
    if (!left) ++counts.alpha_capped;
    if (!left || is_black(*left)) return;
    visible = *left;
  }
  StateId q = StateTable::light_start;
  if (asks_words()) {
    q = light_state(choice->light);
    if (q == StateTable::dead && effects_.light_edits) return void(++counts.states_capped);
    if (!states_.taking(q).empty()) {
      ++counts.edit_queries;
      if (scene_.edits().any_taken(states_, q, {vertex.hit.position, V3d(sample->wi), 0, sample->reach, -1})) return;
    }
  }
  for (const Arm& arm : arms) {
    for (int i = 0; i < count; ++i) {
      const Arrived& at = arrived[static_cast<std::size_t>(i)];
      Joined to = asks_state(arm.joins) ? join(q, event_at(arm.joins, vertex, at.event)) : Joined{picture};
      to.images &= arm.images;
      if (to.images) add(part, path, at.radiance * visible * arm.weight, to);
    }
  }
}

ViewTracer::Joined ViewTracer::try_join(StateId q, int joins) noexcept {
  const auto [at_eye, fate] = joins_.arrive(states_, q, joins);
  if (fate == Joins::Fate::StatesCapped && !joins_.is_constrained(joins)) return {picture, at_eye, fate};  // lost to the layers alone
  if (fate != Joins::Fate::Arrives) return {0, at_eye, fate};
  if (!effects_.layers) return {picture, at_eye};
  const StateId whole = states_.next(at_eye, scene_.edits().event_class(Event::E, -1));
  return {states_.images(whole), at_eye, whole == StateTable::dead ? Joins::Fate::StatesCapped : fate};
}

ViewTracer::Joined ViewTracer::counted(const Joined& joined) noexcept {
  if (joined.fate == Joins::Fate::GatesCapped) ++counts.gates_capped;
  if (joined.fate == Joins::Fate::StatesCapped) ++counts.states_capped;
  return joined;
}

// For a state of the pass's photons. Remembered while C stays the same.
ViewTracer::Joined ViewTracer::join_photon(std::uint32_t q, int joins) noexcept {
  if (!asks_state(joins)) return {picture, state_of_[q]};
  if (joins != memo_joins_) memo_joins_ = joins, ++memo_now_;
  if (memo_mark_[q] != memo_now_) {
    memo_mark_[q] = memo_now_;
    memo_[q] = try_join(state_of_[q], joins);
  }
  return counted(memo_[q]);
}

// Gathering lobes by what C and the layers can tell apart. The picture's are taken at once where C allows all of them, so that layers
// change no bit of it.
template <class Estimate>
void ViewTracer::for_each_lobe(int joins, const Vertex& vertex, ImageSet images, Estimate&& estimate) {
  const bool is_apart = joins_.is_constrained(joins);
  if (!is_apart && !effects_.layers) return estimate(gathering, Joins::all, images);
  const EventMask kinds = vertex.bsdf.events() & gathering;
  if (!is_apart && (kinds != gathering || same_event(vertex)))
    return estimate(gathering, event_at(joins, vertex, kinds == mask_of(Event::G) ? Event::G : Event::D), images);
  if (!is_apart) {
    if (images & picture) estimate(gathering, joins, picture);
    images &= ~picture;
  }
  for_each_event(kinds, [&](Event e) { estimate(mask_of(e), event_at(joins, vertex, e), images); });
}

// Caustics and edited light: photons that arrived at v by a followed lobe or through an exit.
void ViewTracer::close_density(const ViewPath& path, const Vertex& v) {
  if (effects_.close_arrivals == 0 || !(v.bsdf.events() & gathering)) return;
  const float radius = close_radius(path, v.hit.position);
  const int room = settings_.max_depth - path.depth - 1;
  for_each_lobe(path.joins, v, all_images, [&](EventMask mask, int joins, ImageSet asked) {
    ++counts.gathers;
    const bool asks = asks_photons(joins), sums = path.hue < 0 && (asked & picture);  // the picture's share is summed up first
    std::array<Color, arrival_count> sum;
    sum.fill(Color(0));
    estimate_density(photons_->close, Receiver(v, mask), radius, [&](const Photon& photon, const Color& radiance) {
      if (photon.depth > room) return void(++counts.depth_capped);
      Joined to = asks ? join_photon(photon.q(), joins) : Joined{picture};
      to.images &= asked;
      if (!to.images) return;
      ++counts.photons_gathered;
      if (sums) sum[static_cast<std::size_t>(photon.arrival)] += radiance, to.images &= ~picture, credit(to.q, radiance * path.weight);
      if (to.images) add(photon.arrival == Arrival::Caustic ? Part::Caustics : Part::Edited, path, radiance, to);
    });
    if (!sums) return;
    add(Part::Caustics, path, sum[static_cast<std::size_t>(Arrival::Caustic)], {picture});
    add(Part::Edited, path, sum[static_cast<std::size_t>(Arrival::Edited)], {picture});
  });
}

// The ways light of the gather segment goes on at v: one, or one per kind of lobe where C or a layer could tell them apart.
ViewTracer::Arms ViewTracer::arms_of(const ViewPath& path, const Vertex& v, const BsdfSample& sample) {
  const EventMask kinds = v.bsdf.events() & gathering;
  Arms arms;
  const auto joins_for = [&](Event e) { return asks_words() ? event_at(path.joins, v, e) : path.joins; };
  if (kinds != gathering) {
    arms.add({joins_for(sample.event), sample.weight / square(sample.eta), all_images});
    return arms;
  }
  const bool is_one = !effects_.light_edits && path.hue < 0;  // for the picture: layers change no bit of it
  if (is_one) {
    const bool is_all = !effects_.layers || same_event(v);
    arms.add({joins_for(Event::D), eval(v.bsdf, v.point.wo, sample.wi, gathering) / sample.pdf, is_all ? all_images : picture});
    if (is_all) return arms;
  }
  for (const Event e : {Event::D, Event::G})
    arms.add({joins_for(e), eval(v.bsdf, v.point.wo, sample.wi, mask_of(e)) / sample.pdf, is_one ? ~picture : all_images});
  return arms;
}

// One segment from v's D and G lobes, straight on only: light through an exit is the density's at v. Emitters that it meets are direct
// light found by lobe sampling.
void ViewTracer::gather(const ViewPath& path, const Vertex& v) {
  if (!(effects_.direct || effects_.indirect) || !(v.bsdf.events() & gathering)) return;
  const auto sample = sluice::sample(v.bsdf, v.point.wo, v.bsdf.count > 1 ? first(path, 4) : 0, pair(path, 5), gathering);
  if (!sample || !(sample->pdf > 0)) return;
  Arms arms = arms_of(path, v, *sample);
  const LightSegment segment{v.hit.position, sample->wi, lit_side(v.bsdf), sample->pdf};
  Ray ray = ray_from(v.hit, sample->wi);
  double length = 0;
  bool arrived = false;
  for (int layer = 0; layer < max_alpha_layers && !arrived; ++layer) {
    const auto hit = scene_.intersect(ray);
    ++counts.rays;
    if (!hit) {
      narrow(path, segment, length, ray.t_max, nullptr, arms);
      return far_emission(path, segment, arms);
    }
    make_vertex(scene_, *hit, -sample->wi, false, Carries::Radiance, far_);
    narrow(path, segment, length, length + hit->t, &far_, arms);
    length += hit->t;
    const float chance = pass_chance(far_.bsdf);
    arrived = chance < 1 && (chance == 0 || random() >= chance);
    for (Arm& arm : arms) arm.weight *= arrived ? Color(1 / (1 - chance)) : far_.bsdf.transparency / chance;
    ray = ray_from(*hit, sample->wi);
  }
  if (!arrived) return void(++counts.alpha_capped);
  surface_emission(path, segment, far_, arms);
  if (!effects_.indirect) return;
  if (path.depth + 2 > settings_.max_depth) return void(counts.depth_capped += far_.bsdf.count > 0);
  direct_light(path, far_, arms, Part::Indirect);
  gather_at(path, far_, arms, length, gather_radius(*guide_, length, sample->pdf) * radius_scale_);
}

// Light edits that could take what a piece of the gather segment carries: by the last event there, at its far end (null: nothing met)
// or at a lamp.
EditSet ViewTracer::takers_from(const Vertex* far, std::span<const LampHit> lamps) {
  const Edits& edits = scene_.edits();
  if (far && pass_chance(far->bsdf) > 0) return edits.takers(Side::Light);
  takers_.assign(edits.takers(Side::Light).size(), 0);
  const auto add = [&](Event last, int entity) {
    const EditSet set = edits.takers_after(Side::Light, edits.event_class(last, entity));
    for (std::size_t i = 0; i < set.size(); ++i) takers_[i] |= set[i];
  };
  if (far) {
    for_each_event(far->bsdf.events() & gathering, [&](Event e) { add(e, scene_.entity(far->hit)); });
    const int light = scene_.mesh_light(far->hit.instance);
    if (!is_black(far->bsdf.emission)) add(Event::L, light >= 0 ? scene_.light_entity(light) : scene_.entity(far->hit));
  } else {
    for (const int light : scene_.infinite_lights()) add(Event::L, scene_.light_entity(light));
  }
  for (const LampHit& lamp : lamps) add(Event::L, scene_.light_entity(lamp.light));
  return takers_;
}

// One piece of the gather segment, from length t_start to t_end: C narrows at every entry that it passes.
void ViewTracer::narrow(const ViewPath& path, const LightSegment& segment, double t_start, double t_end, const Vertex* far, Arms& arms) {
  const std::span lamps(lamps_);
  int lamp_count = 0, next_lamp = 0;
  if (effects_.direct) {
    lamp_count = intersect_lamps(scene_, {segment.origin, segment.direction, t_end}, lamps);
    lamp_count = static_cast<int>(std::remove_if(lamps.begin(), lamps.begin() + lamp_count, [&](const LampHit& l) { return l.t <= t_start; }) - lamps.begin());
    std::sort(lamps.begin(), lamps.begin() + lamp_count, [](const LampHit& a, const LampHit& b) { return a.t < b.t; });
  }
  const auto collect_lamps = [&](double until) {
    for (; next_lamp < lamp_count && lamps[static_cast<std::size_t>(next_lamp)].t < until; ++next_lamp) {
      const LampHit& lamp = lamps[static_cast<std::size_t>(next_lamp)];
      add_emission(path, segment, lamp.light, lamp.radiance, nullptr, arms);
    }
  };
  const EditSet takers = effects_.light_edits ? takers_from(far, lamps.first(static_cast<std::size_t>(lamp_count))) : EditSet();
  if (!is_empty(takers)) {
    ++counts.edit_queries;
    scene_.edits().entries_crossed(Side::Light, {segment.origin, V3d(segment.direction), t_start, t_end, -1}, takers, crossings_);
    for (const Crossing& crossing : crossings_) {
      collect_lamps(crossing.t);
      for (Arm& arm : arms) arm.joins = joins_.passed(arm.joins, crossing.edit);
    }
  }
  collect_lamps(std::numeric_limits<double>::infinity());
}

// Photon density at y, `length` from v: all photons with q in C. Those that came straight from a light are kept only where it is
// hidden from next-event estimation or too near for it.
void ViewTracer::gather_at(const ViewPath& path, const Vertex& y, const Arms& arms, double length, float radius) {
  const int room = settings_.max_depth - path.depth - 2;
  for (const Arm& arm : arms) {
    if (is_black(arm.weight)) continue;
    for_each_lobe(arm.joins, y, arm.images, [&](EventMask mask, int joins, ImageSet asked) {
      ++counts.gathers;
      const bool asks = asks_photons(joins), sums = path.hue < 0 && (asked & picture);
      Color sum(0);
      estimate_density(photons_->all, Receiver(y, mask, length), radius, [&](const Photon& photon, const Color& radiance) {
        if (photon.depth > room) return void(++counts.depth_capped);
        Joined to = asks ? join_photon(photon.q(), joins) : Joined{picture};
        to.images &= asked;
        if (!to.images) return;
        ++counts.photons_gathered;
        if (sums) sum += radiance, to.images &= ~picture, credit(to.q, radiance * arm.weight * path.weight);
        if (to.images) add(Part::Indirect, path, radiance * arm.weight, to);
      });
      if (sums) add(Part::Indirect, path, sum * arm.weight, {picture});
    });
  }
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
      radiance *= mis(segment.pdf, choice_pmf(scene_, segment.origin, segment.normal, light, guide_->trust.at_v) * pdf_direct(scene_, light, segment.origin, segment.direction, hit));
    }
  }
  for (const Arm& arm : arms) {
    Joined to{picture};
    if (asks_state(arm.joins)) {
      const int entity = light >= 0 ? scene_.light_entity(light) : scene_.entity(*hit);
      to = join(states_.next(StateTable::light_start, scene_.edits().event_class(Event::L, entity)), arm.joins);
    }
    to.images &= arm.images;
    if (to.images) add(is_direct ? Part::Direct : Part::Emission, path, radiance * arm.weight, to);
  }
}

}  // namespace sluice
