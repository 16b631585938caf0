// SPDX-License-Identifier: GPL-3.0-or-later
// Gates on view segments. Light edits are met backward (design §2 and §5): at a plane of quads light may have
// come straight through, passing every entry there, or out of an exit, taken by that edit's entry; both
// continue, and C remembers which light that was. View edits are met forward from the eye, as paper §4 has
// it.
#include <algorithm>
#include <utility>

#include "transport/view_path.h"

namespace sluice {

// No state left for the path, or a view edit's entry in the plane of the exit where it starts takes it: then
// it does not go on from here.
bool ViewTracer::can_leave(ViewPath& path) {
  if (path.state == StateTable::dead) {
    ++counts.states_capped;
    return false;
  }
  if (path.at_edit < 0) return true;
  const auto crossing = scene_.edits().first_taken_at_exit(selection_.states(), path.state, path.at_edit,
                                                           path.at_exit, path.origin);
  path.at_edit = -1;
  if (crossing) meet_view_edit(path, *crossing);
  return !crossing;
}

// Is there a gate of light edits on the segment? An entry alone is one only for light that starts at the
// segment's far end (null: nothing there) or at a lamp; behind an exit any may be.
bool ViewTracer::meets_light_gate(const ViewPath& path, const Asks& asks, const Segment& segment,
                                  const Vertex* far, std::span<const LampHit> lamps) {
  const Edits& edits = scene_.edits();
  if (asks.exits) {
    ++counts.edit_queries;
    if (meets_exit(path, segment)) return true;
  }
  if (!asks.entries) return false;
  const EditSet takers = takers_from(far, any_lobe, lamps);
  if (is_empty(takers)) return false;
  counts.edit_queries += !asks.exits;
  return edits.any_entry_crossed(Side::Light, segment, takers);
}

bool ViewTracer::meets_exit(const ViewPath& path, const Segment& segment) const noexcept {
  const Edits& edits = scene_.edits();
  if (path.is_camera)
    if (const auto few = gates_in_view_.listed(Side::Light, bundle_[at_].x, bundle_[at_].y))
      return std::ranges::any_of(*few, [&](const QuadId& id) { return edits.is_crossed(id, segment); });
  return edits.any_exit_crossed(Side::Light, segment, edits.takers(Side::Light));
}

// The gates on a segment in the order of the ray, and the lamps between them.
ViewTracer::Went ViewTracer::cross_gates(ViewPath& path, const Asks& asks, double t_end, const Vertex* far,
                                         std::span<LampHit> lamps) {
  const Edits& edits = scene_.edits();
  Segment segment{path.origin, V3d(path.direction), 0, t_end, path.excluded_group};
  std::optional<Crossing> capture;
  if (asks.view_entries) {
    ++counts.edit_queries;
    capture = edits.first_taken(selection_.states(), path.state, segment);
    if (capture) segment.t_max = capture->t;
  }
  const auto collect_lamps = [&](double until) {
    for (LampHit& lamp : lamps)
      if (lamp.t < until) {
        add_emission(path, segment_of(path), lamp.light, lamp.radiance, nullptr, arm_of(path));
        lamp.t = std::numeric_limits<double>::infinity();  // done
      }
  };
  if (effects_.light_edits && (capture || meets_light_gate(path, asks, segment, far, lamps))) {
    edits.crossings(Side::Light, segment, edits.takers(Side::Light), crossings_);
    for (std::size_t i = 0; i < crossings_.size();) {
      std::size_t end = i + 1;
      while (end < crossings_.size() && crossings_[end].group == crossings_[i].group &&
             crossings_[end].t == crossings_[i].t)
        ++end;
      collect_lamps(crossings_[i].t);
      const Went went = cross_plane(path, std::span(crossings_).subspan(i, end - i));
      if (went != Went::Straight) return went;
      i = end;
    }
  }
  collect_lamps(segment.t_max);
  if (!capture) return Went::Straight;
  meet_view_edit(path, *capture);
  return Went::Nowhere;
}

// Entries and exits of light edits at one point of one plane. Pushes the ways light may have come out of a
// gate here and leaves `path` on the straight way; above the split budget one way is chosen, with weight.
ViewTracer::Went ViewTracer::cross_plane(ViewPath& path, std::span<const Crossing> plane) {
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
    counts.gates_capped += static_cast<std::uint64_t>(std::exchange(ways, 0));
  if (!budget_.spend(ways)) {
    ++counts.split_capped;
    float at = random() * all - 1;
    for (auto c = plane.begin(); at >= 0 && c != plane.end(); ++c)
      if (const float weight = way(*c); weight > 0 && (at -= weight) < 0)
        return go_backward(path, plane, *c, all) ? Went::Elsewhere : Went::Nowhere;
    path.weight *= all;
  } else if (ways > 0) {
    for (const Crossing& c : plane) {
      const float weight = way(c);
      if (!(weight > 0)) continue;
      branches_[branch_count_] = path;
      if (go_backward(branches_[branch_count_], plane, c, weight)) ++branch_count_;
    }
  }
  path.joins = pass_entries(path, plane, -1);
  if (path.own_entry >= 0) path.own_entry = -1;
  return Went::Straight;
}

// Never through an edit already in the path without repeat: C would refuse every q in the end.
bool ViewTracer::may_take(const ViewPath& path, const Crossing& crossing) const noexcept {
  const Edit& edit = scene_.edits()[crossing.edit];
  if (crossing.exit == QuadId::entry && !edit.is_partial) return false;
  return edit.repeat || !selection_.constraints().uses(path.joins, crossing.edit);
}

// Light went straight past the plane's entries, or past those between an exit and the entry that the path
// came out of: entries of a higher order than that one are not crossed (design §2).
ConstraintId ViewTracer::pass_entries(const ViewPath& path, std::span<const Crossing> plane, int except) {
  ConstraintId joins = path.joins;
  const auto is_below = [&](const Crossing& c) {  // of equals, the first described
    return path.own_entry < 0 ||
           std::pair(c.order, c.edit) < std::pair(scene_.edits()[path.own_entry].order, path.own_entry);
  };
  for (const Crossing& c : plane)
    if (c.exit == QuadId::entry && c.edit != except && c.edit != path.own_entry && is_below(c))
      joins = selection_.constraints().passed(joins, c.edit);
  return joins;
}

// Backward through a gate: to where its entry took the light. False: nothing comes that way.
bool ViewTracer::go_backward(ViewPath& path, std::span<const Crossing> plane, const Crossing& crossing,
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
    ++counts.grazing_dropped;
    return false;
  }
  path.joins = selection_.constraints().gate(pass_entries(path, plane, crossing.edit), crossing.edit);
  // its F is an event of the view word too
  if (effects_.view_edits) path.state = selection_.states().through(path.state, crossing.edit);
  path.own_entry = path.last_edit = crossing.edit;
  apply_gate(path, *passage, weight);
  return !is_black(path.weight);
}

// A view edit takes the path: every exit shows its place (paper §4.3), so copies add.
void ViewTracer::meet_view_edit(const ViewPath& path, const Crossing& crossing) {
  EditCounts& count = of_view_edit(crossing.edit);
  ++count.matched;
  if (path.gates >= scene_.edits().max_gates()) {
    ++count.capped, ++counts.gates_capped;
    return;
  }
  const auto push = [&](int exit, float weight) { push_view_copy(path, crossing, exit, weight); };
  if (!send_on(scene_.edits(), crossing, budget_, [this] { return random(); }, push)) ++counts.split_capped;
}

void ViewTracer::push_view_copy(const ViewPath& path, const Crossing& crossing, int exit, float weight) {
  const auto passage = scene_.edits().forward(crossing.edit, exit, crossing.uv, path.direction);
  if (!passage) {
    ++counts.grazing_dropped;
    return;
  }
  ViewPath& copy = branches_[branch_count_] = path;
  copy.state = selection_.states().through(path.state, crossing.edit);
  copy.joins = selection_.constraints().view_gate(path.joins, crossing.edit);
  copy.at_edit = copy.last_edit = crossing.edit, copy.at_exit = exit;
  apply_gate(copy, *passage, weight);
  if (is_black(copy.weight)) return;
  ++branch_count_;
  ++of_view_edit(crossing.edit).moved;
}

void ViewTracer::apply_gate(ViewPath& path, const Passage& passage, float weight) {
  path.weight *= passage.gain * weight;
  if (passage.hue != 0) {
    hues_.push_back({path.weight, passage.hue, path.hue});
    path.hue = static_cast<int>(hues_.size()) - 1;
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
