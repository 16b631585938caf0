// SPDX-License-Identifier: GPL-3.0-or-later
// The language of expressions for Python: reads, checks and explains them without a scene.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "base/error.h"
#include "bindings/parts.h"
#include "expr/accepts.h"
#include "expr/expression.h"
#include "expr/side.h"
#include "expr/unknown_names.h"

namespace py = pybind11;

namespace sluice {
namespace {

py::dict check_expression(const std::string& text, const std::vector<std::string>& names) {
  const Expression expression = parse_expression(text);
  py::dict d;
  d["side"] = name_of(side_of(expression));
  d["warnings"] = unknown_names(expression, names);
  return d;
}

py::dict check_layer_expression(const std::string& text, const std::vector<std::string>& names) {
  py::dict d;
  d["warnings"] = unknown_names(parse_layer_expression(text), names);
  return d;
}

// ("atom", negated, ((letter, (name, …)), …)), ("sequence", node, …), ("choice", node, …), ("repeat", node,
// min, max or None).
py::tuple tree_of(const Expression& expression, int index) {
  const SyntaxNode& node = expression.nodes[static_cast<std::size_t>(index)];
  py::list parts;
  if (node.kind == SyntaxNode::Kind::Atom) {
    const Atom& atom = expression.atoms[static_cast<std::size_t>(node.atom)];
    for (const Symbol& symbol : atom.symbols)
      parts.append(
          py::make_tuple(std::string(1, letter_of(symbol.kinds)), py::tuple(py::cast(symbol.names))));
    return py::make_tuple(name_of(node.kind), atom.negated, py::tuple(parts));
  }
  parts.append(name_of(node.kind));
  for (const int child : node.children) parts.append(tree_of(expression, child));
  if (node.kind == SyntaxNode::Kind::Repeat) {
    parts.append(node.min);
    parts.append(node.max == SyntaxNode::unbounded ? py::object(py::none()) : py::object(py::int_(node.max)));
  }
  return py::tuple(parts);
}

}  // namespace

void define_language(py::module_& m) {
  m.def(
      "accepts",
      [](const std::string& expression, const std::vector<std::string>& events) {
        return accepts(expression, events);
      },
      py::arg("expression"), py::arg("events"),
      "Does the expression accept the word? events in the order of light: [\"L\", \"S'Egg'\", \"D\"].");
  m.def(
      "accepts_many",
      [](const std::string& expression, const std::vector<std::string>& events,
         const py::array_t<std::uint8_t, py::array::c_style>& words) {
        if (words.ndim() != 2) throw SceneError("words", "words must have two dimensions: one row per word");
        return accepts_many(expression, events,
                            std::span(words.data(), static_cast<std::size_t>(words.size())),
                            static_cast<std::size_t>(words.shape(1)));
      },
      py::arg("expression"), py::arg("events"), py::arg("words"),
      "Rows of `words` are numbers of `events`, ended early by 255; 0 or 1 per row.");
  m.def("check_expression", &check_expression, py::arg("text"), py::arg("names"),
        "{'side', 'warnings'} of an edit's expression; ExpressionError if it has none.");

  m.def("check_layer_expression", &check_layer_expression, py::arg("text"), py::arg("names"),
        "{'warnings'} of a layer's expression; ExpressionError if it has none.");
  m.def(
      "parse",
      [](const std::string& text) {
        const Expression expression = parse_expression(text);
        return tree_of(expression, expression.root);
      },
      py::arg("text"),
      "The syntax tree as nested tuples: ('atom', negated, ((letter, names), …)), ('sequence', …), "
      "('choice', …), ('repeat', node, min, max or None).");
}

}  // namespace sluice
