// SPDX-License-Identifier: GPL-3.0-or-later
// What both oracles know of edits: which entry takes light that goes forward in some state, read straight
// from paper §4.1 and design §2. Also their random numbers and what they bring back.
#pragma once
#include <array>

#include "oracle/gates.h"
#include "oracle/words.h"
#include "transport/film.h"
#include "transport/settings.h"

namespace sluice::oracle {

// Light's history: the word so far, edits used up.
struct History {
  Word word;
  std::uint64_t used = 0;
  int gates = 0;
};

class Rules {
 public:
  Rules(const SceneDescription& description, const Scene& scene, int max_gates)
      : gates(description, scene), words(description, scene), max_gates_(max_gates) {}

  Gates gates;
  Words words;

  [[nodiscard]] bool takes(const History& h, int edit) {
    return (gates.edit(edit).repeat || !((h.used >> edit) & 1)) && words.accepts(edit, h.word);
  }
  [[nodiscard]] bool at_cap(const History& h) const { return h.gates >= max_gates_; }
  void through(History& h, int edit) const {
    h.word += words.gate(edit);
    h.used |= std::uint64_t{1} << edit;
    ++h.gates;
  }

  // The entry that takes light on a segment.
  [[nodiscard]] std::optional<Meeting> capture_on(const History& h, const V3d& origin, const V3d& direction,
                                                  double t_end, int skipped_plane) {
    if (gates.empty()) return {};
    return first(h, gates.along(origin, direction, t_end, skipped_plane), -1);
  }
  // Light has just left an exit (-1: gone straight on at the entry) at `point`: it crosses the plane's
  // entries, all but its own.
  [[nodiscard]] std::optional<Meeting> capture_at(const History& h, int edit, int exit, const V3d& point) {
    return first(h, gates.at(gates.gate(edit, exit).plane, point), edit);
  }

 private:
  [[nodiscard]] std::optional<Meeting> first(const History& h, const Meetings& met, int own) {
    for (const Meeting& m : met)
      if (m.gate->is_entry() && !m.gate->of_view && m.gate->edit != own && takes(h, m.gate->edit)) return m;
    return {};
  }
  int max_gates_;
};

// A plain random stream (PCG32).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ull + 0xda3e39cb94b95bdbull) {
    unit(), unit();
  }
  float unit() {
    const std::uint64_t s = state_;
    state_ = s * 6364136223846793005ull + 1442695040888963407ull;
    const auto x = static_cast<std::uint32_t>(((s >> 18) ^ s) >> 27), r = static_cast<std::uint32_t>(s >> 59);
    return static_cast<float>(((x >> r) | (x << ((32 - r) & 31))) >> 8) * 0x1p-24f;
  }
  V2f pair() {
    const float x = unit();
    return {x, unit()};
  }
  int below(int n) { return std::min(static_cast<int>(unit() * static_cast<float>(n)), n - 1); }

 private:
  std::uint64_t state_;
};

// Mean radiance of the image's regions (side × side of them), by the part of Combined it belongs to.
using Parts = std::array<V3d, part_count>;
struct Regions {
  int side = 0;
  std::vector<Parts> mean;

  explicit Regions(int per_side) : side(per_side), mean(static_cast<std::size_t>(per_side * per_side)) {
    for (Parts& p : mean) p.fill(V3d(0));
  }
  // continuous pixel coordinates
  [[nodiscard]] V3d& at(double x, double y, const FrameDescription& frame, Part part) {
    const auto cell = [&](double c, int pixels) {
      return std::clamp(static_cast<int>(c * side / pixels), 0, side - 1);
    };
    return mean[static_cast<std::size_t>(cell(y, frame.height) * side + cell(x, frame.width))]
               [static_cast<std::size_t>(part)];
  }
};

// Design §5: the class of light at v is the last event before it.
inline Part part_of(Event before_v) {
  switch (before_v) {
    case Event::L: return Part::Direct;
    case Event::S: return Part::Caustics;
    case Event::F: return Part::Edited;
    default: return Part::Indirect;
  }
}

}  // namespace sluice::oracle
