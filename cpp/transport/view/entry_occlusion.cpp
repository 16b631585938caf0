// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/entry_occlusion.h"

#include <utility>

#include "transport/view/lobe_groups.h"

namespace sluice {
namespace {

constexpr std::size_t max_listed = 8;  // entries that a connection asks one by one

}  // namespace

// Collects the states in which light leaves y by any of its lobes, the edits that would take it then, and (if
// there are few) their entries inside the cone that holds all connections to y.
void EntryOcclusion::find_takers(const Vertex& y, const SharingVertex& finder,
                                 std::span<const SharingVertex> bundle) {
  if (std::exchange(knows_takers_, true)) return;
  states_.clear(), takers_.clear(), entries_.clear();
  StateTable& table = selection_.states();
  for (const StateId q : arrived_)
    for_each_event(events_to_all(scene_.material(y.hit), y.bsdf) & gathering, [&](Event e) {
      const StateId behind = table.next(q, scene_.event_class(e, y.hit));
      if (std::ranges::find(states_, behind) == states_.end()) states_.push_back(behind);
    });
  for (const StateId state : states_) {
    const EditSet taking = table.taking_list(state).members;
    if (table.takes_none(state)) continue;
    takers_.resize(taking.size());
    for (std::size_t i = 0; i < taking.size(); ++i) takers_[i] |= taking[i];
  }
  if (takers_.empty()) return;
  const V3d axis = y.hit.position - finder.v.hit.position;
  double radius2 = 0;
  for (const SharingVertex& other : bundle)
    if (other.signature == finder.signature)
      radius2 = std::max(radius2, (other.v.hit.position - finder.v.hit.position).length2());
  ++sums_.counts.edit_queries;
  const Segment segment{finder.v.hit.position, axis.normalized(), 0, axis.length(), -1};
  are_all_listed_ =
      scene_.edits().entries_in_cone(Side::Light, segment, std::sqrt(radius2), takers_, max_listed, entries_);
}

// Is all light that leaves y in C at v, by whatever lobe of v?
bool EntryOcclusion::arrives_at_eye(const SharingVertex& vertex) {
  bool arrives = true;
  for_each_event(vertex.v.bsdf.events() & gathering, [&](Event e) {
    const ConstraintId constraint = constraint_at(selection_, scene_, vertex.path.constraint, vertex.v, e);
    for (const StateId state : states_)
      arrives = arrives && selection_.constraints().arrive(selection_.states(), state, constraint).outcome ==
                               JoinOutcome::Joined;
  });
  return arrives;
}

bool EntryOcclusion::ask_entries(const Connection& connection, const Vertex& y, const SharingVertex& finder,
                                 std::span<const SharingVertex> bundle) {
  find_takers(y, finder, bundle);
  const SharingVertex& vertex = *connection.to;
  if (selection_.constraints().is_constrained(vertex.path.constraint) && !arrives_at_eye(vertex)) return true;
  if (entries_.empty()) return false;
  ++sums_.counts.edit_queries;
  const Segment segment{vertex.v.hit.position, V3d(connection.wi), 0, connection.distance, -1};
  const Edits& edits = scene_.edits();
  return are_all_listed_ ? edits.any_of_entries_crossed(Side::Light, segment, entries_)
                         : edits.any_entry_crossed(Side::Light, segment, takers_);
}

}  // namespace sluice
