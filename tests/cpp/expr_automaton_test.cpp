// SPDX-License-Identifier: GPL-3.0-or-later
// Automata against a naive matcher that walks the syntax tree, the sizes of numerics §4, and what is shared.
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <set>

#include "expr/automaton.h"
#include "expr/unknown_names.h"

namespace sluice {
namespace {

struct WordEvent {
  Event kind;
  std::vector<std::string> names;
};
using Word = std::vector<WordEvent>;

// Where a match of `node` that begins at each of `from` can end. No automaton: sets of positions in the word.
class NaiveMatcher {
 public:
  NaiveMatcher(const Expression& e, const Word& w) : e_(e), w_(w) {}
  bool matches() { return ends(e_.root, {0}).contains(w_.size()); }

 private:
  using Places = std::set<std::size_t>;

  static bool names_meet(const Symbol& s, const WordEvent& event) {
    for (const auto& a : s.names)
      for (const auto& b : event.names)
        if (a == b) return true;
    return s.names.empty();
  }
  static bool match(const Atom& atom, const WordEvent& event) {
    bool any = false;
    for (const Symbol& s : atom.symbols)
      any = any || ((s.kinds & mask_of(event.kind)) && names_meet(s, event));
    return atom.negated ? !any && event.kind != Event::L && event.kind != Event::E : any;
  }
  Places ends(int index, const Places& from) {
    const SyntaxNode& node = e_.nodes[static_cast<std::size_t>(index)];
    Places to;
    switch (node.kind) {
      case SyntaxNode::Kind::Atom:
        for (const std::size_t i : from)
          if (i < w_.size() && match(e_.atoms[static_cast<std::size_t>(node.atom)], w_[i])) to.insert(i + 1);
        return to;
      case SyntaxNode::Kind::Sequence:
        to = from;
        for (const int child : node.children) to = ends(child, to);
        return to;
      case SyntaxNode::Kind::Choice:
        for (const int child : node.children) to.merge(ends(child, from));
        return to;
      case SyntaxNode::Kind::Repeat: {
        Places now = from;
        for (int i = 0; i < node.min; ++i) now = ends(node.children.front(), now);
        to = now;
        const int more =
            node.max == SyntaxNode::unbounded ? static_cast<int>(w_.size()) + 1 : node.max - node.min;
        for (int i = 0; i < more; ++i) {
          now = ends(node.children.front(), now);
          to.insert(now.begin(), now.end());
        }
        return to;
      }
    }
    return to;
  }

  const Expression& e_;
  const Word& w_;
};

std::string random_expression(std::mt19937& random, int depth) {
  const auto pick = [&](std::initializer_list<const char*> all) {
    return std::string(*(all.begin() + random() % all.size()));
  };
  const auto symbol = [&] {
    return pick({"L", "E", "D", "S", "G", "F", "X"}) + pick({"", "", "'a'", "'b'", "'a,c'"});
  };
  switch (depth == 0 ? random() % 4 : random() % 9) {
    case 0: return symbol();
    case 1: return pick({".", "!"}) == "." ? "." : "!" + symbol();
    case 2: return "[" + pick({"", "^"}) + symbol() + symbol() + "]";
    case 3: return "!(" + symbol() + "|" + symbol() + ")";
    case 4: return random_expression(random, depth - 1) + random_expression(random, depth - 1);
    case 5:
      return "(" + random_expression(random, depth - 1) + "|" + random_expression(random, depth - 1) + ")";
    case 6:
      return "(" + random_expression(random, depth - 1) + ")" +
             pick({"*", "+", "?", "{2}", "{1,}", "{0,2}", "{1,3}", "{0}"});
    default: return "(" + random_expression(random, depth - 1) + ")";
  }
}

struct Compiled {
  std::vector<Expression> expressions;
  Automata automata;

  Compiled(const std::vector<std::string>& texts, std::span<const Entity> entities,
           std::span<const Entity> gates = {}, std::vector<int> own_gates = {}, bool reversed = false) {
    for (const auto& text : texts) expressions.push_back(parse_expression(text));
    std::vector<Rule> rules;
    for (std::size_t i = 0; i < texts.size(); ++i)
      rules.push_back(
          {"edit " + std::to_string(i), &expressions[i], own_gates.empty() ? -1 : own_gates[i], reversed});
    automata = compile_automata(rules, entities, gates);
  }
  // Rules that accept, over all groups.
  std::set<int> accepting(const std::vector<EventClass>& word, bool reversed = false) const {
    std::set<int> all;
    for (const Dfa& dfa : reversed ? automata.backward : automata.forward) {
      std::uint16_t state = 0;
      if (reversed)
        for (auto it = word.rbegin(); it != word.rend(); ++it) state = dfa.step(state, *it);
      else
        for (const EventClass c : word) state = dfa.step(state, c);
      for (const auto rule : dfa.accepts(state)) all.insert(rule);
    }
    return all;
  }
};

const std::vector<Entity> things{{{"a"}}, {{"b", "c"}}, {{"c"}}, {{"d"}}};
const std::vector<Entity> gates{{{"a"}}, {{"e", "c"}}};

// Words of all kinds and names; -1 is a nameless thing.
Word random_word(std::mt19937& random, const Alphabet& alphabet, std::vector<EventClass>& classes) {
  Word word;
  classes.clear();
  for (auto length = random() % 9; length > 0; --length) {
    const auto kind = static_cast<Event>(random() % event_count);
    if (kind == Event::F) {
      const auto gate = static_cast<int>(random() % gates.size());
      word.push_back({kind, gates[static_cast<std::size_t>(gate)].names});
      classes.push_back(alphabet.gate(gate));
    } else {
      const int thing = static_cast<int>(random() % (things.size() + 1)) - 1;
      word.push_back(
          {kind, thing < 0 ? std::vector<std::string>{} : things[static_cast<std::size_t>(thing)].names});
      classes.push_back(alphabet.event(kind, thing));
    }
  }
  return word;
}

// All expressions together, shared automata and all; forward, and reversed on reversed words.
TEST(Automaton, AgreesWithANaiveMatcher) {
  std::mt19937 random(7);
  std::vector<std::string> texts;
  while (texts.size() < 300) texts.push_back(random_expression(random, 4));
  int accepted = 0;
  for (const bool reversed : {false, true}) {
    const Compiled all(texts, things, gates, {}, reversed);
    std::vector<EventClass> classes;
    for (int i = 0; i < 2000; ++i) {
      const Word word = random_word(random, all.automata.alphabet, classes);
      const std::set<int> found = all.accepting(classes, reversed);
      accepted += static_cast<int>(found.size());
      for (std::size_t r = 0; r < texts.size(); ++r)
        ASSERT_EQ(found.contains(static_cast<int>(r)), NaiveMatcher(all.expressions[r], word).matches())
            << texts[r] << ", word " << i;
    }
    for (const Dfa& dfa : reversed ? all.automata.backward : all.automata.forward)
      EXPECT_LE(dfa.states, max_dfa_states);
  }
  EXPECT_GT(accepted, 20'000);
}

std::string dots(int n) { return std::string(static_cast<std::size_t>(n), '.'); }

// numerics §4: L.*S and n dots need 2^(n+1) + 2 states.
TEST(Automaton, BlowUpIsLimited) {
  for (const int n : {4, 8, 10}) {
    const auto start = std::chrono::steady_clock::now();
    const Compiled one({"L.*S" + dots(n)}, things);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    ASSERT_EQ(one.automata.forward.size(), 1u);
    EXPECT_EQ(one.automata.forward[0].states, (1 << (n + 1)) + 2);
    RecordProperty("compile_ms_" + std::to_string(n), std::to_string(ms));
    std::printf("L.*S and %d dots: %d states, %.2f ms\n", n, one.automata.forward[0].states, ms);
  }
  try {
    const Compiled two({"L", "L.*S" + dots(11)}, things);
    ADD_FAILURE() << "4,098 states were accepted";
  } catch (const ExpressionError& e) {
    EXPECT_EQ(e.item, "edit 1");
    EXPECT_NE(std::string(e.what()).find("4,096"), std::string::npos);
  }
}

TEST(Automaton, ExpressionsShareOneWhileItFits) {
  const Compiled some({"L.*S", "LS+", "L.*D'a'", "LX'b'*S"}, things);
  EXPECT_EQ(some.automata.forward.size(), 1u);
  // Two that are exponential in different events fit alone and not together (2^8 · 2^8 states).
  const Compiled two({"L.*S'a'" + dots(7), "L.*D'b'" + dots(7), "LS"}, things);
  EXPECT_EQ(two.automata.forward.size(), 2u);
  const EventClass l = two.automata.alphabet.event(Event::L, -1),
                   s = two.automata.alphabet.event(Event::S, 0), d = two.automata.alphabet.event(Event::D, 1);
  EXPECT_EQ(two.accepting({l, s, d, d, d, d, d, d, d}), std::set<int>{0});
  EXPECT_EQ(two.accepting({l, s, d, s, s, s, s, s, s, s}), std::set<int>{1});
  EXPECT_EQ(two.accepting({l, s}), std::set<int>{2});
}

TEST(Automaton, EqualExpressionsAreOne) {
  const std::vector<std::string> same(1000, "L.*S'a'D");
  const Compiled all(same, things);
  ASSERT_EQ(all.automata.forward.size(), 1u);
  EXPECT_EQ(all.automata.forward[0].states, Compiled({"L.*S'a'D"}, things).automata.forward[0].states);
  const auto& alphabet = all.automata.alphabet;
  EXPECT_EQ(
      all.accepting({alphabet.event(Event::L, -1), alphabet.event(Event::S, 0), alphabet.event(Event::D, 2)})
          .size(),
      1000u);
}

// Design §3: an edit that acts once cannot see its own F before it acts, so guards against oneself cost no
// states.
TEST(Automaton, GuardsAgainstOneselfShare) {
  std::vector<std::string> guarded;
  std::vector<Entity> edits;
  std::vector<int> own;
  for (int i = 0; i < 1000; ++i) {
    guarded.push_back("L(!F'edit " + std::to_string(i) + "')*S");
    edits.push_back({{"edit " + std::to_string(i)}});
    own.push_back(i);
  }
  const auto start = std::chrono::steady_clock::now();
  const Compiled all(guarded, things, edits, own);
  std::printf("1000 guarded edits: %.1f ms\n",
              std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  ASSERT_EQ(all.automata.forward.size(), 1u);
  EXPECT_EQ(all.automata.forward[0].states, Compiled({"L.*S"}, things).automata.forward[0].states);
  // Edits that repeat keep the guard: after its own F, edit 3 no longer accepts.
  const Compiled repeating({guarded[3], guarded[4]}, things, edits, {-1, -1});
  const auto& alphabet = repeating.automata.alphabet;
  EXPECT_EQ(repeating.accepting({alphabet.event(Event::L, 0), alphabet.gate(3), alphabet.event(Event::S, 0)}),
            std::set<int>{1});
}

TEST(Automaton, ManyDifferentNames) {
  std::vector<std::string> texts;
  std::vector<Entity> named;
  for (int i = 0; i < 1000; ++i) {
    texts.push_back("L S'object " + std::to_string(i) + "'");
    named.push_back({{"object " + std::to_string(i)}});
  }
  const auto start = std::chrono::steady_clock::now();
  const Compiled all(texts, named);
  std::printf("1000 names: %.1f ms\n",
              std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  EXPECT_EQ(all.automata.forward.size(), 1u);
  const auto& alphabet = all.automata.alphabet;
  EXPECT_EQ(all.accepting({alphabet.event(Event::L, -1), alphabet.event(Event::G, 700)}), std::set<int>{700});
}

TEST(Automaton, ClassesAreFew) {
  std::vector<Entity> scene(100'000, Entity{{"rock", "Rocks"}});
  scene[5].names.push_back("Egg");
  const Compiled one({"L.*S'Egg'"}, scene);
  EXPECT_LE(one.automata.alphabet.size(), 4);  // L, S'Egg', other interactions, the rest
  EXPECT_EQ(one.automata.alphabet.event(Event::S, 7), one.automata.alphabet.event(Event::D, 5));
  EXPECT_NE(one.automata.alphabet.event(Event::S, 7), one.automata.alphabet.event(Event::S, 5));
  EXPECT_EQ(one.automata.alphabet.event(Event::G, 5), one.automata.alphabet.event(Event::S, 5));
}

TEST(Automaton, UnknownNamesAreWarned) {
  const Expression e = parse_expression("L S'Eg' F'Flor' D'Floor'");
  const Rule rule{"Move", &e};
  const std::vector<Entity> scene{{{"Egg"}}, {{"Floor"}}, {{"Leg", "Furniture"}}},
      edits{{{"Move"}}, {{"Flow"}}};
  Warnings warnings;
  warn_unknown_names({&rule, 1}, scene, edits, warnings);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(warnings[0].item, "Move");
  EXPECT_NE(warnings[0].message.find("'Eg'"), std::string::npos);
  EXPECT_NE(warnings[0].message.find("'Egg'"), std::string::npos);
  EXPECT_NE(warnings[1].message.find("'Flow'"), std::string::npos);
}

}  // namespace
}  // namespace sluice
