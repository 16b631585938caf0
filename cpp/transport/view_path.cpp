// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view_path.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "edit/hue.h"
#include "transport/radii.h"

namespace sluice {
namespace {

constexpr float far_away = 1e10f;  // Blender's depth of nothing

}  // namespace

void ViewTracer::start_pass(const PassContext& context, const PhotonSet& photons) {
  photons_ = &photons;
  guide_ = &context.guide;
  radius_scale_ = radius_scale(context.pass);
  counts.start(scene_.edits().size());
  selection_.start_pass(photons.states);
}

void ViewTracer::trace(std::span<const ViewSample> bundle) {
  bundle_ = bundle, seer_count_ = 0;
  selection_.start_bundle();
  for (at_ = 0; at_ < bundle.size(); ++at_) trace_sample();
  gather_together();
}

void ViewTracer::trace_sample() {
  const ViewSample& asked = bundle_[at_];
  sampler_ = asked.sampler, key_ = asked.key, draws_ = 0;
  BundleMember& member = self();
  member.sample = {}, member.light_variance = V3d(0), recorded_ = asked.seeks == Seeks::Emission;
  member.layers.assign(scene_.edits().layers().size(), Color(0));
  hues_.clear();
  const V2f offset = scene_.pixel_filter().sample_filter(sampler_.pair(0));
  const V2f on_lens = scene_.camera().has_lens() ? sampler_.pair(1) : V2f(0);
  const float x = static_cast<float>(asked.x) + 0.5f + offset.x,
              y = static_cast<float>(asked.y) + 0.5f + offset.y;
  const Ray camera = scene_.camera().generate(x, y, on_lens);
  ViewPath path{.origin = camera.origin, .direction = camera.direction, .t_max = camera.t_max};
  if (effects_.view_edits)
    path.state = selection_.states().next(StateTable::view_start, scene_.edits().event_class(Event::E, -1));
  counts.view_paths += asked.seeks != Seeks::Emission;
  branches_[0] = path;
  branch_count_ = 1, budget_ = {};
  while (branch_count_ > 0) {
    ViewPath branch = branches_[--branch_count_];
    const BranchClock clock(counts, branch.last_edit);
    follow(branch);
  }
  // an edit took the path: black, but no hole in the film
  if (!recorded_) member.sample.alpha = 1, member.sample.depth = far_away;
}

// The sum of numbers that are finite need not be. It is capped so that the sum of all parts of all samples of
// a pixel is.
void ViewTracer::add_up(Color& sum, const Color& radiance) noexcept {
  constexpr float most = std::numeric_limits<float>::max() / (8 * SampleMap::most);
  static_assert(part_count <= 8);
  sum += radiance;
  if (max_component(sum) < most) return;
  ++counts.non_finite;
  for (int c = 0; c < 3; ++c) sum[c] = std::min(sum[c], most);
}

// Adds light that reaches the path's far end, as the eye sees it. H acts on the colour of one path, so the
// gates' hues are applied to each contribution on its own, from the light's end to the eye's (design §4).
void ViewTracer::add(Part part, const ViewPath& path, Color radiance, JoinResult to) noexcept {
  radiance *= path.weight;
  for (int step = path.hue; step >= 0; step = hues_[static_cast<std::size_t>(step)].towards_eye)
    radiance = apply_hue(radiance, hues_[static_cast<std::size_t>(step)].angle) *
               hues_[static_cast<std::size_t>(step)].factor;
  if (!is_finite(radiance)) {
    ++counts.non_finite;
    return;
  }
  if (to.images & picture) {
    add_up(self().sample.parts[static_cast<std::size_t>(part)], radiance);
    credit_radiance(to.q, radiance);
  }
  for (ImageSet layers = to.images >> 1; layers; layers &= layers - 1)
    add_up(self().layers[static_cast<std::size_t>(std::countr_zero(layers))], radiance);
}

void ViewTracer::follow(ViewPath& path) {
  for (;;) {
    const Vertex& v = seers_[seer_count_].v;
    if (!next_vertex(path, seers_[seer_count_].v)) return;
    record_first(&v);
    surface_emission(path, segment_of(path), v, arm_of(path));
    if (path.depth + 1 > settings_.max_depth) return void(counts.depth_capped += v.bsdf.count > 0);
    if (bundle_[at_].seeks != Seeks::Emission) collect_light(path, v);
    if (!extend(path, v)) return;
  }
}

// By the estimators of design §5, at v.
void ViewTracer::collect_light(const ViewPath& path, const Vertex& v) {
  const bool shares = join_bundle(path);
  const GatherSegments& segments = bundle_[at_].segments;
  if (effects_.direct) direct_light(path, v, shares ? segments.mean : static_cast<float>(segments.alone()));
  close_density(path, v);
  if (!shares) gather_alone(path, v);
}

// Depth, Normal, Albedo, alpha: of the first thing the sample meets; null: the world.
void ViewTracer::record_first(const Vertex* vertex) noexcept {
  if (recorded_) return;
  recorded_ = true;
  PixelSample& sample = self().sample;
  sample.alpha = vertex || !settings_.transparent_film ? 1 : 0;
  sample.depth = vertex ? static_cast<float>(scene_.camera().depth(vertex->hit.position)) : far_away;
  if (!vertex) return;
  sample.normal = vertex->point.ns;
  sample.albedo = albedo(vertex->bsdf, vertex->point.wo, any_lobe);
}

// On to the next surface, collecting emission on the way. False: the path is over, or goes on in branches_.
bool ViewTracer::next_vertex(ViewPath& path, Vertex& vertex) {
  if (effects_.view_edits && !can_leave(path)) return false;
  const Edits& edits = scene_.edits();
  for (int layer = 0; layer < max_alpha_layers; ++layer) {
    if (path.own_entry >= 0) {
      edits.crossings_at(Side::Light, edits[path.own_entry].entry.group, path.origin,
                         edits.takers(Side::Light), crossings_);
      const Went went = cross_plane(path, crossings_);
      if (went == Went::Nowhere) return false;
      if (went == Went::Elsewhere) continue;
    }
    const Ray ray{path.origin, path.direction, path.t_max, path.clearance, path.is_camera};
    const auto hit = scene_.intersect(ray);
    ++counts.rays;
    const double t_end = hit ? hit->t : path.t_max;
    const std::span lamps(
        lamps_.data(),
        static_cast<std::size_t>(intersect_lamps(
            scene_, {path.origin, path.direction, t_end, path.clearance, path.is_camera}, lamps_)));
    if (hit) make_vertex(scene_, *hit, -path.direction, path.is_camera, Carries::Radiance, vertex);
    const Vertex* far = hit ? &vertex : nullptr;
    if (const Asks asks = asks_of(path, far, lamps); asks.any() || !lamps.empty()) {
      const Went went = cross_gates(path, asks, t_end, far, lamps);
      if (went == Went::Nowhere) return false;
      if (went == Went::Elsewhere) continue;
    }
    if (!hit) {
      record_first(nullptr);
      if (!(path.is_camera && settings_.transparent_film)) far_emission(path, segment_of(path), arm_of(path));
      return false;
    }
    const float chance = vertex.pass_chance;
    if (chance < 1 && (chance == 0 || random() >= chance)) {
      path.weight /= 1 - chance;
      return true;
    }
    path.weight *= vertex.bsdf.transparency / chance;
    path.origin = hit->position, path.clearance = hit->clearance;
    path.t_max -= hit->t;
  }
  ++counts.alpha_capped;
  return false;
}

// On by the followed lobes: a mirror, glass. At the first vertex all of them, if they are few and exact, as
// both Fresnel branches of glass matter to the picture; later one, by its albedo.
bool ViewTracer::extend(ViewPath& path, const Vertex& vertex) {
  const Bsdf& bsdf = vertex.bsdf;
  if (!(bsdf.events() & followed)) return false;
  int lobes = 0;
  bool all_delta = true;
  for (int i = 0; i < bsdf.count; ++i)
    if (bsdf.lobes[i].event == Event::S) ++lobes, all_delta = all_delta && bsdf.lobes[i].delta;
  if (path.depth == 0 && lobes > 1 && all_delta && budget_.spend(lobes - 1)) {
    for (int i = 0; i < bsdf.count; ++i) {
      if (bsdf.lobes[i].event != Event::S) continue;
      if (const auto sample = sample_lobe(bsdf, i, vertex.point.wo, pair(path, 1))) {
        branches_[branch_count_] = path;
        take_lobe(branches_[branch_count_++], vertex, *sample);
      }
    }
    return false;
  }
  const auto sample = sluice::sample(bsdf, vertex.point.wo, pair(path, 0).x, pair(path, 1), followed);
  if (!sample) return false;
  path.throughput *= sample->weight;
  const float survival = survival_chance(path.throughput, path.depth + 1);
  if (!(pair(path, 0).y < survival)) return false;
  path.weight /= survival, path.throughput /= survival;
  take_lobe(path, vertex, *sample);
  return !is_black(path.weight);
}

void ViewTracer::take_lobe(ViewPath& path, const Vertex& vertex, const BsdfSample& sample) {
  // radiance scales by (η_to/η_from)², light flowing towards the eye
  path.weight *= sample.weight / square(sample.eta);
  path.origin = vertex.hit.position, path.clearance = vertex.hit.clearance, path.direction = sample.wi;
  path.t_max = std::numeric_limits<double>::infinity();
  path.lobe_pdf = sample.delta ? 0 : sample.pdf;
  path.lobe_origin = vertex.hit.position, path.lobe_normal = lit_side(vertex.bsdf);
  path.excluded_group = -1;
  path.is_camera = false;
  const EventClass event = scene_.event_class(Event::S, vertex.hit);
  if (effects_.words) path.joins = selection_.constraints().event(path.joins, event);
  if (effects_.view_edits) path.state = selection_.states().next(path.state, event);
  path.word = mix(path.word, static_cast<std::uint64_t>(scene_.entity(vertex.hit)) + 1);
  ++path.depth;
}

}  // namespace sluice
