// SPDX-License-Identifier: GPL-3.0-or-later
// Gather segments of a bundle. A point y that one sample found is light for every sample of the same surface
// that sees it: each way from a v to y is weighted by the density with which all of them together would have
// found that y (balance heuristic), so nothing is counted twice and each sample alone would still find
// everything. A way counts if nothing lies on it and no entry from y to the eye would take any of the light:
// a v whose way fails is left out, of the light and of the density, whoever found y. If the finder's own way
// fails, y stays its own; so does the light of photons at a y that does not look the same from all. (Which
// photons there are at y depends on the finder's radius: near entries that take only some of them, all this
// holds as radii shrink.)
#include <algorithm>
#include <utility>

#include "transport/view_path.h"

namespace sluice {
namespace {

constexpr std::size_t most_near = 8;  // entries that a way asks one by one
// closer to grazing its shading normal depends on who looks (surface.cpp)
constexpr float least_cosine_at_y = 0.02f;
// Angles (rad) between two directions from y that are taken for one: a bias that shrinks with the radii, and
// blurs nothing beyond the bundle's pixels. for the photons' light, which y throws as to its finder: this, or
// so many widths of a sharp lobe
constexpr float cone_of_photons = 0.3f, cone_of_width = 1.5f;
constexpr float cone_of_lobes = 0.1f;  // for the weights of y's lobes

// A bound on the angle (rad) over which what the lobes of y send out changes little; infinite where all
// directions see the same. Nodes may make weights and colours of the direction, too.
float least_width(const Material& material, const Vertex& y) noexcept {
  float least = material.sees_direction() ? 1.0f : infinity;
  for (int i = 0; i < y.bsdf.count; ++i) {
    const Lobe& lobe = y.bsdf.lobes[static_cast<std::size_t>(i)];
    if (!(mask_of(lobe.event) & gathering)) continue;
    if (const auto* reflection = std::get_if<Reflection>(&lobe.shape))
      least = std::min({least, reflection->alpha.x, reflection->alpha.y});
    else if (const auto* refraction = std::get_if<Refraction>(&lobe.shape))
      least = std::min(least, refraction->alpha);
    else if (!std::holds_alternative<Lambert>(lobe.shape) && !std::holds_alternative<Translucent>(lobe.shape))
      least = std::min(least, 1.0f);
  }
  return least;
}

EventMask kinds_of(const Vertex& v) noexcept { return v.bsdf.events() & gathering; }

}  // namespace

// The way from v to y, if it comes by a side and angle from which y is the same as for its finder.
bool ViewTracer::connect(const Seer& to, Connection& way) const noexcept {
  const FarEnd& far = far_end_;
  const V3d towards = far.y.hit.position - to.v.hit.position;
  const double distance2 = towards.length2();
  way.to = &to, way.distance = std::sqrt(distance2);
  if (!(way.distance > 0)) return false;
  way.wi = V3f(towards / way.distance);
  const float cosine = -way.wi.dot(far.y.point.ng);
  way.geometry = static_cast<float>(cosine / distance2);
  return cosine >= least_cosine_at_y && -way.wi.dot(far.y.point.ns) >= least_cosine_at_y;
}

// May the light of the path's vertex come from gather segments of the whole bundle? Then it takes part in it.
bool ViewTracer::join_bundle(const ViewPath& path) noexcept {
  Seer& seer = seers_[seer_count_];
  if (bundle_.size() == 1 || path.gates > 0 || !effects_.indirect || !kinds_of(seer.v) ||
      seer_count_ == most_seers)
    return false;
  ++seer_count_;
  seer.sample = at_, seer.path = path;
  seer.word =
      mix(path.word, (static_cast<std::uint64_t>(scene_.entity(seer.v.hit)) + 1) << 8 | kinds_of(seer.v));
  return true;
}

// From here on, light that leaves y is kept for the bundle.
void ViewTracer::keep_far_end(const Arms& arms, const BsdfSample& sample, bool may_share) {
  FarEnd& far = far_end_;
  far.is_own = !may_share;
  far.pdf = sample.pdf;
  far.width = least_width(scene_.material(far.y.hit), far.y);
  far.arms = arms;
  far.straight.count = 0;
  for (std::size_t i = 0; Arm & arm : far.arms) {
    far.light[i].picture = Color(0);
    far.light[i].layers.assign(scene_.edits().layers().size(), Color(0));
    far.light[i].taken.clear();
    arm.is_kept = true, arm.index = i++;
  }
  far.arrived.clear();
  far.may_be_taken = effects_.light_edits && scene_.may_be_taken_from(far.y.hit), far.knows_takers = false;
}

// Light in state q arrives at y.
void ViewTracer::note_state(StateId q) {
  std::vector<StateId>& known = far_end_.arrived;
  if (effects_.light_edits && std::ranges::find(known, q) == known.end()) known.push_back(q);
}

// Which states it leaves y in, by any of its lobes, who would take it then, and where: all ways end at y, so
// they lie in a cone round the finder's.
void ViewTracer::find_takers(const Seer& finder) {
  FarEnd& far = far_end_;
  if (std::exchange(far.knows_takers, true)) return;
  far.states.clear(), far.takers.clear(), far.near_entries.clear();
  for (const StateId q : far.arrived)
    for_each_event(events_to_all(scene_.material(far.y.hit), far.y.bsdf) & gathering, [&](Event e) {
      const StateId behind = selection_.states().next(q, scene_.event_class(e, far.y.hit));
      if (std::ranges::find(far.states, behind) == far.states.end()) far.states.push_back(behind);
    });
  for (const StateId state : far.states) {
    const EditSet taking = selection_.states().taking_list(state).members;
    if (selection_.states().takes_none(state)) continue;
    far.takers.resize(taking.size());
    for (std::size_t i = 0; i < taking.size(); ++i) far.takers[i] |= taking[i];
  }
  if (far.takers.empty()) return;
  const V3d axis = far.y.hit.position - finder.v.hit.position;
  double radius2 = 0;
  for (const Seer& other : std::span(seers_).first(seer_count_))
    if (other.word == finder.word)
      radius2 = std::max(radius2, (other.v.hit.position - finder.v.hit.position).length2());
  ++counts.edit_queries;
  const Segment segment{finder.v.hit.position, axis.normalized(), 0, axis.length(), -1};
  far.has_all_near = scene_.edits().entries_in_cone(Side::Light, segment, std::sqrt(radius2), far.takers,
                                                    most_near, far.near_entries);
}

// Would an entry take some of the light, between y and v or between v and the eye?
inline bool ViewTracer::is_taken(const Connection& way, const Seer& finder) {
  // seldom: apart, so that it costs no call
  return (selection_.constraints().is_constrained(way.to->path.joins) || far_end_.may_be_taken) &&
         ask_entries(way, finder);
}
bool ViewTracer::ask_entries(const Connection& way, const Seer& finder) {
  find_takers(finder);
  const Seer& seer = *way.to;
  const FarEnd& far = far_end_;
  if (selection_.constraints().is_constrained(seer.path.joins)) {
    bool arrives = true;
    for_each_event(kinds_of(seer.v), [&](Event e) {
      const ConstraintId joins = event_at(seer.path.joins, seer.v, e);
      for (const StateId state : far.states)
        arrives = arrives && selection_.constraints().arrive(selection_.states(), state, joins).outcome ==
                                 JoinOutcome::Joined;
    });
    if (!arrives) return true;
  }
  if (far.near_entries.empty()) return false;
  ++counts.edit_queries;
  const Segment segment{seer.v.hit.position, V3d(way.wi), 0, way.distance, -1};
  const Edits& edits = scene_.edits();
  return far.has_all_near ? edits.any_of_entries_crossed(Side::Light, segment, far.near_entries)
                          : edits.any_entry_crossed(Side::Light, segment, far.takers);
}

// When all are known that may see what the segments find.
void ViewTracer::gather_together() {
  for (std::size_t s = 0; s < seer_count_; ++s) {
    const Seer& seer = seers_[s];
    at_ = seer.sample, key_ = mix(bundle_[at_].key, s + 1), draws_ = 0;
    const GatherSegments& segments = bundle_[at_].segments;
    for (std::uint32_t i = 0; i < segments.count; ++i)
      if (gather(seer.path, seer.v, segments.numbers(i), segments.mean, true)) share(seer);
  }
}

// The light of the y that `finder` found, to all that see it.
void ViewTracer::share(const Seer& finder) {
  FarEnd& far = far_end_;
  // layers are parts of it
  const bool has_photons =
      !std::ranges::all_of(far.arms, [&](const Arm& arm) { return is_black(far.light_of(arm).picture); });
  if (!has_photons && far.straight.count == 0) return;
  std::array<Connection, most_seers> ways;
  std::size_t count = 0;
  Connection& own = ways[count++];
  const bool stays = far.is_own || !connect(finder, own) || is_taken(own, finder);
  const bool shares_photons = has_photons && !stays && sees_same_photons(finder);
  for (const Arm& arm : far.arms) {
    if (has_photons && !shares_photons) receive(finder, far.light_of(arm), arm.weight);
    if (stays) throw_straight_light(arm, far.y.bsdf, far.y.point.wo, finder, arm.weight);
  }
  if (stays || (!shares_photons && far.straight.count == 0)) return;
  for (const Seer& other : std::span(seers_).first(seer_count_)) {
    if (other.word != finder.word || &other == &finder) continue;
    Connection& way = ways[count];
    if (!connect(other, way)) continue;
    way.pdf = pdf(other.v.bsdf, other.v.point.wo, way.wi, gathering);
    if (way.pdf > 0) ++count;
  }
  const std::span others = std::span(ways).subspan(1, count - 1);
  find_clear(others);
  for (Connection& way : others) way.is_open = way.is_open && !is_taken(way, finder);
  own.pdf = far.pdf, own.is_open = true;
  const std::span all = std::span(ways).first(count);
  float density = 0;
  for (const Connection& way : all)
    if (way.is_open) density += bundle_[way.to->sample].segments.mean * way.pdf * way.geometry;
  for (const Connection& way : all) {
    if (!way.is_open) continue;
    const Bsdf& bsdf = lobes_towards(-way.wi);
    for (const Arm& arm : far.arms) {
      const Color factor =
          eval(way.to->v.bsdf, way.to->v.point.wo, way.wi, arm.lobes) * (way.geometry / density);
      if (shares_photons) receive(*way.to, far.light_of(arm), factor);
      throw_straight_light(arm, bsdf, -way.wi, *way.to, factor);
    }
  }
}

// Do all that could share y see the same light of its photons? Asked of all, lit or not, so that it does not
// matter who found y. (Where roughness depends on the direction it may, near the limit: a bias of the same
// kind.)
bool ViewTracer::sees_same_photons(const Seer& finder) const noexcept {
  const FarEnd& far = far_end_;
  if (!std::isfinite(far.width)) return true;
  const float least = std::cos(radius_scale_ * std::min(cone_of_photons, cone_of_width * far.width));
  std::optional<V3f> axis;
  return std::ranges::all_of(std::span(seers_).first(seer_count_), [&](const Seer& other) {
    if (other.word != finder.word) return true;
    const V3f direction = V3f(far.y.hit.position - other.v.hit.position).normalized();
    if (!axis) axis = direction;
    return axis->dot(direction) >= least;
  });
}

// Of y, seen from wo: as its finder sees them, unless they depend on the direction and that is too far from
// the finder's.
const Bsdf& ViewTracer::lobes_towards(const V3f& wo) noexcept {
  const FarEnd& far = far_end_;
  const bool differ = far.straight.count > 0 && scene_.material(far.y.hit).sees_direction() &&
                      wo.dot(far.y.point.wo) < std::cos(cone_of_lobes * radius_scale_);
  if (!differ) return far.y.bsdf;
  make_vertex(scene_, far.y.hit, wo, false, Carries::Radiance, far_);
  return far_.bsdf;
}

// The straight light that leaves y by wo for one arm, on to the eye.
void ViewTracer::throw_straight_light(const Arm& arm, const Bsdf& bsdf, const V3f& wo, const Seer& to,
                                      const Color& factor) {
  const StraightLight& straight = far_end_.straight;
  if (straight.count == 0) return;
  outgoing_.picture = Color(0), outgoing_.layers.assign(scene_.edits().layers().size(), Color(0)),
  outgoing_.taken.clear();
  for (const StraightLight::Share& share : std::span(straight.shares).first(straight.count))
    if (share.arm == arm.index)
      put(outgoing_, eval(bsdf, wo, straight.wi, mask_of(share.event)) * straight.arriving, share.q,
          share.images);
  receive(to, outgoing_, factor);
}

void ViewTracer::put(Outgoing& light, const Color& radiance, StateId q, ImageSet images) {
  if (!is_finite(radiance)) return void(++counts.non_finite);
  if (images & picture) {
    light.picture += radiance;
    credit_outgoing(light, radiance, q);
  }
  for (ImageSet layers = images >> 1; layers; layers &= layers - 1)
    light.layers[static_cast<std::size_t>(std::countr_zero(layers))] += radiance;
}

void ViewTracer::credit_outgoing(Outgoing& light, const Color& radiance, StateId q) {
  credit(q, radiance, [&](std::uint32_t edit) {
    const auto at = std::ranges::find(light.taken, edit, &std::pair<std::uint32_t, Color>::first);
    if (at == light.taken.end())
      light.taken.emplace_back(edit, radiance);
    else
      at->second += radiance;
  });
}

void ViewTracer::find_clear(std::span<Connection> ways) noexcept {
  const FarEnd& far = far_end_;
  std::array<Ray, most_seers> rays;
  std::array<bool, most_seers> clear;
  const double clearance = far.y.hit.clearance.length();
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const Connection& way = ways[i];
    rays[i] = ray_from(way.to->v.hit, way.wi, short_of(way.distance, clearance, -way.wi.dot(far.y.point.ng)));
  }
  scene_.find_clear(std::span(rays).first(ways.size()), clear);
  counts.shadow_rays += ways.size();
  for (std::size_t i = 0; i < ways.size(); ++i) ways[i].is_open = clear[i];
}

void ViewTracer::receive(const Seer& seer, const Outgoing& light, const Color& factor) noexcept {
  const Color whole = factor * seer.path.weight, radiance = light.picture * whole;
  if (!is_finite(radiance)) return void(++counts.non_finite);
  BundleMember& member = members_[seer.sample];
  add_up(member.sample.parts[static_cast<std::size_t>(Part::Indirect)], radiance);
  for (std::size_t l = 0; l < member.layers.size(); ++l) add_up(member.layers[l], light.layers[l] * whole);
  for (const auto& [edit, part] : light.taken)
    counts.of_edit(static_cast<int>(edit)).shown += luminance(part * whole) * bundle_[seer.sample].share;
}

}  // namespace sluice
