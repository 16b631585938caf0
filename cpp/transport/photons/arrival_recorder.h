// SPDX-License-Identifier: GPL-3.0-or-later
// An observer of light paths that writes down their events, and which of them cross the entry of one edit.
// Bounded: what does not fit is left out.
#pragma once
#include <array>
#include <optional>
#include <span>

#include "transport/photons/light_tracer.h"

namespace sluice {

class ArrivalRecorder {
 public:
  static constexpr bool sees = true;
  // A path's events so far: the number of the last of them, which knows the one before. -1: none yet.
  struct Word {
    int last = -1;
  };
  using Path = LightPath<Word>;

  explicit ArrivalRecorder(const Scene& scene) noexcept : scene_(scene) {}
  // From now on the entry of this edit is looked at.
  void watch(int edit) noexcept { edit_ = edit, clear(); }
  void clear() noexcept { event_count_ = crossing_count_ = 0, taker_ = -1; }

  // A path leaves a light, is scattered, or is moved by an edit: the longer word.
  [[nodiscard]] Word started(int light) noexcept;
  [[nodiscard]] Word scattered(const Word& word, Event event, const Hit& hit) noexcept;
  [[nodiscard]] Word moved(const Word& word, int edit) noexcept;
  // A piece of a path, up to what it meets; `capture`: an entry takes it before.
  void crossed(const Path& path, const Segment& segment, const std::optional<Crossing>& capture) noexcept;
  // The same for a path that has just left an exit in the entry's own plane: its next segment does not cross
  // that any more.
  void left_exit(const Path& path, const std::optional<Crossing>& capture) noexcept;

  struct Step {
    Word before;
    Event kind;
    int thing;  // an entity, or of F the edit; -1: none
  };
  struct Arrived {
    Word word;
    double energy;
    bool along;  // the entry's arrow
  };
  [[nodiscard]] const Step& step(const Word& word) const noexcept {
    return events_[static_cast<std::size_t>(word.last)];
  }
  // an edit that took the path on its way to the entry, -1: none
  [[nodiscard]] int taker() const noexcept { return taker_; }
  [[nodiscard]] std::span<const Arrived> arrived() const noexcept {
    return {crossings_.data(), static_cast<std::size_t>(crossing_count_)};
  }

 private:
  [[nodiscard]] const Quad& entry() const noexcept { return scene_.edits()[edit_].entry; }
  [[nodiscard]] Word add(const Step& step) noexcept;
  void note(const Path& path, const V3d& direction, const std::optional<Crossing>& taken_before) noexcept;
  [[nodiscard]] bool is_first(const Crossing& capture) const noexcept;  // of entries in one plane

  const Scene& scene_;
  int edit_ = 0;
  int event_count_ = 0, crossing_count_ = 0, taker_ = -1;
  std::array<Step, 1024> events_;
  std::array<Arrived, 64> crossings_;
};

}  // namespace sluice
