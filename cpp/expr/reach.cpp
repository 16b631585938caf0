// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/reach.h"

namespace sluice {

Reach::Reach(std::span<const Dfa> automata, const std::vector<char>& occurs, int edits,
             const CancelPoint& cancel)
    : words_((static_cast<std::size_t>(edits) + 63) / 64) {
  bits_.assign(occurs.size() * words_, 0);
  any_.assign(words_, 0);
  for (const Dfa& dfa : automata) {
    std::vector<char> met(static_cast<std::size_t>(dfa.states), 0);
    std::vector<std::uint16_t> open{0};
    met[0] = 1;
    while (!open.empty()) {
      const std::uint16_t state = open.back();
      open.pop_back();
      cancel();
      for (std::size_t event = 0; event < occurs.size(); ++event) {
        if (!occurs[event]) continue;
        const std::uint16_t to = dfa.step(state, static_cast<EventClass>(event));
        for (const std::uint16_t edit : dfa.accepts(to))
          bits_[event * words_ + edit / 64] |= std::uint64_t{1} << (edit % 64);
        if (!met[to]) met[to] = 1, open.push_back(to);
      }
    }
  }
  for (std::size_t i = 0; i < bits_.size(); ++i) any_[i % words_] |= bits_[i];
  for (std::size_t event = 0; event < occurs.size(); ++event)
    size_.push_back(is_empty({bits_.data() + event * words_, words_}) ? 0 : words_);
}

}  // namespace sluice
