// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/automaton.h"

#include <algorithm>
#include <map>
#include <optional>
#include <unordered_map>

#include "base/error.h"
#include "expr/event_classes.h"
#include "expr/positions.h"

namespace sluice {

namespace {

// Two rules with equal keys have one automaton: same positions, same meanings.
std::vector<std::uint64_t> key_of(const Positions& positions, const std::vector<std::uint32_t>& meaning) {
  std::vector<std::uint64_t> key{positions.nullable ? 1u : 0u};
  const auto append = [&key](const PositionSet& set) {
    key.insert(key.end(), set.words.begin(), set.words.end());
  };
  append(positions.first);
  append(positions.last);
  for (int p = 0; p < positions.size(); ++p) {
    key.push_back(meaning[static_cast<std::size_t>(positions.atoms[static_cast<std::size_t>(p)])]);
    append(positions.follow[static_cast<std::size_t>(p)]);
  }
  return key;
}

// Merges automata two by two while the product fits; what cannot be merged stays a group of its own.
std::vector<Dfa> share(std::vector<Dfa> dfas, const CancelPoint& cancel) {
  for (bool merged = true; merged && dfas.size() > 1;) {
    merged = false;
    std::stable_sort(dfas.begin(), dfas.end(),
                     [](const Dfa& a, const Dfa& b) { return a.states < b.states; });
    std::vector<Dfa> next;
    for (std::size_t i = 0; i < dfas.size(); i += 2) {
      cancel();
      if (i + 1 == dfas.size()) {
        next.push_back(std::move(dfas[i]));
      } else if (auto both = product(dfas[i], dfas[i + 1])) {
        next.push_back(minimised(*both, cancel));
        merged = true;
      } else {
        next.push_back(std::move(dfas[i]));
        next.push_back(std::move(dfas[i + 1]));
      }
    }
    dfas = std::move(next);
  }
  return dfas;
}

}  // namespace

Automata compile_automata(std::span<const Rule> rules, std::span<const Entity> entities,
                          std::span<const Entity> gates, const CancelPoint& cancel) {
  ClassedRules classed = classify(rules, entities, gates, cancel);
  Automata automata;
  for (std::vector<Dfa>* group : {&automata.forward, &automata.backward, &automata.layers}) {
    const bool backward = group == &automata.backward, layers = group == &automata.layers;
    std::map<std::vector<std::uint64_t>, std::uint16_t> known;
    std::vector<std::vector<std::uint16_t>> users;  // [distinct expression] -> rules
    std::vector<Dfa> dfas;
    for (std::size_t r = 0; r < rules.size(); ++r) {
      if (rules[r].reversed != backward || rules[r].is_layer != layers) continue;
      cancel();
      Positions positions = make_positions(*rules[r].expression);
      if (backward) positions = reversed(positions);
      const auto [it, is_new] =
          known.emplace(key_of(positions, classed.meaning[r]), static_cast<std::uint16_t>(users.size()));
      if (is_new) {
        auto dfa = determinised(positions, classed.meaning[r], classed.matchers, classed.alphabet.size(),
                                it->second);
        if (!dfa) {
          throw ExpressionError(rules[r].name, 1,
                                "this expression needs more than 4,096 states; write fewer . or {n,m} behind "
                                "a *, each of them doubles the states");
        }
        dfas.push_back(minimised(*dfa, cancel));
        users.emplace_back();
      }
      users[it->second].push_back(static_cast<std::uint16_t>(r));
    }
    dfas = share(std::move(dfas), cancel);
    for (Dfa& dfa : dfas)
      for (auto& accepting : dfa.accepting) {
        std::vector<std::uint16_t> all;
        for (const std::uint16_t expression : accepting)
          all.insert(all.end(), users[expression].begin(), users[expression].end());
        std::sort(all.begin(), all.end());
        accepting = std::move(all);
      }
    *group = std::move(dfas);
  }
  automata.alphabet = std::move(classed.alphabet);
  return automata;
}

}  // namespace sluice
