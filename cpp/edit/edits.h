// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled edits (paper §4), and the questions that paths ask them: which entries a segment meets, and which
// of them take a path in its state. Immutable after compile_edits(). All positions are re-centred: world =
// position + centre. Knows no surfaces, lights or pixels; counting and the order of decisions along a path
// are the caller's.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "base/image.h"
#include "edit/description.h"
#include "edit/gate.h"
#include "edit/quad.h"
#include "edit/quad_set.h"
#include "edit/state_table.h"
#include "expr/automaton.h"
#include "expr/reach.h"
#include "expr/side.h"

namespace sluice {

static_assert(straight_on == QuadId::entry);  // the implicit exit's quad is the entry's

class Edits {
 public:
  [[nodiscard]] int size() const noexcept { return static_cast<int>(edits_.size()); }
  [[nodiscard]] const Edit& operator[](int edit) const noexcept {
    return edits_[static_cast<std::size_t>(edit)];
  }
  // The edits of a side whose expression some path of the scene can fulfil, and those of them that may take a
  // path right after an event. Other edits need not be asked.
  [[nodiscard]] EditSet could_take(Side side) const noexcept { return reach_[index(side)].any(); }
  // How many edits light must be told apart by: none if no path of the scene can match one of them, else all.
  [[nodiscard]] int told_apart() const noexcept {
    return is_empty(could_take(Side::Light)) && is_empty(could_take(Side::View)) ? 0 : size();
  }
  [[nodiscard]] EditSet could_take_after(Side side, EventClass last) const noexcept {
    return reach_[index(side)].after(last);
  }
  [[nodiscard]] int max_gates() const noexcept { return max_gates_; }
  // How far (m) each quad floats in front of its own plane, its own offset left aside (design §2).
  [[nodiscard]] double delta() const noexcept { return delta_; }
  [[nodiscard]] const Automata& automata() const noexcept { return automata_; }

  [[nodiscard]] std::span<const LayerDescription> layers() const noexcept { return layers_; }

  // An edit's entry (exit < 0) or exit.
  [[nodiscard]] const Quad& quad(int edit, int exit) const noexcept;

  // The symbols that paths are spelled with: L, E, D, S, G at an entity (-1: one without a name), F at an
  // edit.
  [[nodiscard]] EventClass event_class(Event kind, int entity) const noexcept {
    return automata_.alphabet.event(kind, entity);
  }
  [[nodiscard]] EventClass gate_class(int edit) const noexcept { return automata_.alphabet.gate(edit); }

  // The first crossing of the segment with an entry that takes a path in `state`: entries of light edits for
  // light states, of view edits for view states. Of crossings at the same t the lowest order is first.
  [[nodiscard]] std::optional<Crossing> first_taken(const StateTable& table, StateId state,
                                                    const Segment& segment) const noexcept;
  [[nodiscard]] bool any_taken(const StateTable& table, StateId state, const Segment& segment) const noexcept;
  // Right after leaving `exit` of `edit` (straight_on: at the entry itself) at `point`, with the state behind
  // the gate: the first entry by order of the exit's plane group, other than edit's own, that contains the
  // point and takes the state.
  [[nodiscard]] std::optional<Crossing> first_taken_at_exit(const StateTable& table, StateId state, int edit,
                                                            int exit, const V3d& point) const noexcept;

  // For view rays, which meet the gates of light backward: all entries and exits of one side's edits on a
  // segment, sorted by t, then plane group, entries before exits, then order. If `members` is not empty, only
  // its edits count. `out` is the caller's scratch memory; it is cleared first.
  void crossings(Side side, const Segment& segment, EditSet members, std::vector<Crossing>& out) const;
  // The same for entries alone, where no gate can be met backward.
  void entries_crossed(Side side, const Segment& segment, EditSet members, std::vector<Crossing>& out) const;
  [[nodiscard]] bool any_entry_crossed(Side side, const Segment& segment, EditSet members) const noexcept {
    return entries_[index(side)].any(segment, members);
  }
  // Finds the numbers of the entries in a cone round the segment (QuadSet::in_cone); the second function asks
  // these alone.
  [[nodiscard]] bool entries_in_cone(Side side, const Segment& segment, double radius, EditSet members,
                                     std::size_t max_count, std::vector<std::uint32_t>& out) const {
    out.clear();
    return entries_[index(side)].in_cone(segment, radius, members, max_count, out);
  }
  [[nodiscard]] bool any_of_entries_crossed(Side side, const Segment& segment,
                                            std::span<const std::uint32_t> numbers) const noexcept {
    return entries_[index(side)].any_of(numbers, segment);
  }
  [[nodiscard]] bool has_exits(Side side) const noexcept { return !exits_[index(side)].empty(); }
  [[nodiscard]] bool any_exit_crossed(Side side, const Segment& segment, EditSet members) const noexcept {
    return exits_[index(side)].any(segment, members);
  }
  [[nodiscard]] bool is_crossed(const QuadId& id, const Segment& segment) const noexcept;
  // crossings() of a single point of a plane group, all at t = 0: where a ray arrives that went backward
  // through an exit.
  void crossings_at(Side side, int group, const V3d& point, EditSet members,
                    std::vector<Crossing>& out) const;

  // The functions of gate.h for an edit's number.
  [[nodiscard]] float weight(int edit, const V2d& uv) const noexcept {
    return entry_weight((*this)[edit], uv);
  }
  [[nodiscard]] std::optional<Passage> forward(int edit, int exit, const V2d& uv,
                                               const V3f& direction) const noexcept {
    return pass_forward((*this)[edit], exit, uv, direction, images_);
  }
  [[nodiscard]] std::optional<Passage> backward(int edit, int exit, const V2d& uv,
                                                const V3f& direction) const noexcept {
    return pass_backward((*this)[edit], exit, uv, direction, images_);
  }

 private:
  friend class EditsBuilder;
  std::vector<Edit> edits_;
  std::vector<LayerDescription> layers_;
  int max_gates_ = 0;
  double delta_ = 0;
  Automata automata_;
  Reach reach_[2];  // [side]
  std::vector<Image> images_;
  std::vector<std::vector<QuadId>> groups_;  // [plane group]: entries by order, then exits by order
  QuadSet entries_[2], exits_[2];            // [side]
};

}  // namespace sluice
