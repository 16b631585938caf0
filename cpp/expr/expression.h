// SPDX-License-Identifier: GPL-3.0-or-later
// Expressions over path events (design §3, paper §3 and §4.1): from text to a syntax tree. Knows no scene:
// which names exist is not checked here (unknown_names.h), nor which side an expression belongs to (side.h).
// Every error is an ExpressionError with a column and what to write. Postfix operators bind tighter than
// concatenation, which binds tighter than "|".
//
//   expression = branch { "|" branch }
//   branch     = factor { factor }
//   factor     = atom [ "*" | "+" | "?" | "{" n [ "," [ m ] ] "}" ]
//   atom       = "(" expression ")" | "." | symbol
//              | "!" symbol | "!" "(" symbol { "|" symbol } ")" | "[" ["^"] symbol { symbol } "]"
//   symbol     = kind [ "'" name { "," name } "'" ]
//   kind       = L | E | D | S | G | F | X, and C for E
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/event.h"

namespace sluice {

inline constexpr int max_expression_characters = 1024;
inline constexpr int max_expression_levels = 64;
inline constexpr int max_expression_atoms = 256;  // {n,m} counted expanded

// Events of any of these kinds at a thing that bears one of the names (none: at anything).
struct Symbol {
  EventMask kinds = 0;  // D and S hold G too: glossy is D|S (paper §3)
  std::vector<std::string> names;
  int column = 0;
};

inline constexpr EventMask any_interaction =
    static_cast<EventMask>(mask_of(Event::D) | mask_of(Event::S) | mask_of(Event::G) | mask_of(Event::F));

// One event: one that some symbol matches, or (negated) an interaction that none matches. "." is the negation
// of nothing.
struct Atom {
  std::vector<Symbol> symbols;
  bool negated = false;
  int column = 0;

  [[nodiscard]] EventMask kinds() const noexcept;  // kinds of event that it can match at all
};

// Sequence and Choice have any number of children; Repeat has one.
struct SyntaxNode {
  enum class Kind : std::uint8_t { Atom, Sequence, Choice, Repeat };
  static constexpr int unbounded = -1;

  Kind kind = Kind::Atom;
  int atom = -1;              // Atom: index into Expression::atoms
  int min = 1, max = 1;       // Repeat
  std::vector<int> children;  // indices into Expression::nodes
};

[[nodiscard]] constexpr const char* name_of(SyntaxNode::Kind kind) noexcept {
  switch (kind) {
    case SyntaxNode::Kind::Atom: return "atom";
    case SyntaxNode::Kind::Sequence: return "sequence";
    case SyntaxNode::Kind::Choice: return "choice";
    case SyntaxNode::Kind::Repeat: return "repeat";
  }
  return nullptr;
}

struct Expression {
  std::string text;
  std::vector<Atom> atoms;
  std::vector<SyntaxNode> nodes;
  int root = -1;
};

// `item` is named in errors: the edit or layer.
[[nodiscard]] Expression parse_expression(std::string_view text, const std::string& item = {});

// The letter that a symbol of these kinds is written with; E for C.
[[nodiscard]] char letter_of(EventMask kinds) noexcept;

// One event as tests and scripts write it: "L", "S'Egg'", "D'Floor,Ground floor'". Several names: one thing
// that bears them all.
struct NamedEvent {
  Event kind = Event::L;
  std::vector<std::string> names;
};
[[nodiscard]] NamedEvent parse_event(std::string_view text);

}  // namespace sluice
