// SPDX-License-Identifier: GPL-3.0-or-later
// Decided on the language, not on the text: a position counts only if some word passes it.
#include "expr/side.h"

#include "expr/positions.h"

namespace sluice {

namespace {

constexpr EventMask light = mask_of(Event::L), eye = mask_of(Event::E);

struct Language {
  const Expression& expression;
  const std::string& item;
  Positions positions;
  PositionSet live;  // positions that lie on some word

  Language(const Expression& e, const std::string& name)
      : expression(e), item(name), positions(make_positions(e)) {
    live = reach(positions, any_interaction | light | eye);
    live &= reach(reversed(positions), any_interaction | light | eye);
    positions.first &= live;
    positions.last &= live;
  }

  // Positions that words of events in `kinds` alone can come to.
  [[nodiscard]] PositionSet reach(const Positions& from, EventMask kinds) const {
    PositionSet possible, reached;
    for (int p = 0; p < from.size(); ++p)
      if (this->kinds(p) & kinds) possible.insert(p);
    PositionSet front = from.first & possible;
    while (!front.empty()) {
      reached |= front;
      PositionSet next;
      front.for_each([&](int p) { next |= from.follow[static_cast<std::size_t>(p)]; });
      next &= possible;
      front = {};
      next.for_each([&](int p) {
        if (!reached.contains(p)) front.insert(p);
      });
    }
    return reached;
  }

  [[nodiscard]] const Atom& atom(int p) const {
    return expression.atoms[static_cast<std::size_t>(positions.atoms[static_cast<std::size_t>(p)])];
  }
  [[nodiscard]] EventMask kinds(int p) const { return atom(p).kinds(); }

  // Column of the leftmost position of `set` that can be an event of `some`; 0 if none can.
  [[nodiscard]] int column(const PositionSet& set, EventMask some) const {
    int found = 0;
    set.for_each([&](int p) {
      if ((kinds(p) & some) && (!found || atom(p).column < found)) found = atom(p).column;
    });
    return found;
  }

  [[noreturn]] void fail(int at, const char* message) const { throw ExpressionError(item, at, message); }

  void check_not_empty() const {
    if (live.empty()) fail(1, "no path can ever match this; write the events of a path, such as L.*S D");
  }
};

constexpr EventMask not_light = static_cast<EventMask>(any_interaction | eye),
                    not_eye = static_cast<EventMask>(any_interaction | light);

}  // namespace

Side side_of(const Expression& expression, const std::string& item) {
  const Language words(expression, item);
  words.check_not_empty();
  const int first_l = words.column(words.live, light), first_e = words.column(words.live, eye);
  if (!first_l && !first_e)
    words.fail(1,
               "this says neither where the path starts nor where it ends; write L first for a light edit, "
               "or E last for a view edit");
  if (first_l && first_e)
    words.fail(first_e,
               "an edit reads the path from its light (L first, no E) or to the eye (E last, no L); write "
               "one of the two without the other");
  if (first_l) {
    if (const int at = words.column(words.positions.first, not_light))
      words.fail(at,
                 "some paths of this expression begin here, and every path of a light edit begins with L; "
                 "write L first");
    if (words.positions.nullable)
      words.fail(first_l,
                 "this also matches the empty path, and every path of a light edit begins with L; write L "
                 "without making it optional");
    return Side::Light;
  }
  if (const int at = words.column(words.positions.last, not_eye))
    words.fail(
        at,
        "some paths of this expression end here, and every path of a view edit ends with E; write E last");
  if (words.positions.nullable)
    words.fail(first_e,
               "this also matches the empty path, and every path of a view edit ends with E; write E without "
               "making it optional");
  constexpr EventMask seen_kinds = static_cast<EventMask>(mask_of(Event::S) | mask_of(Event::F) | eye);
  const PositionSet seen = words.reach(words.positions, seen_kinds) & words.positions.last;
  if (seen.empty()) {
    PositionSet blocking;  // the events that only a D or G lobe can be
    words.live.for_each([&](int p) {
      if (!(words.kinds(p) & seen_kinds)) blocking.insert(p);
    });
    words.fail(words.column(blocking, gathering | light),
               "view paths end at their first D or G, so this view edit never acts; write it with S, F and E "
               "alone, such as S E");
  }
  return Side::View;
}

Side check_edit_expression(std::string_view text, const std::string& item) {
  return side_of(parse_expression(text, item), item);
}

void check_layer(const Expression& expression, const std::string& item) {
  const Language words(expression, item);
  words.check_not_empty();
  if (const int at = words.column(words.positions.first, not_light))
    words.fail(at, "a layer reads whole paths from L to E, and some begin here; write L first");
  if (const int at = words.column(words.positions.last, not_eye))
    words.fail(at, "a layer reads whole paths from L to E, and some end here; write E last");
  if (words.positions.nullable) words.fail(1, "this also matches the empty path; write L first and E last");
}

Expression parse_layer_expression(std::string_view text, const std::string& item) {
  Expression expression = parse_expression(text, item);
  check_layer(expression, item);
  return expression;
}

}  // namespace sluice
