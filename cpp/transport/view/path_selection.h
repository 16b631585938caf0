// SPDX-License-Identifier: GPL-3.0-or-later
// Path selection on the view side, the set C of design §3: may light in state q be joined to a view path
// here, and which images is the whole path part of then? The whole path's word is known where both halves
// meet, so layers ask the same question. Knows no geometry and counts nothing.
#pragma once
#include <vector>

#include "edit/edits.h"
#include "transport/effects.h"
#include "transport/photons/photon_states.h"
#include "transport/view/join_constraints.h"

namespace sluice {

struct JoinResult {
  ImageSet images = 0;           // that the whole path is part of; none: it does not exist
  StateId q = StateTable::dead;  // at the eye: which edits took the light, if any did
  JoinOutcome outcome = JoinOutcome::Joined;
  int refused_by = -1;  // the edit whose entry kept it from the eye
};

class PathSelection {
 public:
  PathSelection(const Edits& edits, const Effects& effects, const StateLimits& limits)
      : edits_(edits), effects_(effects), states_(edits, limits) {}

  // The photons of a new pass carry numbers of `photon_states` (null: nobody asked for them).
  void start_pass(const PhotonStates* photon_states);
  // The lists of the bundle before are forgotten.
  void start_bundle() noexcept {
    constraints_.clear();
    memo_constraint_ = no_memo;
  }

  [[nodiscard]] StateTable& states() noexcept { return states_; }
  [[nodiscard]] const StateTable& states() const noexcept { return states_; }
  [[nodiscard]] JoinConstraints& constraints() noexcept { return constraints_; }
  [[nodiscard]] const JoinConstraints& constraints() const noexcept { return constraints_; }
  [[nodiscard]] const Effects& effects() const noexcept { return effects_; }

  // Does it depend on q what becomes of light that is joined here? Else it is in the picture, and there is no
  // need to ask.
  [[nodiscard]] bool asks_state(ConstraintId id) const noexcept {
    return effects_.layers || constraints_.is_constrained(id);
  }
  // Does it depend on a photon's q what becomes of it, or which edits it speaks for?
  [[nodiscard]] bool asks_photons(ConstraintId id) const noexcept {
    return effects_.light_edits || asks_state(id);
  }

  // What becomes of light in state q that arrives at the far end of a list.
  [[nodiscard]] JoinResult join(StateId q, ConstraintId id) noexcept;
  // The same for a photon's q, remembered while the list stays the same.
  [[nodiscard]] JoinResult join_photon(std::uint32_t q, ConstraintId id) noexcept;
  [[nodiscard]] StateId state_of_photon(std::uint32_t q) const noexcept { return state_of_photon_[q]; }

  // Did some edit take light in state q on its way? Which?
  [[nodiscard]] bool has_acted_edits(StateId q) const noexcept {
    return q != StateTable::dead && states_.gates(q) > 0;
  }
  [[nodiscard]] std::span<const std::uint32_t> acted_edits(StateId q) const noexcept {
    return states_.used(q);
  }

 private:
  static constexpr ConstraintId no_memo = -2;

  const Edits& edits_;
  const Effects& effects_;
  StateTable states_;
  JoinConstraints constraints_;
  const PhotonStates* photon_states_ = nullptr;  // whose numbers the next list knows
  std::vector<StateId> state_of_photon_;         // [a photon's q] -> this thread's number
  // join_photon()'s answers, valid where the mark is the present one
  std::vector<JoinResult> memo_;          // [a photon's q]
  std::vector<std::uint32_t> memo_mark_;  // [a photon's q]
  std::uint32_t memo_now_ = 0;
  ConstraintId memo_constraint_ = no_memo;
};

}  // namespace sluice
