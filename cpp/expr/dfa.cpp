// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/dfa.h"

#include <algorithm>
#include <bit>
#include <map>
#include <unordered_map>

#include "base/random.h"
#include "expr/positions.h"

namespace sluice {

namespace {

// Numbers pairs (a, b) in the order in which they are first seen. Clearing is free, which minimisation lives
// by.
class PairNumbers {
 public:
  explicit PairNumbers(std::size_t most) : slots_(std::bit_ceil(2 * most + 2)) {}

  void clear() noexcept {
    ++epoch_;
    count_ = 0;
  }
  [[nodiscard]] std::uint32_t size() const noexcept { return count_; }
  [[nodiscard]] std::uint32_t number(std::uint32_t a, std::uint32_t b) noexcept {
    const std::uint64_t key = (static_cast<std::uint64_t>(a) << 32) | b;
    for (std::size_t i = mix(key);; ++i) {
      Slot& slot = slots_[i & (slots_.size() - 1)];
      if (slot.epoch != epoch_) {
        slot = {key, epoch_, count_};
        return count_++;
      }
      if (slot.key == key) return slot.number;
    }
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t epoch = 0, number = 0;
  };
  std::vector<Slot> slots_;  // at least twice as many as pairs are ever seen between two clears
  std::uint32_t epoch_ = 1, count_ = 0;
};

struct PositionSetHash {
  std::size_t operator()(const PositionSet& set) const noexcept {
    std::uint64_t h = 0;
    for (const std::uint64_t w : set.words) h = mix(h ^ w);
    return h;
  }
};

}  // namespace

std::optional<Dfa> determinised(const Positions& positions, std::span<const std::uint32_t> meaning,
                                std::span<const Bits> matchers, int classes, std::uint16_t number) {
  Dfa dfa;
  dfa.accepting = {{}, {number}};
  // Events that match the same positions share a column.
  std::vector<PositionSet> masks;
  std::unordered_map<PositionSet, std::uint16_t, PositionSetHash> column_of;
  for (int c = 0; c < classes; ++c) {
    PositionSet mask;
    for (int p = 0; p < positions.size(); ++p) {
      const auto atom = static_cast<std::size_t>(positions.atoms[static_cast<std::size_t>(p)]);
      if (has_bit(matchers[meaning[atom]], static_cast<std::size_t>(c))) mask.insert(p);
    }
    const auto [it, is_new] = column_of.try_emplace(mask, static_cast<std::uint16_t>(masks.size()));
    if (is_new) masks.push_back(mask);
    dfa.column.push_back(it->second);
  }
  dfa.columns = static_cast<int>(masks.size());

  // A state is the set of positions that the last event may have been; the start has read nothing and is like
  // no other.
  std::vector<PositionSet> sets{PositionSet{}};
  std::unordered_map<PositionSet, std::uint16_t, PositionSetHash> state_of;
  dfa.label.push_back(positions.nullable ? 1 : 0);
  for (std::size_t s = 0; s < sets.size(); ++s) {
    PositionSet follow = s == 0 ? positions.first : PositionSet{};
    if (s > 0) sets[s].for_each([&](int p) { follow |= positions.follow[static_cast<std::size_t>(p)]; });
    for (const PositionSet& mask : masks) {
      const PositionSet to = follow & mask;
      const auto [it, is_new] = state_of.try_emplace(to, static_cast<std::uint16_t>(sets.size()));
      if (is_new) {
        if (sets.size() == max_dfa_states) return std::nullopt;
        sets.push_back(to);
        dfa.label.push_back((to & positions.last).empty() ? 0 : 1);
      }
      dfa.next.push_back(it->second);
    }
  }
  dfa.states = static_cast<int>(sets.size());
  return dfa;
}

// Moore's refinement: states are equal until a label or a successor tells them apart. Rounds grow with the
// longest word that is needed to tell two states apart; automata where that is absurdly long are returned as
// they are.
Dfa minimised(const Dfa& dfa, const CancelPoint& cancel) {
  constexpr int max_rounds = 300;
  const auto n = static_cast<std::size_t>(dfa.states), columns = static_cast<std::size_t>(dfa.columns);
  std::vector<std::uint32_t> block(dfa.label.begin(), dfa.label.end()), refined(n);
  PairNumbers pairs(n);
  std::uint32_t count = 0;
  for (int round = 0;; ++round) {
    if (round == max_rounds) return dfa;
    cancel();
    refined = block;
    std::uint32_t found = count;
    for (std::size_t c = 0; c < columns; ++c) {
      pairs.clear();
      for (std::size_t s = 0; s < n; ++s)
        refined[s] = pairs.number(refined[s], block[dfa.next[s * columns + c]]);
      found = pairs.size();
    }
    block.swap(refined);
    if (found == count) break;
    count = found;
  }

  Dfa out;
  out.columns = dfa.columns;
  out.column = dfa.column;
  out.accepting = dfa.accepting;
  std::vector<int> number(count, -1);
  std::vector<std::size_t> met{0};  // one old state per new one
  number[block[0]] = 0;
  for (std::size_t i = 0; i < met.size(); ++i) {
    out.label.push_back(dfa.label[met[i]]);
    for (std::size_t c = 0; c < columns; ++c) {
      const std::size_t to = dfa.next[met[i] * columns + c];
      int& known = number[block[to]];
      if (known < 0) {
        known = static_cast<int>(met.size());
        met.push_back(to);
      }
      out.next.push_back(static_cast<std::uint16_t>(known));
    }
  }
  out.states = static_cast<int>(met.size());
  return out;
}

std::optional<Dfa> product(const Dfa& a, const Dfa& b) {
  Dfa out;
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::uint16_t> columns, labels;
  for (std::size_t c = 0; c < a.column.size(); ++c)
    out.column.push_back(
        columns.emplace(std::pair(a.column[c], b.column[c]), static_cast<std::uint16_t>(columns.size()))
            .first->second);
  std::vector<std::pair<std::uint16_t, std::uint16_t>> column_list(columns.size());
  for (const auto& [pair, number] : columns) column_list[number] = pair;
  out.columns = static_cast<int>(columns.size());

  PairNumbers numbers(std::min<std::size_t>(
      static_cast<std::size_t>(a.states) * static_cast<std::size_t>(b.states), max_dfa_states + 1));
  std::vector<std::pair<std::uint16_t, std::uint16_t>> states{{0, 0}};
  (void)numbers.number(0, 0);
  for (std::size_t s = 0; s < states.size(); ++s) {
    const auto [sa, sb] = states[s];
    const auto [label, is_new] =
        labels.emplace(std::pair(a.label[sa], b.label[sb]), static_cast<std::uint16_t>(labels.size()));
    if (is_new) {
      auto& both = out.accepting.emplace_back(a.accepts(sa).begin(), a.accepts(sa).end());
      both.insert(both.end(), b.accepts(sb).begin(), b.accepts(sb).end());
      std::sort(both.begin(), both.end());
    }
    out.label.push_back(label->second);
    for (const auto& [ca, cb] : column_list) {
      const std::uint16_t ta =
          a.next[static_cast<std::size_t>(sa) * static_cast<std::size_t>(a.columns) + ca];
      const std::uint16_t tb =
          b.next[static_cast<std::size_t>(sb) * static_cast<std::size_t>(b.columns) + cb];
      const std::uint32_t to = numbers.number(ta, tb);
      if (to == states.size()) {
        if (to == max_dfa_states) return std::nullopt;
        states.emplace_back(ta, tb);
      }
      out.next.push_back(static_cast<std::uint16_t>(to));
    }
  }
  out.states = static_cast<int>(states.size());
  return out;
}

}  // namespace sluice
