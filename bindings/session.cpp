// SPDX-License-Identifier: GPL-3.0-or-later
// Sessions for Python: start, poll, read pictures and figures.
#include "render/session.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>

#include "bindings/description.h"
#include "bindings/parts.h"
#include "render/report.h"

namespace py = pybind11;

namespace sluice {
namespace {

py::object or_none(double value) {
  return value < 0 ? py::object(py::none()) : py::object(py::float_(value));
}

// None where there is no estimate yet.
void add_errors(py::dict& d, const char* error, const Accuracy& now) {
  d[error] = or_none(now.error()), d["noise"] = or_none(now.noise);
  d["bias"] = or_none(now.is_known() ? now.bias : -1);
}

py::dict progress_of(const Session& session) {
  const Progress p = session.progress();
  py::dict d;
  d["state"] = name_of(p.state), d["stop_reason"] = name_of(p.stop_reason);
  d["pass"] = p.pass, d["passes"] = p.passes, d["photons"] = p.photons, d["seconds"] = p.seconds;
  d["seconds_left"] = or_none(p.seconds_left);
  add_errors(d, "error_estimate", p.accuracy);
  d["main_cause"] = p.main_cause ? py::object(py::make_tuple(p.main_cause->name, p.main_cause->share))
                                 : py::object(py::none());
  d["passes_to_target"] = or_none(p.passes_to_target);
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

py::dict edit_of(const RenderStatistics& s, std::size_t e) {
  const EditCounts& counts = s.counts.edits[e];
  py::dict d;
  d["name"] = s.edit_names[e];
  d["matched"] = counts.matched, d["moved"] = counts.moved, d["capped"] = counts.capped;
  d["floats"] = s.edit_floats[e].distance, d["side"] = s.edit_floats[e].side;
  d["energy_in"] = counts.energy_in, d["energy_out"] = counts.energy_out;
  d["acted"] = counts.has_acted(), d["share"] = e < s.shares.edits.size() ? s.shares.edits[e] : 0.0;
  d["seconds"] = counts.seconds / s.threads;
  if (e < s.arrivals.size()) {
    const Arrivals& found = s.arrivals[e];
    py::list arrivals;
    for (const auto& kind : found.kinds) arrivals.append(py::make_tuple(kind.expression, kind.share));
    d["probed"] = found.probed, d["crossed"] = found.crossed, d["arrivals"] = arrivals;
    d["taken"] = found.taken, d["taker"] = found.taker;
  }
  return d;
}

// Errors are relative; of parts and edits so that their squares add up about to the picture's.
py::dict accuracy_of(const Accuracy& now, const std::vector<std::string>& edit_names) {
  py::dict d;
  d["pass"] = now.pass, d["seconds"] = now.seconds, d["rays"] = now.rays, d["photons"] = now.photons;
  add_errors(d, "error", now);
  py::list parts, edits;
  for (int i = 0; now.is_known() && i < part_count; ++i) {
    const ErrorSquares& part = now.shares.parts[static_cast<std::size_t>(i)];
    parts.append(py::dict(py::arg("name") = name_of(static_cast<Part>(i)),
                          py::arg("noise") = std::sqrt(part.noise), py::arg("bias") = std::sqrt(part.bias)));
  }
  for (std::size_t e = 0; e < now.shares.edits.size() && e < edit_names.size(); ++e)
    edits.append(py::dict(py::arg("name") = edit_names[e],
                          py::arg("noise") = std::sqrt(now.shares.edits[e].noise),
                          py::arg("bias") = std::sqrt(now.shares.edits[e].bias)));
  d["parts"] = parts, d["edits"] = edits;
  return d;
}

// [{"pass", …, "image": float32 (height, width, 4)}]
py::list kept_of(const Session& session) {
  py::list found;
  const std::vector<std::string> names = session.statistics().edit_names;
  for (const Session::Kept& kept : session.kept()) {
    py::dict d = accuracy_of(kept.accuracy, names);
    const Session::Picture& p = kept.picture;
    d["image"] = py::array_t<float>({p.height, p.width, p.channels}, p.pixels.data());
    found.append(d);
  }
  return found;
}

// Those of work at the top, as "rays" both kinds together.
void add_counts(py::dict& d, const Counts& counts) {
  py::dict dropped, ledger;
  for (const WorkCounter& counter : work_counters) d[counter.name] = counts.*counter.value;
  d["rays"] = counts.rays + counts.shadow_rays;
  for (const DropCounter& counter : drop_counters) dropped[counter.name] = counts.*counter.value;
  for (const LedgerTerm& term : ledger_terms) ledger[term.name] = counts.ledger.*term.value;
  d["dropped"] = dropped, d["ledger"] = ledger;
}

py::dict statistics_of(const Session& session) {
  const RenderStatistics s = session.statistics();
  py::dict d, seconds;
  py::list effects, edits, layers, unmet, accuracy;
  add_counts(d, s.counts);
  d["ledger"]["worst_residual"] = s.worst_ledger_residual;
  for (int i = 0; i < phase_count; ++i)
    seconds[name_of(static_cast<Phase>(i))] = s.seconds[static_cast<std::size_t>(i)];
  for (const auto& reason : s.reasons) effects.append(py::make_tuple(reason.effect, reason.runs, reason.why));
  for (std::size_t e = 0; e < s.counts.edits.size() && e < s.edit_names.size(); ++e)
    edits.append(edit_of(s, e));
  for (const LayerShare& l : s.shares.layers)
    layers.append(
        py::dict(py::arg("name") = l.name, py::arg("expression") = l.expression, py::arg("share") = l.share));
  for (const UnmetShare& each : s.unmet)
    unmet.append(py::dict(py::arg("name") = each.name, py::arg("share") = each.share));
  d["report"] = describe(s), d["seconds"] = seconds, d["effects"] = effects, d["edits"] = edits;
  for (const Accuracy& each : s.accuracy) accuracy.append(accuracy_of(each, s.edit_names));
  d["layers"] = layers, d["unmet"] = unmet, d["accuracy"] = accuracy;
  d["bytes_per_photon"] = s.bytes_per_photon, d["triangles"] = s.triangles, d["threads"] = s.threads;
  d["guide_hash"] = hex(s.guide_hash), d["radius"] = s.radius;
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
  py::list passes;
  for (const Film::PassName& pass : Film::fixed_passes())
    passes.append(py::make_tuple(pass.name, pass.channels));
  m.attr("passes") = py::tuple(passes);  // ((name, channels), …) of every picture, whatever its layers
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
          "Like start, with the meshes, materials and lights that another session has compiled; of the "
          "description only the shot: camera, frame, edits, layers and max_gates. "
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
          "sample_counts",
          [](const Session& s) -> py::object {
            const std::optional<Session::Picture> p = s.sample_counts();
            if (!p) return py::none();
            return py::array_t<float>({p->height, p->width, p->channels}, p->pixels.data());
          },
          "What each pixel takes in a pass: view samples, those of emission alone, lights asked, gather "
          "segments; None before that is known.")
      .def("kept", &kept_of, "The pictures that the setting keep_at asks for, each with its accuracy.")
      .def(
          "film_hash", [](const Session& s) { return hex(s.film_hash()); },
          py::call_guard<py::gil_scoped_release>());
}

}  // namespace sluice
