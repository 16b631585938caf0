// SPDX-License-Identifier: GPL-3.0-or-later
// Path words of the oracles: one character per event, and whether an edit's expression accepts a word, asked
// from accepts() (which tests hold against Python's re) and remembered. Knows no automata of scenes, no
// StateTable, no PathSelection.
#pragma once
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "expr/accepts.h"
#include "expr/automaton.h"
#include "scene/scene.h"

namespace sluice::oracle {

using Word = std::string;  // in the order of light

class Words {
 public:
  Words(const SceneDescription& description, const Scene& scene)
      : entities_(static_cast<int>(scene.entities().size())), texts_(256) {
    for (const EditDescription& edit : description.edits) expressions_.push_back(edit.expression);
    const std::size_t gates = expressions_.size();
    for (const LayerDescription& layer : description.layers) expressions_.push_back(layer.expression);
    known_.resize(expressions_.size());
    if (static_cast<std::size_t>(kinds * (entities_ + 1) + 1) > first_gate || first_gate + gates > 256)
      throw std::length_error("too many things for one character per event");
    for (int e = -1; e < entities_; ++e)
      for (const Event kind : {Event::L, Event::D, Event::S, Event::G, Event::E})
        texts_[static_cast<unsigned char>(event(kind, e))] =
            "LEDSGF"[static_cast<int>(kind)] +
            (e < 0 ? "" : "'" + scene.entities()[static_cast<std::size_t>(e)].names[0] + "'");
    for (std::size_t i = 0; i < gates; ++i)
      texts_[first_gate + i] = "F'" + description.edits[i].entry.name + "'";
  }

  [[nodiscard]] char event(Event kind, int entity) const {
    return static_cast<char>(1 + static_cast<int>(kind) * (entities_ + 1) + entity + 1);
  }
  [[nodiscard]] char gate(int edit) const {
    return static_cast<char>(first_gate + static_cast<std::size_t>(edit));
  }

  // Layers are numbered behind the edits.
  [[nodiscard]] bool accepts(int edit, const Word& word) {
    auto& known = known_[static_cast<std::size_t>(edit)];
    const auto found = known.find(word);
    if (found != known.end()) return found->second;
    std::vector<std::string> events;
    for (const char c : word) events.push_back(texts_[static_cast<unsigned char>(c)]);
    return known[word] = sluice::accepts(expressions_[static_cast<std::size_t>(edit)], events);
  }

 private:
  static constexpr int kinds = 5;  // F has characters of its own
  static constexpr std::size_t first_gate = 224;
  int entities_;
  std::vector<std::string> texts_, expressions_;
  std::vector<std::unordered_map<Word, bool>> known_;
};

}  // namespace sluice::oracle
