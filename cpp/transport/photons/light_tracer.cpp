// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/photons/light_tracer.h"

#include "edit/hue.h"
#include "transport/photons/arrival_recorder.h"
#include "transport/photons/photon_dimensions.h"

namespace sluice {
namespace {

constexpr float max_adjoint = 4;  // Veach's factor is unbounded at grazing shading normals (numerics R11)

}  // namespace

template <class Observer>
void LightTracer<Observer>::trace(const EmittedPhoton& photon, float scale, const Sampler& sampler,
                                  std::uint64_t key, std::vector<Photon>& out) {
  key_ = key, draws_ = 0;
  light_ = photon.light, emitter_ = photon.emitter;
  Path start{.origin = photon.origin,
             .direction = photon.direction,
             .clearance = photon.clearance,
             .flux = photon.flux * scale};
  if (photon.from_infinity) start.t_min = -std::numeric_limits<double>::infinity();
  if (effects_.tracks_states)
    start.q = states_.next(StateTable::light_start,
                           scene_.edits().event_class(Event::L, scene_.light_entity(light_)));
  start.word = observer.started(light_);
  counts.ledger.emitted += luminance(start.flux);
  ++counts.photon_paths;
  branches_[0] = start;
  branch_count_ = 1, budget_ = {}, has_split_ = false;
  Vertex vertex;
  while (branch_count_ > 0) {
    Path path = branches_[--branch_count_];
    const BranchClock clock(counts, path.last_edit);
    if (is_watched() && (path.at_edit >= 0 || path.q == StateTable::dead) && !leave_exit(path)) [[unlikely]]
      continue;
    while (next_vertex(path, vertex)) {
      store(path, vertex, out);
      if (!scatter(path, vertex, sampler)) break;
    }
  }
}

// Paper §4: on to the next surface, through the gates on the way. False: the path is over, or goes on in
// branches_.
template <class Observer>
bool LightTracer<Observer>::next_vertex(Path& path, Vertex& vertex) noexcept {
  for (int layer = 0; layer < max_alpha_layers; ++layer) {
    const auto hit = scene_.intersect(
        {path.origin, path.direction, std::numeric_limits<double>::infinity(), path.clearance});
    ++counts.rays;
    if (is_watched() && asks(path)) [[unlikely]]
      if (meet_entries(path, hit ? hit->t : std::numeric_limits<double>::infinity())) return false;
    if (!hit) {
      counts.ledger.escaped += luminance(path.flux);
      return false;
    }
    make_vertex(scene_, *hit, -path.direction, false, Carries::Flux, vertex);
    const float chance = vertex.pass_chance;
    if (chance == 0) return true;
    const double before = luminance(path.flux), straight = luminance(path.flux * vertex.bsdf.transparency);
    // scatter() books all that the lobes of this vertex do not scatter as absorbed, `straight` too, which
    // this choice may still send on: so it is taken off that account here.
    if (chance < 1) {
      counts.ledger.absorbed -= straight;
      const bool stays = random() >= chance;
      path.flux = stays ? path.flux / (1 - chance) : path.flux * vertex.bsdf.transparency / chance;
      counts.ledger.sampling += luminance(path.flux) - before - straight;
      if (stays) return true;
    } else {
      counts.ledger.absorbed += before - straight;
      path.flux *= vertex.bsdf.transparency;
    }
    path.origin = hit->position, path.clearance = hit->clearance, path.t_min = 0;
  }
  counts.ledger.capped += luminance(path.flux);
  ++counts.alpha_capped;
  return false;
}

// No memory left for what must be remembered of it.
template <class Observer>
bool LightTracer<Observer>::drop_if_dead(const Path& path) noexcept {
  if (path.q != StateTable::dead || !effects_.light_edits) return false;
  counts.ledger.capped += luminance(path.flux);
  ++counts.states_capped;
  return true;
}

// Where a branch starts: an entry in the plane of its exit may take it.
template <class Observer>
bool LightTracer<Observer>::leave_exit(Path& path) noexcept {
  if (drop_if_dead(path)) return false;
  if (path.at_edit < 0) return true;
  const auto crossing =
      scene_.edits().first_taken_at_exit(states_, path.q, path.at_edit, path.at_exit, path.origin);
  observer.left_exit(path, crossing);
  path.at_edit = -1;
  if (crossing) meet_light_edit(path, *crossing);
  return !crossing;
}

// Does an entry on the segment take it?
template <class Observer>
bool LightTracer<Observer>::meet_entries(const Path& path, double t_end) noexcept {
  const Segment segment{path.origin, V3d(path.direction), path.t_min, t_end, path.excluded_group};
  std::optional<Crossing> crossing;
  if (!states_.takes_none(path.q)) {
    ++counts.edit_queries;
    crossing = scene_.edits().first_taken(states_, path.q, segment);
  }
  observer.crossed(path, segment, crossing);
  if (crossing) meet_light_edit(path, *crossing);
  return crossing.has_value();
}

// The entry takes the path: T of paper §4 makes one copy per exit (none: absorbed). Above the split budget
// one copy stands for all.
template <class Observer>
void LightTracer<Observer>::meet_light_edit(const Path& path, const Crossing& crossing) noexcept {
  EditCounts& count = counts.of_edit(crossing.edit);
  const double energy = luminance(path.flux);
  ++count.matched;
  count.energy_in += energy;
  if (states_.at_cap(path.q)) {
    ++count.capped, ++counts.gates_capped;
    counts.ledger.capped += energy;
    return;
  }
  double sent = 0, expected = 0;
  const auto push = [&](int exit, float weight) { sent += push_light_copy(path, crossing, exit, weight); };
  if (split_path(scene_.edits(), crossing, budget_, [this] { return random(); }, push)) {
    expected = sent;
  } else {
    ++counts.split_capped;
    ExitSplit(scene_.edits(), crossing).for_each([&](int exit, float weight) {
      expected += copy_of(path, crossing, exit, weight).energy;
    });
    counts.ledger.sampling += sent - expected;
  }
  const double gained = expected - energy;
  (gained > 0 ? counts.ledger.added : counts.ledger.removed) += std::abs(gained);
}

// A copy that cannot go on counts as the light that came in times the weight of its exit, as its gain is not
// known.
template <class Observer>
typename LightTracer<Observer>::Copy LightTracer<Observer>::copy_of(const Path& path,
                                                                    const Crossing& crossing, int exit,
                                                                    float weight) const noexcept {
  Copy copy{.passage = scene_.edits().forward(crossing.edit, exit, crossing.uv, path.direction),
            .energy = static_cast<double>(luminance(path.flux)) * weight};
  if (!copy.passage) return copy;
  copy.flux = apply_hue(path.flux, copy.passage->hue) * (copy.passage->gain * weight);
  if (is_finite(copy.flux)) copy.energy = luminance(copy.flux);
  return copy;
}

// Returns its energy, sent on or lost.
template <class Observer>
double LightTracer<Observer>::push_light_copy(const Path& path, const Crossing& crossing, int exit,
                                              float weight) noexcept {
  const auto [passage, flux, energy] = copy_of(path, crossing, exit, weight);
  if (!passage || !is_finite(flux)) {
    ++(passage ? counts.non_finite : counts.grazing_dropped);
    counts.ledger.capped += energy;
    return energy;
  }
  Path& copy = branches_[branch_count_] = path;
  copy.flux = flux;
  copy.origin = passage->position, copy.direction = passage->direction, copy.clearance = V3f(0);
  copy.t_min = 0;
  copy.q = states_.through(path.q, crossing.edit);
  copy.last = Event::F;
  copy.word = observer.moved(path.word, crossing.edit);
  copy.excluded_group = passage->group;
  copy.at_edit = copy.last_edit = crossing.edit, copy.at_exit = exit;
  ++branch_count_;
  EditCounts& count = counts.of_edit(crossing.edit);
  ++count.moved;
  count.energy_out += energy;
  return energy;
}

// Does some estimator read a photon here? Straight light at y is next-event estimation's, but for lights
// hidden or too near for it.
template <class Observer>
bool LightTracer<Observer>::is_read(const Path& path, Arrival arrival, const Vertex& vertex) const noexcept {
  if (!(effects_.stored_arrivals & bit_of(arrival)) || !(vertex.bsdf.events() & gathering)) return false;
  if (arrival != Arrival::Direct || (trust && trust->is_hidden(light_))) return true;
  return is_too_near(scene_.lights()[static_cast<std::size_t>(light_)],
                     pdf_direct(scene_, light_, vertex.hit.position, -path.direction, &emitter_));
}

template <class Observer>
void LightTracer<Observer>::store(const Path& path, const Vertex& vertex, std::vector<Photon>& out) {
  const Arrival arrival = arrival_of(path.last, path.was_diffuse);
  if (!is_read(path, arrival, vertex)) return;
  Photon photon;
  photon.position = V3f(vertex.hit.position);
  photon.wi = pack_direction(-path.direction);
  photon.normal = pack_direction(vertex.point.ns);
  photon.set_flux(path.flux);
  if (shared_states_) {
    std::uint32_t& number = states_.note(path.q);
    if (number == PhotonStates::none) [[unlikely]] {  // the first photon in that state
      number = shared_states_->number(states_.content(path.q));
      if (number == PhotonStates::none) return void(++counts.states_capped);
    }
    photon.q = number;
    photon.met_gate = states_.gates(path.q) > 0;
  }
  photon.arrival = arrival;
  photon.depth = static_cast<std::uint8_t>(std::min(path.depth, 255));
  out.push_back(photon);
  ++counts.photons_stored;
}

// On by one lobe, with the weight of that lobe. False: absorbed, or on in branches_.
template <class Observer>
bool LightTracer<Observer>::scatter(Path& path, const Vertex& vertex, const Sampler& sampler) noexcept {
  const Bsdf& bsdf = vertex.bsdf;
  const double before = luminance(path.flux);
  if (path.depth + 1 >= settings_.max_depth) {  // the next vertex would have no event left
    counts.ledger.capped += before;
    ++counts.depth_capped;
    return false;
  }
  const double expected = luminance(path.flux * albedo(bsdf, vertex.point.wo, any_lobe));
  if (!std::isfinite(expected)) {
    counts.ledger.capped += before;
    ++counts.non_finite;
    return false;
  }
  counts.ledger.absorbed += before - expected;
  counts.ledger.sampling -= expected;  // what goes on is added
  const auto pair = [&](PhotonDimension d) { return pair_of(sampler, d, path.depth); };
  if (path.depth == 0 && !has_split_ && bsdf.count > 1 && bsdf.is_exact()) {
    // Both ways of the first glass: else the few photons that it mirrors would be bright ones. Throughput
    // stays as it is, or roulette would make them so again.
    has_split_ = true;
    for (int lobe = 0; lobe < bsdf.count; ++lobe) {
      branches_[branch_count_] = path;
      if (const auto sample = sample_lobe(bsdf, lobe, vertex.point.wo, pair(PhotonDimension::LobeDirection)))
        if (take_lobe(branches_[branch_count_], vertex, lobe, *sample, sample->weight)) ++branch_count_;
    }
    return false;
  }

  float total = 0;
  for (int i = 0; i < bsdf.count; ++i) total += bsdf.lobes[i].choice;
  if (!(total > 0)) return false;
  const V2f u = pair(PhotonDimension::LobeAndRoulette);
  float target = u.x * total;
  int lobe = 0;
  while (lobe + 1 < bsdf.count && target >= bsdf.lobes[lobe].choice) target -= bsdf.lobes[lobe++].choice;
  const auto sample = sample_lobe(bsdf, lobe, vertex.point.wo, pair(PhotonDimension::LobeDirection));
  if (!sample) return false;
  const Color weight = sample->weight * (total / bsdf.lobes[lobe].choice);
  path.throughput *= weight;
  const float survival = survival_chance(path.throughput, path.depth + 1);
  if (!(u.y < survival)) return false;
  path.throughput /= survival;
  return take_lobe(path, vertex, lobe, *sample, weight / survival);
}

// Goes on by the lobe. False: nothing is left.
template <class Observer>
bool LightTracer<Observer>::take_lobe(Path& path, const Vertex& vertex, int lobe, const BsdfSample& sample,
                                      const Color& weight) noexcept {
  const float factor = adjoint_factor(vertex.bsdf, lobe, vertex.point.wo, sample.wi),
              clamped = std::min(factor, max_adjoint);
  const double before = luminance(path.flux);
  path.flux *= weight;
  const double scattered = luminance(path.flux);
  path.flux *= clamped;
  if (!is_finite(path.flux)) {
    counts.ledger.capped += before, counts.ledger.sampling += before;
    ++counts.non_finite;
    return false;
  }
  counts.ledger.clamped += scattered * (factor - clamped);
  counts.ledger.sampling += scattered * factor;
  if (clamped < factor) ++counts.adjoint_clamped;
  if (is_black(path.flux)) return false;

  path.last = sample.event;
  path.was_diffuse = path.was_diffuse || path.last == Event::D;
  ++path.depth;
  if (is_watched()) {
    path.q = states_.next(path.q, scene_.event_class(path.last, vertex.hit));
    path.word = observer.scattered(path.word, path.last, vertex.hit);
    if (path.q == StateTable::dead && drop_if_dead(path)) [[unlikely]]
      return false;
  }
  path.origin = vertex.hit.position, path.clearance = vertex.hit.clearance, path.t_min = 0;
  path.direction = sample.wi;
  path.excluded_group = -1;
  return true;
}

template class LightTracer<Unobserved>;
template class LightTracer<ArrivalRecorder>;

}  // namespace sluice
