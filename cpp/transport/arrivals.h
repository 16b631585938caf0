// SPDX-License-Identifier: GPL-3.0-or-later
// What light arrives at an entry, by kind, whether its edit takes it or not: for artists whose expression
// finds nothing. Traces light paths of its own, which are no part of the image.
#pragma once
#include <array>
#include <atomic>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/event.h"
#include "edit/edits.h"
#include "transport/effects.h"
#include "transport/settings.h"

namespace sluice {

struct LightPath;

// Light paths write down their events here and which of them cross a quad. Bounded: what does not fit is left
// out.
class Witness {
 public:
  Witness(const Edits& edits, int edit) noexcept : edits_(edits), edit_(edit) {}

  // One word more: `word` (-1: none yet) and an event at an entity, or F of an edit. Returns the longer word.
  [[nodiscard]] int after(int word, Event kind, int thing) noexcept;
  // A piece of a path, up to what it meets; `capture`: an entry takes it before.
  void look(int word, double energy, const Segment& segment, const std::optional<Crossing>& capture) noexcept;
  // The same for a path that has just left an exit in the quad's own plane: its next segment does not cross
  // that any more.
  void look_at_exit(const LightPath& path, const std::optional<Crossing>& capture) noexcept;
  void clear() noexcept { event_count_ = crossing_count_ = 0, taker_ = -1; }

  struct Step {
    int before;
    Event kind;
    int thing;
  };
  struct Crossed {
    int word;
    double energy;
    bool along;  // the quad's arrow
  };
  [[nodiscard]] const Step& step(int word) const noexcept { return events_[static_cast<std::size_t>(word)]; }
  // an edit that took the path on its way to the quad, -1: none
  [[nodiscard]] int taker() const noexcept { return taker_; }
  [[nodiscard]] std::span<const Crossed> crossed() const noexcept {
    return {crossings_.data(), static_cast<std::size_t>(crossing_count_)};
  }

 private:
  void note(const Crossed& crossed, const std::optional<Crossing>& taken_before) noexcept;
  [[nodiscard]] bool is_first(const Crossing& capture) const noexcept;  // of entries in one plane

  const Edits& edits_;
  int edit_;
  int event_count_ = 0, crossing_count_ = 0, taker_ = -1;
  std::array<Step, 1024> events_;
  std::array<Crossed, 64> crossings_;
};

struct Arrivals {
  struct Kind {
    std::string expression;  // that takes it
    double share;            // of the energy that comes from its side
  };
  std::uint64_t probed = 0, crossed = 0;  // paths
  std::uint64_t taken = 0;                // paths that another edit took right before
  std::string taker;                      // the one that took most
  // the commonest first, few; of the side from which more energy comes
  std::vector<Kind> kinds;
};

// Per edit of the scene; nothing for view edits. On one thread, of a render on `threads`.
[[nodiscard]] std::vector<Arrivals> find_arrivals(const Scene& scene, const TransportSettings& settings,
                                                  const Effects& effects, int threads,
                                                  const std::atomic<bool>& cancel);

}  // namespace sluice
