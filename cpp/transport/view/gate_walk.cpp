// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/gate_walk.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sluice {

bool GateWalk::leave_exit(Sample& sample, ViewPath& path) {
  if (path.state == StateTable::dead) {
    ++sums_.counts.states_capped;
    return false;
  }
  if (path.at_edit < 0) return true;
  const auto crossing = scene_.edits().first_taken_at_exit(selection_.states(), path.state, path.at_edit,
                                                           path.at_exit, path.origin);
  path.at_edit = -1;
  if (crossing) meet_view_edit(sample, path, *crossing);
  return !crossing;
}

SegmentEnd GateWalk::leave_own_entry(Sample& sample, ViewPath& path) {
  const Edits& edits = scene_.edits();
  edits.crossings_at(Side::Light, edits[path.own_entry].entry.group, path.origin,
                     edits.could_take(Side::Light), crossings_);
  return cross_plane(sample, path, crossings_);
}

// A view edit that takes the path; the segment ends there.
std::optional<Crossing> GateWalk::find_capture(const ViewPath& path, Segment& segment) {
  ++sums_.counts.edit_queries;
  const auto capture = scene_.edits().first_taken(selection_.states(), path.state, segment);
  if (capture) segment.t_max = capture->t;
  return capture;
}

// Is there a gate of light edits on the segment? An entry alone is one only for light that starts at a source
// of the segment; behind an exit any may be.
bool GateWalk::meets_light_gate(const Sample& sample, const ViewPath& path, const GateQueries& queries,
                                const Segment& segment, const SegmentSources& sources) {
  if (queries.exits) {
    ++sums_.counts.edit_queries;
    if (meets_exit(sample, path, segment)) return true;
  }
  if (!queries.entries) return false;
  const EditSet takers = takers_.find(scene_, sources, any_lobe);
  if (is_empty(takers)) return false;
  sums_.counts.edit_queries += !queries.exits;
  return scene_.edits().any_entry_crossed(Side::Light, segment, takers);
}

bool GateWalk::meets_exit(const Sample& sample, const ViewPath& path, const Segment& segment) const noexcept {
  const Edits& edits = scene_.edits();
  if (path.is_camera)
    if (const auto few = gates_in_view_.listed(Side::Light, sample.asked.x, sample.asked.y))
      return std::ranges::any_of(*few, [&](const QuadId& id) { return edits.is_crossed(id, segment); });
  return edits.any_exit_crossed(Side::Light, segment, edits.could_take(Side::Light));
}

// Entries and exits of light edits at one point of one plane. Pushes the ways light may have come out of a
// gate here and leaves `path` on the straight way; above the split budget one way is chosen, with weight.
SegmentEnd GateWalk::cross_plane(Sample& sample, ViewPath& path, std::span<const Crossing> plane) {
  const Edits& edits = scene_.edits();
  // weight with which light comes this way through the gate; 0: it cannot
  const auto way = [&](const Crossing& c) -> float {
    if (c.edit == path.own_entry || !may_take(path, c)) return 0;
    const float taken = edits[c.edit].is_partial ? edits.weight(c.edit, c.uv) : 1;
    return c.exit == QuadId::entry ? 1 - taken : taken;
  };
  int ways = 0;
  float all = 1;  // weight of all ways, the straight one's is 1
  for (const Crossing& c : plane)
    if (const float weight = way(c); weight > 0) ++ways, all += weight;
  if (path.gates >= edits.max_gates())
    sums_.counts.gates_capped += static_cast<std::uint64_t>(std::exchange(ways, 0));
  if (!branches_.budget.spend(ways)) {
    ++sums_.counts.split_capped;
    float at = sample.random() * all - 1;
    for (auto c = plane.begin(); at >= 0 && c != plane.end(); ++c) {
      const float weight = way(*c);
      at -= weight;
      if (weight > 0 && at < 0)
        return go_backward(path, plane, *c, all) ? SegmentEnd::Redirected : SegmentEnd::Over;
    }
    path.weight *= all;
  } else if (ways > 0) {
    for (const Crossing& c : plane) {
      const float weight = way(c);
      if (weight > 0 && !go_backward(branches_.push(path), plane, c, weight)) branches_.drop();
    }
  }
  path.constraint = pass_entries(path, plane, -1);
  path.own_entry = -1;
  return SegmentEnd::Straight;
}

// Never through an edit already in the path without repeat: C would refuse every q in the end.
bool GateWalk::may_take(const ViewPath& path, const Crossing& crossing) const noexcept {
  const Edit& edit = scene_.edits()[crossing.edit];
  if (crossing.exit == QuadId::entry && !edit.is_partial) return false;
  return edit.repeat || !selection_.constraints().uses(path.constraint, crossing.edit);
}

// Light went straight past the plane's entries, or past those between an exit and the entry that the path
// came out of: entries of a higher order than that one are not crossed (design §2).
ConstraintId GateWalk::pass_entries(const ViewPath& path, std::span<const Crossing> plane, int except) {
  ConstraintId constraint = path.constraint;
  const auto is_below = [&](const Crossing& c) {  // of equals, the first described
    return path.own_entry < 0 ||
           std::pair(c.order, c.edit) < std::pair(scene_.edits()[path.own_entry].order, path.own_entry);
  };
  for (const Crossing& c : plane)
    if (c.exit == QuadId::entry && c.edit != except && c.edit != path.own_entry && is_below(c))
      constraint = selection_.constraints().passed(constraint, c.edit);
  return constraint;
}

// Backward through a gate: to where its entry took the light. False: nothing comes that way.
bool GateWalk::go_backward(ViewPath& path, std::span<const Crossing> plane, const Crossing& crossing,
                           float weight) {
  const bool is_straight = crossing.exit == QuadId::entry;  // the implicit exit of a partial entry
  std::optional<Passage> passage;
  if (is_straight)
    passage = Passage{.position = path.origin + V3d(path.direction) * crossing.t,
                      .direction = path.direction,
                      .group = crossing.group};
  else
    passage = scene_.edits().backward(crossing.edit, crossing.exit, crossing.uv, path.direction);
  if (!passage) {
    ++sums_.counts.grazing_dropped;
    return false;
  }
  path.constraint = selection_.constraints().gate(pass_entries(path, plane, crossing.edit), crossing.edit);
  // its F is an event of the view word too
  if (effects_.view_edits) path.state = selection_.states().through(path.state, crossing.edit);
  path.own_entry = path.last_edit = crossing.edit;
  apply_gate(path, *passage, weight);
  return !is_black(path.weight);
}

// A view edit takes the path: every exit shows its place (paper §4.3), so copies add.
void GateWalk::meet_view_edit(Sample& sample, const ViewPath& path, const Crossing& crossing) {
  EditCounts& count = sums_.of_view_edit(sample, crossing.edit);
  ++count.matched;
  if (path.gates >= scene_.edits().max_gates()) {
    ++count.capped, ++sums_.counts.gates_capped;
    return;
  }
  const auto random = [&] { return sample.random(); };
  const auto push = [&](int exit, float weight) { push_view_copy(sample, path, crossing, exit, weight); };
  if (!split_path(scene_.edits(), crossing, branches_.budget, random, push)) ++sums_.counts.split_capped;
}

void GateWalk::push_view_copy(const Sample& sample, const ViewPath& path, const Crossing& crossing, int exit,
                              float weight) {
  const auto passage = scene_.edits().forward(crossing.edit, exit, crossing.uv, path.direction);
  if (!passage) {
    ++sums_.counts.grazing_dropped;
    return;
  }
  ViewPath& copy = branches_.push(path);
  copy.state = selection_.states().through(path.state, crossing.edit);
  copy.constraint = selection_.constraints().view_gate(path.constraint, crossing.edit);
  copy.at_edit = copy.last_edit = crossing.edit, copy.at_exit = exit;
  apply_gate(copy, *passage, weight);
  if (is_black(copy.weight)) return branches_.drop();
  ++sums_.of_view_edit(sample, crossing.edit).moved;
}

void GateWalk::apply_gate(ViewPath& path, const Passage& passage, float weight) {
  path.weight *= passage.gain * weight;
  if (passage.hue != 0) {
    path.hue = sums_.hue_gates.add(path.weight, passage.hue, path.hue);
    path.weight = Color(1);
  }
  ++path.gates;
  path.origin = passage.position, path.direction = passage.direction, path.clearance = V3f(0);
  path.t_max = std::numeric_limits<double>::infinity();
  path.excluded_group = passage.group;
  // next-event estimation runs straight through exits: it cannot find what lies behind a gate
  path.lobe_pdf = 0;
  path.is_camera = false;
}

}  // namespace sluice
