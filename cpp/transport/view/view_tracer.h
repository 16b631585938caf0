// SPDX-License-Identifier: GPL-3.0-or-later
// The integrator of the view side: radiance that one pixel sample sees, by the estimators of design §5.
//
//   L(x -> eye) = Σ over the vertices of a path by followed lobes (S), their throughput times
//       emission that the path meets                                         (Emission; Direct, by MIS)
//     + light straight from lights, at a vertex v with gathering lobes (D, G)  (Direct)
//     + caustics and edited light: photons at v                              (Caustics, Edited)
//     + all other light: photons and lights at the far ends y of segments from v  (Indirect)
//
// The terms are disjoint: each path of light is told by its last events before the eye (the table of design
// §5). Edits hold on every segment: shadow and gather segments ask the light edits by the C rule
// (path_selection.h), view segments take both continuations at an exit (straight on, and backward through it
// to its entry), view edits capture the view path itself. The light side of the same rules is
// photons/light_tracer.h.
//
// Each part has its own data, and calls go one way, by way of one part or directly; but GateWalk calls back
// for the lamps between gates (cross_gates):
//
//   ViewTracer -> SharedGather -> Gather -> DirectLight -> PathSelection, SampleSums
//   ViewTracer -> GateWalk -> PathSelection, SampleSums
#pragma once
#include <span>
#include <vector>

#include "transport/view/gate_walk.h"
#include "transport/photons/photon_set.h"
#include "transport/view/shared_gather.h"

namespace sluice {

// What traces view samples on one of `threads` threads.
class alignas(64) ViewTracer {  // threads write to theirs: no cache line is shared
 public:
  ViewTracer(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads)
      : context_{scene, settings, effects},
        selection_(scene.edits(), effects, {state_memory_of_one(settings, threads)}),
        lamps_(max_lamp_hits(scene)) {}
  ViewTracer(const ViewTracer&) = delete;  // its parts know each other
  ViewTracer& operator=(const ViewTracer&) = delete;

  void start_pass(const PassContext& context, const PhotonSet& photons);
  // At most bundle_size samples of pixels near each other.
  void trace(std::span<const ViewSample> bundle);

  // Of the last bundle.
  [[nodiscard]] std::span<const TakenLight> edits(std::size_t index) const noexcept {
    return sums_.edits(index);
  }
  [[nodiscard]] const PixelSample& sample(std::size_t index) const noexcept { return sums_.sample(index); }
  [[nodiscard]] std::span<const Color> layers(std::size_t index) const noexcept {
    return sums_.layers(index);
  }
  // Of the mean direct light of a sample with ViewSample::measures_lights.
  [[nodiscard]] const V3d& light_variance(std::size_t index) const noexcept {
    return sums_.light_variance(index);
  }
  [[nodiscard]] Counts& counts() noexcept { return sums_.counts; }

 private:
  void trace_sample(Sample& sample);
  [[nodiscard]] ViewPath camera_path(const Sample& sample);
  void follow(Sample& sample, ViewPath& path);
  [[nodiscard]] bool next_surface(Sample& sample, ViewPath& path, Vertex& vertex);
  [[nodiscard]] SegmentEnd cross_gates(Sample& sample, ViewPath& path, double t_end, const Vertex* far);
  void collect_light(Sample& sample, const ViewPath& path, const Vertex& v);
  [[nodiscard]] bool follow_specular(const Sample& sample, ViewPath& path, const Vertex& vertex);
  [[nodiscard]] bool split_specular(const Sample& sample, const ViewPath& path, const Vertex& vertex);
  void scatter(ViewPath& path, const Vertex& vertex, const BsdfSample& direction);

  ViewContext context_;
  PathSelection selection_;
  SampleSums sums_{context_.scene, context_.settings, selection_};
  BranchStack branches_;
  GateWalk gates_{context_, selection_, sums_, branches_};
  DirectLight direct_{context_, selection_, sums_};
  Gather gather_{context_, selection_, sums_, direct_};
  SharedGather shared_{context_, selection_, sums_, gather_};
  std::vector<LampHit> lamps_;  // scratch memory: of one segment; room for all there are
};

}  // namespace sluice
