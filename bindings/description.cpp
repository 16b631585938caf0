// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/description.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstring>
#include <optional>
#include <type_traits>

#include "base/enum_names.h"
#include "base/error.h"

namespace sluice {
namespace {

namespace py = pybind11;

// Arrays reach vectors of Imath's types by one copy of their bytes.
static_assert(sizeof(V2f) == 8 && sizeof(V3f) == 12 && sizeof(std::array<std::uint32_t, 3>) == 12);

[[noreturn]] void refuse(const std::string& item, const char* key, const std::string& what) {
  throw SceneError(item, std::string("'") + key + "' of the description " + what);
}

// A dict on its way into a struct; `item` is named in errors.
class Reader {
 public:
  Reader(py::handle source, std::string item) : item_(std::move(item)) {
    if (!py::isinstance<py::dict>(source))
      throw SceneError(item_,
                       "a description must be a dict, not " + std::string(py::str(py::type::of(source))));
    source_ = py::reinterpret_borrow<py::dict>(source);
  }
  void rename(std::string item) { item_ = std::move(item); }
  [[nodiscard]] bool has(const char* key) const { return source_.contains(key); }

  template <class T>
  void value(const char* key, T& to) const {
    if (!has(key)) return;
    try {
      to = source_[key].cast<T>();
    } catch (const py::cast_error&) { refuse(item_, key, "has a value of the wrong type or range"); }
  }
  // Three numbers: a sequence or an array.
  void vector(const char* key, V3f& to) const {
    if (!has(key)) return;
    try {
      const auto c = py::cast<std::array<float, 3>>(py::tuple(source_[key]));
      to = {c[0], c[1], c[2]};
    } catch (const std::exception&) { refuse(item_, key, "must be three numbers"); }
  }
  // Column-vector convention outside, row vectors inside.
  void matrix(const char* key, M44d& to) const {
    if (!has(key)) return;
    const auto a = checked<double>(key, 2);
    if (a.shape(0) != 4 || a.shape(1) != 4) refuse(item_, key, "must be a 4 × 4 matrix");
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) to[j][i] = a.at(i, j);
  }
  // An array with a row per T; Scalar is what NumPy holds.
  template <class Scalar, class T>
  void rows(const char* key, std::vector<T>& to) const {
    if (!has(key)) return;
    constexpr py::ssize_t columns = sizeof(T) / sizeof(Scalar);
    const auto a = checked<Scalar>(key, 0);
    if (columns > 1 && !(a.ndim() == 2 && a.shape(1) == columns))
      refuse(item_, key, "must have " + std::to_string(columns) + " columns");
    to.resize(static_cast<std::size_t>(a.size() / columns));
    if (!to.empty())
      std::memcpy(static_cast<void*>(to.data()), a.data(),
                  static_cast<std::size_t>(a.size()) * sizeof(Scalar));
  }
  template <class Enum>
  void choice(const char* key, Enum& to) const {
    if (!has(key)) return;
    std::string text;
    value(key, text);
    const std::optional<Enum> named = value_named<Enum>(text);
    if (!named) refuse(item_, key, "cannot be '" + text + "'");
    to = *named;
  }
  // A row of a table such as for_each_property(): its type says how it is read.
  template <class T>
  void member(const char* key, T& to) const {
    if constexpr (std::is_same_v<T, Color>)
      vector(key, to);
    else if constexpr (std::is_same_v<T, M44d>)
      matrix(key, to);
    else if constexpr (std::is_enum_v<T>)
      choice(key, to);
    else
      value(key, to);
  }
  template <class T, class Read>
  void list(const char* key, std::vector<T>& to, Read&& read) const {
    if (!has(key)) return;
    if (!py::isinstance<py::sequence>(source_[key])) refuse(item_, key, "must be a list");
    for (const py::handle& element : py::reinterpret_borrow<py::sequence>(source_[key])) {
      Reader reader(element, item_);
      to.push_back(read(reader));
    }
  }
  template <class Read>
  void part(const char* key, Read&& read) const {
    if (!has(key)) return;
    Reader reader(source_[key], item_);
    read(reader);
  }

 private:
  template <class Scalar>
  [[nodiscard]] py::array_t<Scalar, py::array::c_style> checked(const char* key,
                                                                py::ssize_t dimensions) const {
    using Array = py::array_t<Scalar, py::array::c_style>;
    const py::object object = source_[key];
    if (!py::isinstance<Array>(object))
      refuse(item_, key, "must be a C-contiguous array of " + std::string(py::str(py::dtype::of<Scalar>())));
    auto a = py::reinterpret_borrow<Array>(object);
    if (dimensions > 0 && a.ndim() != dimensions) refuse(item_, key, "has the wrong number of dimensions");
    return a;
  }

  py::dict source_;
  std::string item_;
};

std::string first_of(const std::vector<std::string>& names) {
  return names.empty() ? std::string() : names.front();
}

MeshDescription read_mesh(Reader& r) {
  MeshDescription m;
  r.value("name", m.name);
  r.rename(m.name);
  r.rows<float>("positions", m.positions);
  r.rows<std::uint32_t>("triangles", m.triangles);
  r.rows<float>("normals", m.normals);
  r.part("polygons", [&](Reader& p) {
    p.rows<std::uint32_t>("corners", m.polygons.corners);
    p.rows<std::uint32_t>("starts", m.polygons.starts);
    p.rows<std::uint32_t>("sizes", m.polygons.sizes);
    p.rows<std::uint8_t>("smooth", m.polygons.smooth);
    p.rows<std::uint32_t>("of_triangles", m.polygons.of_triangles);
  });
  r.rows<std::uint16_t>("material_slots", m.material_slots);
  r.list("uv_maps", m.uv_maps, [](Reader& layer) {
    UvMap map;
    layer.value("name", map.name);
    layer.rows<float>("corners", map.corners);
    return map;
  });
  r.list("colors", m.colors, [](Reader& layer) {
    ColorAttribute attribute;
    layer.value("name", attribute.name);
    layer.rows<float>("corners", attribute.corners);
    return attribute;
  });
  r.vector("texture_origin", m.texture_origin);
  r.vector("texture_size", m.texture_size);
  return m;
}

InstanceDescription read_instance(Reader& r) {
  InstanceDescription i;
  r.value("names", i.names);
  r.rename(first_of(i.names));
  r.value("mesh", i.mesh);
  r.matrix("matrix", i.matrix);
  r.value("materials", i.materials);
  r.value("visible_to_camera", i.visible_to_camera);
  r.value("casts_shadow", i.casts_shadow);
  r.vector("color", i.color);
  r.value("random", i.random);
  r.value("object_index", i.object_index);
  return i;
}

LightDescription read_light(Reader& r) {
  LightDescription l;
  for_each_member(l, [&](const char* key, auto& member) {
    r.member(key, member);
    r.rename(first_of(l.names));  // which were read first
  });
  return l;
}

NodeDescription read_node(Reader& r) {
  NodeDescription n;
  r.value("kind", n.kind);
  r.value("name", n.name);
  r.value("options", n.options);
  r.value("image", n.image);
  r.rows<float>("table", n.table);
  r.list("inputs", n.inputs, [](Reader& i) {
    InputDescription input;
    i.value("name", input.name);
    i.value("value", input.value);
    i.value("node", input.node);
    i.value("output", input.output);
    return input;
  });
  return n;
}

MaterialDescription read_material(Reader& r) {
  MaterialDescription m;
  r.value("name", m.name);
  r.rename(m.name);
  r.list("nodes", m.nodes, read_node);
  r.value("surface", m.surface);
  r.value("surface_output", m.surface_output);
  return m;
}

Image read_image(Reader& r) {
  Image image;
  ColorSpace space = ColorSpace::SRGB;
  r.value("name", image.name);
  r.rename(image.name);
  r.value("width", image.width);
  r.value("height", image.height);
  r.choice("color_space", space);
  std::vector<float> rgba;
  r.rows<float>("rgba", rgba);
  if (rgba.empty()) return image;
  try {
    return make_image(image.name, image.width, image.height, std::move(rgba), space);
  } catch (const SceneError&) {
    return image;  // no pixels: compile() warns and draws the placeholder
  }
}

QuadDescription read_quad(Reader& r) {
  QuadDescription q;
  r.value("name", q.name);
  r.rename(q.name);
  r.matrix("matrix", q.matrix);
  r.value("half_size", q.half_size);
  r.value("offset", q.offset);
  r.value("order", q.order);
  return q;
}

EditDescription read_edit(Reader& r) {
  EditDescription e;
  r.part("entry", [&](Reader& quad) { e.entry = read_quad(quad); });
  r.rename(e.entry.name);
  r.value("collections", e.collections);
  r.value("expression", e.expression);
  r.value("enabled", e.enabled);
  r.value("repeat", e.repeat);
  r.value("amount", e.amount);
  r.value("feather", e.feather);
  r.list("exits", e.exits, [](Reader& x) {
    ExitDescription exit;
    x.part("quad", [&](Reader& quad) { exit.quad = read_quad(quad); });
    x.rename(exit.quad.name);
    for_each_property(exit, [&](const char* key, auto& member, const auto&) { x.member(key, member); });
    return exit;
  });
  return e;
}

void read_camera(Reader& r, CameraDescription& c) {
  r.value("name", c.name);
  r.rename(c.name);
  r.choice("kind", c.kind);
  r.matrix("matrix", c.matrix);
  r.value("lens", c.lens);
  r.value("sensor_width", c.sensor_width);
  r.value("sensor_height", c.sensor_height);
  r.choice("sensor_fit", c.sensor_fit);
  r.value("ortho_scale", c.ortho_scale);
  r.value("shift_x", c.shift_x);
  r.value("shift_y", c.shift_y);
  r.value("clip_start", c.clip_start);
  r.value("clip_end", c.clip_end);
  r.value("aperture_radius", c.aperture_radius);
  r.value("focus_distance", c.focus_distance);
  r.value("aperture_blades", c.aperture_blades);
  r.value("aperture_rotation", c.aperture_rotation);
  r.value("aperture_ratio", c.aperture_ratio);
}

void read_frame(Reader& r, FrameDescription& f) {
  r.value("width", f.width);
  r.value("height", f.height);
  f.x1 = f.width, f.y1 = f.height;
  r.value("x0", f.x0);
  r.value("y0", f.y0);
  r.value("x1", f.x1);
  r.value("y1", f.y1);
  r.value("pixel_aspect_x", f.pixel_aspect_x);
  r.value("pixel_aspect_y", f.pixel_aspect_y);
  r.value("filter_width", f.filter_width);
  r.value("filter_box", f.filter_box);
}

void read_shot_into(Reader& r, ShotDescription& s) {
  r.list("edits", s.edits, read_edit);
  r.list("layers", s.layers, [](Reader& layer) {
    LayerDescription l;
    layer.value("name", l.name);
    layer.rename("layer '" + l.name + "'");
    layer.value("expression", l.expression);
    return l;
  });
  r.part("camera", [&](Reader& camera) { read_camera(camera, s.camera); });
  r.part("frame", [&](Reader& frame) { read_frame(frame, s.frame); });
  r.value("max_gates", s.max_gates);
}

}  // namespace

std::vector<std::string> exit_properties() {
  std::vector<std::string> names;
  ExitProperties any;
  for_each_property(any, [&](const char* name, const auto&, const auto&) { names.push_back(name); });
  return names;
}

SceneDescription read_description(const py::dict& scene) {
  SceneDescription s;
  Reader r(scene, "scene");
  r.list("meshes", s.meshes, read_mesh);
  r.list("instances", s.instances, read_instance);
  r.list("lights", s.lights, read_light);
  r.list("materials", s.materials, read_material);
  r.list("images", s.images, read_image);
  r.part("world", [&](Reader& world) {
    world.value("name", s.world.name);
    world.value("material", s.world.material);
    world.value("resolution", s.world.resolution);
  });
  r.value("specular_threshold", s.specular_threshold);
  read_shot_into(r, s);
  return s;
}

ShotDescription read_shot(const py::dict& shot) {
  ShotDescription s;
  Reader r(shot, "scene");
  read_shot_into(r, s);
  return s;
}

RenderSettings read_settings(const py::dict& settings) {
  RenderSettings s;
  Reader r(settings, "settings");
  TransportSettings& t = s.transport;
  std::int64_t seed = 0;
  double error_percent = 0;
  r.value("passes", s.passes);
  if (r.has("render_passes")) r.value("render_passes", s.render_passes.emplace());
  r.value("photons", t.photons);
  r.value("seed", seed);
  r.value("use_animated_seed", s.use_animated_seed);
  r.value("max_depth", t.max_depth);
  r.value("pilot_paths", t.pilot_paths);
  r.value("state_memory", t.state_memory);
  r.value("time_limit", s.time_limit);
  r.value("error_target", error_percent);
  r.value("use_direct", t.use_direct);
  r.value("use_caustics", t.use_caustics);
  r.value("use_edited", t.use_edited);
  r.value("use_indirect", t.use_indirect);
  r.value("use_edits", s.use_edits);
  r.value("explain_edits", s.explain_edits);
  r.value("film_transparent", t.transparent_film);
  r.value("caustic_radius_factor", t.caustic_radius_factor);
  r.value("caustic_radius_range", t.caustic_radius_range);
  r.value("soft_range", t.soft_range);
  r.value("use_adaptive_sampling", t.use_adaptive_sampling);
  r.value("use_guide", t.use_guide);
  r.value("threads", s.threads);
  r.value("frame", s.frame);
  r.value("keep_at", s.keep_at);
  t.seed = static_cast<std::uint64_t>(seed);
  s.error_target = error_percent / 100;
  return s;
}

}  // namespace sluice
