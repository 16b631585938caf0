// SPDX-License-Identifier: GPL-3.0-or-later
// Path selection against words that are run forward: every way a path of a few steps can be cut into light
// and view path must tell the same as the light that walks all of it. The expected answers know neither state
// tables nor automata of scenes: accepts(), which other tests hold against Python's re, reads each word.
#include <gtest/gtest.h>

#include <array>

#include "expr/accepts.h"
#include "edit_scene.h"
#include "transport/view/path_selection.h"

namespace sluice {
namespace {

constexpr int max_gates = 2, max_steps = 6;
enum { Lamp, Floor, Egg, Wall };
enum { Once, Repeats, OfView, edit_count };  // edits

// What happens to a path, in the order of light.
enum Step { Diffuse, Specular, Glossy, GateOnce, GateRepeats, GateOfView, PassOnce, PassRepeats, step_count };
constexpr int word_steps = GateOfView + 1;  // those before are events of the word
bool is_gate(int step) { return step >= GateOnce && step <= GateOfView; }
int edit_of(int step) { return step < PassOnce ? step - GateOnce : step - PassOnce; }

const std::vector<Entity> entities{{{"Lamp"}}, {{"Floor"}}, {{"Egg"}}, {{"Wall"}}};
const std::vector<LayerDescription> layers{{"Caustics", "L.*SDE"}, {"Moved", "L.*F'Once'.*E"}};

std::vector<EditDescription> some_edits() {
  std::vector<EditDescription> all{edit_at("Once", at({0, 0, 0}), "L.*(S|G)", 1),
                                   edit_at("Repeats", at({9, 0, 0}), "L.*(D'Floor'|F'Once')S?", 0),
                                   edit_at("View", at({18, 0, 0}), "SE", 2)};
  all[Repeats].repeat = true;
  return all;
}

// Words of up to max_steps events behind L, numbered, and what each expression says of them.
class Words {
 public:
  Words() {
    first_.push_back(0);
    for (std::size_t length = 0, count = 1; length <= max_steps; ++length, count *= word_steps)
      first_.push_back(first_.back() + count);
    const auto edits = some_edits();
    for (const int edit : {Once, Repeats})
      takes_[edit] = ask(edits[static_cast<std::size_t>(edit)].expression, false);
    for (std::size_t l = 0; l < layers.size(); ++l) in_layer_[l] = ask(layers[l].expression, true);
  }
  struct Word {
    std::size_t length = 0, number = 0;  // in base word_steps
    [[nodiscard]] Word with(int event) const {
      return {length + 1, number * word_steps + static_cast<std::size_t>(event)};
    }
  };
  [[nodiscard]] bool takes(int edit, const Word& word) const { return takes_[edit][index(word)]; }
  [[nodiscard]] ImageSet images(const Word& word) const {
    ImageSet images = picture;
    for (std::size_t l = 0; l < layers.size(); ++l) images |= ImageSet{in_layer_[l][index(word)]} << (l + 1);
    return images;
  }

 private:
  [[nodiscard]] std::size_t index(const Word& word) const { return first_[word.length] + word.number; }
  [[nodiscard]] std::vector<std::uint8_t> ask(const std::string& expression, bool to_eye) const {
    const std::vector<std::string> events{"D'Floor'",   "S'Egg'",  "G'Wall'", "F'Once'",
                                          "F'Repeats'", "F'View'", "L'Lamp'", "E"};
    constexpr std::uint8_t light = 6, eye = 7;
    std::vector<std::uint8_t> rows;
    for (std::size_t length = 0; length <= max_steps; ++length)
      for (std::size_t number = 0; number < first_[length + 1] - first_[length]; ++number) {
        std::array<std::uint8_t, max_steps + 2> row;
        row.fill(word_end);
        row[0] = light;
        std::size_t rest = number;
        for (std::size_t i = length; i > 0; --i, rest /= word_steps)
          row[i] = static_cast<std::uint8_t>(rest % word_steps);
        if (to_eye) row[length + 1] = eye;
        rows.insert(rows.end(), row.begin(), row.end());
      }
    return accepts_many(expression, events, rows, max_steps + 2);
  }

  std::vector<std::size_t> first_;  // [length] -> number of shorter words
  std::array<std::vector<std::uint8_t>, 2> takes_, in_layer_;
};

// Light that walks forward, by the rules of design §2.
struct Walker {
  Words::Word word;
  unsigned used = 0;
  int gates = 0;
  JoinOutcome outcome = JoinOutcome::Joined;
  int refused_by = -1;

  void walk(const Words& words, int step) {
    if (outcome != JoinOutcome::Joined) return;
    const int edit = edit_of(step);
    const auto takes = [&] { return words.takes(edit, word) && (edit == Repeats || !(used & (1u << edit))); };
    if (step >= PassOnce) {
      if (takes()) outcome = JoinOutcome::Refused, refused_by = edit;
      return;
    }
    if (is_gate(step)) {
      if (edit != OfView && !takes()) return void(outcome = JoinOutcome::Refused);
      if (gates == max_gates) return void(outcome = JoinOutcome::GatesCapped);
      ++gates, used |= 1u << edit;
    }
    word = word.with(step);
  }
};

struct PathSelectionTest : testing::Test {
  const Words words;
  Warnings warnings;
  const Edits edits = compile_edits(some_edits(), entities, {}, {V3d(0), {}}, max_gates, warnings, layers);
  Effects effects;
  PathSelection selection{edits, with(effects), {}};
  const StateId lit = selection.states().next(StateTable::light_start, edits.event_class(Event::L, Lamp));

  static const Effects& with(Effects& effects) {
    effects.light_edits = effects.view_edits = effects.layers = effects.tracks_states = true;
    return effects;
  }
  [[nodiscard]] EventClass event_of(int step) const {
    if (step == Diffuse) return edits.event_class(Event::D, Floor);
    return step == Specular ? edits.event_class(Event::S, Egg) : edits.event_class(Event::G, Wall);
  }
  // Light in state q does as a step says.
  StateId forward(StateId q, int step) {
    StateTable& states = selection.states();
    if (step >= PassOnce) return q;
    return is_gate(step) ? states.through(q, edit_of(step)) : states.next(q, event_of(step));
  }
  // The view path was there before, nearer to the eye.
  ConstraintId backward(ConstraintId id, int step) {
    JoinConstraints& constraints = selection.constraints();
    if (step >= PassOnce) return constraints.passed(id, edit_of(step));
    if (step == GateOfView) return constraints.view_gate(id, edit_of(step));
    return is_gate(step) ? constraints.gate(id, edit_of(step)) : constraints.event(id, event_of(step));
  }
  // Calls act(steps) for all sequences of up to max_steps.
  template <class Act>
  void for_each_path(Act&& act) {
    std::array<int, max_steps> steps{};
    for (std::size_t length = 0; length <= max_steps; ++length) {
      std::size_t count = 1;
      for (std::size_t i = 0; i < length; ++i) count *= step_count;
      for (std::size_t number = 0; number < count; ++number) {
        std::size_t rest = number;
        for (std::size_t i = 0; i < length; ++i, rest /= step_count)
          steps[i] = static_cast<int>(rest % step_count);
        act(std::span(steps).first(length));
      }
    }
  }
};

// Light never goes through the gate of a view edit: the light half ends before the first. Both halves
// together must end as the walker does, with the same gates behind it, in the images that the whole word is
// part of.
TEST_F(PathSelectionTest, EveryCutSaysWhatLightDoesThatWalksForward) {
  std::uint64_t count[4] = {}, wrong = 0;
  for_each_path([&](std::span<const int> steps) {
    Walker whole;
    for (const int step : steps) whole.walk(words, step);
    selection.start_bundle();
    std::array<ConstraintId, max_steps + 1> list;
    list[steps.size()] = no_constraint;
    for (std::size_t i = steps.size(); i > 0; --i) list[i - 1] = backward(list[i], steps[i - 1]);
    Walker light;
    StateId q = lit;
    for (std::size_t cut = 0; cut <= steps.size(); ++cut) {
      const JoinResult joined = selection.join(q, list[cut]);
      ++count[static_cast<int>(joined.outcome)];
      const bool arrives = whole.outcome == JoinOutcome::Joined;
      bool is_right = joined.outcome == whole.outcome && joined.refused_by == whole.refused_by &&
                      joined.images == (arrives ? words.images(whole.word) : 0);
      if (arrives) {
        unsigned takers = 0;
        if (selection.has_acted_edits(joined.q))
          for (const std::uint32_t edit : selection.acted_edits(joined.q)) takers |= 1u << edit;
        is_right = is_right && takers == whole.used && selection.states().gates(joined.q) == whole.gates;
      }
      if (!is_right && ++wrong <= 3)
        ADD_FAILURE() << "cut " << cut << " of "
                      << testing::PrintToString(std::vector(steps.begin(), steps.end())) << ": outcome "
                      << static_cast<int>(joined.outcome) << ", images " << joined.images;
      if (cut == steps.size() || steps[cut] == GateOfView) break;
      light.walk(words, steps[cut]);
      if (light.outcome != JoinOutcome::Joined) break;  // there is no such light
      q = forward(q, steps[cut]);
    }
  });
  EXPECT_EQ(wrong, 0u);
  for (const auto outcome : {JoinOutcome::Joined, JoinOutcome::Refused, JoinOutcome::GatesCapped})
    EXPECT_GT(count[static_cast<int>(outcome)], 1000u);
  EXPECT_EQ(count[static_cast<int>(JoinOutcome::StatesCapped)], 0u);
}

// Only lists with a gate or a passed entry can refuse light; what they use is in them.
TEST_F(PathSelectionTest, ListsOfEventsAloneAllowAllLight) {
  for_each_path([&](std::span<const int> steps) {
    if (steps.size() > 4) return;
    selection.start_bundle();
    ConstraintId list = no_constraint;
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) list = backward(list, *step);
    const auto is_any = [&](auto test) { return std::ranges::any_of(steps, test); };
    EXPECT_EQ(selection.constraints().is_constrained(list), is_any([](int s) { return s >= GateOnce; }));
    for (int edit = 0; edit < edit_count; ++edit)
      EXPECT_EQ(selection.constraints().uses(list, edit),
                is_any([&](int s) { return is_gate(s) && edit_of(s) == edit; }));
    EXPECT_TRUE(selection.asks_state(list));  // the layers do
  });
}

// Photons carry numbers of their own, and answers are remembered as long as the list is the same.
TEST_F(PathSelectionTest, PhotonsAreToldWhatTheirStateIs) {
  StateTable of_light_paths(edits);
  PhotonStates numbers;
  std::vector<StateId> here;
  for (const int first : {Specular, Diffuse, Glossy})
    for (const int second : {Glossy, Specular, Diffuse}) {
      StateId q = of_light_paths.next(StateTable::light_start, edits.event_class(Event::L, Lamp));
      for (const int step : {first, second}) q = of_light_paths.next(q, event_of(step));
      const std::uint32_t number = numbers.number(of_light_paths.content(q));
      if (number == here.size()) here.push_back(forward(forward(lit, first), second));
    }
  ASSERT_GT(here.size(), 2u);
  selection.start_pass(&numbers);
  for (const bool is_new_bundle : {false, true}) {
    if (is_new_bundle) selection.start_bundle();  // numbers of lists begin anew
    const ConstraintId passed = selection.constraints().passed(no_constraint, is_new_bundle ? Once : Repeats),
                       gate = selection.constraints().gate(no_constraint, Once);
    for (const ConstraintId list : {passed, gate, no_constraint, passed})
      for (int again = 0; again < 2; ++again)
        for (std::uint32_t q = 0; q < here.size(); ++q) {
          EXPECT_EQ(selection.state_of_photon(q), here[q]);
          const JoinResult of_photon = selection.join_photon(q, list),
                           of_state = selection.join(here[q], list);
          EXPECT_EQ(of_photon.images, of_state.images);
          EXPECT_EQ(of_photon.q, of_state.q);
          EXPECT_EQ(of_photon.outcome, of_state.outcome);
          EXPECT_EQ(of_photon.refused_by, of_state.refused_by);
        }
  }
}

// Where the table has no room for more, light that no gate asks about is in the picture and in no layer; any
// other is lost, and both are said.
TEST_F(PathSelectionTest, AFullTableIsSaid) {
  PathSelection full(edits, effects, {.states = 4});
  StateTable& states = full.states();
  StateId q = states.next(StateTable::light_start, edits.event_class(Event::L, Lamp));
  ASSERT_NE(q, StateTable::dead);
  const ConstraintId event = full.constraints().event(no_constraint, event_of(Glossy)),
                     passed = full.constraints().passed(no_constraint, Repeats),
                     event_before_passed = full.constraints().event(passed, event_of(Glossy));
  EXPECT_EQ(full.join(q, event).outcome, JoinOutcome::StatesCapped);
  EXPECT_EQ(full.join(q, event).images, picture);
  EXPECT_EQ(full.join(q, event_before_passed).outcome, JoinOutcome::StatesCapped);
  EXPECT_EQ(full.join(q, event_before_passed).images, 0u);
}

}  // namespace
}  // namespace sluice
