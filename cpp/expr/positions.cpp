// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/positions.h"

#include <utility>

namespace sluice {

namespace {

class Builder {
 public:
  Builder(const Expression& expression, Positions& out) : expression_(expression), out_(out) {}

  struct Part {
    bool nullable = true;
    PositionSet first, last;
  };

  // Recursion is as deep as the parser allowed. Each visit makes new positions, so that {n,m} is expanded by
  // visiting again.
  Part build(int index) {
    const SyntaxNode& node = expression_.nodes[static_cast<std::size_t>(index)];
    Part part;
    switch (node.kind) {
      case SyntaxNode::Kind::Atom: {
        const int p = out_.size();
        out_.atoms.push_back(node.atom);
        out_.follow.emplace_back();
        part.nullable = false;
        part.first.insert(p);
        part.last.insert(p);
        break;
      }
      case SyntaxNode::Kind::Sequence:
        for (const int child : node.children) append(part, build(child));
        break;
      case SyntaxNode::Kind::Choice:
        part.nullable = false;
        for (const int child : node.children) {
          const Part branch = build(child);
          part.nullable |= branch.nullable;
          part.first |= branch.first;
          part.last |= branch.last;
        }
        break;
      case SyntaxNode::Kind::Repeat: part = repeat(node); break;
    }
    return part;
  }

 private:
  void connect(const PositionSet& from, const PositionSet& to) {
    from.for_each([&](int p) { out_.follow[static_cast<std::size_t>(p)] |= to; });
  }

  void append(Part& part, const Part& next) {
    connect(part.last, next.first);
    if (part.nullable) part.first |= next.first;
    if (!next.nullable) part.last = {};
    part.last |= next.last;
    part.nullable &= next.nullable;
  }

  Part repeat(const SyntaxNode& node) {
    const bool open = node.max == SyntaxNode::unbounded;
    const int copies = open ? std::max(node.min, 1) : node.max;
    Part part;
    for (int i = 0; i < copies; ++i) {
      const int before = out_.size();
      Part copy = build(node.children.front());
      if (out_.size() == before) break;  // a child without symbols: more copies would add nothing
      if (i >= node.min) copy.nullable = true;
      if (open && i == copies - 1) connect(copy.last, copy.first);
      append(part, copy);
    }
    return part;
  }

  const Expression& expression_;
  Positions& out_;
};

}  // namespace

Positions make_positions(const Expression& expression) {
  Positions positions;
  const Builder::Part whole = Builder(expression, positions).build(expression.root);
  positions.first = whole.first;
  positions.last = whole.last;
  positions.nullable = whole.nullable;
  return positions;
}

Positions reversed(const Positions& positions) {
  Positions r = positions;
  std::swap(r.first, r.last);
  for (PositionSet& f : r.follow) f = {};
  for (int p = 0; p < positions.size(); ++p)
    positions.follow[static_cast<std::size_t>(p)].for_each(
        [&](int q) { r.follow[static_cast<std::size_t>(q)].insert(p); });
  return r;
}

}  // namespace sluice
