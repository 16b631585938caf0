// SPDX-License-Identifier: GPL-3.0-or-later
// Entries between a shared gather point y and the bundle's vertices occlude like surfaces: a connection on
// which one would take any of the light from y is not open.
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "transport/view/sample_sums.h"
#include "transport/view/sharing_vertex.h"

namespace sluice {

class EntryOcclusion {
 public:
  EntryOcclusion(const Scene& scene, const Effects& effects, PathSelection& selection, SampleSums& sums)
      : scene_(scene), effects_(effects), selection_(selection), sums_(sums) {}

  // A new y, of whose light nothing is known.
  void start(const Vertex& y) noexcept {
    arrived_.clear();
    may_be_taken_ = effects_.light_edits && scene_.may_be_taken_from(y.hit);
    knows_takers_ = false;
  }
  // Light in state q arrives at y.
  void note_state(StateId q) {
    if (effects_.light_edits && std::ranges::find(arrived_, q) == arrived_.end()) arrived_.push_back(q);
  }
  // Would an entry take some of the light, between y and v or between v and the eye? `bundle`: all vertices
  // that may be asked about, the finder of y among them.
  [[nodiscard]] bool occludes(const Connection& connection, const Vertex& y, const SharingVertex& finder,
                              std::span<const SharingVertex> bundle) {
    // seldom: apart, so that it costs no call
    return (selection_.constraints().is_constrained(connection.to->path.constraint) || may_be_taken_) &&
           ask_entries(connection, y, finder, bundle);
  }

 private:
  [[nodiscard]] bool ask_entries(const Connection& connection, const Vertex& y, const SharingVertex& finder,
                                 std::span<const SharingVertex> bundle);
  [[nodiscard]] bool arrives_at_eye(const SharingVertex& vertex);
  void find_takers(const Vertex& y, const SharingVertex& finder, std::span<const SharingVertex> bundle);

  const Scene& scene_;
  const Effects& effects_;
  PathSelection& selection_;
  SampleSums& sums_;
  std::vector<StateId> arrived_;  // states of light at y
  bool may_be_taken_ = false;     // by some edit, on its way to v
  // Found when first asked for.
  bool knows_takers_ = false;
  std::vector<StateId> states_;         // of the light, behind y
  std::vector<std::uint64_t> takers_;   // light edits that would take some of it; empty: none on any way
  std::vector<std::uint32_t> entries_;  // of theirs, those that may lie on a connection, by numbers
  bool are_all_listed_ = false;         // there were few enough of these entries
};

}  // namespace sluice
