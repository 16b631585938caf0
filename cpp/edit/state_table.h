// SPDX-License-Identifier: GPL-3.0-or-later
// What a path remembers for edits (design §3): states of the automata, gates taken, edits used. Contents are
// interned as met and transitions memoised, so that an event costs one array lookup. One table per thread;
// numbers differ between threads and contents do not, so photons carry numbers that threads share
// (transport/photons/photon_states.h). Knows no geometry but hands queries the candidates of a state.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "edit/quad_set.h"
#include "expr/dfa.h"
#include "expr/edit_set.h"

namespace sluice {

class Edits;

using StateId = std::uint32_t;

// The images that a whole path is part of: bit 0 is the picture itself, which every path belongs to, bit i +
// 1 is layer i.
using ImageSet = std::uint64_t;
inline constexpr ImageSet picture = 1, all_images = ~ImageSet{0};
inline constexpr int max_light_layers = 63;

// The edits that would take a path in some state.
struct TakingList {
  std::vector<std::uint16_t> edits;    // by `order`
  std::vector<std::uint64_t> members;  // the same as bits
  // Their entries; empty if there are many, when the set of all entries is asked instead.
  QuadSet quads;
};

// How large a table may grow. It is full when it reaches either limit.
struct StateLimits {
  std::size_t memory = std::size_t{1} << 29;  // bytes
  StateId states = (1u << 24) - 1;
};

class StateTable {
 public:
  // A path that finds the table full is dead: no edit takes it, and whatever happens to it, it stays dead.
  static constexpr StateId dead = 0;
  // The states before any event; the first event of a light state is an L, of a view state the E.
  static constexpr StateId light_start = 1, view_start = 2;

  // Keeps a pointer to `edits`. Copies are independent.
  explicit StateTable(const Edits& edits, const StateLimits& limits = {});

  // The state after one more event. Light states are fed in the order of light, view states backward from E.
  [[nodiscard, gnu::always_inline]] StateId next(StateId state, EventClass event) noexcept {
    const StateId known = next_[static_cast<std::size_t>(state) * classes_ + event];
    return known != unknown ? known : find_next(state, event);
  }
  // The state after going through `edit`: its F, one more gate, and the edit used up unless it repeats. Light
  // edits and view edits are gates to either side's states.
  [[nodiscard]] StateId through(StateId state, int edit) noexcept;

  // Edits of the state's own side whose entry would take the path (expression accepts, not used up). At the
  // cap too.
  [[nodiscard]] const TakingList& taking_list(StateId state) const noexcept { return *lists_[list_[state]]; }
  [[nodiscard]] bool takes_none(StateId state) const noexcept { return list_[state] == 0; }
  [[nodiscard]] bool takes(StateId state, int edit) const noexcept {
    return contains(lists_[list_[state]]->members, edit);
  }
  [[nodiscard]] int gates(StateId state) const noexcept { return gates_[state]; }
  // If so, an entry that would take the path absorbs it.
  [[nodiscard]] bool at_cap(StateId state) const noexcept { return gates_[state] >= max_gates_; }
  // Edits that have acted on the path, in ascending order; those that do not repeat are used up. The span
  // lives until the next state is interned.
  [[nodiscard]] std::span<const std::uint32_t> used(StateId state) const noexcept;

  // A number that the table's owner notes for a state; `no_note` until then.
  static constexpr std::uint32_t no_note = ~0u;
  [[nodiscard]] std::uint32_t& note(StateId state) noexcept { return notes_[state]; }

  // The images of a whole path, by its state behind E.
  [[nodiscard]] ImageSet images(StateId state) const noexcept {
    return images_.empty() ? picture : images_[state];
  }

  // Content: side, gates, automaton states, then used edits in ascending order. Equal in all tables of one
  // Edits: by it threads know each other's states. The span lives until the next state is interned.
  [[nodiscard]] std::span<const std::uint32_t> content(StateId state) const noexcept;
  [[nodiscard]] StateId intern(std::span<const std::uint32_t> content) noexcept;

  // States are 0 .. size() - 1.
  [[nodiscard]] StateId size() const noexcept { return static_cast<StateId>(list_.size()); }
  // An upper bound of the memory that it holds, as vectors grow to twice their use.
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  static constexpr StateId unknown = ~0u;

  [[nodiscard]] StateId find_next(StateId state, EventClass event) noexcept;
  [[nodiscard]] StateId advance(StateId state, EventClass event, int edit) noexcept;
  StateId append(std::span<const std::uint32_t> content, std::uint64_t hash);
  std::uint32_t list_for(std::span<const std::uint32_t> content);
  [[nodiscard]] std::span<const Dfa* const> automata_of(std::uint32_t side) const noexcept;
  [[nodiscard]] ImageSet images_for(std::span<const std::uint32_t> content) const noexcept;
  void grow_index();
  [[nodiscard]] bool is_full() const noexcept {
    return size() > view_start && (size() >= limits_.states || bytes_ >= limits_.memory);
  }

  const Edits* edits_;
  StateLimits limits_;
  std::size_t bytes_ = 0;
  std::size_t classes_;
  int max_gates_;
  std::vector<const Dfa*> automata_[2];  // [side]: of its edits, then, for light, of the layers
  std::size_t layers_at_;                // where those begin
  std::vector<StateId> next_;            // [state * classes_ + class]
  std::vector<std::uint16_t> gates_;     // [state]
  std::vector<std::uint32_t> list_;      // [state] -> lists_
  std::vector<std::uint32_t> notes_;     // [state]
  std::vector<ImageSet> images_;         // [state]; empty: there are no layers
  std::vector<std::uint64_t> hash_;      // [state]
  std::vector<std::size_t> begin_;       // [state] -> words_, one more at the end
  std::vector<std::uint32_t> words_, scratch_;
  std::vector<StateId> index_;                            // open addressing: slots of states, by content
  std::unordered_map<std::uint64_t, StateId> through_;    // (state, edit)
  std::vector<std::shared_ptr<const TakingList>> lists_;  // [0]: empty
  std::map<std::vector<std::uint16_t>, std::uint32_t> list_numbers_;  // edits -> lists_
};

}  // namespace sluice
