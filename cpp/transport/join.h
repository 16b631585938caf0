// SPDX-License-Identifier: GPL-3.0-or-later
// C of design §3, "one idea carries all of path selection": which light states a view path may be joined to.
// A view path keeps what happened to it as a list from its far end towards the eye; q is in C iff running q
// forward along that list meets no contradiction. So C is never built, and a path that met no gate allows
// every q at once. Layers ask what q is then: at the eye the word is whole.
#pragma once
#include <vector>

#include "edit/edits.h"

namespace sluice {

class Joins {
 public:
  static constexpr int all = -1;   // C at the eye: every q
  static constexpr int none = -2;  // no list at all

  void clear() noexcept { steps_.clear(); }
  [[nodiscard]] int event(int towards_eye, EventClass event) {
    return add({towards_eye, Kind::Event, event, is_constrained(towards_eye)});
  }
  // Light crossed the entry of `edit` here and was not taken.
  [[nodiscard]] int passed(int towards_eye, int edit) {
    return add({towards_eye, Kind::Passed, static_cast<std::uint16_t>(edit), true});
  }
  // Light was taken by a light edit's entry and left through an exit.
  [[nodiscard]] int gate(int towards_eye, int edit) {
    return add({towards_eye, Kind::Gate, static_cast<std::uint16_t>(edit), true});
  }
  // The view path was taken by a view edit: an F of the word like any other, and one of the path's gates.
  [[nodiscard]] int view_gate(int towards_eye, int edit) {
    return add({towards_eye, Kind::ViewGate, static_cast<std::uint16_t>(edit), true});
  }

  // False: every q may be joined, whatever its content (the list holds events alone).
  [[nodiscard]] bool is_constrained(int step) const noexcept {
    return step >= 0 && steps_[static_cast<std::size_t>(step)].constrained;
  }

  // Did the list go through a gate of `edit`?
  [[nodiscard]] bool uses(int step, int edit) const noexcept {
    for (; is_constrained(step); step = steps_[static_cast<std::size_t>(step)].towards_eye)
      if (const Step& s = steps_[static_cast<std::size_t>(step)];
          s.id == edit && (s.kind == Kind::Gate || s.kind == Kind::ViewGate))
        return true;
    return false;
  }

  // What becomes of light in state q that arrives at the list's far end: at the eye in a state, or refused as
  // q is not in C, or lost to a cap.
  enum class Fate : std::uint8_t { Arrives, Refused, GatesCapped, StatesCapped };
  struct AtEye {
    StateId q;
    Fate fate;
    int taker = -1;  // refused as this edit's entry took it on the way
  };
  [[nodiscard]] AtEye arrive(StateTable& states, StateId q, int step) const noexcept {
    for (; step >= 0 && q != StateTable::dead; step = steps_[static_cast<std::size_t>(step)].towards_eye) {
      const Step& s = steps_[static_cast<std::size_t>(step)];
      switch (s.kind) {
        case Kind::Event: q = states.next(q, s.id); break;
        case Kind::Passed:
          if (states.takes(q, s.id)) return {q, Fate::Refused, s.id};
          break;
        case Kind::Gate:
          if (!states.takes(q, s.id)) return {q, Fate::Refused};
          if (states.at_cap(q)) return {q, Fate::GatesCapped};
          q = states.through(q, s.id);
          break;
        case Kind::ViewGate:
          if (states.at_cap(q)) return {q, Fate::GatesCapped};
          q = states.through(q, s.id);
          break;
      }
    }
    return {q, q == StateTable::dead ? Fate::StatesCapped : Fate::Arrives};
  }

 private:
  enum class Kind : std::uint8_t { Event, Passed, Gate, ViewGate };
  struct Step {
    int towards_eye;
    Kind kind;
    std::uint16_t id;  // event class, or edit
    bool constrained;  // this step or one nearer to the eye is not a plain event
  };
  int add(const Step& step) {
    steps_.push_back(step);
    return static_cast<int>(steps_.size()) - 1;
  }

  std::vector<Step> steps_;  // of all branches of all view samples of a bundle
};

}  // namespace sluice
