// SPDX-License-Identifier: GPL-3.0-or-later
// Sessions for Python: start, poll, read pictures and figures.
#include "render/session.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "bindings/description.h"
#include "bindings/parts.h"
#include "render/report.h"

namespace py = pybind11;

namespace sluice {
namespace {

py::object or_none(double value) {
  return value < 0 ? py::object(py::none()) : py::object(py::float_(value));
}

py::dict progress_of(const Session& session) {
  const Progress p = session.progress();
  static constexpr const char* states[] = {"idle",     "compiling", "rendering",
                                           "finished", "cancelled", "failed"};
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
  seconds["compile"] = s.seconds[0], seconds["guide"] = s.seconds[1], seconds["photons"] = s.seconds[2],
  seconds["view"] = s.seconds[3];
  for (const auto& reason : s.reasons) effects.append(py::make_tuple(reason.effect, reason.runs, reason.why));
  for (std::size_t e = 0; e < c.edits.size() && e < s.edit_names.size(); ++e) {
    py::dict edit;
    edit["name"] = s.edit_names[e], edit["matched"] = c.edits[e].matched, edit["moved"] = c.edits[e].moved,
    edit["capped"] = c.edits[e].capped;
    edit["floats"] = s.edit_floats[e].distance, edit["side"] = s.edit_floats[e].side;
    edit["energy_in"] = c.edits[e].energy_in, edit["energy_out"] = c.edits[e].energy_out;
    edit["acted"] = c.edits[e].has_acted(), edit["share"] = e < s.edit_shares.size() ? s.edit_shares[e] : 0.0,
    edit["seconds"] = c.edits[e].seconds / s.threads;
    if (e < s.arrivals.size()) {
      py::list arrivals;
      for (const auto& kind : s.arrivals[e].kinds)
        arrivals.append(py::make_tuple(kind.expression, kind.share));
      edit["probed"] = s.arrivals[e].probed, edit["crossed"] = s.arrivals[e].crossed,
      edit["arrivals"] = arrivals;
      edit["taken"] = s.arrivals[e].taken, edit["taker"] = s.arrivals[e].taker;
    }
    edits.append(edit);
  }
  for (const LayerShare& l : s.layers) {
    py::dict layer;
    layer["name"] = l.name, layer["expression"] = l.expression, layer["share"] = l.share;
    layers.append(layer);
  }
  for (const UnmetShare& each : s.unmet)
    unmet.append(py::dict(py::arg("name") = each.name, py::arg("share") = each.share));
  dropped["non_finite"] = c.non_finite, dropped["adjoint_clamped"] = c.adjoint_clamped,
  dropped["depth_capped"] = c.depth_capped;
  dropped["gates_capped"] = c.gates_capped, dropped["split_capped"] = c.split_capped,
  dropped["grazing_dropped"] = c.grazing_dropped;
  dropped["alpha_capped"] = c.alpha_capped, dropped["states_capped"] = c.states_capped;
  ledger["emitted"] = c.ledger.emitted, ledger["added"] = c.ledger.added,
  ledger["sampling"] = c.ledger.sampling;
  ledger["absorbed"] = c.ledger.absorbed, ledger["escaped"] = c.ledger.escaped,
  ledger["removed"] = c.ledger.removed;
  ledger["capped"] = c.ledger.capped, ledger["clamped"] = c.ledger.clamped,
  ledger["worst_residual"] = s.worst_ledger_residual;
  d["report"] = describe(s), d["seconds"] = seconds, d["effects"] = effects, d["edits"] = edits,
  d["layers"] = layers, d["dropped"] = dropped, d["ledger"] = ledger;
  d["rays"] = c.rays + c.shadow_rays, d["photon_paths"] = c.photon_paths,
  d["photons_stored"] = c.photons_stored;
  d["view_paths"] = c.view_paths, d["gathers"] = c.gathers, d["photons_gathered"] = c.photons_gathered,
  d["edit_queries"] = c.edit_queries;
  d["bytes_per_photon"] = s.bytes_per_photon, d["triangles"] = s.triangles, d["threads"] = s.threads,
  d["guide_hash"] = hex(s.guide_hash);
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
    pictures[names[i].c_str()] =
        py::array_t<float>({found[i].height, found[i].width, found[i].channels}, pixels->data(), owner);
  }
  return pictures;
}

}  // namespace

void define_session(py::module_& m) {
  py::class_<Session, std::unique_ptr<Session, DeleteWithoutGil>>(m, "Session", py::module_local(),
                                                                  "One render: start, poll, read pictures.")
      .def(py::init<>())
      .def(
          "start",
          [](Session& s, const py::dict& description, const py::dict& settings) {
            SceneDescription scene = read_description(description);
            const RenderSettings how = read_settings(settings);
            const py::gil_scoped_release release;
            s.start(std::move(scene), how);
          },
          py::arg("description"), py::arg("settings"),
          "Copies both and returns; the render runs on threads of its own.")
      .def(
          "start_from",
          [](Session& s, const Session& base, const py::dict& shot, const py::dict& settings) {
            ShotDescription what = read_shot(shot);
            const RenderSettings how = read_settings(settings);
            const py::gil_scoped_release release;
            return s.start_from(base, std::move(what), how);
          },
          py::arg("base"), py::arg("shot"), py::arg("settings"),
          "Like start, with the things that another session has compiled; of the description only camera, "
          "frame, edits, layers and max_gates. "
          "False: nothing was started, it takes a start.")
      .def("wait", &Session::wait, py::arg("seconds"), py::call_guard<py::gil_scoped_release>(),
           "True when it is over.")
      .def("cancel", &Session::cancel, py::call_guard<py::gil_scoped_release>())
      .def("progress", &progress_of)
      .def("warnings",
           [](const Session& s) {
             py::list found;
             for (const Warning& w : s.warnings()) found.append(py::make_tuple(w.item, w.message));
             return found;
           })
      .def("snapshot", &snapshot_of, py::arg("names"))
      .def("statistics", &statistics_of)
      .def(
          "film_hash", [](const Session& s) { return hex(s.film_hash()); },
          py::call_guard<py::gil_scoped_release>());
}

}  // namespace sluice
