// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/edits.h"

#include <algorithm>
#include <tuple>

namespace sluice {

namespace {

void sort_along(std::vector<Crossing>& out) {
  std::sort(out.begin(), out.end(), [](const Crossing& a, const Crossing& b) {
    return std::tuple(a.t, a.group, a.exit >= 0, a.order, a.edit, a.exit) <
           std::tuple(b.t, b.group, b.exit >= 0, b.order, b.edit, b.exit);
  });
}

}  // namespace

const Quad& Edits::quad(int edit, int exit) const noexcept {
  const Edit& e = (*this)[edit];
  return exit < 0 ? e.entry : e.exits[static_cast<std::size_t>(exit)].quad;
}

bool Edits::is_crossed(const QuadId& id, const Segment& segment) const noexcept {
  const Quad& q = quad(id.edit, id.exit);
  const auto hit = intersect(q, segment.origin, segment.direction);
  return hit && hit->t > segment.t_min && hit->t <= segment.t_max && q.group != segment.excluded_group;
}

std::optional<Crossing> Edits::first_taken(const StateTable& table, StateId state,
                                           const Segment& segment) const noexcept {
  const TakingList& list = table.taking_list(state);
  if (list.edits.empty()) return std::nullopt;
  const Crossing c = list.quads.empty()
                         ? entries_[index((*this)[list.edits.front()].side)].first(segment, list.members)
                         : list.quads.first(segment);
  return c.edit >= 0 ? std::optional(c) : std::nullopt;
}

bool Edits::any_taken(const StateTable& table, StateId state, const Segment& segment) const noexcept {
  const TakingList& list = table.taking_list(state);
  if (list.edits.empty()) return false;
  return list.quads.empty() ? entries_[index((*this)[list.edits.front()].side)].any(segment, list.members)
                            : list.quads.any(segment);
}

std::optional<Crossing> Edits::first_taken_at_exit(const StateTable& table, StateId state, int edit, int exit,
                                                   const V3d& point) const noexcept {
  if (table.takes_none(state)) return std::nullopt;
  const int group = quad(edit, exit).group;
  for (const QuadId& id : groups_[static_cast<std::size_t>(group)]) {
    if (id.exit != QuadId::entry) break;  // entries come first, by order
    if (id.edit == edit || !table.takes(state, id.edit)) continue;
    const Quad& entry = (*this)[id.edit].entry;
    if (const auto uv = locate(entry, point)) return Crossing{0, *uv, id.edit, id.exit, group, entry.order};
  }
  return std::nullopt;
}

void Edits::crossings(Side side, const Segment& segment, EditSet members, std::vector<Crossing>& out) const {
  out.clear();
  entries_[index(side)].all(segment, members, out);
  exits_[index(side)].all(segment, members, out);
  sort_along(out);
}

void Edits::entries_crossed(Side side, const Segment& segment, EditSet members,
                            std::vector<Crossing>& out) const {
  out.clear();
  entries_[index(side)].all(segment, members, out);
  sort_along(out);
}

void Edits::crossings_at(Side side, int group, const V3d& point, EditSet members,
                         std::vector<Crossing>& out) const {
  out.clear();
  for (const QuadId& id : groups_[static_cast<std::size_t>(group)]) {
    if ((*this)[id.edit].side != side || (!members.empty() && !contains(members, id.edit))) continue;
    const Quad& q = quad(id.edit, id.exit);
    if (const auto uv = locate(q, point)) out.push_back({0, *uv, id.edit, id.exit, group, q.order});
  }
}

}  // namespace sluice
