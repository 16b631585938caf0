// SPDX-License-Identifier: GPL-3.0-or-later
// What a path remembers: once and repeat, caps, contents that mean the same in every table.
#include <gtest/gtest.h>

#include <algorithm>

#include <random>
#include <set>

#include "edit_scene.h"

namespace sluice {
namespace {

std::vector<std::uint16_t> list(const TakingList& taking) { return taking.edits; }
std::vector<std::uint32_t> used(const StateTable& table, StateId q) {
  return {table.used(q).begin(), table.used(q).end()};
}
using Taken = std::vector<std::uint16_t>;

const std::vector<Entity> entities{{{"Lamp"}}, {{"Egg"}}, {{"Floor"}}};
enum { Lamp, Egg, Floor };

std::vector<EditDescription> some_edits() {
  std::vector<EditDescription> all{
      edit_at("A", at({0, 0, 0}), "L.*S", 5), edit_at("B", at({5, 0, 0}), "L.*S", 2),
      edit_at("R", at({10, 0, 0}), "L.*", 9), edit_at("V", at({15, 0, 0}), "SE", 1),
      edit_at("Chain", at({20, 0, 0}), "L.*F'A'.*", 4)};
  all[2].repeat = true;
  return all;
}

struct PathState : testing::Test {
  TestEdits test{some_edits(), entities};
  const Edits& edits = test.edits;
  StateTable table{edits};
  StateId lit = table.next(StateTable::light_start, edits.event_class(Event::L, Lamp));
  EventClass s = edits.event_class(Event::S, Egg), d = edits.event_class(Event::D, Floor);
};

TEST_F(PathState, TakingIsSortedByOrder) {
  EXPECT_TRUE(table.takes_none(StateTable::light_start));
  EXPECT_EQ(list(table.taking_list(lit)), Taken{2});
  const StateId q = table.next(lit, s);
  EXPECT_EQ(list(table.taking_list(q)), (Taken{1, 0, 2}));  // orders 2, 5, 9; view edit V takes no light
  EXPECT_TRUE(table.takes(q, 0) && table.takes(q, 2));
  EXPECT_FALSE(table.takes(q, 3) || table.takes(q, 4));
  EXPECT_EQ(list(table.taking_list(table.next(q, d))), Taken{2});
}

TEST_F(PathState, OncePerPathUnlessRepeat) {
  StateId q = table.through(table.next(lit, s), 0);
  EXPECT_EQ(table.gates(q), 1);
  EXPECT_EQ(used(table, q), (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(list(table.taking_list(q)), (Taken{4, 2}));                    // behind F'A' Chain accepts
  EXPECT_EQ(list(table.taking_list(table.next(q, s))), (Taken{1, 4, 2}));  // A is spent, B is not
  q = table.through(q, 2);
  EXPECT_EQ(table.gates(q), 2);
  EXPECT_EQ(used(table, q), (std::vector<std::uint32_t>{0, 2}));
  EXPECT_TRUE(table.takes(q, 2));  // repeats
}

// The paper's L(!F_i)*: with `repeat` the guard alone keeps an edit from acting twice.
TEST(PathStateGuards, AreReadWhenAnEditRepeats) {
  std::vector<EditDescription> two{edit_at("A", at({0, 0, 0}), "L(!F'A')*", 0),
                                   edit_at("B", at({5, 0, 0}), "L(!F'A')*", 1)};
  two[0].repeat = two[1].repeat = true;
  TestEdits test(two, entities);
  StateTable table(test.edits);
  const StateId q = table.next(StateTable::light_start, test.edits.event_class(Event::L, Lamp));
  EXPECT_EQ(list(table.taking_list(q)), (Taken{0, 1}));
  EXPECT_EQ(list(table.taking_list(table.through(q, 1))), (Taken{0, 1}));
  EXPECT_TRUE(table.takes_none(table.through(q, 0)));
}

TEST_F(PathState, CapsStopAtMaxGates) {
  StateId q = lit;
  for (int i = 0; i < 8; ++i) {
    EXPECT_FALSE(table.at_cap(q));
    q = table.through(q, 2);
  }
  EXPECT_TRUE(table.at_cap(q));
  EXPECT_TRUE(table.takes(q, 2));  // the entry would still take it: it absorbs
}

// Layers read the whole word along with the edits, and are no edits.
TEST(PathStateImages, AreThoseOfTheWholeWord) {
  const std::vector<LayerDescription> layers{
      {"Caustic", "LS+DE"}, {"Moved", "L.*F'A'.*E"}, {"Lamp", "L'Lamp'.*E"}, {"All", "L.*E"}};
  std::vector<EditDescription> one{edit_at("A", at({0, 0, 0}), "LS", 0)};
  one[0].exits = {exit_at("A exit", at({5, 0, 0}))};
  Warnings warnings;
  const Edits edits = compile_edits(one, entities, {}, {}, 8, warnings, layers);
  EXPECT_TRUE(warnings.empty());
  StateTable table(edits);
  const auto word = [&](StateId state, std::initializer_list<std::pair<Event, int>> events) {
    for (const auto& [kind, entity] : events) state = table.next(state, edits.event_class(kind, entity));
    return state;
  };
  const StateId caustic = word(StateTable::light_start, {{Event::L, Lamp}, {Event::S, Egg}});
  EXPECT_EQ(list(table.taking_list(caustic)), Taken{0});
  EXPECT_EQ(table.images(caustic), picture);  // not yet at the eye
  EXPECT_EQ(table.images(word(caustic, {{Event::D, Floor}, {Event::E, -1}})), 0b11011u);
  EXPECT_EQ(table.images(word(table.through(caustic, 0), {{Event::D, Floor}, {Event::E, -1}})), 0b11101u);
  EXPECT_EQ(table.images(word(StateTable::light_start, {{Event::L, Floor}, {Event::E, -1}})), 0b10001u);
  EXPECT_EQ(table.images(StateTable::dead), picture);
  TestEdits none(one, entities);
  EXPECT_EQ(StateTable(none.edits).images(StateTable::light_start), picture);
}

TEST_F(PathState, ViewStatesReadBackwardFromTheEye) {
  const EventClass e = edits.event_class(Event::E, -1);
  StateId v = table.next(StateTable::view_start, e);
  EXPECT_TRUE(table.takes_none(v));
  v = table.next(v, s);
  EXPECT_EQ(list(table.taking_list(v)), Taken{3});
  EXPECT_TRUE(table.takes_none(table.next(v, s)));
  EXPECT_TRUE(table.takes_none(table.through(v, 3)));
  // not the forward word
  EXPECT_TRUE(table.takes_none(table.next(table.next(StateTable::view_start, s), e)));
}

TEST_F(PathState, ASpentOrderOfGatesDoesNotMatter) {
  const StateId q = table.next(lit, s);
  const StateId ab = table.next(table.through(table.through(q, 0), 1), s),
                ba = table.next(table.through(table.through(q, 1), 0), s);
  EXPECT_EQ(ab, ba);  // same automaton state, gates and set of used edits
}

TEST_F(PathState, ContentsMeanTheSameInEveryTable) {
  StateTable other(edits);
  std::vector<EventClass> events{s, d, edits.event_class(Event::G, Egg), edits.event_class(Event::E, -1)};
  // Two tables meet states in different orders.
  std::vector<StateId> mine, theirs;
  for (int pass = 0; pass < 2; ++pass)
    for (int walk = 0; walk < 500; ++walk) {
      const int seed = pass == 0 ? walk : 499 - walk;
      std::mt19937 path(static_cast<unsigned>(seed));
      StateTable& t = pass == 0 ? table : other;
      StateId q = t.next(seed % 3 ? StateTable::light_start : StateTable::view_start,
                         edits.event_class(seed % 3 ? Event::L : Event::E, -1));
      for (int i = 0; i < 6; ++i)
        q = path() % 3 ? t.next(q, events[path() % events.size()])
                       : t.through(q, static_cast<int>(path() % 5));
      (pass == 0 ? mine : theirs).push_back(q);
    }
  ASSERT_EQ(table.size(), other.size());
  EXPECT_GT(table.size(), 100u);
  int renumbered = 0;
  for (StateId q = 0; q < other.size(); ++q) {
    const StateId here = table.intern(other.content(q));
    ASSERT_LT(here, table.size());
    renumbered += here != q;
    EXPECT_TRUE(std::ranges::equal(table.content(here), other.content(q)));
    EXPECT_EQ(list(table.taking_list(here)), list(other.taking_list(q)));
    EXPECT_EQ(table.gates(here), other.gates(q));
    EXPECT_EQ(used(table, here), used(other, q));
  }
  EXPECT_GT(renumbered, 10);
  EXPECT_EQ(table.size(), other.size());  // interning met nothing new
  // Sorting by content gives one order for both.
  const auto sorted = [](const StateTable& t) {
    std::vector<std::vector<std::uint32_t>> contents;
    for (StateId i = 0; i < t.size(); ++i) contents.emplace_back(t.content(i).begin(), t.content(i).end());
    std::ranges::sort(contents);
    return contents;
  };
  EXPECT_EQ(sorted(table), sorted(other));
}

TEST_F(PathState, CopiesAreIndependent) {
  const StateId q = table.next(lit, s);
  StateTable copy = table;
  const StateId a = copy.through(q, 0), b = table.through(q, 1);
  EXPECT_EQ(a, b);  // the next free number in both
  EXPECT_EQ(used(copy, a), (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(used(table, b), (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(list(copy.taking_list(q)), list(table.taking_list(q)));
}

TEST_F(PathState, AFullTableEndsPathsAndTakesNothing) {
  StateTable small(edits, {.states = 6});
  StateId q = small.next(StateTable::light_start, edits.event_class(Event::L, Lamp));
  for (int i = 0; i < 10; ++i) q = small.through(q, 2);
  EXPECT_EQ(q, StateTable::dead);
  EXPECT_EQ(small.size(), 6u);
  EXPECT_TRUE(small.takes_none(q));
  EXPECT_EQ(small.next(q, s), StateTable::dead);
  EXPECT_EQ(small.through(q, 0), StateTable::dead);
  EXPECT_TRUE(used(small, q).empty());
  EXPECT_EQ(small.next(StateTable::light_start, d), StateTable::dead);
  EXPECT_EQ(small.next(StateTable::light_start, d), StateTable::dead);  // so that each path is counted
}

// Seven edits that take everything, in any order: 127 sets of used ones, times automaton states.
TEST(PathStateMemory, IsALimit) {
  std::vector<EditDescription> all;
  for (int i = 0; i < 7; ++i) all.push_back(edit_at(numbered("E", i), at({5.0 * i, 0, 0}), "L.*", i));
  TestEdits test(all, entities);
  const auto fill = [&](StateTable& table) {
    std::mt19937 random(3);
    int capped = 0;
    for (int walk = 0; walk < 2000; ++walk) {
      StateId q = table.next(StateTable::light_start, test.edits.event_class(Event::L, Lamp));
      for (int i = 0; i < 6; ++i) q = table.through(q, static_cast<int>(random() % 7));
      capped += q == StateTable::dead;
    }
    return capped;
  };
  StateTable ample(test.edits), tight(test.edits, {.memory = 8192}), none(test.edits, {.memory = 0});
  EXPECT_EQ(fill(ample), 0);
  EXPECT_GT(fill(tight), 100);
  EXPECT_EQ(fill(none), 2000);
  EXPECT_GT(ample.size(), 100u);
  EXPECT_GT(ample.bytes(), 2 * 8192u);
  // it ends with the state that reaches the limit, and its list of seven quads
  EXPECT_LT(tight.bytes(), 8192u + 2048u);
  EXPECT_GT(tight.size(), 3u);
  EXPECT_EQ(none.size(), 3u);  // dead and the two starts are always there
}

TEST_F(PathState, SteadyStateIsALookup) {
  StateId q = lit;
  std::mt19937 random(5);
  const auto walk = [&](int steps) {
    for (int i = 0; i < steps; ++i) q = random() % 8 ? table.next(q, random() % 2 ? s : d) : lit;
  };
  walk(10'000);
  const StateId met = table.size();
  walk(100'000);
  EXPECT_EQ(table.size(), met);
}

TEST(PathStateWithoutEdits, IsTrivial) {
  TestEdits test({}, entities);
  StateTable table(test.edits);
  StateId q = StateTable::light_start;
  for (const Event kind : {Event::L, Event::S, Event::D}) q = table.next(q, test.edits.event_class(kind, 1));
  EXPECT_EQ(q, StateTable::light_start);  // nothing to remember: one state per side
  EXPECT_TRUE(table.takes_none(q));
  EXPECT_EQ(table.size(), 3u);
}

}  // namespace
}  // namespace sluice
