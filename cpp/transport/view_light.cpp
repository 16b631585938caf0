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

}  // namespace

// Next-event estimation at v, or at the gather segment's end y, where it stands alone. The shadow segment runs straight through exits
// and is blocked by every entry that takes q of L. `chance`: that v sends a gather segment, which may find the light too.
void ViewTracer::direct_light(const ViewPath& path, const Vertex& vertex, const Arms& arms, Part part, float chance) {
  const Sampler& numbers = arms.begin()->far ? bundle_[at_].turn : sampler_;  // at a shared y: points of the bundle's sequence
  if (part != Part::Direct) return light_sample(path, vertex, arms, part, {numbers, 1, 0});
  const std::uint32_t count = bundle_[at_].light_samples;
  const auto so_far = [this] { return V3d(self().sample.parts[static_cast<std::size_t>(Part::Direct)]); };
  V3d apart = bundle_[at_].measures_lights ? so_far() : V3d(0);
  for (std::uint32_t i = 0; i < count; ++i) {
    light_sample(path, vertex, arms, part, {numbers.part(i, count), static_cast<float>(count), chance});
    if (bundle_[at_].measures_lights) apart += i == 0 ? so_far() * -2 : so_far();
  }
  self().light_variance += apart * apart;
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
  const float pdf_light = one.count * choice->pmf * sample->pdf;  // of all tries together
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

// Radiance that goes on to the eye by an arm; or, where the bundle shares it, that leaves y.
void ViewTracer::deliver(Part part, const ViewPath& path, const Color& radiance, const Arm& arm, Joined to) {
  if (!arm.far) return add(part, path, radiance * arm.weight, to);
  if (!is_finite(radiance)) return void(++counts.non_finite);
  if (to.images & picture) {
    arm.light().picture += radiance;
    credit_arm(to.q, path, radiance, arm);
  }
  for (ImageSet layers = to.images >> 1; layers; layers &= layers - 1) arm.light().layers[static_cast<std::size_t>(std::countr_zero(layers))] += radiance;
}

void ViewTracer::credit_arm(StateId q, const ViewPath& path, const Color& radiance, const Arm& arm) {
  if (!arm.far) return credit_radiance(q, radiance * arm.weight * path.weight);
  credit(q, radiance, [&, &taken = arm.light().taken](std::uint32_t edit) {
    const auto at = std::ranges::find(taken, edit, &std::pair<std::uint32_t, Color>::first);
    if (at == taken.end())
      taken.emplace_back(edit, radiance);
    else
      at->second += radiance;
  });
}

ViewTracer::Joined ViewTracer::try_join(StateId q, int joins) noexcept {
  const auto [at_eye, fate, taker] = joins_.arrive(states_, q, joins);
  if (fate == Joins::Fate::StatesCapped && !joins_.is_constrained(joins)) return {picture, at_eye, fate};  // lost to the layers alone
  if (fate != Joins::Fate::Arrives) return {0, at_eye, fate, taker};
  if (!effects_.layers) return {picture, at_eye};
  const StateId whole = states_.next(at_eye, scene_.edits().event_class(Event::E, -1));
  return {states_.images(whole), at_eye, whole == StateTable::dead ? Joins::Fate::StatesCapped : fate};
}

ViewTracer::Joined ViewTracer::counted(const Joined& joined) noexcept {
  if (joined.fate == Joins::Fate::GatesCapped) ++counts.gates_capped;
  if (joined.fate == Joins::Fate::StatesCapped) ++counts.states_capped;
  if (joined.taker >= 0) counts.of_edit(joined.taker).kept = true;
  return joined;
}

// The photon begins a run of those in its state.
void ViewTracer::start_run(PhotonRun& run, const Photon& photon, int joins) noexcept {
  run.q = photon.q;
  run.to = join_photon(run.q, joins);
  run.to.images &= run.asked;
  run.is_plain = run.sums && run.to.images == picture && run.to.fate == Joins::Fate::Arrives && states_.gates(run.to.q) == 0;
}

// For a state of the pass's photons. Remembered while C stays the same.
ViewTracer::Joined ViewTracer::join_photon(std::uint32_t q, int joins) noexcept {
  if (!asks_state(joins)) return {picture, state_of_[q]};
  if (joins != memo_joins_) memo_joins_ = joins, ++memo_now_;
  if (memo_mark_[q] != memo_now_) {
    memo_mark_[q] = memo_now_;
    memo_[q] = try_join(state_of_[q], joins);
  }
  return memo_[q];
}

// Gathering lobes by what C and the layers can tell apart. The picture's are taken at once where C allows all of them, so that layers
// change no bit of it.
Few<ViewTracer::LobeGroup> ViewTracer::groups_of(int joins, const Vertex& vertex, ImageSet images) {
  Few<LobeGroup> groups;
  const bool is_apart = joins_.is_constrained(joins);
  const EventMask kinds = vertex.bsdf.events() & gathering;
  if (!is_apart && !effects_.layers) {
    groups.add({gathering, Joins::all, images});
  } else if (!is_apart && (kinds != gathering || same_event(vertex))) {
    groups.add({gathering, event_at(joins, vertex, kinds == mask_of(Event::G) ? Event::G : Event::D), images});
  } else {
    if (!is_apart && (images & picture)) groups.add({gathering, joins, picture});
    if (!is_apart) images &= ~picture;
    for_each_event(kinds, [&](Event e) { groups.add({mask_of(e), event_at(joins, vertex, e), images}); });
  }
  return groups;
}

// Caustics and edited light: photons that arrived at v by a followed lobe or through an exit.
void ViewTracer::close_density(const ViewPath& path, const Vertex& v) {
  if (effects_.close_arrivals == 0 || !(v.bsdf.events() & gathering)) return;
  const float radius = common_radius(path);
  if (photons_->close.size() > 0) add_density(path, v, photons_->close, disk_radius(radius, guide_->disks, v, widest_disk(settings_, radius)));
  if (photons_->soft.size() > 0) add_density(path, v, photons_->soft, disk_radius(radius, guide_->soft_disks, v, widest_soft_disk(settings_, radius, scene_.extent())));
}

void ViewTracer::add_density(const ViewPath& path, const Vertex& v, const PhotonMap& map, float radius) {
  const int room = settings_.max_depth - path.depth - 1;
  for (const auto& [mask, joins, asked] : groups_of(path.joins, v, all_images)) {
    ++counts.gathers;
    const bool sums = path.hue < 0 && (asked & picture);  // the picture's share is summed up first
    PhotonRun run{asks_photons(joins), asked, sums};
    Color caustics(0), edited(0);
    estimate_density(map, Receiver(v, mask), radius, [&, joins = joins](const Photon& photon, const Color& radiance) {
      if (photon.depth > room) return void(++counts.depth_capped);
      if (run.is_new(photon)) start_run(run, photon, joins);
      if (run.is_plain) return void((++counts.photons_gathered, (is_edited(photon.arrival) ? edited : caustics) += radiance));
      Joined to = counted(run.to);
      if (!to.images) return;
      ++counts.photons_gathered;
      if (sums) (is_edited(photon.arrival) ? edited : caustics) += radiance, to.images &= ~picture, credit_radiance(to.q, radiance * path.weight);
      if (to.images) add(is_edited(photon.arrival) ? Part::Edited : Part::Caustics, path, radiance, to);
    });
    if (!sums) continue;
    add(Part::Caustics, path, caustics, {picture});
    add(Part::Edited, path, edited, {picture});
  }
}

// The ways light of the gather segment goes on at v: one, or one per kind of lobe where C or a layer could tell them apart.
Arms ViewTracer::arms_of(const ViewPath& path, const Vertex& v, const BsdfSample& sample) {
  const EventMask kinds = v.bsdf.events() & gathering;
  Arms arms;
  const auto joins_for = [&](Event e) { return effects_.words ? event_at(path.joins, v, e) : path.joins; };
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
    arms.add({joins_for(e), eval(v.bsdf, v.point.wo, sample.wi, mask_of(e)) / sample.pdf, is_one ? ~picture : all_images, mask_of(e)});
  return arms;
}

// One segment from v's D and G lobes, straight on only: light through an exit is the density's at v. Emitters that it meets are direct
// light found by lobe sampling. `seer`: v where the bundle shares its segments, and this sample may have no turn; else null.
void ViewTracer::gather(const ViewPath& path, const Vertex& v, Seer* seer) {
  if (!(effects_.direct || effects_.indirect) || !(v.bsdf.events() & gathering)) return;
  if (seer && !bundle_[at_].has_turn) return;
  const float chance = seer ? turn_chance : 1;
  const Sampler& numbers = seer ? bundle_[at_].turn : sampler_;
  const auto sample = sluice::sample(v.bsdf, v.point.wo, v.bsdf.count > 1 ? numbers.first(pair_of(path, 4)) : 0, numbers.pair(pair_of(path, 5)), gathering);
  if (!sample || !(sample->pdf > 0)) return;
  Arms arms = arms_of(path, v, *sample);
  for (Arm& arm : arms) arm.weight /= chance;
  const LightSegment segment{v.hit.position, sample->wi, lit_side(v.bsdf), sample->pdf * chance / static_cast<float>(bundle_[at_].light_samples)};
  Ray ray = ray_from(v.hit, sample->wi);
  double length = 0;
  bool arrived = false;
  int layer = 0;
  for (; layer < max_alpha_layers && !arrived; ++layer) {
    const auto hit = scene_.intersect(ray);
    ++counts.rays;
    if (!hit) {
      narrow(path, segment, length, ray.t_max, nullptr, arms);
      return far_emission(path, segment, arms);
    }
    make_vertex(scene_, *hit, -sample->wi, false, Carries::Radiance, far_);
    narrow(path, segment, length, length + hit->t, &far_, arms);
    length += hit->t;
    const float pass = pass_chance(far_.bsdf);
    arrived = pass < 1 && (pass == 0 || random() >= pass);
    for (Arm& arm : arms) arm.weight *= arrived ? Color(1 / (1 - pass)) : far_.bsdf.transparency / pass;
    ray = ray_from(*hit, sample->wi);
  }
  if (!arrived) return void(++counts.alpha_capped);
  surface_emission(path, segment, far_, arms);
  if (!effects_.indirect) return;
  if (path.depth + 2 > settings_.max_depth) return void(counts.depth_capped += far_.bsdf.count > 0);
  const Material& material = scene_.material(far_.hit);
  const bool may_share = layer == 1 && (material.is_opaque() || material.is_constant()) && pass_chance(far_.bsdf) == 0;
  if (seer) keep_far_end(seer->far, far_, arms, *sample, may_share);
  light_from(path, far_, seer ? seer->far.arms : arms, length, sample->pdf);
}

// What the gather segment's end y sends to v, by next-event estimation and photons.
void ViewTracer::light_from(const ViewPath& path, const Vertex& y, const Arms& arms, double length, float pdf) {
  direct_light(path, y, arms, Part::Indirect);
  gather_at(path, y, arms, length, gather_radius(*guide_, length, pdf) * radius_scale_);
}

// Light edits that could take what comes along a piece of a segment: by the last event, of some of the lobes at its far end (null: nothing
// met) or of a lamp.
EditSet ViewTracer::takers_from(const Vertex* far, EventMask lobes, std::span<const LampHit> lamps) {
  const Edits& edits = scene_.edits();
  if (far && pass_chance(far->bsdf) > 0) return edits.takers(Side::Light);
  EditSet all;
  const auto add = [&](EventClass last) {
    const EditSet set = edits.takers_after(Side::Light, last);
    if (set.empty() || all.empty() || set.data() == all.data()) return void(all = set.empty() ? all : set);
    if (all.data() != takers_.data()) takers_.assign(all.begin(), all.end()), all = takers_;
    for (std::size_t i = 0; i < set.size(); ++i) takers_[i] |= set[i];
  };
  if (far) {
    for_each_event(far->bsdf.events() & lobes, [&](Event e) { add(scene_.event_class(e, far->hit)); });
    const int light = scene_.mesh_light(far->hit.instance);
    if (!is_black(far->bsdf.emission)) add(light >= 0 ? light_class(light) : scene_.event_class(Event::L, far->hit));
  } else {
    for (const int light : scene_.infinite_lights()) add(light_class(light));
  }
  for (const LampHit& lamp : lamps) add(light_class(lamp.light));
  return all;
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
  const std::span met(lamps.first(static_cast<std::size_t>(lamp_count)));
  const EditSet takers = effects_.light_edits && may_be_taken_from(far, met) ? takers_from(far, gathering, met) : EditSet();
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
    if (!arm.far && is_black(arm.weight)) continue;
    for (const auto& [mask, joins, asked] : groups_of(arm.joins, y, arm.images)) {
      ++counts.gathers;
      const bool sums = path.hue < 0 && (asked & picture);
      PhotonRun run{asks_photons(joins), asked, sums};
      Color sum(0);
      estimate_density(photons_->all, Receiver(y, mask, length), radius, [&, joins = joins](const Photon& photon, const Color& radiance) {
        if (photon.depth > room) return void(++counts.depth_capped);
        if (run.is_new(photon)) {
          start_run(run, photon, joins);
          if (arm.far) note_state(state_of_[run.q], *arm.far);
        }
        if (run.is_plain) return void((++counts.photons_gathered, sum += radiance));
        Joined to = counted(run.to);
        if (!to.images) return;
        ++counts.photons_gathered;
        if (sums) sum += radiance, to.images &= ~picture, credit_arm(to.q, path, radiance, arm);
        if (to.images) deliver(Part::Indirect, path, radiance, arm, to);
      });
      if (sums) deliver(Part::Indirect, path, sum, arm, {picture});
    }
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
      const float pmf = choice_pmf(scene_, segment.origin, segment.normal, light, guide_->trust.at_v(segment.origin));
      radiance *= mis(segment.pdf, pmf * pdf_direct(scene_, light, segment.origin, segment.direction, hit));
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
