// SPDX-License-Identifier: GPL-3.0-or-later
// The alphabet that a scene's expressions are read in: things with names, and the classes of events at them
// that no expression can tell apart (event_classes.h finds these).
#pragma once
#include <string>
#include <vector>

#include "base/event.h"

namespace sluice {

// What an event happened at: an object with its collections, a light, the world, the camera. Names as
// expressions write them.
struct Entity {
  std::vector<std::string> names;
  EventMask events = any_event;  // what can happen there at all
};

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

}  // namespace sluice
