// SPDX-License-Identifier: GPL-3.0-or-later
// From expressions to tables (design §3): the events of a scene fall into classes that no expression can tell
// apart, and expressions of one side share a deterministic automaton while it has at most 4,096 states. Knows
// no geometry and no path.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/cancel.h"
#include "base/error.h"
#include "base/event.h"
#include "expr/expression.h"

namespace sluice {

// What an event happened at: an object with its collections, a light, the world, the camera. Names as
// expressions write them.
struct Entity {
  std::vector<std::string> names;
  EventMask events = any_event;  // what can happen there at all
};

inline constexpr int max_dfa_states = 4096;

// Event classes of a scene.
class Alphabet {
 public:
  // L, E, D, S or G at entities[entity]; -1: a thing without a name.
  [[nodiscard]] EventClass event(Event kind, int entity) const noexcept {
    return classes_[static_cast<std::size_t>(entity + 1) * event_count + static_cast<std::size_t>(kind)];
  }
  // F: through a gate of edit `edit`.
  [[nodiscard]] EventClass gate(int edit) const noexcept { return gates_[static_cast<std::size_t>(edit)]; }
  [[nodiscard]] int size() const noexcept { return size_; }

 private:
  friend class AlphabetBuilder;
  std::vector<EventClass> classes_;  // [entity + 1][kind]
  std::vector<EventClass> gates_;    // [edit]
  int size_ = 0;
};

// Complete: every state has a successor for every class. State 0 is the start.
struct Dfa {
  int states = 0, columns = 0;
  std::vector<std::uint16_t> column;  // [event class]
  std::vector<std::uint16_t> next;    // [state * columns + column]
  std::vector<std::uint16_t> label;   // [state] -> accepting
  // [label] -> numbers of the expressions that accept, ascending
  std::vector<std::vector<std::uint16_t>> accepting;

  [[nodiscard]] std::uint16_t step(std::uint16_t state, EventClass event) const noexcept {
    return next[static_cast<std::size_t>(state) * static_cast<std::size_t>(columns) + column[event]];
  }
  [[nodiscard]] std::span<const std::uint16_t> accepts(std::uint16_t state) const noexcept {
    return accepting[label[state]];
  }
};

// One edit, layer or test expression on its way into an automaton.
struct Rule {
  std::string name;  // said in errors and warnings
  const Expression* expression = nullptr;
  // an edit that acts once: its own F cannot occur before it acts, so it need not be told apart
  int own_gate = -1;
  bool reversed = false;  // view edits are read from E backward
  bool is_layer = false;  // layers are read from L to E, by automata of their own
};

// F at edit g is an event at gates[g].
struct Automata {
  Alphabet alphabet;
  // for light edits, view edits and layers; accepting lists hold indices of rules
  std::vector<Dfa> forward, backward, layers;
};

// Throws ExpressionError naming the rule that does not fit into max_dfa_states alone.
[[nodiscard]] Automata compile_automata(std::span<const Rule> rules, std::span<const Entity> entities,
                                        std::span<const Entity> gates, const CancelPoint& cancel = {});

// Names that nothing bears: a warning on the rule, with the nearest name that exists.
void warn_unknown_names(std::span<const Rule> rules, std::span<const Entity> entities,
                        std::span<const Entity> gates, Warnings& warnings, const CancelPoint& cancel = {});

}  // namespace sluice
