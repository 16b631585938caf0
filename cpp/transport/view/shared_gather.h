// SPDX-License-Identifier: GPL-3.0-or-later
// Gather segments of a bundle. A point y that one vertex found is light for every vertex with the same
// history (SharingVertex::signature) that sees it: each connection from a v to y is weighted by the
// density with which all of them together would have found that y (balance heuristic), so nothing is
// counted twice and each alone would still find everything. A connection counts if nothing lies on it and
// no entry from y to the eye would take any of the light: a v whose connection fails is left out, of the
// light and of the density, whoever found y. If the finder's own fails, y stays its own; so does the light
// of photons at a y that does not look the same from all. (Which photons there are at y depends on the
// finder's radius: near entries that take only some of them, all this holds as radii shrink.)
#pragma once
#include <array>
#include <span>

#include "transport/view/gather.h"
#include "transport/view/sharing_vertex.h"

namespace sluice {

class SharedGather {
 public:
  SharedGather(const ViewContext& context, PathSelection& selection, SampleSums& sums, Gather& gather)
      : context_(context),
        scene_(context.scene),
        sums_(sums),
        gather_(gather),
        occlusion_(context.scene, context.effects, selection, sums) {}

  void start_bundle(std::span<const ViewSample> bundle) noexcept { bundle_ = bundle, count_ = 0; }

  // Where a path's next vertex is made: it is too large to be copied when it takes part.
  [[nodiscard]] Vertex& candidate() noexcept { return vertices_[count_].v; }
  // May the light of the path's vertex, the candidate, come from gather segments of the whole bundle? Then it
  // takes part from now on.
  [[nodiscard]] bool accept_candidate(const Sample& sample, const ViewPath& path) noexcept;

  // All segments, when all are known that may see what they find.
  void gather();

 private:
  [[nodiscard]] std::span<const SharingVertex> vertices() const noexcept {
    return std::span(vertices_).first(count_);
  }
  void start_point();
  // Apart, so that the loop of gather() stays small enough for what it calls to be inlined.
  [[gnu::noinline]] void share(const SharingVertex& finder);
  void keep(const SharingVertex& finder, bool keeps_photons, bool keeps_unscattered);
  [[nodiscard]] std::span<Connection> find_connections(const SharingVertex& finder,
                                                       std::span<Connection> all);
  void find_unoccluded(std::span<Connection> connections) noexcept;
  [[nodiscard]] bool see_same_photons(const SharingVertex& finder) const noexcept;
  [[nodiscard]] const Bsdf& bsdf_towards(const V3f& wo) noexcept;
  void receive(const SharingVertex& vertex, const OutgoingRadiance& light, const Color& factor) noexcept;
  void receive_unscattered(const SharingVertex& vertex, const LobeThroughput& lobe, const Bsdf& bsdf,
                           const V3f& wo, const Color& factor);

  const ViewContext& context_;
  const Scene& scene_;
  SampleSums& sums_;
  Gather& gather_;
  std::span<const ViewSample> bundle_;
  // the last never takes part: room for a candidate when all others are taken
  std::array<SharingVertex, max_sharing + 1> vertices_;
  std::size_t count_ = 0;
  GatherPoint point_;  // that is shared now
  EntryOcclusion occlusion_;
  // Scratch memory.
  Vertex seen_from_elsewhere_;  // y
  OutgoingRadiance scattered_;
};

}  // namespace sluice
