// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/gather.h"

#include <algorithm>
#include <limits>

namespace sluice {
namespace {

// Photons at v, to the eye: parts of the picture by how they arrived.
struct ByArrival {
  SampleSums& sums;
  const Sample& sample;
  const ViewPath& path;
  BlurredLight caustics = {}, edited = {};

  void add_to_sum(Arrival arrival, const BlurredLight& light) noexcept {
    (is_edited(arrival) ? edited : caustics) += light;
  }
  void credit(const BlurredLight& light, StateId q) const noexcept {
    sums.credit(sample, q, light.changed_to(light.radiance * path.weight));
  }
  void add(Arrival arrival, const BlurredLight& light, const JoinResult& joined) const noexcept {
    sums.add(is_edited(arrival) ? Part::Edited : Part::Caustics, sample, path, light, joined);
  }
  void note_state(StateId) const noexcept {}
  // `more` was summed without being handed over; FlatSum leaves out photons that met a gate, so it is no
  // edited light.
  void finish(BlurredLight more) const noexcept {
    sums.add(Part::Caustics, sample, path, more += caustics, {picture});
    sums.add(Part::Edited, sample, path, edited, {picture});
  }
};

}  // namespace

void Gather::add_photons_at_v(const Sample& sample, const ViewPath& path, const Vertex& v) {
  const PhotonMap& map = context_.photons->at_v;
  if (map.size() == 0 || !(v.bsdf.events() & gathering)) return;
  const Reaches reaches = disk_bounds_.around(V3f(v.hit.position), context_.radius_scale);
  const int events_left = context_.settings.max_depth - path.depth - 1;
  for (const LobeGroup& group : lobe_groups(selection_, scene_, path.constraint, v, all_images)) {
    const bool sums = path.hue < 0 && (group.images & picture);
    add_photons(map, reaches, {v, infinity, group, sums, false, events_left}, ByArrival{sums_, sample, path});
  }
}

void Gather::gather_alone(Sample& sample, const ViewPath& path, const Vertex& v) {
  const bool may_find = effects_.indirect || (effects_.direct && effects_.lobes_find_lights);
  if (!may_find || !(v.bsdf.events() & gathering)) return;
  const std::uint32_t segments = sample.asked.segments.alone();
  for (std::uint32_t i = 0; i < segments; ++i) {
    const Sampler numbers = sample.asked.sampler.part(i, segments);
    if (send_segment(sample, path, v, numbers, static_cast<float>(segments), segment_))
      collect_light_at_y(path, segment_, numbers, ToEye{sums_, sample, path});
  }
}

bool Gather::send_segment(Sample& sample, const ViewPath& path, const Vertex& v, const Sampler& numbers,
                          float segments, GatherSegment& found) {
  const float u = v.bsdf.count > 1 ? numbers.first(pair_of(Dimension::GatherLobe, path.depth)) : 0;
  const V2f uv = numbers.pair(pair_of(Dimension::GatherDirection, path.depth));
  const auto direction = sluice::sample(v.bsdf, v.point.wo, u, uv, gathering);
  if (!direction || !(direction->pdf > 0)) return false;
  found.pdf = direction->pdf;
  found.lobes = lobe_throughputs(selection_, scene_, path, v, *direction);
  for (LobeThroughput& lobe : found.lobes) lobe.weight /= segments;
  const LightSegment segment{v.hit.position, direction->wi, lit_side(v.bsdf), direction->pdf * segments};
  if (!follow_segment(sample, path, segment, ray_from(v.hit, direction->wi), found)) return false;
  if (!effects_.indirect) return false;
  if (path.depth + 2 > context_.settings.max_depth) {
    sums_.counts.depth_capped += found.y.bsdf.count > 0;
    return false;
  }
  return true;
}

// Through what is transparent to a surface y; lights on the way and there are direct light. False: there is
// no such surface.
bool Gather::follow_segment(Sample& sample, const ViewPath& path, const LightSegment& segment, Ray ray,
                            GatherSegment& found) {
  Vertex& y = found.y;
  found.length = 0;
  for (int layer = 0; layer < max_alpha_layers; ++layer) {
    const auto hit = scene_.intersect(ray);
    ++sums_.counts.rays;
    if (!hit) {
      narrow(sample, path, segment, found.length, ray.t_max, nullptr, found.lobes);
      direct_.add_infinite_emission(sample, path, segment, found.lobes);
      return false;
    }
    make_vertex(scene_, *hit, -segment.direction, false, Carries::Radiance, y);
    narrow(sample, path, segment, found.length, found.length + hit->t, &y, found.lobes);
    found.length += hit->t;
    const float pass = y.pass_chance;
    const bool arrived = pass < 1 && (pass == 0 || sample.random() >= pass);
    for (LobeThroughput& lobe : found.lobes)
      lobe.weight *= arrived ? Color(1 / (1 - pass)) : y.bsdf.transparency / pass;
    if (arrived) {
      direct_.add_surface_emission(sample, path, segment, y, found.lobes);
      const Material& material = scene_.material(y.hit);
      found.may_share = layer == 0 && (material.is_opaque() || material.is_constant()) && pass == 0;
      return true;
    }
    ray = ray_from(*hit, segment.direction);
  }
  ++sums_.counts.alpha_capped;
  return false;
}

// By distance.
std::span<const LampHit> Gather::lamps_between(const LightSegment& segment, double t_start, double t_end) {
  if (!effects_.direct) return {};
  const auto begin = lamps_.begin();
  auto end = begin + intersect_lamps(scene_, {segment.origin, segment.direction, t_end}, lamps_);
  end = std::remove_if(begin, end, [&](const LampHit& l) { return l.t <= t_start; });
  std::sort(begin, end, [](const LampHit& a, const LampHit& b) { return a.t < b.t; });
  return {begin, end};
}

// One piece of the gather segment, from length t_start to t_end: C narrows at every entry that it passes, and
// lamps on it are seen with C as it is there.
void Gather::narrow(const Sample& sample, const ViewPath& path, const LightSegment& segment, double t_start,
                    double t_end, const Vertex* far, LobeThroughputs& lobes) {
  const std::span lamps = lamps_between(segment, t_start, t_end);
  auto next_lamp = lamps.begin();
  const auto collect_lamps = [&](double until) {
    for (; next_lamp != lamps.end() && next_lamp->t < until; ++next_lamp)
      direct_.add_emission(sample, path, segment, {next_lamp->light, next_lamp->radiance}, lobes);
  };
  const SegmentSources sources{far, lamps};
  const EditSet takers = effects_.light_edits && may_be_taken(scene_, sources)
                             ? takers_.find(scene_, sources, gathering)
                             : EditSet();
  if (!is_empty(takers)) {
    ++sums_.counts.edit_queries;
    scene_.edits().entries_crossed(Side::Light, {segment.origin, V3d(segment.direction), t_start, t_end, -1},
                                   takers, crossings_);
    for (const Crossing& crossing : crossings_) {
      collect_lamps(crossing.t);
      for (LobeThroughput& lobe : lobes)
        lobe.constraint = selection_.constraints().passed(lobe.constraint, crossing.edit);
    }
  }
  collect_lamps(std::numeric_limits<double>::infinity());
}

}  // namespace sluice
