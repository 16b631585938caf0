// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/state_table.h"

#include <algorithm>
#include <new>

#include "base/random.h"
#include "edit/edits.h"

namespace sluice {

namespace {

// Words of a content: side, gates, automaton states, used edits.
constexpr std::size_t side_word = 0, gates_word = 1, states_word = 2;
constexpr std::uint32_t no_side = 2;  // of the dead state

// What a state, a list of edits and a remembered gate take beside their arrays.
constexpr std::size_t bytes_of_state = 48, bytes_of_list = 256, bytes_of_gate = 48;

std::uint64_t hash_of(std::span<const std::uint32_t> content) noexcept {
  std::uint64_t h = content.size();
  for (const std::uint32_t w : content) h = mix(h ^ w);
  return h;
}

}  // namespace

StateTable::StateTable(const Edits& edits, const StateLimits& limits)
    : edits_(&edits),
      limits_(limits),
      classes_(static_cast<std::size_t>(edits.automata().alphabet.size())),
      max_gates_(edits.max_gates()),
      layers_at_(edits.automata().forward.size()),
      begin_{0} {
  const auto add = [](std::vector<const Dfa*>& to, const std::vector<Dfa>& dfas) {
    for (const Dfa& dfa : dfas) to.push_back(&dfa);
  };
  add(automata_[static_cast<std::size_t>(Side::Light)], edits.automata().forward);
  add(automata_[static_cast<std::size_t>(Side::Light)], edits.automata().layers);
  add(automata_[static_cast<std::size_t>(Side::View)], edits.automata().backward);
  lists_.push_back(std::make_shared<TakingList>());
  list_numbers_.emplace(std::vector<std::uint16_t>{}, 0u);
  grow_index();
  (void)intern(std::vector<std::uint32_t>{no_side, 0});
  std::fill(next_.begin(), next_.end(), dead);
  for (const Side side : {Side::Light, Side::View}) {
    std::vector<std::uint32_t> start{static_cast<std::uint32_t>(side), 0};
    start.resize(states_word + automata_of(start[side_word]).size(), 0);
    (void)intern(start);
  }
}

std::span<const Dfa* const> StateTable::automata_of(std::uint32_t side) const noexcept {
  return side == no_side ? std::span<const Dfa* const>() : automata_[side];
}

std::span<const std::uint32_t> StateTable::content(StateId state) const noexcept {
  return {words_.data() + begin_[state], words_.data() + begin_[state + 1]};
}

std::span<const std::uint32_t> StateTable::used(StateId state) const noexcept {
  const auto all = content(state);
  return all.subspan(states_word + automata_of(all[side_word]).size());
}

// Content after one more event; edit >= 0: the event is its gate.
StateId StateTable::advance(StateId state, EventClass event, int edit) noexcept {
  if (state == dead) return dead;
  try {
    const auto from = content(state);
    scratch_.assign(from.begin(), from.end());
    const auto automata = automata_of(scratch_[side_word]);
    for (std::size_t i = 0; i < automata.size(); ++i) {
      std::uint32_t& s = scratch_[states_word + i];
      s = automata[i]->step(static_cast<std::uint16_t>(s), event);
    }
    if (edit >= 0) {
      ++scratch_[gates_word];
      const auto used = scratch_.begin() + static_cast<std::ptrdiff_t>(states_word + automata.size());
      const auto at = std::lower_bound(used, scratch_.end(), static_cast<std::uint32_t>(edit));
      if (at == scratch_.end() || *at != static_cast<std::uint32_t>(edit))
        scratch_.insert(at, static_cast<std::uint32_t>(edit));
    }
    return intern(scratch_);
  } catch (const std::bad_alloc&) { return dead; }
}

// That the table is full is not memoised, so that every path that meets it is counted.
StateId StateTable::find_next(StateId state, EventClass event) noexcept {
  const StateId to = advance(state, event, -1);
  if (to != dead) next_[static_cast<std::size_t>(state) * classes_ + event] = to;
  return to;
}

StateId StateTable::through(StateId state, int edit) noexcept {
  const std::uint64_t key = (static_cast<std::uint64_t>(state) << 32) | static_cast<std::uint32_t>(edit);
  if (const auto known = through_.find(key); known != through_.end()) return known->second;
  const StateId to = advance(state, edits_->gate_class(edit), edit);
  try {
    if (to != dead && bytes_ < limits_.memory) through_.emplace(key, to), bytes_ += bytes_of_gate;
  } catch (const std::bad_alloc&) {}
  return to;
}

StateId StateTable::intern(std::span<const std::uint32_t> content) noexcept {
  const std::uint64_t hash = hash_of(content);
  for (std::size_t i = hash;; ++i) {
    const StateId known = index_[i & (index_.size() - 1)];
    if (known == unknown) break;
    if (hash_[known] == hash && std::ranges::equal(this->content(known), content)) return known;
  }
  if (!is_full()) {
    try {
      return append(content, hash);
    } catch (const std::bad_alloc&) {}
  }
  return dead;
}

// Sizes are set from the number of states, and list_ grows last, so that running out of memory midway leaves
// the table as it was.
StateId StateTable::append(std::span<const std::uint32_t> content, std::uint64_t hash) {
  // the caller's span may lie in words_
  const std::vector<std::uint32_t> copy(content.begin(), content.end());
  const std::size_t n = list_.size();
  if (2 * (n + 1) > index_.size()) grow_index();
  const std::uint32_t list = list_for(copy);
  next_.resize((n + 1) * classes_, unknown);
  gates_.resize(n + 1);
  gates_[n] = static_cast<std::uint16_t>(std::min<std::uint32_t>(copy[gates_word], 0xffff));
  hash_.resize(n + 1);
  hash_[n] = hash;
  words_.resize(begin_[n]);
  words_.insert(words_.end(), copy.begin(), copy.end());
  begin_.resize(n + 1);
  begin_.push_back(words_.size());
  if (!edits_->automata().layers.empty()) {
    images_.resize(n + 1);
    images_[n] = images_for(copy);
  }
  list_.push_back(list);
  notes_.push_back(no_note);
  bytes_ += 2 * ((classes_ + copy.size()) * sizeof(StateId) + bytes_of_state);
  std::size_t slot = hash & (index_.size() - 1);
  while (index_[slot] != unknown) slot = (slot + 1) & (index_.size() - 1);
  index_[slot] = static_cast<StateId>(n);
  return static_cast<StateId>(n);
}

void StateTable::grow_index() {
  std::vector<StateId> larger(std::max<std::size_t>(64, 2 * index_.size()), unknown);
  for (StateId state = 0; state < size(); ++state) {
    std::size_t slot = hash_[state] & (larger.size() - 1);
    while (larger[slot] != unknown) slot = (slot + 1) & (larger.size() - 1);
    larger[slot] = state;
  }
  index_ = std::move(larger);
}

// Edits whose expression accepts in this content and that are not used up, by order.
std::uint32_t StateTable::list_for(std::span<const std::uint32_t> content) {
  const auto automata = automata_of(content[side_word]);
  const auto used = content.subspan(states_word + automata.size());
  const std::size_t of_edits =
      content[side_word] == static_cast<std::uint32_t>(Side::Light) ? layers_at_ : automata.size();
  TakingList list;
  for (std::size_t i = 0; i < of_edits; ++i)
    for (const std::uint16_t edit :
         automata[i]->accepts(static_cast<std::uint16_t>(content[states_word + i])))
      if ((*edits_)[edit].repeat ||
          !std::binary_search(used.begin(), used.end(), static_cast<std::uint32_t>(edit)))
        list.edits.push_back(edit);
  std::sort(list.edits.begin(), list.edits.end(), [&](std::uint16_t a, std::uint16_t b) {
    const int x = (*edits_)[a].order, y = (*edits_)[b].order;
    return x != y ? x < y : a < b;
  });

  if (const auto known = list_numbers_.find(list.edits); known != list_numbers_.end()) return known->second;
  list.members.resize((static_cast<std::size_t>(edits_->size()) + 63) / 64);
  for (const std::uint16_t edit : list.edits) list.members[edit / 64] |= 1ull << (edit % 64);
  if (list.edits.size() <= QuadSet::few) {
    for (const std::uint16_t edit : list.edits) list.quads.add((*edits_)[edit].entry, {edit, QuadId::entry});
    list.quads.build();
  }
  bytes_ += bytes_of_list + 2 * list.edits.size() * sizeof(std::uint16_t) +
            list.members.size() * sizeof(std::uint64_t) + list.quads.bytes();
  const auto number = static_cast<std::uint32_t>(lists_.size());
  auto edits = list.edits;
  lists_.push_back(std::make_shared<const TakingList>(std::move(list)));
  list_numbers_.emplace(std::move(edits), number);
  return number;
}

// The layers' rules come behind those of the edits.
ImageSet StateTable::images_for(std::span<const std::uint32_t> content) const noexcept {
  ImageSet images = picture;
  if (content[side_word] != static_cast<std::uint32_t>(Side::Light)) return images;
  const auto automata = automata_of(content[side_word]);
  for (std::size_t i = layers_at_; i < automata.size(); ++i)
    for (const std::uint16_t rule :
         automata[i]->accepts(static_cast<std::uint16_t>(content[states_word + i])))
      images |= picture << (rule - edits_->size() + 1);
  return images;
}

}  // namespace sluice
