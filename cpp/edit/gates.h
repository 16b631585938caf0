// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled edits (paper §4): which entries a path meets and is taken by, and T = (T_p, T_d, T_s) from an
// entry to its exits, forward with light and backward with view rays. Immutable after compile_edits(). All
// positions are re-centred: world = position + centre. Knows no surfaces, lights or pixels; counting and the
// order of decisions along a path are the caller's.
#pragma once
#include <Imath/ImathBox.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/cancel.h"
#include "base/image.h"
#include "edit/automaton.h"
#include "edit/edit.h"
#include "edit/expression.h"
#include "edit/path_state.h"
#include "edit/quad.h"
#include "edit/quad_set.h"
#include "edit/reach.h"

namespace sluice {

using Box = Imath::Box<V3d>;

// The scene that edits are compiled for, world coordinates.
struct EditSpace {
  V3d centre{0};  // origin of re-centring
  Box bounds;     // of the scene without quads (may be empty)
};

// World bounds of the quads that will act (enabled, not refused); empty if there are none.
[[nodiscard]] Box quad_bounds(std::span<const EditDescription> edits, const Box& scene_bounds);

// numerics P8: gains of a chain must not overflow
inline constexpr float max_intensity = 1e4f, max_area_ratio = 1e6f;

struct Exit {
  Quad quad;
  std::string name;
  float intensity = 1, hue_shift = 0;
  Color tint{1};             // of luminance 1; exactly white unless it colours
  float area_ratio = 1;      // σ on flux: area of exit / area of entry, <= 1e6; 1 when off
  float radiance_ratio = 1;  // σ area of entry / area of exit: 1 when area_ratio is on
  int intensity_texture = -1, hue_shift_texture = -1, normal_map = -1;  // into the edits' own images
};

// One acting edit. Disabled edits and those that were refused are not here at all.
struct Edit {
  std::string name;
  std::size_t description = 0;  // index into the descriptions
  Side side = Side::Light;
  int order = 0;
  bool repeat = false;
  bool is_partial = false;  // amount or feather leave light to go straight on
  float amount = 1, feather = 0;
  Quad entry;
  std::vector<Exit> exits;
};

// The implicit exit that leads straight on, with what the entry's weight leaves.
inline constexpr int straight_on = -1;

// How a path goes on at the far side of a gate. The gain is without the entry's weight; light has it after H.
struct Passage {
  V3d position;   // on the far quad
  V3f direction;  // unit, of travel
  // tint included; light edit forward: of flux; backward: of radiance; view edit forward: of radiance
  Color gain{1};
  float hue = 0;   // H's angle, radians; 0: none
  int group = -1;  // plane group of the far quad: the next segment excludes it
};

// M_d of the paper for a texel of a normal map: columns t, b, n of an orthogonal turn. Identity where the
// texel is no normal.
[[nodiscard]] QuadFrame normal_map_turn(const Color& texel) noexcept;

class Edits {
 public:
  [[nodiscard]] int size() const noexcept { return static_cast<int>(edits_.size()); }
  [[nodiscard]] const Edit& operator[](int edit) const noexcept {
    return edits_[static_cast<std::size_t>(edit)];
  }
  // Edits of a side that some path of the scene can fulfil; of those, the ones that may take a path right
  // after an event. The others are never asked.
  [[nodiscard]] EditSet takers(Side side) const noexcept { return reach_[index(side)].any(); }
  [[nodiscard]] EditSet takers_after(Side side, EventClass last) const noexcept {
    return reach_[index(side)].after(last);
  }
  [[nodiscard]] int max_gates() const noexcept { return max_gates_; }
  // how far quads float, without their own offset
  [[nodiscard]] double delta() const noexcept { return delta_; }
  [[nodiscard]] const Box& bounds() const noexcept { return bounds_; }  // of all quads, re-centred
  [[nodiscard]] const Automata& automata() const noexcept { return automata_; }

  [[nodiscard]] std::span<const LayerDescription> layers() const noexcept { return layers_; }

  // An edit's entry (exit < 0) or exit.
  [[nodiscard]] const Quad& quad(int edit, int exit) const noexcept;

  // Symbols of path words: L, E, D, S, G at an entity (-1: nameless), F at an edit.
  [[nodiscard]] EventClass event_class(Event kind, int entity) const noexcept {
    return automata_.alphabet.event(kind, entity);
  }
  [[nodiscard]] EventClass gate_class(int edit) const noexcept { return automata_.alphabet.gate(edit); }

  // Entries that take a path in `state` (light states: entries of light edits; view states: of view edits).
  // The earliest crossing with t_min < t <= t_max; at one t the lowest order. Empty at once if the state
  // takes nothing.
  [[nodiscard]] std::optional<Crossing> first_taken(const StateTable& table, StateId state,
                                                    const Segment& segment) const noexcept;
  [[nodiscard]] bool any_taken(const StateTable& table, StateId state, const Segment& segment) const noexcept;
  // Right after leaving `exit` of `edit` (straight_on: at the entry itself) at `point`, with the state behind
  // the gate: the first entry by order of the exit's plane group, other than edit's own, that contains the
  // point and takes the state.
  [[nodiscard]] std::optional<Crossing> first_taken_at_exit(const StateTable& table, StateId state, int edit,
                                                            int exit, const V3d& point) const noexcept;

  // For view rays, which meet the gates of light backward: all entries and exits of one side's edits on a
  // segment, sorted by t, then plane group, entries before exits, then order. `members` (empty: all) narrows.
  // `out` is the caller's scratch: cleared first, its capacity kept.
  void crossings(Side side, const Segment& segment, EditSet members, std::vector<Crossing>& out) const;
  // Entries alone, where no gate can be met backward.
  void entries_crossed(Side side, const Segment& segment, EditSet members, std::vector<Crossing>& out) const;
  [[nodiscard]] bool any_entry_crossed(Side side, const Segment& segment, EditSet members) const noexcept {
    return entries_[index(side)].any(segment, members);
  }
  // Those in a cone round the segment, by numbers, and the question to these alone (quad_set.h). `out`:
  // cleared first.
  [[nodiscard]] bool entries_in_cone(Side side, const Segment& segment, double radius, EditSet members,
                                     std::size_t most, std::vector<std::uint32_t>& out) const {
    out.clear();
    return entries_[index(side)].in_cone(segment, radius, members, most, out);
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
  // The same for a point of a plane group (t = 0): where a ray that went backward through an exit arrives.
  void crossings_at(Side side, int group, const V3d& point, EditSet members,
                    std::vector<Crossing>& out) const;

  // a(u, v) = amount × feather: what the exits get. The straight_on exit gets 1 - a.
  [[nodiscard]] float weight(int edit, const V2d& uv) const noexcept;

  // From the entry at uv, going in `direction`, out of an exit. Light edits: flux gain. View edits carry
  // radiance: intensity alone. Empty (to be counted) where a normal_map leaves |cos| < 1e-3 at the exit of a
  // light edit.
  [[nodiscard]] std::optional<Passage> forward(int edit, int exit, const V2d& uv,
                                               const V3f& direction) const noexcept;
  // A view ray going in `direction` meets an exit of a light edit at uv from behind: on from the entry.
  // Radiance gain.
  [[nodiscard]] std::optional<Passage> backward(int edit, int exit, const V2d& uv,
                                                const V3f& direction) const noexcept;

 private:
  friend class EditsBuilder;
  [[nodiscard]] float intensity(const Exit& exit, const V2d& uv) const noexcept;
  [[nodiscard]] float hue(const Exit& exit, const V2d& uv) const noexcept;
  [[nodiscard]] std::optional<QuadFrame> turn(const Exit& exit, const V2d& uv) const noexcept;

  std::vector<Edit> edits_;
  std::vector<LayerDescription> layers_;
  int max_gates_ = 0;
  double delta_ = 0;
  Box bounds_;
  Automata automata_;
  Reach reach_[2];  // [side]
  std::vector<Image> images_;
  std::vector<std::vector<QuadId>> groups_;  // [plane group]: entries by order, then exits by order
  QuadSet entries_[2], exits_[2];            // [side]
};

// Layers share the edits' alphabet and are read along with them. Throws ExpressionError; degenerate quads and
// unknown names become warnings.
[[nodiscard]] Edits compile_edits(std::span<const EditDescription> descriptions,
                                  std::span<const Entity> entities, std::span<const Image> images,
                                  const EditSpace& space, int max_gates, Warnings& warnings,
                                  std::span<const LayerDescription> layers = {},
                                  const CancelPoint& cancel = {});

}  // namespace sluice
