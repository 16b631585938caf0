// SPDX-License-Identifier: GPL-3.0-or-later
// Light that photons brought, at v, the view path's vertex with gathering lobes, beside direct light:
// caustics and edited light as photon density at v, and indirect light by gather segments (final gathering)
// to points y, with next-event estimation and photon density there (design §5).
#pragma once
#include <limits>
#include <span>
#include <vector>

#include "transport/photons/density.h"
#include "transport/photons/disks.h"
#include "transport/radii.h"
#include "transport/view/direct_light.h"
#include "transport/view/state_run.h"

namespace sluice {

class Gather {
 public:
  Gather(const ViewContext& context, PathSelection& selection, SampleSums& sums, DirectLight& direct)
      : context_(context),
        scene_(context.scene),
        effects_(context.effects),
        disk_bounds_(context.scene.camera(), context.scene.frame(), context.settings),
        selection_(selection),
        sums_(sums),
        direct_(direct),
        lamps_(max_lamp_hits(context.scene)) {}

  // Caustics and edited light: photons that arrived at v by a followed lobe or through an exit.
  void add_photons_at_v(const Sample& sample, const ViewPath& path, const Vertex& v);

  // All gather segments of a v that shares nothing.
  void gather_alone(Sample& sample, const ViewPath& path, const Vertex& v);

  // One segment from v's D and G lobes, straight on only: light through an exit is the density's at v.
  // Emitters that it meets are direct light found by lobe sampling, and go to the eye. `segments`: how many v
  // sends in the mean. False: it found no surface y, or none whose light counts.
  [[nodiscard]] bool send_segment(Sample& sample, const ViewPath& path, const Vertex& v,
                                  const Sampler& numbers, float segments, GatherSegment& found);
  // The light of y, to wherever it goes. `numbers`: those of the segment.
  template <class Sink>
  void collect_light_at_y(const ViewPath& path, const GatherSegment& segment, const Sampler& numbers,
                          const Sink& sink);

 private:
  [[nodiscard]] bool follow_segment(Sample& sample, const ViewPath& path, const LightSegment& segment,
                                    Ray ray, GatherSegment& found);
  void narrow(const Sample& sample, const ViewPath& path, const LightSegment& segment, double t_start,
              double t_end, const Vertex* far, LobeThroughputs& lobes);
  [[nodiscard]] std::span<const LampHit> lamps_between(const LightSegment& segment, double t_start,
                                                       double t_end);
  // Which photons a density takes at a vertex, and what it does with them.
  struct PhotonRule {
    const Vertex& vertex;
    double distance;  // from there to where the light goes
    const LobeGroup& group;
    bool sums;         // the picture's share is summed up first
    bool asks_states;  // for the sake of the sink
    int depth;         // D, S, G events that they may have
  };
  template <class Reach, class Out>
  void add_photons(const PhotonMap& map, const Reach& reach, const PhotonRule& rule, Out&& out);

  const ViewContext& context_;
  const Scene& scene_;
  const Effects& effects_;
  const DiskBounds disk_bounds_;
  PathSelection& selection_;
  SampleSums& sums_;
  DirectLight& direct_;
  // Scratch memory.
  std::vector<LampHit> lamps_;  // of one segment; room for all there are
  std::vector<Crossing> crossings_;
  PossibleTakers takers_;
  GatherSegment segment_;  // that shares nothing
};

// Photons at y, through one lobe of v.
template <class Sink>
struct ThroughLobe {
  const Sink& sink;
  const LobeThroughput& lobe;
  BlurredLight sum = {};

  void add_to_sum(Arrival, const BlurredLight& light) noexcept { sum += light; }
  void credit(const BlurredLight& light, StateId q) const { sink.credit(lobe, light, q); }
  void add(Arrival, const BlurredLight& light, const JoinResult& joined) const {
    sink.add(lobe, light, joined);
  }
  void note_state(StateId q) const { sink.note_state(q); }
  void finish(BlurredLight more) const { sink.add(lobe, more += sum, {picture}); }
};

template <class Reach, class Out>
void Gather::add_photons(const PhotonMap& map, const Reach& reach, const PhotonRule& rule, Out&& out) {
  Counts& counts = sums_.counts;
  ++counts.gathers;
  const LobeGroup& group = rule.group;
  const bool sums = rule.sums;
  const int depth = rule.depth;
  StateRun run(selection_, group.constraint, group.images, sums);
  const auto ask = [&](std::uint32_t q) {
    run.start(q);
    out.note_state(selection_.state_of_photon(q));
    return run.answer();
  };
  const auto found = [&](const Photon& photon, const Color& radiance, float share, bool is_summed) {
    if (photon.depth > depth) return void(++counts.depth_capped);
    if (run.is_new(photon)) ask(photon.q);
    const BlurredLight light(radiance, share * luminance(radiance));
    if (run.is_plain()) {
      ++counts.photons_gathered;
      return out.add_to_sum(photon.arrival, light);
    }
    const JoinResult& joined = sums_.counted(run.joined());
    if (!joined.images) return;
    counts.photons_gathered += !is_summed;
    if (sums && !is_summed) {
      out.add_to_sum(photon.arrival, light);
      out.credit(light, joined.q);
    }
    // what is left of the images goes on photon by photon
    const ImageSet left = sums ? joined.images & ~picture : joined.images;
    if (left) out.add(photon.arrival, light, {left, joined.q});
  };
  const SumRule sum_rule{sums, depth, selection_.asks_state(group.constraint) || rule.asks_states};
  const Sum sum =
      estimate_density(map, Receiver(rule.vertex, group.lobes, rule.distance), reach, sum_rule, ask, found);
  counts.photons_gathered += sum.photons;
  if (sums) out.finish({sum.radiance, sum.bias});
}

template <class Sink>
void Gather::collect_light_at_y(const ViewPath& path, const GatherSegment& segment, const Sampler& numbers,
                                const Sink& sink) {
  const Vertex& y = segment.y;
  direct_.next_event_at_gather_point(y, path.depth, numbers, segment.lobes, sink);
  const float radius = gather_radius(*context_.guide, segment.length, segment.pdf) * context_.radius_scale;
  const int events_left = context_.settings.max_depth - path.depth - 2;
  for (const LobeThroughput& lobe : segment.lobes) {
    if (sink.ignores(lobe)) continue;
    for (const LobeGroup& group : lobe_groups(selection_, scene_, lobe.constraint, y, lobe.images)) {
      const bool sums = path.hue < 0 && (group.images & picture);
      const bool asks_states = Sink::is_shared && effects_.light_edits;
      add_photons(context_.photons->at_y, radius, {y, segment.length, group, sums, asks_states, events_left},
                  ThroughLobe<Sink>{sink, lobe});
    }
  }
}

}  // namespace sluice
