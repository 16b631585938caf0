// SPDX-License-Identifier: GPL-3.0-or-later
// Gates on view segments. Light edits are met backward (design §2 and §5): at a plane of quads light may have
// come straight through, passing every entry there, or out of an exit, taken by that edit's entry; both
// continue, and C remembers which light that was. View edits are met forward from the eye, as paper §4 has
// it. Knows nothing of the light that is found on the way.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "scene/gates_in_view.h"
#include "transport/view/branch_stack.h"
#include "transport/view/possible_takers.h"
#include "transport/view/path_selection.h"
#include "transport/view/sample_sums.h"
#include "transport/view/view_context.h"

namespace sluice {

// How a path goes on at the end of a segment: straight to what it met there, from another place where a gate
// sent it, or no further itself, though copies of it may wait in the BranchStack.
enum class SegmentEnd : std::uint8_t { Straight, Redirected, Over };

class GateWalk {
 public:
  GateWalk(const ViewContext& context, PathSelection& selection, SampleSums& sums, BranchStack& branches)
      : scene_(context.scene),
        effects_(context.effects),
        gates_in_view_(context.scene.gates_in_view()),
        selection_(selection),
        sums_(sums),
        branches_(branches) {}

  // False: the path does not go on from here. There is no state left for it, or a view edit's entry in the
  // plane of the exit where it starts takes it.
  [[nodiscard]] bool leave_exit(Sample& sample, ViewPath& path);

  // At the start of a segment behind a gate of a light edit: the other gates in the plane of its entry.
  [[nodiscard]] SegmentEnd leave_own_entry(Sample& sample, ViewPath& path);

  // Follows a segment of length t_end through its gates in the order of the ray. Before the path changes, at
  // each plane of gates and at the end, on_stretch(t) is called with the t up to which the path is as it is.
  template <class OnStretch>
  [[nodiscard]] SegmentEnd cross(Sample& sample, ViewPath& path, double t_end, const SegmentSources& sources,
                                 OnStretch&& on_stretch) {
    const GateQueries queries = queries_of(sample, path, sources);
    if (!queries.any()) return on_stretch(t_end), SegmentEnd::Straight;
    const Edits& edits = scene_.edits();
    Segment segment{path.origin, V3d(path.direction), 0, t_end, path.excluded_group};
    const std::optional<Crossing> capture = queries.view_entries ? find_capture(path, segment) : std::nullopt;
    if (effects_.light_edits && (capture || meets_light_gate(sample, path, queries, segment, sources))) {
      edits.crossings(Side::Light, segment, edits.could_take(Side::Light), crossings_);
      for (std::size_t i = 0; i < crossings_.size();) {
        const std::span plane = plane_at(i);
        on_stretch(plane.front().t);
        const SegmentEnd end = cross_plane(sample, path, plane);
        if (end != SegmentEnd::Straight) return end;
        i += plane.size();
      }
    }
    on_stretch(segment.t_max);
    if (!capture) return SegmentEnd::Straight;
    meet_view_edit(sample, path, *capture);
    return SegmentEnd::Over;
  }

 private:
  // Which gates does a segment have to ask for? Nearly always none.
  struct GateQueries {
    bool exits;         // of light edits, where light may have come out
    bool entries;       // of light edits, that may take light from a source of the segment
    bool view_entries;  // that may take the path
    [[nodiscard]] bool any() const noexcept { return exits || entries || view_entries; }
  };
  // For rays from the camera GatesInView tells, by blocks of pixels, whether gates can lie on them.
  [[nodiscard]] GateQueries queries_of(const Sample& sample, const ViewPath& path,
                                       const SegmentSources& sources) const noexcept {
    const auto in_view = [&](Side side) {
      return !path.is_camera || gates_in_view_.any(side, sample.asked.x, sample.asked.y);
    };
    return {effects_.light_edits && scene_.edits().has_exits(Side::Light) && in_view(Side::Light),
            effects_.light_edits && may_be_taken(scene_, sources),
            effects_.view_edits && !selection_.states().takes_none(path.state) && in_view(Side::View)};
  }
  [[nodiscard]] std::optional<Crossing> find_capture(const ViewPath& path, Segment& segment);
  [[nodiscard]] bool meets_light_gate(const Sample& sample, const ViewPath& path, const GateQueries& queries,
                                      const Segment& segment, const SegmentSources& sources);
  [[nodiscard]] bool meets_exit(const Sample& sample, const ViewPath& path,
                                const Segment& segment) const noexcept;
  // Crossings of one point of one plane, from the i-th on.
  [[nodiscard]] std::span<const Crossing> plane_at(std::size_t i) const noexcept {
    std::size_t end = i + 1;
    while (end < crossings_.size() && crossings_[end].group == crossings_[i].group &&
           crossings_[end].t == crossings_[i].t)
      ++end;
    return std::span(crossings_).subspan(i, end - i);
  }
  [[nodiscard]] SegmentEnd cross_plane(Sample& sample, ViewPath& path, std::span<const Crossing> plane);
  [[nodiscard]] bool may_take(const ViewPath& path, const Crossing& crossing) const noexcept;
  [[nodiscard]] ConstraintId pass_entries(const ViewPath& path, std::span<const Crossing> plane, int except);
  [[nodiscard]] bool go_backward(ViewPath& path, std::span<const Crossing> plane, const Crossing& exit,
                                 float weight);
  void meet_view_edit(Sample& sample, const ViewPath& path, const Crossing& crossing);
  void push_view_copy(const Sample& sample, const ViewPath& path, const Crossing& crossing, int exit,
                      float weight);
  void apply_gate(ViewPath& path, const Passage& passage, float weight);

  const Scene& scene_;
  const Effects& effects_;
  const GatesInView& gates_in_view_;
  PathSelection& selection_;
  SampleSums& sums_;
  BranchStack& branches_;
  // Scratch memory.
  std::vector<Crossing> crossings_;
  PossibleTakers takers_;
};

}  // namespace sluice
