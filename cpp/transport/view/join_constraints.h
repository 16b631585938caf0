// SPDX-License-Identifier: GPL-3.0-or-later
// The constraints that a view path puts on light which joins it. The path keeps what happened to it as a list
// of steps from its far end towards the eye; light in state q may join iff running q forward along the list
// meets no contradiction. So the set C of design §3 is never built, and the empty list allows every q at
// once. Lists of branches share their ends, as each step only names the next one towards the eye.
#pragma once
#include <vector>

#include "edit/edits.h"

namespace sluice {

// The first step of a list of JoinConstraints, as seen from the light.
using ConstraintId = int;
inline constexpr ConstraintId no_constraint = -1;  // the empty list, at the eye

// What becomes of light that arrives at a list's far end: it reaches the eye, is refused as its q is not in
// C, or is lost to a cap on the way.
enum class JoinOutcome : std::uint8_t { Joined, Refused, GatesCapped, StatesCapped };

class JoinConstraints {
 public:
  // Forgets all lists; their numbers become invalid.
  void clear() noexcept { steps_.clear(); }

  // Light was scattered by an event.
  [[nodiscard]] ConstraintId event(ConstraintId towards_eye, EventClass event) {
    return add({towards_eye, Kind::Event, event, is_constrained(towards_eye)});
  }
  // Light crossed the entry of `edit` and was not taken.
  [[nodiscard]] ConstraintId passed(ConstraintId towards_eye, int edit) {
    return add({towards_eye, Kind::Passed, static_cast<std::uint16_t>(edit), true});
  }
  // Light was taken by a light edit's entry and left through an exit.
  [[nodiscard]] ConstraintId gate(ConstraintId towards_eye, int edit) {
    return add({towards_eye, Kind::Gate, static_cast<std::uint16_t>(edit), true});
  }
  // The view path was taken by a view edit: an F of the word like any other, and one of the path's gates.
  [[nodiscard]] ConstraintId view_gate(ConstraintId towards_eye, int edit) {
    return add({towards_eye, Kind::ViewGate, static_cast<std::uint16_t>(edit), true});
  }

  // False: the list holds events alone, so that every q may be joined, whatever its content.
  [[nodiscard]] bool is_constrained(ConstraintId id) const noexcept {
    return id >= 0 && steps_[static_cast<std::size_t>(id)].constrained;
  }

  // Does the list go through a gate of `edit`?
  [[nodiscard]] bool uses(ConstraintId id, int edit) const noexcept {
    for (; is_constrained(id); id = steps_[static_cast<std::size_t>(id)].towards_eye)
      if (const Step& s = steps_[static_cast<std::size_t>(id)];
          s.id == edit && (s.kind == Kind::Gate || s.kind == Kind::ViewGate))
        return true;
    return false;
  }

  struct AtEye {
    StateId q;
    JoinOutcome outcome;
    int refused_by = -1;  // refused as this edit's entry took it on the way
  };
  // Runs light in state q, which arrives at the list's far end, forward to the eye.
  [[nodiscard]] AtEye arrive(StateTable& states, StateId q, ConstraintId id) const noexcept {
    for (; id >= 0 && q != StateTable::dead; id = steps_[static_cast<std::size_t>(id)].towards_eye) {
      const Step& s = steps_[static_cast<std::size_t>(id)];
      switch (s.kind) {
        case Kind::Event: q = states.next(q, s.id); break;
        case Kind::Passed:
          if (states.takes(q, s.id)) return {q, JoinOutcome::Refused, s.id};
          break;
        case Kind::Gate:
          if (!states.takes(q, s.id)) return {q, JoinOutcome::Refused};
          if (states.at_cap(q)) return {q, JoinOutcome::GatesCapped};
          q = states.through(q, s.id);
          break;
        case Kind::ViewGate:
          if (states.at_cap(q)) return {q, JoinOutcome::GatesCapped};
          q = states.through(q, s.id);
          break;
      }
    }
    return {q, q == StateTable::dead ? JoinOutcome::StatesCapped : JoinOutcome::Joined};
  }

 private:
  enum class Kind : std::uint8_t { Event, Passed, Gate, ViewGate };
  struct Step {
    ConstraintId towards_eye;
    Kind kind;
    std::uint16_t id;  // event class, or edit
    bool constrained;  // this step or one nearer to the eye is not a plain event
  };
  ConstraintId add(const Step& step) {
    steps_.push_back(step);
    return static_cast<ConstraintId>(steps_.size()) - 1;
  }

  std::vector<Step> steps_;  // of all branches of all view samples of a bundle
};

}  // namespace sluice
