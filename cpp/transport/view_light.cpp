// SPDX-License-Identifier: GPL-3.0-or-later
// The estimators of design §5 at v, the view path's vertex with gathering lobes, beside direct light
// (view_direct.cpp): caustics and edited light (photon density at v), and indirect light (gather segments to
// y; next-event estimation and photon density there).
#include <algorithm>

#include "transport/radii.h"
#include "transport/view_path.h"

namespace sluice {

// Radiance that goes on to the eye by an arm; or, where the bundle shares it, that leaves y.
void ViewTracer::deliver(const ViewPath& path, const Color& radiance, const Arm& arm, JoinResult to) {
  if (arm.is_kept)
    put(far_end_.light_of(arm), radiance, to.q, to.images);
  else
    add(Part::Indirect, path, radiance * arm.weight, to);
}

void ViewTracer::credit_arm(StateId q, const ViewPath& path, const Color& radiance, const Arm& arm) {
  if (arm.is_kept)
    credit_outgoing(far_end_.light_of(arm), radiance, q);
  else
    credit_radiance(q, radiance * arm.weight * path.weight);
}

JoinResult ViewTracer::counted(const JoinResult& joined) noexcept {
  if (joined.outcome == JoinOutcome::GatesCapped) ++counts.gates_capped;
  if (joined.outcome == JoinOutcome::StatesCapped) ++counts.states_capped;
  if (joined.taker >= 0) counts.of_edit(joined.taker).kept = true;
  return joined;
}

void ViewTracer::join_run(PhotonRun& run, ConstraintId joins) noexcept {
  run.to = selection_.join_photon(run.q, joins);
  run.to.images &= run.asked;
  run.is_plain = run.sums && run.to.images == picture && run.to.outcome == JoinOutcome::Joined &&
                 selection_.states().gates(run.to.q) == 0;
}

// Gathering lobes by what C and the layers can tell apart. The picture's are taken at once where C allows all
// of them, so that layers change no bit of it.
Few<ViewTracer::LobeGroup> ViewTracer::groups_of(ConstraintId joins, const Vertex& vertex, ImageSet images) {
  Few<LobeGroup> groups;
  const bool is_apart = selection_.constraints().is_constrained(joins);
  const EventMask kinds = vertex.bsdf.events() & gathering;
  if (!is_apart && !effects_.layers) {
    groups.add({gathering, no_constraint, images});
  } else if (!is_apart && (kinds != gathering || same_event(vertex))) {
    groups.add(
        {gathering, event_at(joins, vertex, kinds == mask_of(Event::G) ? Event::G : Event::D), images});
  } else {
    if (!is_apart && (images & picture)) groups.add({gathering, joins, picture});
    if (!is_apart) images &= ~picture;
    for_each_event(kinds, [&](Event e) { groups.add({mask_of(e), event_at(joins, vertex, e), images}); });
  }
  return groups;
}

// Caustics and edited light: photons that arrived at v by a followed lobe or through an exit.
void ViewTracer::close_density(const ViewPath& path, const Vertex& v) {
  if (photons_->close.size() == 0 || !(v.bsdf.events() & gathering)) return;
  const Reaches reaches = disk_bounds_.around(V3f(v.hit.position), radius_scale_);
  const int left = settings_.max_depth - path.depth - 1;  // events
  for (const auto& [mask, joins, asked] : groups_of(path.joins, v, all_images)) {
    ++counts.gathers;
    const bool sums = path.hue < 0 && (asked & picture);  // the picture's share is summed up first
    PhotonRun run{selection_.asks_photons(joins), asked, sums};
    Color caustics(0), edited(0);
    const auto ask = [&, joins = joins](std::uint32_t q) { return start_run(run, q, joins), answer_of(run); };
    const auto found = [&, joins = joins](const Photon& photon, const Color& radiance, bool is_summed) {
      if (photon.depth > left) return void(++counts.depth_capped);
      if (run.is_new(photon)) start_run(run, photon.q, joins);
      if (run.is_plain)
        return void((++counts.photons_gathered, (is_edited(photon.arrival) ? edited : caustics) += radiance));
      JoinResult to = counted(run.to);
      if (!to.images) return;
      counts.photons_gathered += !is_summed;
      if (sums && !is_summed)
        (is_edited(photon.arrival) ? edited : caustics) += radiance,
            credit_radiance(to.q, radiance * path.weight);
      if (sums) to.images &= ~picture;
      if (to.images) add(is_edited(photon.arrival) ? Part::Edited : Part::Caustics, path, radiance, to);
    };
    const Sum sum = estimate_density(photons_->close, Receiver(v, mask), reaches,
                                     {sums, left, selection_.asks_state(joins)}, ask, found);
    counts.photons_gathered += sum.photons;
    if (!sums) continue;
    add(Part::Caustics, path, caustics + sum.radiance, {picture});
    add(Part::Edited, path, edited, {picture});
  }
}

// The ways light of the gather segment goes on at v: one, or one per kind of lobe where C or a layer could
// tell them apart.
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
    arms.add({joins_for(Event::D), eval(v.bsdf, v.point.wo, sample.wi, gathering) / sample.pdf,
              is_all ? all_images : picture});
    if (is_all) return arms;
  }
  for (const Event e : {Event::D, Event::G})
    arms.add({joins_for(e), eval(v.bsdf, v.point.wo, sample.wi, mask_of(e)) / sample.pdf,
              is_one ? ~picture : all_images, mask_of(e)});
  return arms;
}

// From a v that shares nothing.
void ViewTracer::gather_alone(const ViewPath& path, const Vertex& v) {
  if (!(effects_.direct || effects_.indirect) || !(v.bsdf.events() & gathering)) return;
  const std::uint32_t segments = bundle_[at_].segments.alone();
  for (std::uint32_t i = 0; i < segments; ++i)
    gather(path, v, sampler_.part(i, segments), static_cast<float>(segments), false);
}

// One segment from v's D and G lobes, straight on only: light through an exit is the density's at v. Emitters
// that it meets are direct light found by lobe sampling. `segments`: how many v sends in the mean. `shares`:
// what it finds at a surface is kept for the bundle. True: it found a surface whose light counts.
bool ViewTracer::gather(const ViewPath& path, const Vertex& v, const Sampler& numbers, float segments,
                        bool shares) {
  const float u = v.bsdf.count > 1 ? numbers.first(pair_of(path, 4)) : 0;
  const auto sample = sluice::sample(v.bsdf, v.point.wo, u, numbers.pair(pair_of(path, 5)), gathering);
  if (!sample || !(sample->pdf > 0)) return false;
  Arms arms = arms_of(path, v, *sample);
  for (Arm& arm : arms) arm.weight /= segments;
  const LightSegment segment{v.hit.position, sample->wi, lit_side(v.bsdf), sample->pdf * segments,
                             light_samples()};
  Vertex& y = shares ? far_end_.y : far_;
  const auto reached = reach(path, segment, ray_from(v.hit, sample->wi), arms, y);
  if (!reached || !effects_.indirect) return false;
  if (path.depth + 2 > settings_.max_depth) {
    counts.depth_capped += y.bsdf.count > 0;
    return false;
  }
  if (shares) keep_far_end(arms, *sample, reached->may_share);
  const Arms& from_y = shares ? far_end_.arms : arms;
  straight_light(path, y, numbers, from_y);
  gather_at(path, y, from_y, reached->length,
            gather_radius(*guide_, reached->length, sample->pdf) * radius_scale_);
  return true;
}

// Follows a gather segment through what is transparent to a surface y; lights on the way and there are direct
// light. Empty: it met none.
std::optional<ViewTracer::Reached> ViewTracer::reach(const ViewPath& path, const LightSegment& segment,
                                                     Ray ray, Arms& arms, Vertex& y) {
  double length = 0;
  for (int layer = 0; layer < max_alpha_layers; ++layer) {
    const auto hit = scene_.intersect(ray);
    ++counts.rays;
    if (!hit) {
      narrow(path, segment, length, ray.t_max, nullptr, arms);
      far_emission(path, segment, arms);
      return {};
    }
    make_vertex(scene_, *hit, -segment.direction, false, Carries::Radiance, y);
    narrow(path, segment, length, length + hit->t, &y, arms);
    length += hit->t;
    const float pass = y.pass_chance;
    const bool arrived = pass < 1 && (pass == 0 || random() >= pass);
    for (Arm& arm : arms) arm.weight *= arrived ? Color(1 / (1 - pass)) : y.bsdf.transparency / pass;
    if (arrived) {
      surface_emission(path, segment, y, arms);
      const Material& material = scene_.material(y.hit);
      return Reached{length, layer == 0 && (material.is_opaque() || material.is_constant()) && pass == 0};
    }
    ray = ray_from(*hit, segment.direction);
  }
  ++counts.alpha_capped;
  return {};
}

// Light edits that could take what comes along a piece of a segment: by the last event, of some of the lobes
// at its far end (null: nothing met) or of a lamp.
EditSet ViewTracer::takers_from(const Vertex* far, EventMask lobes, std::span<const LampHit> lamps) {
  const Edits& edits = scene_.edits();
  if (far && far->pass_chance > 0) return edits.takers(Side::Light);
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
    if (!is_black(far->bsdf.emission))
      add(light >= 0 ? light_class(light) : scene_.event_class(Event::L, far->hit));
  } else {
    for (const int light : scene_.infinite_lights()) add(light_class(light));
  }
  for (const LampHit& lamp : lamps) add(light_class(lamp.light));
  return all;
}

// One piece of the gather segment, from length t_start to t_end: C narrows at every entry that it passes.
void ViewTracer::narrow(const ViewPath& path, const LightSegment& segment, double t_start, double t_end,
                        const Vertex* far, Arms& arms) {
  const std::span lamps(lamps_);
  int lamp_count = 0, next_lamp = 0;
  if (effects_.direct) {
    lamp_count = intersect_lamps(scene_, {segment.origin, segment.direction, t_end}, lamps);
    lamp_count = static_cast<int>(std::remove_if(lamps.begin(), lamps.begin() + lamp_count,
                                                 [&](const LampHit& l) { return l.t <= t_start; }) -
                                  lamps.begin());
    std::sort(lamps.begin(), lamps.begin() + lamp_count,
              [](const LampHit& a, const LampHit& b) { return a.t < b.t; });
  }
  const auto collect_lamps = [&](double until) {
    for (; next_lamp < lamp_count && lamps[static_cast<std::size_t>(next_lamp)].t < until; ++next_lamp) {
      const LampHit& lamp = lamps[static_cast<std::size_t>(next_lamp)];
      add_emission(path, segment, lamp.light, lamp.radiance, nullptr, arms);
    }
  };
  const std::span met(lamps.first(static_cast<std::size_t>(lamp_count)));
  const EditSet takers =
      effects_.light_edits && may_be_taken_from(far, met) ? takers_from(far, gathering, met) : EditSet();
  if (!is_empty(takers)) {
    ++counts.edit_queries;
    scene_.edits().entries_crossed(Side::Light, {segment.origin, V3d(segment.direction), t_start, t_end, -1},
                                   takers, crossings_);
    for (const Crossing& crossing : crossings_) {
      collect_lamps(crossing.t);
      for (Arm& arm : arms) arm.joins = selection_.constraints().passed(arm.joins, crossing.edit);
    }
  }
  collect_lamps(std::numeric_limits<double>::infinity());
}

// Photon density at y, `length` from v: all photons with q in C. Those that came straight from a light are
// kept only where it is hidden from next-event estimation or too near for it.
void ViewTracer::gather_at(const ViewPath& path, const Vertex& y, const Arms& arms, double length,
                           float radius) {
  const int left = settings_.max_depth - path.depth - 2;  // events
  for (const Arm& arm : arms) {
    if (!arm.is_kept && is_black(arm.weight)) continue;
    for (const auto& [mask, joins, asked] : groups_of(arm.joins, y, arm.images)) {
      ++counts.gathers;
      const bool sums = path.hue < 0 && (asked & picture);
      PhotonRun run{selection_.asks_photons(joins), asked, sums};
      Color found_sum(0);
      const auto ask = [&, joins = joins](std::uint32_t q) {
        start_run(run, q, joins);
        if (arm.is_kept) note_state(selection_.state_of_photon(q));
        return answer_of(run);
      };
      const auto found = [&](const Photon& photon, const Color& radiance, bool is_summed) {
        if (photon.depth > left) return void(++counts.depth_capped);
        if (run.is_new(photon)) ask(photon.q);
        if (run.is_plain) return void((++counts.photons_gathered, found_sum += radiance));
        JoinResult to = counted(run.to);
        if (!to.images) return;
        counts.photons_gathered += !is_summed;
        if (sums && !is_summed) found_sum += radiance, credit_arm(to.q, path, radiance, arm);
        if (sums) to.images &= ~picture;
        if (to.images) deliver(path, radiance, arm, to);
      };
      const SumRule rule{sums, left, selection_.asks_state(joins) || (effects_.light_edits && arm.is_kept)};
      const Sum sum = estimate_density(photons_->all, Receiver(y, mask, length), radius, rule, ask, found);
      counts.photons_gathered += sum.photons;
      if (sums) deliver(path, found_sum + sum.radiance, arm, {picture});
    }
  }
}

}  // namespace sluice
