// SPDX-License-Identifier: GPL-3.0-or-later
// Light straight from lights: next-event estimation at v, with what lobe sampling finds of the same light,
// weighed by MIS (design §5), and at y, where it stands alone; also emission that a segment meets. Knows no
// photons.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "transport/view/possible_takers.h"
#include "transport/view/sinks.h"
#include "transport/view/view_context.h"

namespace sluice {

// A segment whose far end may be an emitter: what MIS needs to know of its near end.
struct LightSegment {
  V3d origin;
  V3f direction, normal;
  // of the direction, times the number of such segments; 0: next-event estimation could not have made it
  float pdf;
  bool camera = false;
};
// Of a path that goes on by followed lobes.
[[nodiscard]] inline LightSegment segment_of(const ViewPath& path) noexcept {
  return {path.lobe_origin, path.direction, path.lobe_normal, path.lobe_pdf, path.is_camera};
}

// Emission that a segment meets: of a light, or of a surface that is none (light < 0), met by `hit`.
struct MetEmission {
  int light;
  Color radiance;
  const Hit* hit = nullptr;
};

class DirectLight {
 public:
  DirectLight(const ViewContext& context, PathSelection& selection, SampleSums& sums)
      : context_(context),
        scene_(context.scene),
        effects_(context.effects),
        selection_(selection),
        sums_(sums) {}

  // Next-event estimation at v, by as many samples as are worth their time there. The shadow segment runs
  // straight through exits and is blocked by every entry that takes q of L. `segments`: how many gather
  // segments v sends in the mean; each may find the light too.
  void next_event_at_v(const Sample& sample, const ViewPath& path, const Vertex& v, float segments);

  // Next-event estimation at the gather segment's end y, where it stands alone: what is hidden from it or too
  // near, photon density has. `depth`: of v; `lobes`: of v.
  template <class Sink>
  void next_event_at_gather_point(const Vertex& y, int depth, const Sampler& numbers,
                                  const LobeThroughputs& lobes, const Sink& sink);

  // Emission that a path meets goes to the eye by some lobes: as the Emission part, or as direct light where
  // next-event estimation could have found it too (then MIS).
  void add_emission(const Sample& sample, const ViewPath& path, const LightSegment& segment,
                    MetEmission emission, const LobeThroughputs& lobes);
  // Of a surface.
  void add_surface_emission(const Sample& sample, const ViewPath& path, const LightSegment& segment,
                            const Vertex& vertex, const LobeThroughputs& lobes) {
    add_emission(sample, path, segment,
                 {scene_.mesh_light(vertex.hit.instance), vertex.bsdf.emission, &vertex.hit}, lobes);
  }
  // Of the world and suns, where a segment meets nothing.
  void add_infinite_emission(const Sample& sample, const ViewPath& path, const LightSegment& segment,
                             const LobeThroughputs& lobes);

 private:
  struct LightSample {
    int light;
    DirectSample point;
    float pdf;  // of light and point (1/sr, or of what a delta light has)
  };
  struct Unblocked {
    Color left;  // of the light's radiance
    StateId q;
  };
  // What a light would add if nothing blocked it, by an event at the vertex.
  struct Scattered {
    Event event;
    Color radiance;
  };

  [[nodiscard]] std::optional<LightSample> sample_light(const V3d& place, const V3f& side, LightTrust trust,
                                                        float u, const V2f& uv) const noexcept;
  [[nodiscard]] std::optional<LightSample> sample_light_of_y(const Vertex& y, int depth,
                                                             const Sampler& numbers) const noexcept;
  void measure(const Sample& sample, const ViewPath& path, const Vertex& v, float segments);
  void add_light_sample(const Sample& sample, const ViewPath& path, const Vertex& v, const Sampler& numbers,
                        float segments);
  void keep_unscattered(const LightSample& found, const ToGatherPoint& sink);
  [[nodiscard]] std::optional<Unblocked> unblocked(const Vertex& vertex, int light,
                                                   const DirectSample& sample);
  void count_taken(StateId q, const Segment& to_light);
  [[nodiscard]] bool is_taken_from_view(const ViewPath& path, const Vertex& vertex,
                                        const DirectSample& light);
  [[nodiscard]] JoinResult join_behind(ConstraintId constraint, StateId q, const Vertex& vertex, Event event);

  const ViewContext& context_;
  const Scene& scene_;
  const Effects& effects_;
  PathSelection& selection_;
  SampleSums& sums_;
  std::vector<Crossing> crossings_;  // scratch memory
};

template <class Sink>
void DirectLight::next_event_at_gather_point(const Vertex& y, int depth, const Sampler& numbers,
                                             const LobeThroughputs& lobes, const Sink& sink) {
  const auto found = sample_light_of_y(y, depth, numbers);
  if (!found) return;
  if constexpr (Sink::is_shared)
    if (sink.point.depends_on_direction()) return keep_unscattered(*found, sink);
  const auto& [light, point, density] = *found;
  std::array<Scattered, 2> scattered;
  std::size_t count = 0;
  for_each_event(y.bsdf.events() & gathering, [&](Event e) {
    if (const Color f = eval(y.bsdf, y.point.wo, point.wi, mask_of(e)); !is_black(f))
      scattered[count++] = {e, f * point.radiance};
  });
  if (count == 0) return;
  const auto way = unblocked(y, light, point);
  if (!way) return;
  sink.note_state(way->q);
  for (const LobeThroughput& lobe : lobes)
    for (const Scattered& at : std::span(scattered).first(count)) {
      JoinResult joined = join_behind(lobe.constraint, way->q, y, at.event);
      joined.images &= lobe.images;
      if (joined.images) sink.add(lobe, at.radiance * way->left / density, joined);
    }
}

}  // namespace sluice
