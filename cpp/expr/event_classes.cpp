// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/event_classes.h"

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <unordered_map>

#include "base/error.h"

namespace sluice {

// Events are told apart by kind and by those of their names that some rule mentions: usually none, so scenes
// of any size have few.
class AlphabetBuilder {
 public:
  AlphabetBuilder(std::span<const Rule> rules, std::span<const Entity> entities,
                  std::span<const Entity> gates, const CancelPoint& cancel)
      : rules_(rules), cancel_(cancel) {
    for (const Rule& rule : rules)
      for (const Atom& atom : rule.expression->atoms)
        for (const Symbol& symbol : atom.symbols)
          for (const std::string& name : symbol.names)
            mentioned_.emplace(name, static_cast<int>(mentioned_.size()));
    name_class({});               // class 0: nothing that a rule mentions
    name_class_of_.push_back(0);  // of a thing without a name
    for (const Entity& entity : entities) name_class_of_.push_back(name_class(mentioned(entity)));
    for (const Entity& gate : gates) gates_.push_back(mentioned(gate));
  }

  ClassedRules build() {
    find_meanings();
    find_classes();
    return std::move(out_);
  }

 private:
  using Names = std::vector<int>;  // numbers of mentioned names, ascending

  Names mentioned(const Entity& entity) const {
    Names names;
    for (const std::string& name : entity.names)
      if (const auto it = mentioned_.find(name); it != mentioned_.end()) names.push_back(it->second);
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
  }

  std::uint32_t name_class(const Names& names) {
    const auto [it, is_new] = name_classes_.emplace(names, static_cast<std::uint32_t>(name_list_.size()));
    if (is_new) name_list_.push_back(names);
    return it->second;
  }

  // All events that can differ: kinds × name classes, then one F per gate.
  [[nodiscard]] std::size_t universe() const noexcept {
    return name_list_.size() * event_count + gates_.size();
  }

  // An atom with its names as numbers.
  struct NumberedSymbol {
    EventMask kinds;
    Names names;
  };
  [[nodiscard]] std::vector<NumberedSymbol> numbered(const Atom& atom) const {
    std::vector<NumberedSymbol> symbols;
    for (const Symbol& symbol : atom.symbols) {
      Names& names = symbols.emplace_back(NumberedSymbol{symbol.kinds, {}}).names;
      for (const std::string& name : symbol.names) names.push_back(mentioned_.at(name));
    }
    return symbols;
  }

  [[nodiscard]] static bool matches(const std::vector<NumberedSymbol>& symbols, bool negated, Event kind,
                                    const Names& names) {
    const EventMask bit = mask_of(kind);
    const bool any = std::any_of(symbols.begin(), symbols.end(), [&](const NumberedSymbol& symbol) {
      return (symbol.kinds & bit) &&
             (symbol.names.empty() || std::find_first_of(names.begin(), names.end(), symbol.names.begin(),
                                                         symbol.names.end()) != names.end());
    });
    return negated ? !any && (any_interaction & bit) : any;
  }

  void find_meanings() {
    std::map<Bits, std::uint32_t> known;
    for (const Rule& rule : rules_) {
      cancel_();
      auto& meaning = out_.meaning.emplace_back();
      for (const Atom& atom : rule.expression->atoms) {
        const auto symbols = numbered(atom);
        Bits bits((universe() + 63) / 64);
        std::size_t event = 0;
        for (const Names& names : name_list_)
          for (int kind = 0; kind < event_count; ++kind, ++event)
            if (static_cast<Event>(kind) != Event::F &&
                matches(symbols, atom.negated, static_cast<Event>(kind), names))
              set_bit(bits, event);
        // An edit that acts once never sees its own F before it acts, so that F may count as any: it counts
        // as a nameless one, and edits that guard against themselves, L(!F'A')*S, keep the automaton of L.*S
        // (design §3).
        for (std::size_t g = 0; g < gates_.size(); ++g, ++event)
          if (matches(symbols, atom.negated, Event::F,
                      static_cast<int>(g) == rule.own_gate ? Names{} : gates_[g]))
            set_bit(bits, event);
        meaning.push_back(known.emplace(bits, static_cast<std::uint32_t>(known.size())).first->second);
      }
    }
    meanings_.resize(known.size());
    for (const auto& [bits, number] : known) meanings_[number] = bits;
  }

  // Splits the universe by each meaning in turn: what lies in it leaves its class for a new one. Then numbers
  // what is left.
  void find_classes() {
    std::vector<std::uint32_t> classes(universe(), 0);
    std::uint32_t made = 1;
    std::unordered_map<std::uint32_t, std::uint32_t> split;
    for (const Bits& meaning : meanings_) {
      split.clear();
      for_each_bit(meaning, [&](std::size_t event) {
        const auto [it, is_new] = split.emplace(classes[event], made);
        if (is_new) ++made;
        classes[event] = it->second;
      });
    }
    split.clear();
    for (std::uint32_t& c : classes)
      c = split.emplace(c, static_cast<std::uint32_t>(split.size())).first->second;
    const std::size_t count = split.size();
    if (count > std::numeric_limits<EventClass>::max())
      throw SceneError("", "the expressions of the edits name too many different things; use fewer names");

    Alphabet& alphabet = out_.alphabet;
    alphabet.size_ = static_cast<int>(count);
    for (const std::uint32_t names : name_class_of_)
      for (std::size_t kind = 0; kind < event_count; ++kind)
        alphabet.classes_.push_back(static_cast<EventClass>(classes[names * event_count + kind]));
    for (std::size_t event = name_list_.size() * event_count; event < classes.size(); ++event)
      alphabet.gates_.push_back(static_cast<EventClass>(classes[event]));
    for (const Bits& meaning : meanings_) {
      Bits& matcher = out_.matchers.emplace_back((count + 63) / 64);
      for_each_bit(meaning, [&](std::size_t event) { set_bit(matcher, classes[event]); });
    }
  }

  std::span<const Rule> rules_;
  const CancelPoint& cancel_;
  std::unordered_map<std::string, int> mentioned_;
  std::map<Names, std::uint32_t> name_classes_;
  std::vector<std::uint32_t> name_class_of_;  // [entity + 1]
  std::vector<Names> name_list_, gates_;
  std::vector<Bits> meanings_;
  ClassedRules out_;
};

ClassedRules classify(std::span<const Rule> rules, std::span<const Entity> entities,
                      std::span<const Entity> gates, const CancelPoint& cancel) {
  return AlphabetBuilder(rules, entities, gates, cancel).build();
}

}  // namespace sluice
