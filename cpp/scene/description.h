// SPDX-License-Identifier: GPL-3.0-or-later
// The scene as plain data: the one schema that the exporter fills and compile() reads. Blender's units and
// conventions: metres, right-handed, Z up, cameras and lights look along local -Z, matrices are local to
// world for row vectors (p * m). "index" members point into the lists of SceneDescription, -1 = none. Nothing
// here is checked; compile() checks all of it.
#pragma once
#include <array>
#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "base/colour.h"
#include "base/image.h"
#include "base/math.h"
#include "edit/description.h"
#include "shading/nodes.h"

namespace sluice {

struct UvMap {
  std::string name;
  std::vector<V2f> corners;  // three per triangle
};

struct ColorAttribute {
  std::string name;
  std::vector<Color> corners;  // linear, three per triangle
};

// The polygons that triangles were cut from; smooth normals are made of them.
struct PolygonDescription {
  std::vector<std::uint32_t> corners;       // vertices, as indices into positions
  std::vector<std::uint32_t> starts;        // per polygon: where its corners begin
  std::vector<std::uint32_t> sizes;         // per polygon: how many they are
  std::vector<std::uint8_t> smooth;         // per polygon: 0 = flat
  std::vector<std::uint32_t> of_triangles;  // per triangle: its polygon
};

struct MeshDescription {
  std::string name;
  std::vector<V3f> positions;                           // object space
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices into positions
  // shading normals, three per triangle; empty: made of polygons, flat if there are none
  std::vector<V3f> normals;
  PolygonDescription polygons;
  std::vector<std::uint16_t> material_slots;  // per triangle; empty = slot 0
  std::vector<UvMap> uv_maps;                 // the first is the active-render one
  std::vector<ColorAttribute> colors;         // the first is the active-render one
  // "generated" = (p - origin) / size, as Blender's texture space maps to [0, 1]
  V3f texture_origin{0}, texture_size{1};
};

// One object as it is seen: several instances may share a mesh.
struct InstanceDescription {
  // names[0]: the object's (an instance: its original's); then its collections'. For expressions
  std::vector<std::string> names;
  int mesh = -1;
  M44d matrix;                 // local to world
  std::vector<int> materials;  // material index per slot
  bool visible_to_camera = true;
  bool casts_shadow = true;
  Color color{1};        // Object Info
  float random = 0;      // Object Info, [0, 1)
  int object_index = 0;  // Object Info
};

// Enums have names, by which they come from the host (base/enum_names.h).
enum class LightKind : std::uint8_t { Point, Spot, Sun, Area };
[[nodiscard]] constexpr const char* name_of(LightKind value) noexcept {
  switch (value) {
    case LightKind::Point: return "Point";
    case LightKind::Spot: return "Spot";
    case LightKind::Sun: return "Sun";
    case LightKind::Area: return "Area";
  }
  return nullptr;
}

// Does it shine along local -Z, so that a matrix without this axis is refused?
[[nodiscard]] constexpr bool has_direction(LightKind value) noexcept {
  switch (value) {
    case LightKind::Point: return false;
    case LightKind::Spot:
    case LightKind::Sun:
    case LightKind::Area: return true;
  }
  return true;
}

enum class AreaShape : std::uint8_t { Square, Rectangle, Disk, Ellipse };
[[nodiscard]] constexpr const char* name_of(AreaShape value) noexcept {
  switch (value) {
    case AreaShape::Square: return "Square";
    case AreaShape::Rectangle: return "Rectangle";
    case AreaShape::Disk: return "Disk";
    case AreaShape::Ellipse: return "Ellipse";
  }
  return nullptr;
}

// Blender's radiometry: `power` is W (sun: W/m²) as the lamp panel shows it. Cycles' conventions decide every
// factor. A member stands here and as a row of for_each_member(), by which it is read from the host and
// checked; the builder of its kind uses it (light_kinds.h).
struct LightDescription {
  std::vector<std::string> names;  // names[0]: the object's; then its collections'
  LightKind kind = LightKind::Point;
  M44d matrix;
  Color color{1};
  float power = 10;
  float radius = 0;  // point, spot: sphere radius (m)
  float angle = 0;   // sun: angular diameter (rad)
  float spot_angle = 0.785f, spot_blend = 0.15f;
  // times the cosine to its axis, as in Blender 3; from 4.2 on they go without
  bool spot_cosine = true;
  AreaShape shape = AreaShape::Square;
  float size_x = 1, size_y = 1;  // area: full widths (m); square and disk use size_x
  float spread = pi;             // area: full angle (rad)
  bool casts_shadow = true;
  bool visible_to_camera = false;  // Blender's lamps are seen in mirrors, never directly
};

// Calls visit(name, member) for each member of a LightDescription, which may be const; its names come first.
template <class Lamp, class Visit>
  requires std::same_as<std::remove_const_t<Lamp>, LightDescription>
void for_each_member(Lamp& lamp, const Visit& visit) {
  // All members by name: one that is missing here does not compile.
  auto& [names, kind, matrix, color, power, radius, angle, spot_angle, spot_blend, spot_cosine, shape, size_x,
         size_y, spread, casts_shadow, visible_to_camera] = lamp;
  visit("names", names);
  visit("kind", kind);
  visit("shape", shape);
  visit("matrix", matrix);
  visit("color", color);
  visit("power", power);
  visit("radius", radius);
  visit("angle", angle);
  visit("spot_angle", spot_angle);
  visit("spot_blend", spot_blend);
  visit("spot_cosine", spot_cosine);
  visit("size_x", size_x);
  visit("size_y", size_y);
  visit("spread", spread);
  visit("casts_shadow", casts_shadow);
  visit("visible_to_camera", visible_to_camera);
}

struct WorldDescription {
  std::string name;       // for expressions (L'World')
  int material = -1;      // a material whose program ends in Background/Emission; -1 = black
  int resolution = 1024;  // width of the importance map
};

enum class CameraKind : std::uint8_t { Perspective, Orthographic };
[[nodiscard]] constexpr const char* name_of(CameraKind value) noexcept {
  switch (value) {
    case CameraKind::Perspective: return "Perspective";
    case CameraKind::Orthographic: return "Orthographic";
  }
  return nullptr;
}

enum class SensorFit : std::uint8_t { Auto, Horizontal, Vertical };
[[nodiscard]] constexpr const char* name_of(SensorFit value) noexcept {
  switch (value) {
    case SensorFit::Auto: return "Auto";
    case SensorFit::Horizontal: return "Horizontal";
    case SensorFit::Vertical: return "Vertical";
  }
  return nullptr;
}

struct CameraDescription {
  std::string name;
  CameraKind kind = CameraKind::Perspective;
  M44d matrix;
  float lens = 50, sensor_width = 36, sensor_height = 24;  // mm
  SensorFit sensor_fit = SensorFit::Auto;
  float ortho_scale = 6;
  float shift_x = 0, shift_y = 0;
  float clip_start = 0.1f, clip_end = 1000;  // m along the view axis
  float aperture_radius = 0;                 // m, 0 = no depth of field
  float focus_distance = 10;
  int aperture_blades = 0;
  float aperture_rotation = 0, aperture_ratio = 1;
};

// The picture: full frame and the part of it that is rendered (pixels, [x0, x1) × [y0, y1), row 0 at the
// bottom).
struct FrameDescription {
  int width = 960, height = 540;
  float pixel_aspect_x = 1, pixel_aspect_y = 1;
  int x0 = 0, y0 = 0, x1 = 960, y1 = 540;
  // pixels; Blackman-Harris of that half width (Blender's Filter Size); a box of one pixel when filter_box
  float filter_width = 1.5f;
  bool filter_box = false;
};

// What may differ between pictures of the same things: the view, and the edits of their light.
struct ShotDescription {
  CameraDescription camera;
  FrameDescription frame;
  std::vector<EditDescription> edits;
  std::vector<LayerDescription> layers;
  int max_gates = 8;
};

struct SceneDescription : ShotDescription {
  std::vector<MeshDescription> meshes;
  std::vector<InstanceDescription> instances;
  std::vector<LightDescription> lights;
  std::vector<MaterialDescription> materials;
  std::vector<Image> images;
  WorldDescription world;
  float specular_threshold = 0.1f;  // Blender roughness up to which a lobe is followed (S)
};

}  // namespace sluice
