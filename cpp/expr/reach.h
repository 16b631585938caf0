// SPDX-License-Identifier: GPL-3.0-or-later
// Which expressions a path can fulfil at all, and right after which event: a fixed point over the automata
// with the events that the scene can make. Segments ask only the edits that could take them (design §2: what
// no state accepts makes no query). An answer may hold too many edits (gates used up, depth), never too few.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "base/cancel.h"
#include "expr/dfa.h"
#include "expr/edit_set.h"

namespace sluice {

class Reach {
 public:
  Reach() = default;
  // `occurs`: per event class, can the scene make it?
  Reach(std::span<const Dfa> automata, const std::vector<char>& occurs, int edits,
        const CancelPoint& cancel = {});

  // The edits that may take a path whose last event is of this class (the span is empty if there are none),
  // and those that may take a path after any event.
  [[nodiscard]] EditSet after(EventClass last) const noexcept {
    return {bits_.data() + static_cast<std::size_t>(last) * words_, size_[last]};
  }
  [[nodiscard]] EditSet any() const noexcept { return {any_.data(), any_.size()}; }

 private:
  std::size_t words_ = 0;
  std::vector<std::uint64_t> bits_, any_;  // [class][word]
  std::vector<std::size_t> size_;          // [class] -> words_, or 0 where no bit is set
};

}  // namespace sluice
