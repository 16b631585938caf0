// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/unknown_names.h"

#include <string_view>
#include <unordered_set>

#include "expr/text.h"

namespace sluice {

void warn_unknown_names(std::span<const Rule> rules, std::span<const Entity> entities,
                        std::span<const Entity> gates, Warnings& warnings, const CancelPoint& cancel) {
  std::unordered_set<std::string_view> known, known_gates;
  // in the scene's order, so that the nearest of equals does not change
  std::vector<const std::string*> all, all_gates;
  const auto learn = [](std::span<const Entity> things, auto& set, auto& list) {
    for (const Entity& thing : things)
      for (const std::string& name : thing.names)
        if (set.insert(name).second) list.push_back(&name);
  };
  learn(gates, known_gates, all_gates);
  learn(entities, known, all);
  learn(gates, known, all);
  for (const Rule& rule : rules) {
    cancel();
    std::unordered_set<std::string_view> said;
    for (const Atom& atom : rule.expression->atoms)
      for (const Symbol& symbol : atom.symbols)
        for (const std::string& name : symbol.names) {
          const bool is_gate = symbol.kinds == mask_of(Event::F);
          if ((is_gate ? known_gates : known).contains(name) || !said.insert(name).second) continue;
          const std::string* nearest = nearest_name(name, is_gate ? all_gates : all);
          warnings.push_back(
              {rule.name,
               (is_gate ? "no edit or collection is named '" : "no object, light or collection is named '") +
                   name + "'" + (nearest ? "; the nearest name is '" + *nearest + "'" : std::string())});
        }
  }
}

std::vector<std::string> unknown_names(const Expression& expression, std::span<const std::string> names) {
  const Rule rule{.name = {}, .expression = &expression};
  std::vector<Entity> entities;
  for (const std::string& name : names) entities.push_back({{name}});
  Warnings warnings;
  warn_unknown_names({&rule, 1}, entities, entities, warnings);
  std::vector<std::string> messages;
  for (Warning& warning : warnings) messages.push_back(std::move(warning.message));
  return messages;
}

}  // namespace sluice
