// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/expression.h"

#include <algorithm>
#include <optional>

#include "expr/text.h"

namespace sluice {

EventMask Atom::kinds() const noexcept {
  // a named symbol leaves other things of its kind, so it excludes no kind
  EventMask matched = 0, excluded = 0;
  for (const Symbol& s : symbols) {
    matched |= s.kinds;
    if (s.names.empty()) excluded |= s.kinds;
  }
  return negated ? static_cast<EventMask>(any_interaction & ~excluded) : matched;
}

namespace {

// How symbols are written; D and S hold G too. The first of equal kinds is told back.
struct Letter {
  char letter;
  EventMask kinds;
  std::optional<Event> event;  // none: several kinds of event
};
constexpr EventMask glossy = mask_of(Event::G);
constexpr Letter letters[] = {
    {'L', mask_of(Event::L), Event::L},          {'E', mask_of(Event::E), Event::E},
    {'C', mask_of(Event::E), Event::E},          {'D', mask_of(Event::D) | glossy, Event::D},
    {'S', mask_of(Event::S) | glossy, Event::S}, {'G', glossy, Event::G},
    {'F', mask_of(Event::F), Event::F},          {'X', any_lobe, std::nullopt}};

// 0: not the letter of any event.
EventMask kinds_of(char32_t c) noexcept {
  const auto* letter = std::ranges::find(letters, c, [](const Letter& l) { return char32_t(l.letter); });
  return letter == std::end(letters) ? EventMask{0} : letter->kinds;
}

// Recursive descent; parentheses alone recurse and are counted, so the stack is bounded.
class Parser {
 public:
  Parser(std::string_view text, const std::string& item) : text_(decode_utf8(text, item)), item_(item) {
    expression_.text = text;
  }

  Expression parse() {
    if (text_.size() > max_expression_characters)
      fail(max_expression_characters, "an expression has at most 1,024 characters; write a shorter one");
    skip_space();
    if (at_end()) fail(0, "the expression is empty; write the events of the path, such as L.*S D");
    expression_.root = choice(0).node;
    if (!at_end()) fail(at_, "this ) closes nothing; leave it out or write its ( before");
    return std::move(expression_);
  }

 private:
  struct Part {
    int node;
    int atoms;  // {n,m} expanded
  };

  [[noreturn]] void fail(std::size_t at, const std::string& message) const {
    throw ExpressionError(item_, static_cast<int>(at) + 1, message);
  }

  [[nodiscard]] bool at_end() const noexcept { return at_ >= text_.size(); }
  [[nodiscard]] char32_t peek() const noexcept { return at_end() ? U'\0' : text_[at_]; }
  void skip_space() noexcept {
    while (!at_end() && is_space(text_[at_])) ++at_;
  }
  void advance() noexcept {
    ++at_;
    skip_space();
  }

  int add(SyntaxNode node) {
    expression_.nodes.push_back(std::move(node));
    return static_cast<int>(expression_.nodes.size()) - 1;
  }

  // A list with one child is that child.
  Part list_of(SyntaxNode::Kind kind, const std::vector<Part>& parts, std::size_t at) {
    if (parts.size() == 1) return parts.front();
    SyntaxNode node;
    node.kind = kind;
    int atoms = 0;
    for (const Part& part : parts) {
      node.children.push_back(part.node);
      atoms += part.atoms;
    }
    check_atoms(atoms, at);
    return {add(std::move(node)), atoms};
  }

  void check_atoms(long long atoms, std::size_t at) const {
    if (atoms > max_expression_atoms)
      fail(at,
           "the expression holds more than 256 symbols, counts expanded; write a smaller count, or * or +");
  }

  Part choice(int level) {
    const std::size_t start = at_;
    std::vector<Part> branches{sequence(level)};
    while (!at_end() && peek() == U'|') {
      advance();
      branches.push_back(sequence(level));
    }
    return list_of(SyntaxNode::Kind::Choice, branches, start);
  }

  Part sequence(int level) {
    const std::size_t start = at_;
    std::vector<Part> factors;
    while (!at_end() && peek() != U'|' && peek() != U')') factors.push_back(factor(level));
    if (factors.empty())
      fail(at_,
           "something is missing here; write a symbol such as L, D or S, or make what stands beside optional "
           "with ?");
    return list_of(SyntaxNode::Kind::Sequence, factors, start);
  }

  Part factor(int level) {
    const Part part = primary(level);
    const std::size_t at = at_;
    SyntaxNode repeat;
    repeat.kind = SyntaxNode::Kind::Repeat;
    switch (peek()) {
      case U'*': repeat.min = 0, repeat.max = SyntaxNode::unbounded; break;
      case U'+': repeat.min = 1, repeat.max = SyntaxNode::unbounded; break;
      case U'?': repeat.min = 0, repeat.max = 1; break;
      case U'{': count(repeat); break;
      default: return part;
    }
    advance();
    if (is_postfix(peek()))
      fail(at_, "only one of * + ? {n,m} may follow; put parentheses round what it repeats, such as (D*)?");
    // D{2,} is D D*, so an open end costs no symbol of its own.
    const long long times = repeat.max == SyntaxNode::unbounded ? std::max(repeat.min, 1) : repeat.max;
    check_atoms(times * part.atoms, at);
    repeat.children = {part.node};
    return {add(std::move(repeat)), static_cast<int>(times * part.atoms)};
  }

  [[nodiscard]] static bool is_postfix(char32_t c) noexcept {
    return c == U'*' || c == U'+' || c == U'?' || c == U'{';
  }

  // "{" n [ "," [ m ] ] "}"; stops at the closing brace.
  void count(SyntaxNode& repeat) {
    advance();
    repeat.min = number();
    repeat.max = repeat.min;
    if (peek() == U',') {
      advance();
      if (peek() == U'}') {
        repeat.max = SyntaxNode::unbounded;
      } else {
        const std::size_t at = at_;
        repeat.max = number();
        if (repeat.max < repeat.min)
          fail(at, "the second count is below the first; write the smaller one first");
      }
    }
    if (at_end() || peek() != U'}') fail(at_, "a count ends here; write }");
  }

  int number() {
    const std::size_t at = at_;
    int value = 0;
    for (; !at_end() && peek() >= U'0' && peek() <= U'9'; ++at_)
      value = std::min(value * 10 + static_cast<int>(peek() - U'0'), 100'000);
    if (at_ == at) fail(at, "a count is missing; write {2}, {2,} or {2,5}");
    if (value > max_expression_atoms) fail(at, "a count is at most 256; write a smaller one, or * or +");
    skip_space();
    return value;
  }

  Part primary(int level) {
    const std::size_t at = at_;
    switch (peek()) {
      case U'(': {
        if (level >= max_expression_levels) fail(at, "parentheses are nested more than 64 deep; write fewer");
        advance();
        if (at_end()) fail(at, "this ( is never closed; write what it shall hold, then its )");
        if (peek() == U')')
          fail(at, "these parentheses are empty; write what they shall hold, or leave them out");
        const Part part = choice(level + 1);
        if (at_end()) fail(at, "this ( is never closed; write its )");
        advance();
        return part;
      }
      case U'.': {
        advance();
        return atom({}, true, at);
      }
      case U'!': return negation(at);
      case U'[': return set(at);
      default: return atom({symbol()}, false, at);
    }
  }

  Part atom(std::vector<Symbol> symbols, bool negated, std::size_t at) {
    Atom a{std::move(symbols), negated, static_cast<int>(at) + 1};
    expression_.atoms.push_back(std::move(a));
    SyntaxNode node;
    node.atom = static_cast<int>(expression_.atoms.size()) - 1;
    return {add(std::move(node)), 1};
  }

  Part negation(std::size_t at) {
    advance();
    if (peek() != U'(')
      return atom({symbol("after ! write one event, such as !D, or several, such as !(D|S)")}, true, at);
    advance();
    std::vector<Symbol> symbols;
    while (true) {
      symbols.push_back(
          symbol("inside !( ) write events with | between, such as !(D|S'Egg'): only a single event can be "
                 "negated"));
      if (peek() != U'|') break;
      advance();
    }
    if (peek() != U')')
      fail(at_,
           "inside !( ) write events with | between and then ), such as !(D|S): only a single event can be "
           "negated");
    advance();
    return atom(std::move(symbols), true, at);
  }

  Part set(std::size_t at) {
    advance();
    const bool negated = peek() == U'^';
    if (negated) advance();
    std::vector<Symbol> symbols;
    while (!at_end() && peek() != U']')
      symbols.push_back(symbol(
          "inside [ ] events stand side by side, such as [DS'Egg']; write them without anything between"));
    if (at_end()) fail(at, "this [ is never closed; write its ]");
    if (symbols.empty()) fail(at_, "these brackets are empty; write the events of the set, such as [DS]");
    advance();
    return atom(std::move(symbols), negated, at);
  }

  Symbol symbol(const char* instead = nullptr) {
    Symbol s;
    s.column = static_cast<int>(at_) + 1;
    s.kinds = at_end() ? EventMask{0} : kinds_of(peek());
    if (!s.kinds) fail_symbol(instead);
    advance();
    if (peek() != U'\'') return s;
    s.names = names();
    skip_space();
    return s;
  }

  [[noreturn]] void fail_symbol(const char* instead) const {
    if (at_end()) fail(at_, instead ? instead : "the expression ends too early; write an event");
    const char32_t c = peek();
    if (c >= U'a' && c <= U'z' && kinds_of(c - U'a' + U'A'))
      fail(at_, "events are capital letters; write " + std::string(1, static_cast<char>(c - U'a' + U'A')));
    if (instead) fail(at_, instead);
    if (is_postfix(c)) fail(at_, "nothing stands before this to be repeated; write an event first");
    if (c == U'\'') fail(at_, "a name belongs to an event; write its kind before it, such as D'Floor'");
    if (c == U'"' || c == U'‘' || c == U'’' || c == U'“' || c == U'”')
      fail(at_, "names stand in straight single quotes; write D'Floor'");
    if (c == U']' || c == U'}')
      fail(at_, std::string("this ") + static_cast<char>(c) + " closes nothing; leave it out");
    if (c < U' ' || c == 0x7f)
      fail(at_,
           "this character cannot be seen and is no event; write one of L E D S G F X, or . for any "
           "interaction");
    fail(at_, "'" + encode_utf8(c) + "' is no event; write one of L E D S G F X, or . for any interaction");
  }

  // "'" name { "," name } "'"; everything between counts, also spaces. A backslash before ' , or \ takes it
  // as it is.
  std::vector<std::string> names() {
    const std::size_t open = at_++;
    std::vector<std::string> all;
    std::string name;
    while (true) {
      if (at_end()) fail(open, "this name is never closed; write ' behind it");
      const char32_t c = text_[at_];
      if (c == U'\'' || c == U',') {
        if (name.empty())
          fail(at_, "a name is missing here; write it, or leave the quotes out to mean anything");
        all.push_back(std::move(name));
        name.clear();
        ++at_;
        if (c == U'\'') return all;
        continue;
      }
      if (c == U'\\') {
        ++at_;
        const char32_t escaped = peek();
        if (at_end() || (escaped != U'\'' && escaped != U',' && escaped != U'\\'))
          fail(at_ - 1, "in a name a backslash is written \\\\, a quote \\' and a comma \\,");
      }
      name += encode_utf8(text_[at_++]);
    }
  }

  std::u32string text_;
  std::string item_;
  std::size_t at_ = 0;
  Expression expression_;
};

}  // namespace

Expression parse_expression(std::string_view text, const std::string& item) {
  return Parser(text, item).parse();
}

char letter_of(EventMask kinds) noexcept { return std::ranges::find(letters, kinds, &Letter::kinds)->letter; }

NamedEvent parse_event(std::string_view text) {
  const std::string item(text);
  const Expression e = parse_expression(text, item);
  if (e.nodes.size() == 1 && !e.atoms.front().negated && e.atoms.front().symbols.size() == 1) {
    const Symbol& s = e.atoms.front().symbols.front();
    if (const auto event = std::ranges::find(letters, s.kinds, &Letter::kinds)->event)
      return {*event, s.names};
  }
  throw ExpressionError(
      item, 1,
      "an event of a path is one of L E D S G F with the names of its thing; write it like D'Floor'");
}

}  // namespace sluice
