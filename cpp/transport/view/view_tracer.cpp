// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/view_tracer.h"

#include <limits>

namespace sluice {

void ViewTracer::start_pass(const PassContext& context, const PhotonSet& photons) {
  context_.photons = &photons;
  context_.guide = &context.guide;
  context_.radius_scale = radius_scale(context.pass);
  sums_.counts.start(context_.scene.edits().size());
  selection_.start_pass(photons.states);
}

void ViewTracer::trace(std::span<const ViewSample> bundle) {
  selection_.start_bundle();
  sums_.start_bundle(bundle);
  shared_.start_bundle(bundle);
  for (std::size_t i = 0; i < bundle.size(); ++i) {
    Sample sample(bundle[i], i, bundle[i].key);
    trace_sample(sample);
  }
  shared_.gather();
}

void ViewTracer::trace_sample(Sample& sample) {
  sums_.start(sample);
  sums_.counts.view_paths += sample.asked.seeks != Seeks::Emission;
  branches_.start(camera_path(sample));
  while (!branches_.empty()) {
    ViewPath path = branches_.pop();
    const BranchClock clock(sums_.counts, path.last_edit);
    follow(sample, path);
  }
  sums_.finish(sample);
}

ViewPath ViewTracer::camera_path(const Sample& sample) {
  const Scene& scene = context_.scene;
  const V2f offset = scene.pixel_filter().sample_filter(sample.pair(Dimension::Filter));
  const V2f on_lens = scene.camera().has_lens() ? sample.pair(Dimension::Lens) : V2f(0);
  const float x = static_cast<float>(sample.asked.x) + 0.5f + offset.x,
              y = static_cast<float>(sample.asked.y) + 0.5f + offset.y;
  const Ray ray = scene.camera().generate(x, y, on_lens);
  ViewPath path{.origin = ray.origin, .direction = ray.direction, .t_max = ray.t_max};
  if (context_.effects.view_edits)
    path.state = selection_.states().next(StateTable::view_start, scene.edits().event_class(Event::E, -1));
  return path;
}

// One branch, from surface to surface.
void ViewTracer::follow(Sample& sample, ViewPath& path) {
  for (;;) {
    Vertex& v = shared_.candidate();
    if (!next_surface(sample, path, v)) return;
    sums_.record_first(sample, &v);
    direct_.add_surface_emission(sample, path, segment_of(path), v, whole_path(path));
    if (path.depth + 1 > context_.settings.max_depth)
      return void(sums_.counts.depth_capped += v.bsdf.count > 0);
    if (sample.asked.seeks != Seeks::Emission) collect_light(sample, path, v);
    if (!follow_specular(sample, path, v)) return;
  }
}

// Light that v sends towards the eye: direct light by all lobes but exact ones, the rest by D and G.
void ViewTracer::collect_light(Sample& sample, const ViewPath& path, const Vertex& v) {
  const bool shares = shared_.accept_candidate(sample, path);
  const SegmentPlan& segments = sample.asked.segments;
  const float mean_segments = shares ? segments.mean : static_cast<float>(segments.alone());
  if (context_.effects.direct) direct_.next_event_at_v(sample, path, v, mean_segments);
  gather_.add_photons_at_v(sample, path, v);
  if (!shares) gather_.gather_alone(sample, path, v);
}

// On to the next surface, through gates and what is transparent, collecting emission on the way. False: the
// path is over, or its branches go on.
bool ViewTracer::next_surface(Sample& sample, ViewPath& path, Vertex& vertex) {
  if (context_.effects.view_edits && !gates_.leave_exit(sample, path)) return false;
  const Scene& scene = context_.scene;
  for (int layer = 0; layer < max_alpha_layers; ++layer) {
    if (path.own_entry >= 0) {
      const SegmentEnd end = gates_.leave_own_entry(sample, path);
      if (end == SegmentEnd::Over) return false;
      if (end == SegmentEnd::Redirected) continue;
    }
    const auto hit =
        scene.intersect({path.origin, path.direction, path.t_max, path.clearance, path.is_camera});
    ++sums_.counts.rays;
    if (hit) make_vertex(scene, *hit, -path.direction, path.is_camera, Carries::Radiance, vertex);
    const SegmentEnd end = cross_gates(sample, path, hit ? hit->t : path.t_max, hit ? &vertex : nullptr);
    if (end == SegmentEnd::Over) return false;
    if (end == SegmentEnd::Redirected) continue;
    if (!hit) {
      sums_.record_first(sample, nullptr);
      if (!(path.is_camera && context_.settings.transparent_film))
        direct_.add_infinite_emission(sample, path, segment_of(path), whole_path(path));
      return false;
    }
    const float chance = vertex.pass_chance;
    if (chance < 1 && (chance == 0 || sample.random() >= chance)) {
      path.weight /= 1 - chance;
      return true;
    }
    path.weight *= vertex.bsdf.transparency / chance;
    path.origin = hit->position, path.clearance = hit->clearance;
    path.t_max -= hit->t;
  }
  ++sums_.counts.alpha_capped;
  return false;
}

// The gates of a segment, and the lamps between them, which are seen by the path as it is there.
SegmentEnd ViewTracer::cross_gates(Sample& sample, ViewPath& path, double t_end, const Vertex* far) {
  const Ray ray{path.origin, path.direction, t_end, path.clearance, path.is_camera};
  const auto count = static_cast<std::size_t>(intersect_lamps(context_.scene, ray, lamps_));
  const std::span lamps = std::span(lamps_).first(count);
  const auto add_lamps = [&](double until) {
    for (LampHit& lamp : lamps)
      if (lamp.t < until) {
        direct_.add_emission(sample, path, segment_of(path), {lamp.light, lamp.radiance}, whole_path(path));
        lamp.t = std::numeric_limits<double>::infinity();  // done
      }
  };
  return gates_.cross(sample, path, t_end, {far, lamps}, add_lamps);
}

// On by the followed lobes, a mirror or glass: by one of them, chosen by its albedo, while roulette lets it
// live. False: the path is over, or its branches go on.
bool ViewTracer::follow_specular(const Sample& sample, ViewPath& path, const Vertex& vertex) {
  const Bsdf& bsdf = vertex.bsdf;
  if (!(bsdf.events() & followed)) return false;
  if (path.depth == 0 && split_specular(sample, path, vertex)) return false;
  const V2f chance = sample.pair(Dimension::FollowedLobe, path.depth);  // and that of roulette
  const auto direction = sluice::sample(bsdf, vertex.point.wo, chance.x,
                                        sample.pair(Dimension::FollowedDirection, path.depth), followed);
  if (!direction) return false;
  path.throughput *= direction->weight;
  const float survival = survival_chance(path.throughput, path.depth + 1);
  if (!(chance.y < survival)) return false;
  path.weight /= survival, path.throughput /= survival;
  scatter(path, vertex, *direction);
  return !is_black(path.weight);
}

// At the first vertex by all of them, each a branch, if they are few and exact: both Fresnel branches of
// glass matter to the picture.
bool ViewTracer::split_specular(const Sample& sample, const ViewPath& path, const Vertex& vertex) {
  const Bsdf& bsdf = vertex.bsdf;
  int lobes = 0;
  bool all_delta = true;
  for (int i = 0; i < bsdf.count; ++i)
    if (bsdf.lobes[i].event == Event::S) ++lobes, all_delta = all_delta && bsdf.lobes[i].delta;
  if (lobes <= 1 || !all_delta || !branches_.budget.spend(lobes - 1)) return false;
  const V2f uv = sample.pair(Dimension::FollowedDirection, path.depth);
  for (int i = 0; i < bsdf.count; ++i) {
    if (bsdf.lobes[i].event != Event::S) continue;
    if (const auto direction = sample_lobe(bsdf, i, vertex.point.wo, uv))
      scatter(branches_.push(path), vertex, *direction);
  }
  return true;
}

void ViewTracer::scatter(ViewPath& path, const Vertex& vertex, const BsdfSample& direction) {
  // radiance scales by (η_to/η_from)², light flowing towards the eye
  path.weight *= direction.weight / square(direction.eta);
  path.origin = vertex.hit.position, path.clearance = vertex.hit.clearance, path.direction = direction.wi;
  path.t_max = std::numeric_limits<double>::infinity();
  path.lobe_pdf = direction.delta ? 0 : direction.pdf;
  path.lobe_origin = vertex.hit.position, path.lobe_normal = lit_side(vertex.bsdf);
  path.excluded_group = -1;
  path.is_camera = false;
  const Scene& scene = context_.scene;
  const EventClass event = scene.event_class(Event::S, vertex.hit);
  if (context_.effects.tracks_states)
    path.constraint = selection_.constraints().event(path.constraint, event);
  if (context_.effects.view_edits) path.state = selection_.states().next(path.state, event);
  path.signature = mix(path.signature, static_cast<std::uint64_t>(scene.entity(vertex.hit)) + 1);
  ++path.depth;
}

}  // namespace sluice
