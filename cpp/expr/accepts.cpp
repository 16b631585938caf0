// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/accepts.h"

#include "base/error.h"
#include "expr/automaton.h"
#include "expr/expression.h"

namespace sluice {

namespace {

// The automaton of one expression, over the things that the events speak of.
struct WordAcceptor {
  Automata automata;
  std::vector<EventClass> classes;  // [event]

  WordAcceptor(std::string_view text, std::span<const std::string> events) {
    const std::string item(text);
    const Expression expression = parse_expression(text, item);
    std::vector<NamedEvent> named;
    std::vector<Entity> entities, gates;
    for (const std::string& event : events) {
      named.push_back(parse_event(event));
      (named.back().kind == Event::F ? gates : entities).push_back({named.back().names});
    }
    Rule rule;
    rule.name = item;
    rule.expression = &expression;
    automata = compile_automata({&rule, 1}, entities, gates);
    int entity = 0, gate = 0;
    for (const NamedEvent& event : named)
      classes.push_back(event.kind == Event::F ? automata.alphabet.gate(gate++)
                                               : automata.alphabet.event(event.kind, entity++));
  }
};

}  // namespace

std::vector<std::uint8_t> accepts_many(std::string_view expression, std::span<const std::string> events,
                                       std::span<const std::uint8_t> words, std::size_t length) {
  if (events.size() >= word_end)
    throw SceneError(std::string(expression), "words are written with at most 254 different events");
  if (length ? words.size() % length != 0 : !words.empty())
    throw SceneError(std::string(expression), "words come in rows of equal length");
  const WordAcceptor acceptor(expression, events);
  const Dfa& dfa = acceptor.automata.forward.front();
  std::vector<std::uint8_t> accepted;
  for (std::size_t row = 0; row < words.size(); row += length) {
    std::uint16_t state = 0;
    for (std::size_t i = row; i < row + length && words[i] != word_end; ++i) {
      if (words[i] >= events.size())
        throw SceneError(std::string(expression), "a word names an event that was not given");
      state = dfa.step(state, acceptor.classes[words[i]]);
    }
    accepted.push_back(dfa.accepts(state).empty() ? 0 : 1);
  }
  return accepted;
}

bool accepts(std::string_view expression, std::span<const std::string> events) {
  const WordAcceptor acceptor(expression, events);
  const Dfa& dfa = acceptor.automata.forward.front();
  std::uint16_t state = 0;
  for (const EventClass c : acceptor.classes) state = dfa.step(state, c);
  return !dfa.accepts(state).empty();
}

}  // namespace sluice
