// SPDX-License-Identifier: GPL-3.0-or-later
// Expressions over path events (design §3, paper §3 and §4.1): text to syntax tree, and the side that a
// language belongs to. Knows no scene: which names exist is not checked here. Every error is an
// ExpressionError with a column and what to write.
//
//   expression = branch { "|" branch }            postfix binds tighter than concatenation, which binds
//   tighter than "|" branch     = factor { factor } factor     = atom [ "*" | "+" | "?" | "{" n [ "," [ m ] ]
//   "}" ] atom       = "(" expression ")" | "." | symbol | "!" symbol | "!" "(" symbol { "|" symbol } ")" |
//   "[" ["^"] symbol { symbol } "]" symbol     = kind [ "'" name { "," name } "'" ]     kind = L | E | D | S
//   | G | F | X, and C for E
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

struct Expression {
  std::string text;
  std::vector<Atom> atoms;
  std::vector<SyntaxNode> nodes;
  int root = -1;
};

// `item` is named in errors: the edit or layer.
[[nodiscard]] Expression parse_expression(std::string_view text, const std::string& item = {});

enum class Side : std::uint8_t { Light, View };
[[nodiscard]] constexpr std::size_t index(Side side) noexcept { return static_cast<std::size_t>(side); }

// Light: every word begins with L and none contains E. View: every word ends with E, none contains L, and
// some word is of S, F and E alone, as view paths end at their first D or G. Anything else throws.
[[nodiscard]] Side side_of(const Expression& expression, const std::string& item = {});
[[nodiscard]] Side check_edit_expression(std::string_view text, const std::string& item = {});

// Layers select whole paths: every word begins with L and ends with E. Throws otherwise.
void check_layer(const Expression& expression, const std::string& item = {});
[[nodiscard]] Expression parse_layer_expression(std::string_view text, const std::string& item = {});

// One event as tests and scripts write it: "L", "S'Egg'", "D'Floor,Ground floor'". Several names: one thing
// that bears them all.
struct NamedEvent {
  Event kind = Event::L;
  std::vector<std::string> names;
};
[[nodiscard]] NamedEvent parse_event(std::string_view text);

}  // namespace sluice
