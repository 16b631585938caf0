// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/path_selection.h"

namespace sluice {

void PathSelection::start_pass(const PhotonStates* photon_states) {
  if (photon_states_ != photon_states) state_of_photon_.clear();
  photon_states_ = photon_states;
  const std::uint32_t count = photon_states ? photon_states->size() : 0;
  for (auto q = static_cast<std::uint32_t>(state_of_photon_.size()); q < count; ++q)
    state_of_photon_.push_back(states_.intern(photon_states->content(q)));
  memo_.assign(count, {});
  memo_mark_.assign(count, 0);
  memo_now_ = 0, memo_constraint_ = no_memo;
}

JoinResult PathSelection::join(StateId q, ConstraintId id) noexcept {
  const auto [at_eye, outcome, refused_by] = constraints_.arrive(states_, q, id);
  // lost to the layers alone
  if (outcome == JoinOutcome::StatesCapped && !constraints_.is_constrained(id))
    return {picture, at_eye, outcome};
  if (outcome != JoinOutcome::Joined) return {0, at_eye, outcome, refused_by};
  if (!effects_.layers) return {picture, at_eye};
  const StateId whole = states_.next(at_eye, edits_.event_class(Event::E, -1));
  return {states_.images(whole), at_eye, whole == StateTable::dead ? JoinOutcome::StatesCapped : outcome};
}

JoinResult PathSelection::join_photon(std::uint32_t q, ConstraintId id) noexcept {
  if (!asks_state(id)) return {picture, state_of_photon_[q]};
  if (id != memo_constraint_) memo_constraint_ = id, ++memo_now_;
  if (memo_mark_[q] != memo_now_) {
    memo_mark_[q] = memo_now_;
    memo_[q] = join(state_of_photon_[q], id);
  }
  return memo_[q];
}

}  // namespace sluice
