// SPDX-License-Identifier: GPL-3.0-or-later
// sluice_core: description in, session handle out, errors as ValueErrors with item and column. The GIL is
// released in every call that may take longer than a millisecond; nothing in the core calls Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstring>

#include "bindings/description.h"
#include "bindings/parts.h"
#include "scene/normals.h"
#include "shading/blackbody.h"

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

void translate(std::exception_ptr pointer) {  // NOLINT(performance-unnecessary-value-param): as pybind11 asks
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const ExpressionError& error) {
    raise(error_types().expression, error.what(), error.item, error.column);
  } catch (const SceneError& error) { raise(error_types().scene, error.what(), error.item, 0); }
}

}  // namespace

PYBIND11_MODULE(sluice_core, m) {
  m.doc() = "Sluice's core: a progressive photon mapper in which light itself can be edited.";
  m.attr("__version__") = SLUICE_VERSION;
  m.attr("instruction_set") = SLUICE_ARCH;

  const py::object value_error = py::reinterpret_borrow<py::object>(PyExc_ValueError);
  const auto error_type = [&](const char* name, const py::object& base) {
    const py::object type = py::reinterpret_steal<py::object>(
        PyErr_NewException((std::string("sluice_core.") + name).c_str(), base.ptr(), nullptr));
    m.attr(name) = type;
    return type;
  };
  error_types().scene = error_type("SceneError", value_error);
  error_types().expression = error_type("ExpressionError", error_types().scene);
  py::register_local_exception_translator(translate);

  define_language(m);
  m.def(
      "shading_normals", &shading_normals, py::arg("mesh"),
      "One row per corner of a triangle of a mesh's description, as renders take them; none if it is flat.");
  m.def(
      "blackbody",
      [](float kelvin) {
        const Color color = blackbody(kelvin);
        return py::make_tuple(color[0], color[1], color[2]);
      },
      py::arg("kelvin"),
      "(r, g, b) of a glowing body, Rec. 709 of luminance 1: what the Blackbody node gives.");

  m.attr("exit_properties") = py::tuple(py::cast(exit_properties()));

  define_session(m);
}
