// SPDX-License-Identifier: GPL-3.0-or-later
// sluice_core: description in, session handle out, errors as ValueErrors with item and column. The GIL is released in every call that
// may take longer than a millisecond; nothing in the core calls Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstring>

#include "bindings/description.h"
#include "edit/accepts.h"
#include "edit/automaton.h"
#include "render/report.h"
#include "scene/normals.h"

namespace py = pybind11;
using namespace sluice;

namespace {

// Through a scene of this mesh alone, so that it is read and checked as each is.
py::array_t<float> shading_normals(const py::dict& mesh) {
  py::dict scene;
  scene["meshes"] = py::make_tuple(mesh);
  MeshDescription read = std::move(read_description(scene).meshes.front());
  check_mesh(read);
  make_normals(read);
  const py::ssize_t count = static_cast<py::ssize_t>(read.normals.size());
  py::array_t<float> normals({count, py::ssize_t{3}});
  if (count > 0) std::memcpy(normals.mutable_data(), read.normals.data(), read.normals.size() * sizeof(V3f));
  return normals;
}

// ValueErrors with .item and .column, whose types live as long as the module.
struct ErrorTypes {
  py::object scene, expression;
};
ErrorTypes& error_types() {
  static auto* types = new ErrorTypes;  // never destroyed: Python may be gone before static destructors run
  return *types;
}

void raise(const py::object& type, const char* message, const std::string& item, int column) {
  const py::object error = type(message);
  error.attr("item") = item;
  error.attr("column") = column > 0 ? py::object(py::int_(column)) : py::none();
  PyErr_SetObject(type.ptr(), error.ptr());
}

void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const ExpressionError& error) {
    raise(error_types().expression, error.what(), error.item, error.column);
  } catch (const SceneError& error) {
    raise(error_types().scene, error.what(), error.item, 0);
  }
}

py::object or_none(double value) { return value < 0 ? py::object(py::none()) : py::object(py::float_(value)); }

py::dict progress_of(const Session& session) {
  const Progress p = session.progress();
  static constexpr const char* states[] = {"idle", "compiling", "rendering", "finished", "cancelled", "failed"};
  static constexpr const char* reasons[] = {"", "passes", "time", "error", "cancelled"};
  py::dict d;
  d["state"] = states[static_cast<int>(p.state)], d["stop_reason"] = reasons[static_cast<int>(p.stop_reason)];
  d["pass"] = p.pass, d["passes"] = p.passes, d["photons"] = p.photons, d["seconds"] = p.seconds;
  d["seconds_left"] = or_none(p.seconds_left), d["error_estimate"] = or_none(p.relative_error);
  d["unmet"] = p.unmet;
  d["memory"] = p.memory, d["message"] = p.failure ? p.failure->message : std::string();
  d["error"] = py::none();
  if (p.failure) {
    py::dict e;
    e["message"] = p.failure->message, e["item"] = p.failure->item;
    e["column"] = p.failure->column > 0 ? py::object(py::int_(p.failure->column)) : py::none();
    d["error"] = e;
  }
  return d;
}

py::dict statistics_of(const Session& session) {
  const Statistics s = session.statistics();
  const Counts& c = s.counts;
  py::dict d, seconds, dropped, ledger;
  py::list effects, edits, layers, unmet;
  seconds["compile"] = s.seconds[0], seconds["guide"] = s.seconds[1], seconds["photons"] = s.seconds[2], seconds["view"] = s.seconds[3];
  for (const auto& reason : s.reasons) effects.append(py::make_tuple(reason.effect, reason.runs, reason.why));
  for (std::size_t e = 0; e < c.edits.size() && e < s.edit_names.size(); ++e) {
    py::dict edit;
    edit["name"] = s.edit_names[e], edit["matched"] = c.edits[e].matched, edit["moved"] = c.edits[e].moved, edit["capped"] = c.edits[e].capped;
    edit["floats"] = s.edit_floats[e].distance, edit["side"] = s.edit_floats[e].side;
    edit["energy_in"] = c.edits[e].energy_in, edit["energy_out"] = c.edits[e].energy_out;
    edit["acted"] = c.edits[e].has_acted(), edit["share"] = e < s.edit_shares.size() ? s.edit_shares[e] : 0.0, edit["seconds"] = c.edits[e].seconds / s.threads;
    if (e < s.arrivals.size()) {
      py::list arrivals;
      for (const auto& kind : s.arrivals[e].kinds) arrivals.append(py::make_tuple(kind.expression, kind.share));
      edit["probed"] = s.arrivals[e].probed, edit["crossed"] = s.arrivals[e].crossed, edit["arrivals"] = arrivals;
      edit["taken"] = s.arrivals[e].taken, edit["taker"] = s.arrivals[e].taker;
    }
    edits.append(edit);
  }
  for (const LayerShare& l : s.layers) {
    py::dict layer;
    layer["name"] = l.name, layer["expression"] = l.expression, layer["share"] = l.share;
    layers.append(layer);
  }
  for (const UnmetShare& each : s.unmet) unmet.append(py::dict(py::arg("name") = each.name, py::arg("share") = each.share));
  dropped["non_finite"] = c.non_finite, dropped["adjoint_clamped"] = c.adjoint_clamped, dropped["depth_capped"] = c.depth_capped;
  dropped["gates_capped"] = c.gates_capped, dropped["split_capped"] = c.split_capped, dropped["grazing_dropped"] = c.grazing_dropped;
  dropped["alpha_capped"] = c.alpha_capped, dropped["states_capped"] = c.states_capped;
  ledger["emitted"] = c.ledger.emitted, ledger["added"] = c.ledger.added, ledger["sampling"] = c.ledger.sampling;
  ledger["absorbed"] = c.ledger.absorbed, ledger["escaped"] = c.ledger.escaped, ledger["removed"] = c.ledger.removed;
  ledger["capped"] = c.ledger.capped, ledger["clamped"] = c.ledger.clamped, ledger["worst_residual"] = s.worst_ledger_residual;
  d["report"] = describe(s), d["seconds"] = seconds, d["effects"] = effects, d["edits"] = edits, d["layers"] = layers, d["dropped"] = dropped, d["ledger"] = ledger;
  d["rays"] = c.rays + c.shadow_rays, d["photon_paths"] = c.photon_paths, d["photons_stored"] = c.photons_stored;
  d["view_paths"] = c.view_paths, d["gathers"] = c.gathers, d["photons_gathered"] = c.photons_gathered, d["edit_queries"] = c.edit_queries;
  d["bytes_per_photon"] = s.bytes_per_photon, d["triangles"] = s.triangles, d["threads"] = s.threads, d["guide_hash"] = hex(s.guide_hash);
  d["radius"] = s.radius, d["unmet"] = unmet;
  return d;
}

// A session waits for its threads when it dies; Python's other threads must not wait with it.
struct DeleteWithoutGil {
  void operator()(Session* session) const {
    const py::gil_scoped_release release;
    delete session;
  }
};

// {name: float32 (height, width, channels)} or None before the first tile.
py::object snapshot_of(const Session& session, const std::vector<std::string>& names) {
  std::vector<Session::Picture> found;
  {
    const py::gil_scoped_release release;
    found = session.pictures(names);
  }
  if (found.empty()) return py::none();
  py::dict pictures;
  for (std::size_t i = 0; i < names.size(); ++i) {
    auto* pixels = new std::vector<float>(std::move(found[i].pixels));
    const py::capsule owner(pixels, [](void* p) { delete static_cast<std::vector<float>*>(p); });
    pictures[names[i].c_str()] = py::array_t<float>({found[i].height, found[i].width, found[i].channels}, pixels->data(), owner);
  }
  return pictures;
}

// What an expression says of names that nothing bears.
py::list unknown_names(const Expression& expression, const std::vector<std::string>& names) {
  const Rule rule{.name = {}, .expression = &expression};
  std::vector<Entity> entities;
  for (const std::string& name : names) entities.push_back({{name}});
  Warnings warnings;
  warn_unknown_names(std::span(&rule, 1), entities, entities, warnings);  // objects, lights, collections and entries alike
  py::list messages;
  for (const Warning& warning : warnings) messages.append(warning.message);
  return messages;
}

py::dict check_expression(const std::string& text, const std::vector<std::string>& names) {
  const Side side = check_edit_expression(text);
  py::dict d;
  d["side"] = side == Side::Light ? "light" : "view", d["warnings"] = unknown_names(parse_expression(text), names);
  return d;
}

py::dict check_layer_expression(const std::string& text, const std::vector<std::string>& names) {
  py::dict d;
  d["warnings"] = unknown_names(parse_layer_expression(text), names);
  return d;
}

std::string letter_of(EventMask kinds) {
  static constexpr std::pair<Event, const char*> letters[] = {{Event::L, "L"}, {Event::E, "E"}, {Event::D, "D"}, {Event::S, "S"}, {Event::F, "F"}};
  if (kinds == any_lobe) return "X";
  for (const auto& [kind, letter] : letters)
    if (kinds & mask_of(kind)) return letter;  // D and S hold G too
  return "G";
}

// ("atom", negated, ((letter, (name, …)), …)), ("sequence", node, …), ("choice", node, …), ("repeat", node, min, max or None).
py::tuple tree_of(const Expression& expression, int index) {
  const SyntaxNode& node = expression.nodes[static_cast<std::size_t>(index)];
  py::list parts;
  if (node.kind == SyntaxNode::Kind::Atom) {
    const Atom& atom = expression.atoms[static_cast<std::size_t>(node.atom)];
    for (const Symbol& symbol : atom.symbols) parts.append(py::make_tuple(letter_of(symbol.kinds), py::tuple(py::cast(symbol.names))));
    return py::make_tuple("atom", atom.negated, py::tuple(parts));
  }
  static constexpr const char* kinds[] = {"atom", "sequence", "choice", "repeat"};
  parts.append(kinds[static_cast<int>(node.kind)]);
  for (const int child : node.children) parts.append(tree_of(expression, child));
  if (node.kind == SyntaxNode::Kind::Repeat) {
    parts.append(node.min);
    parts.append(node.max == SyntaxNode::unbounded ? py::object(py::none()) : py::object(py::int_(node.max)));
  }
  return py::tuple(parts);
}

}  // namespace

PYBIND11_MODULE(sluice_core, m) {
  m.doc() = "Sluice's core: a progressive photon mapper in which light itself can be edited.";
  m.attr("__version__") = SLUICE_VERSION;
  m.attr("instruction_set") = SLUICE_ARCH;

  const py::object value_error = py::reinterpret_borrow<py::object>(PyExc_ValueError);
  const auto error_type = [&](const char* name, const py::object& base) {
    const py::object type = py::reinterpret_steal<py::object>(PyErr_NewException((std::string("sluice_core.") + name).c_str(), base.ptr(), nullptr));
    m.attr(name) = type;
    return type;
  };
  error_types().scene = error_type("SceneError", value_error);
  error_types().expression = error_type("ExpressionError", error_types().scene);
  py::register_local_exception_translator(translate);

  m.def("accepts", [](const std::string& expression, const std::vector<std::string>& events) { return accepts(expression, events); },
        py::arg("expression"), py::arg("events"), "Does the expression accept the word? events in the order of light: [\"L\", \"S'Egg'\", \"D\"].");
  m.def("accepts_many", [](const std::string& expression, const std::vector<std::string>& events, const py::array_t<std::uint8_t, py::array::c_style>& words) {
          if (words.ndim() != 2) throw SceneError("words", "words must have two dimensions: one row per word");
          return accepts_many(expression, events, std::span(words.data(), static_cast<std::size_t>(words.size())), static_cast<std::size_t>(words.shape(1)));
        }, py::arg("expression"), py::arg("events"), py::arg("words"), "Rows of `words` are numbers of `events`, ended early by 255; 0 or 1 per row.");
  m.def("check_expression", &check_expression, py::arg("text"), py::arg("names"), "{'side', 'warnings'} of an edit's expression; ExpressionError if it has none.");

  m.def("check_layer_expression", &check_layer_expression, py::arg("text"), py::arg("names"), "{'warnings'} of a layer's expression; ExpressionError if it has none.");
  m.def("parse", [](const std::string& text) {
          const Expression expression = parse_expression(text);
          return tree_of(expression, expression.root);
        }, py::arg("text"), "The syntax tree as nested tuples: ('atom', negated, ((letter, names), …)), ('sequence', …), ('choice', …), ('repeat', node, min, max or None).");

  m.def("shading_normals", &shading_normals, py::arg("mesh"),
        "One row per corner of a triangle of a mesh's description, as renders take them; none if it is flat.");

  py::class_<Session, std::unique_ptr<Session, DeleteWithoutGil>>(m, "Session", py::module_local(), "One render: start, poll, read pictures.")
      .def(py::init<>())
      .def("start", [](Session& s, const py::dict& description, const py::dict& settings) {
          SceneDescription scene = read_description(description);
          const RenderSettings how = read_settings(settings);
          const py::gil_scoped_release release;
          s.start(std::move(scene), how);
        }, py::arg("description"), py::arg("settings"), "Copies both and returns; the render runs on threads of its own.")
      .def("start_from", [](Session& s, const Session& base, const py::dict& shot, const py::dict& settings) {
          ShotDescription what = read_shot(shot);
          const RenderSettings how = read_settings(settings);
          const py::gil_scoped_release release;
          return s.start_from(base, std::move(what), how);
        }, py::arg("base"), py::arg("shot"), py::arg("settings"),
        "Like start, with the things that another session has compiled; of the description only camera, frame, edits, layers and max_gates. "
        "False: nothing was started, it takes a start.")
      .def("wait", &Session::wait, py::arg("seconds"), py::call_guard<py::gil_scoped_release>(), "True when it is over.")
      .def("cancel", &Session::cancel, py::call_guard<py::gil_scoped_release>())
      .def("progress", &progress_of)
      .def("warnings", [](const Session& s) {
          py::list found;
          for (const Warning& w : s.warnings()) found.append(py::make_tuple(w.item, w.message));
          return found;
        })
      .def("snapshot", &snapshot_of, py::arg("names"))
      .def("statistics", &statistics_of)
      .def("film_hash", [](const Session& s) { return hex(s.film_hash()); }, py::call_guard<py::gil_scoped_release>());
}
