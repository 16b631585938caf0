// SPDX-License-Identifier: GPL-3.0-or-later
// Light that photons brought, at v, the view path's vertex with gathering lobes, beside direct light:
// caustics and edited light as photon density at v, and indirect light by gather segments (final gathering)
// to points y, with next-event estimation and photon density there (design §5).
#pragma once
#include <optional>
#include <vector>

#include "transport/density.h"
#include "transport/disks.h"
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
        lamps_(most_lamp_hits(context.scene)) {}

  // Caustics and edited light: photons that arrived at v by a followed lobe or through an exit.
  void add_caustics(const Sample& sample, const ViewPath& path, const Vertex& v);

  // All gather segments of a v that shares nothing.
  void gather_alone(Sample& sample, const ViewPath& path, const Vertex& v);

  // What a gather segment found.
  struct Found {
    float pdf;              // of its direction (1/sr)
    LobeThroughputs lobes;  // of v
    double length;
    bool may_share;  // no alpha on the way or at y, of which a shadow ray cannot tell
  };
  // One segment from v's D and G lobes, straight on only: light through an exit is the density's at v.
  // Emitters that it meets are direct light found by lobe sampling, and go to the eye. `segments`: how many v
  // sends in the mean. Empty: it found no surface y, or none whose light counts.
  [[nodiscard]] std::optional<Found> send_segment(Sample& sample, const ViewPath& path, const Vertex& v,
                                                  const Sampler& numbers, float segments, Vertex& y);
  // The light of y, to wherever it goes. `lobes`: of v.
  template <class Sink>
  void collect_light(const ViewPath& path, const Vertex& y, const Found& found, const LobeThroughputs& lobes,
                     const Sampler& numbers, const Sink& sink);

 private:
  [[nodiscard]] bool follow_segment(Sample& sample, const ViewPath& path, const LightSegment& segment,
                                    Ray ray, Found& found, Vertex& y);
  void narrow(const Sample& sample, const ViewPath& path, const LightSegment& segment, double t_start,
              double t_end, const Vertex* far, LobeThroughputs& lobes);
  [[nodiscard]] std::span<const LampHit> lamps_between(const LightSegment& segment, double t_start,
                                                       double t_end);
  // What photon densities do with photons of a group of lobes.
  struct PhotonRule {
    const LobeGroup& group;
    bool sums;         // the picture's share is summed up first
    bool asks_states;  // for the sake of the sink
    int depth;         // D, S, G events that they may have
  };
  template <class Reach, class Out>
  void add_photons(const PhotonMap& map, const Receiver& receiver, const Reach& reach, const PhotonRule& rule,
                   Out&& out);

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
  EntryTakers takers_;
  Vertex y_;  // of a segment that shares nothing; too large to copy about
};

// Photons at y, through one lobe of v.
template <class Sink>
struct ThroughLobe {
  const Sink& sink;
  const LobeThroughput& lobe;
  Color sum{0};

  void add_to_sum(Arrival, const Color& radiance) noexcept { sum += radiance; }
  void credit(const Color& radiance, StateId q) const { sink.credit(lobe, radiance, q); }
  void add(Arrival, const Color& radiance, const JoinResult& joined) const {
    sink.add(lobe, radiance, joined);
  }
  void note_state(StateId q) const { sink.note_state(q); }
  void finish(const Color& more) const { sink.add(lobe, sum + more, {picture}); }
};

template <class Reach, class Out>
void Gather::add_photons(const PhotonMap& map, const Receiver& receiver, const Reach& reach,
                         const PhotonRule& rule, Out&& out) {
  Counts& counts = sums_.counts;
  ++counts.gathers;
  const auto& [group, sums, asks_states, depth] = rule;
  StateRun run(selection_, group.constraint, group.images, sums);
  const auto ask = [&](std::uint32_t q) {
    run.start(q);
    out.note_state(selection_.state_of_photon(q));
    return run.answer();
  };
  const auto found = [&](const Photon& photon, const Color& radiance, bool is_summed) {
    if (photon.depth > depth) return void(++counts.depth_capped);
    if (run.is_new(photon)) ask(photon.q);
    if (run.is_plain()) {
      ++counts.photons_gathered;
      return out.add_to_sum(photon.arrival, radiance);
    }
    JoinResult joined = sums_.counted(run.joined());
    if (!joined.images) return;
    counts.photons_gathered += !is_summed;
    if (sums && !is_summed) {
      out.add_to_sum(photon.arrival, radiance);
      out.credit(radiance, joined.q);
    }
    if (sums) joined.images &= ~picture;
    if (joined.images) out.add(photon.arrival, radiance, joined);
  };
  const SumRule sum_rule{sums, depth, selection_.asks_state(group.constraint) || asks_states};
  const Sum sum = estimate_density(map, receiver, reach, sum_rule, ask, found);
  counts.photons_gathered += sum.photons;
  if (sums) out.finish(sum.radiance);
}

template <class Sink>
void Gather::collect_light(const ViewPath& path, const Vertex& y, const Found& found,
                           const LobeThroughputs& lobes, const Sampler& numbers, const Sink& sink) {
  direct_.next_event_at_gather_point(y, path.depth, numbers, lobes, sink);
  const float radius = gather_radius(*context_.guide, found.length, found.pdf) * context_.radius_scale;
  const int events_left = context_.settings.max_depth - path.depth - 2;
  for (const LobeThroughput& lobe : lobes) {
    if (sink.ignores(lobe)) continue;
    for (const LobeGroup& group : lobe_groups(selection_, scene_, lobe.constraint, y, lobe.images)) {
      const bool sums = path.hue < 0 && (group.images & picture);
      const PhotonRule rule{group, sums, Sink::is_shared && effects_.light_edits, events_left};
      add_photons(context_.photons->all, Receiver(y, group.lobes, found.length), radius, rule,
                  ThroughLobe<Sink>{sink, lobe});
    }
  }
}

}  // namespace sluice
