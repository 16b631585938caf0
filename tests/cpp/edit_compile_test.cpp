// SPDX-License-Identifier: GPL-3.0-or-later
// What describing edits says: errors, warnings, and that edits which are off leave no trace.
#include <gtest/gtest.h>

#include <algorithm>

#include "edit_scene.h"

namespace sluice {
namespace {

const std::vector<Entity> entities{{{"Lamp"}}, {{"Egg", "Glass things"}}, {{"Floor"}}};

EditDescription whole(const std::string& name, const std::string& expression, int order,
                      const V3d& place = V3d(0)) {
  EditDescription e = edit_at(name, at(place), expression, order);
  e.exits.push_back(exit_at(name + " exit", at(place + V3d(3, 0, 0)), order + 1));
  return e;
}

// Same candidates, same floats, same bits.
void expect_same(const Edits& a, const Edits& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.delta(), b.delta());
  EXPECT_EQ(a.automata().alphabet.size(), b.automata().alphabet.size());
  EXPECT_EQ(a.automata().forward.size(), b.automata().forward.size());
  for (int i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].entry.corner, b[i].entry.corner);
    EXPECT_EQ(a[i].entry.group, b[i].entry.group);
    EXPECT_EQ(a.gate_class(i), b.gate_class(i));
  }
}

TEST(CompileEdits, WhatIsOffLeavesNoTrace) {
  const std::vector<EditDescription> one{whole("A", "L.*S'Egg'", 0)};
  EditDescription off = whole("Off", "this is no expression", 5, {100, 100, 100});
  off.enabled = false;
  EditDescription flat = whole("Flat", "L.*S'Floor'", 7, {-500, 0, 0});
  flat.entry.matrix = placed({1, 0, 0}, {2, 0, 0}, {0, 0, 1}, V3d(0));
  EditDescription broken = whole("Broken", "LD", 9);
  broken.exits[0].quad.matrix[3][0] = std::nan("");
  const TestEdits alone(one, entities), among({off, one[0], flat, broken}, entities);
  expect_same(alone.edits, among.edits);
  EXPECT_EQ(among.edits[0].description, 1u);
  EXPECT_TRUE(alone.warnings.empty());
  ASSERT_EQ(among.warnings.size(), 2u);
  EXPECT_EQ(among.warnings[0].item, "Flat");
  EXPECT_EQ(among.warnings[1].item, "Broken exit");
  EXPECT_NE(among.warnings[1].message.find("'Broken'"), std::string::npos);
  const Box bounds = quad_bounds(std::vector<EditDescription>{off, one[0], flat, broken}, {});
  EXPECT_EQ(bounds.min, V3d(-1, -1, 0));
  EXPECT_EQ(bounds.max, V3d(4, 1, 0));
  EXPECT_TRUE(quad_bounds(std::vector<EditDescription>{off}, {}).isEmpty());
  const TestEdits nothing({off, broken}, entities);
  EXPECT_EQ(nothing.edits.size(), 0);
  expect_same(nothing.edits, TestEdits({}, entities).edits);
}

TEST(CompileEdits, ErrorsNameTheEdit) {
  const auto error_of = [](const std::string& expression) {
    try {
      const TestEdits edits({whole("Good", "L", 0), whole("Caustic", expression, 1)}, entities);
    } catch (const ExpressionError& e) { return e.item + " " + std::to_string(e.column); }
    return std::string();
  };
  EXPECT_EQ(error_of("LS+"), "");
  EXPECT_EQ(error_of("L(S"), "Caustic 2");
  EXPECT_EQ(error_of("L.*E"), "Caustic 4");
  EXPECT_EQ(error_of("DE"), "Caustic 1");
  EXPECT_EQ(error_of("L.*S..............."), "Caustic 1");
  EXPECT_EQ(error_of(""), "Caustic 1");
}

TEST(CompileEdits, AnEntryWithoutExitsAbsorbsAndSaysSoOnce) {
  EditDescription e = whole("A", "L", 0);
  e.exits.clear();
  const TestEdits edits({e}, entities);
  ASSERT_EQ(edits.warnings.size(), 1u);
  EXPECT_EQ(edits.warnings[0].item, "A");
  EXPECT_TRUE(edits.edits[0].exits.empty());
}

// An exit that grows: its flux is its share of the entry's area, from nothing on, and the entry stays what it
// is.
TEST(CompileEdits, AnExitWithoutAreaSendsNothing) {
  const auto grown = [](double x, double y) {
    EditDescription e = whole("A", "L", 0);
    e.exits[0].quad.matrix = placed({x, 0, 0}, {0, y, 0}, {0, 0, x}, {3, 0, 0});
    e.exits.push_back(exit_at("Other", at({0, 3, 0}), 2));
    return TestEdits({e}, entities);
  };
  const TestEdits full = grown(1, 1);
  for (const auto& [x, y] : {std::pair(0.0, 0.0), {0.0, 1.0}, {1.0, 0.0}, {1e-30, 1e-30}}) {
    const TestEdits none = grown(x, y);
    ASSERT_EQ(none.edits.size(), 1);
    ASSERT_EQ(none.edits[0].exits.size(), 1u);
    EXPECT_EQ(none.edits[0].exits[0].name, "Other");
    EXPECT_EQ(none.edits[0].entry.area, full.edits[0].entry.area);
    ASSERT_EQ(none.warnings.size(), 1u);
    EXPECT_EQ(none.warnings[0].item, "A exit");
  }
  for (const double scale : {1e-5, 1e-3, 0.1, 1.0, 10.0}) {
    const TestEdits some = grown(scale, scale);
    EXPECT_TRUE(some.warnings.empty());
    ASSERT_EQ(some.edits[0].exits.size(), 2u);
    const auto passage = some.edits.forward(0, 0, {0.5, 0.5}, {0, 0, -1});
    ASSERT_TRUE(passage);
    EXPECT_NEAR(passage->gain.x / (scale * scale), 1, 1e-6);
    EXPECT_EQ(passage->direction, V3f(0, 0, -1));
  }
}

TEST(CompileEdits, UnknownNamesAreWarnedKnownOnesAreNot) {
  EditDescription off = whole("Old", "L", 3);
  off.enabled = false;
  EditDescription grouped = whole("B", "L", 4, {0, 0, 5});
  grouped.collections = {"Moves"};
  const TestEdits edits(
      {whole("A", "L'Lmap' D'Glass things' X'floor' F'Moves' F'Old' F'A' F'C'", 0), off, grouped}, entities);
  ASSERT_EQ(edits.warnings.size(), 4u);
  EXPECT_NE(edits.warnings[0].message.find("'Lamp'"), std::string::npos);
  EXPECT_NE(edits.warnings[1].message.find("'Floor'"), std::string::npos);
  EXPECT_NE(edits.warnings[2].message.find("no edit"), std::string::npos);
  EXPECT_NE(edits.warnings[3].message.find("no path of this scene can match"), std::string::npos);
}

// F'Collection' means every edit in it.
TEST(CompileEdits, CollectionsOfEdits) {
  EditDescription a = whole("A", "LD", 0), b = whole("B", "LD", 1, {0, 0, 5}),
                  c = whole("C", "LDF'Moves'", 2, {0, 0, 9});
  a.collections = {"Moves", "Other"};
  const TestEdits test({a, b, c}, entities);
  StateTable table(test.edits);
  const StateId q = table.next(table.next(StateTable::light_start, test.edits.event_class(Event::L, 0)),
                               test.edits.event_class(Event::D, 2));
  EXPECT_TRUE(table.takes(table.through(q, 0), 2));
  EXPECT_FALSE(table.takes(table.through(q, 1), 2));
}

// The order of descriptions decides nothing but equal orders.
TEST(CompileEdits, OrderIsTheArtists) {
  std::vector<EditDescription> all;
  for (int i = 0; i < 50; ++i)
    all.push_back(whole(numbered("e", i), i % 3 ? "L.*" : "L.*S", (i * 37) % 50, {0.01 * i, 0, 0}));
  const TestEdits forward(all, entities);
  std::reverse(all.begin(), all.end());
  const TestEdits backward(all, entities);
  StateTable a(forward.edits), b(backward.edits);
  for (double x = -0.9; x < 0.9; x += 0.1) {
    const Segment segment{{x, 0.1, 5}, {0, 0, -1}};
    const auto lit = [](StateTable& t, const Edits& e) {
      return t.next(StateTable::light_start, e.event_class(Event::L, 0));
    };
    const auto p = forward.edits.first_taken(a, lit(a, forward.edits), segment),
               q = backward.edits.first_taken(b, lit(b, backward.edits), segment);
    ASSERT_TRUE(p && q);
    EXPECT_EQ(forward.edits[p->edit].name, backward.edits[q->edit].name);
    EXPECT_EQ(p->t, q->t);
    EXPECT_EQ(p->uv, q->uv);
  }
}

}  // namespace
}  // namespace sluice
