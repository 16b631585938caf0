// SPDX-License-Identifier: GPL-3.0-or-later
// Where light goes that leaves y, the far end of a gather segment: on to the eye by one view path, or into a
// point that a whole bundle shares. Estimators take either as a template argument.
#pragma once
#include "transport/view/entry_occlusion.h"
#include "transport/view/gather_point.h"
#include "transport/view/sample_sums.h"

namespace sluice {

struct ToEye {
  static constexpr bool is_shared = false;
  SampleSums& sums;
  const Sample& sample;
  const ViewPath& path;

  // Radiance that leaves y goes on through a lobe of v.
  void add(const LobeThroughput& lobe, const BlurredLight& light, const JoinResult& joined) const noexcept {
    sums.add(Part::Indirect, sample, path, light.changed_to(light.radiance * lobe.weight), joined);
  }
  // Radiance added in a sum counts for the edits that took it.
  void credit(const LobeThroughput& lobe, const BlurredLight& light, StateId q) const noexcept {
    sums.credit(sample, q, light.changed_to(light.radiance * lobe.weight * path.weight));
  }
  // Light in state q arrives at y.
  void note_state(StateId) const noexcept {}
  [[nodiscard]] bool ignores(const LobeThroughput& lobe) const noexcept { return is_black(lobe.weight); }
};

struct ToGatherPoint {
  static constexpr bool is_shared = true;
  SampleSums& sums;
  GatherPoint& point;
  EntryOcclusion& occlusion;

  void add(const LobeThroughput& lobe, const BlurredLight& light, const JoinResult& joined) const {
    sums.add(point.light[point.index_of(lobe)], light, joined);
  }
  void credit(const LobeThroughput& lobe, const BlurredLight& light, StateId q) const {
    sums.credit(point.light[point.index_of(lobe)], light, q);
  }
  void note_state(StateId q) const { occlusion.note_state(q); }
  // Others than the finder may see y where its own lobe is black.
  [[nodiscard]] bool ignores(const LobeThroughput&) const noexcept { return false; }
};

}  // namespace sluice
