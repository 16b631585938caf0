// SPDX-License-Identifier: GPL-3.0-or-later
// Gather segments of a bundle. A point y that one sample found is light for every sample of the same surface that sees it: each way from
// a v to y is weighted by the density with which all of them together would have found that y (balance heuristic), so nothing is counted
// twice and each sample alone would still find everything. A way counts if nothing lies on it and no entry from y to the eye would take any
// of the light: a v whose way fails is left out, of the light and of the density, whoever found y. If the finder's own way fails, or y does
// not look the same from all, y stays its own. (Which light there is at y depends on the finder's radius: near entries that take only
// some of it, all this holds as radii shrink.)
#include <algorithm>

#include "transport/view_path.h"

namespace sluice {
namespace {

constexpr float least_cosine_at_y = 0.02f;  // closer to grazing its shading normal depends on who looks (surface.cpp)
// Directions so close (rad) see the same, up to a bias that shrinks with the radii:
constexpr float cone_of_weights = 0.1f;  // of lobes that depend on the direction, as by Fresnel's factor
constexpr float cone_of_width = 0.3f;    // and of how a lobe throws what comes from many sides, times its width

// A bound on the angle (rad) over which what the lobes of y send out changes little; infinite where all directions see the same. Nodes
// may make weights and colours of the direction, too.
float least_width(const Material& material, const Vertex& y) noexcept {
  float least = material.is_constant() ? infinity : 1.0f;
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
bool ViewTracer::connect(Seer& to, const FarEnd& far, Connection& way) noexcept {
  const V3d towards = far.y.hit.position - to.v.hit.position;
  const double distance2 = towards.length2();
  way.to = &to, way.distance = std::sqrt(distance2);
  if (!(way.distance > 0)) return false;
  way.wi = V3f(towards / way.distance);
  const float cosine = -way.wi.dot(far.y.point.ng);
  way.geometry = static_cast<float>(cosine / distance2);
  return cosine >= least_cosine_at_y && -way.wi.dot(far.y.point.ns) >= least_cosine_at_y;
}

// The path's vertex, if its light may come from gather segments of the whole bundle: then it sends one itself by turns.
Seer* ViewTracer::join_bundle(const ViewPath& path) noexcept {
  Seer& seer = seers_[seer_count_];
  if (bundle_.size() == 1 || path.gates > 0 || !effects_.indirect || !kinds_of(seer.v) || seer_count_ == most_seers) return nullptr;
  ++seer_count_;
  seer.sample = at_, seer.weight = path.weight, seer.joins = path.joins;
  seer.word = mix(path.word, (static_cast<std::uint64_t>(scene_.entity(seer.v.hit)) + 1) << 8 | kinds_of(seer.v));
  seer.far.found = false;
  return &seer;
}

// From here on, light that leaves y is kept apart.
void ViewTracer::keep_far_end(FarEnd& far, const Arms& arms, const BsdfSample& sample, bool may_share) {
  far.found = true, far.is_own = !may_share;
  far.pdf = sample.pdf;
  const float width = least_width(scene_.material(far.y.hit), far.y);
  far.cone = std::isfinite(width) ? std::cos(cone_of_weights * radius_scale_) : -1;
  far.photon_cone = std::isfinite(width) ? std::cos(std::min(cone_of_weights, cone_of_width * width) * radius_scale_) : -1;
  far.arms = arms;
  far.straight.arriving = Color(0), far.straight.count = 0;
  for (std::size_t i = 0; Arm& arm : far.arms) {
    far.light[i].picture = Color(0);
    far.light[i].layers.assign(scene_.edits().layers().size(), Color(0));
    far.light[i].taken.clear();
    arm.far = &far, arm.index = i++;
  }
  far.arrived.clear();
}

// Light in state q arrives at y.
void ViewTracer::note_state(StateId q, FarEnd& far) {
  if (effects_.light_edits && std::ranges::find(far.arrived, q) == far.arrived.end()) far.arrived.push_back(q);
}

// It leaves y by any of its lobes.
void ViewTracer::find_far_takers(FarEnd& far) {
  far.states.clear(), far.takers.clear();
  for (const StateId q : far.arrived)
    for_each_event(kinds_of(far.y), [&](Event e) {
      const StateId behind = states_.next(q, scene_.event_class(e, far.y.hit));
      if (std::ranges::find(far.states, behind) == far.states.end()) far.states.push_back(behind);
    });
  for (const StateId state : far.states) {
    const EditSet taking = states_.taking_list(state).members;
    if (states_.takes_none(state)) continue;
    far.takers.resize(taking.size());
    for (std::size_t i = 0; i < taking.size(); ++i) far.takers[i] |= taking[i];
  }
}

// Would an entry take some of the light, between y and v or between v and the eye?
inline bool ViewTracer::is_taken(const Connection& way, const FarEnd& far) {
  return (joins_.is_constrained(way.to->joins) || !far.takers.empty()) && ask_entries(way, far);  // hardly ever: apart, so that it costs no call
}
bool ViewTracer::ask_entries(const Connection& way, const FarEnd& far) {
  const Seer& seer = *way.to;
  if (joins_.is_constrained(seer.joins)) {
    bool arrives = true;
    for_each_event(kinds_of(seer.v), [&](Event e) {
      const int joins = event_at(seer.joins, seer.v, e);
      for (const StateId state : far.states) arrives = arrives && joins_.arrive(states_, state, joins).fate == Joins::Fate::Arrives;
    });
    if (!arrives) return true;
  }
  if (far.takers.empty()) return false;
  ++counts.edit_queries;
  return scene_.edits().any_entry_crossed(Side::Light, {seer.v.hit.position, V3d(way.wi), 0, way.distance, -1}, far.takers);
}

void ViewTracer::share_gathers() {
  for (Seer& seer : std::span(seers_).first(seer_count_))
    if (seer.far.found) share(seer);
}

// The light of the y that `finder` found, to all that see it.
void ViewTracer::share(Seer& finder) {
  find_far_takers(finder.far);
  const FarEnd& far = finder.far;
  const bool has_photons = !std::ranges::all_of(far.arms, [](const Arm& arm) { return is_black(arm.light().picture); });  // layers are parts of it
  if (!has_photons && is_black(far.straight.arriving)) return;
  std::array<Connection, most_seers> ways;
  std::size_t count = 0;
  Connection& own = ways[count++];
  const auto keep = [&](bool straight) {
    for (const Arm& arm : far.arms) send(far, arm, far.y.point.wo, {straight, has_photons}, finder, arm.weight);
  };
  const float alike = far.cone < 0 ? 1 : least_cosine(finder);
  if (far.is_own || !connect(finder, far, own) || is_taken(own, far) || alike < far.cone) return keep(true);
  const bool shares_photons = has_photons && alike >= far.photon_cone;
  if (has_photons && !shares_photons) keep(false);
  if (!shares_photons && far.straight.count == 0) return;
  for (Seer& other : std::span(seers_).first(seer_count_)) {
    if (other.word != finder.word || &other == &finder) continue;
    Connection& way = ways[count];
    if (!connect(other, far, way)) continue;
    way.pdf = pdf(other.v.bsdf, other.v.point.wo, way.wi, gathering);
    if (way.pdf > 0) ++count;
  }
  const std::span others = std::span(ways).subspan(1, count - 1);
  find_clear(others, far);
  for (Connection& way : others) way.is_open = way.is_open && !is_taken(way, far);
  own.pdf = far.pdf, own.is_open = true;
  const std::span all = std::span(ways).first(count);
  float density = 0;
  for (const Connection& way : all)
    if (way.is_open) density += turn_chance * way.pdf * way.geometry;
  for (const Connection& way : all) {
    if (!way.is_open) continue;
    for (const Arm& arm : far.arms)
      send(far, arm, -way.wi, {true, shares_photons}, *way.to, eval(way.to->v.bsdf, way.to->v.point.wo, way.wi, arm.lobes) * (way.geometry / density));
  }
}

// What leaves y by wo for one arm, on to the eye: of straight light, of photons.
void ViewTracer::send(const FarEnd& far, const Arm& arm, const V3f& wo, Sent sent, const Seer& to, const Color& factor) {
  if (!sent.straight || far.straight.count == 0) return sent.photons ? receive(to, arm.light(), factor) : void();
  if (sent.photons) {
    outgoing_ = arm.light();
  } else {
    outgoing_.picture = Color(0), outgoing_.layers.assign(scene_.edits().layers().size(), Color(0)), outgoing_.taken.clear();
  }
  for (const StraightLight::Share& share : std::span(far.straight.shares).first(far.straight.count))
    if (share.arm == arm.index) put(outgoing_, eval(far.y.bsdf, wo, far.straight.wi, mask_of(share.event)) * far.straight.arriving, share.q, share.images);
  receive(to, outgoing_, factor);
}

void ViewTracer::put(Outgoing& light, const Color& radiance, StateId q, ImageSet images) {
  if (!is_finite(radiance)) return void(++counts.non_finite);
  if (images & picture) {
    light.picture += radiance;
    credit_outgoing(light, radiance, q);
  }
  for (ImageSet layers = images >> 1; layers; layers &= layers - 1) light.layers[static_cast<std::size_t>(std::countr_zero(layers))] += radiance;
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

void ViewTracer::find_clear(std::span<Connection> ways, const FarEnd& far) noexcept {
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

// Seen from y, how far apart do all lie that could share it? Asked of all, lit or not, so that it does not matter who found y.
float ViewTracer::least_cosine(const Seer& finder) const noexcept {
  std::optional<V3f> axis;
  float least = 1;
  for (const Seer& other : std::span(seers_).first(seer_count_)) {
    if (other.word != finder.word) continue;
    const V3f direction = V3f(finder.far.y.hit.position - other.v.hit.position).normalized();
    if (!axis) axis = direction;
    least = std::min(least, axis->dot(direction));
  }
  return least;
}

void ViewTracer::receive(const Seer& seer, const Outgoing& light, const Color& factor) noexcept {
  const Color whole = factor * seer.weight, radiance = light.picture * whole;
  if (!is_finite(radiance)) return void(++counts.non_finite);
  BundleMember& member = members_[seer.sample];
  add_up(member.sample.parts[static_cast<std::size_t>(Part::Indirect)], radiance);
  for (std::size_t l = 0; l < member.layers.size(); ++l) add_up(member.layers[l], light.layers[l] * whole);
  for (const auto& [edit, part] : light.taken) counts.of_edit(static_cast<int>(edit)).shown += luminance(part * whole) * bundle_[seer.sample].share;
}

}  // namespace sluice
