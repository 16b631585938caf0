// SPDX-License-Identifier: GPL-3.0-or-later
// What makes no sense in a description: nothing in it is trusted. Messages say what was found and what was
// expected.
#include <algorithm>

#include "scene/normals.h"
#include "scene/parts.h"

namespace sluice {
namespace {

void expect(bool condition, const std::string& item, const std::string& message) {
  if (!condition) throw SceneError(item, message);
}

void expect_size(std::size_t size, std::size_t expected, const std::string& item, const std::string& what) {
  expect(size == expected, item,
         what + ": " + std::to_string(size) + " values, expected " + std::to_string(expected));
}

void expect_index(int index, std::size_t size, const std::string& item, const std::string& what) {
  expect(index >= -1 && (index < 0 || static_cast<std::size_t>(index) < size), item,
         what + ": index " + std::to_string(index) + " into a list of " + std::to_string(size));
}

void check_polygons(const MeshDescription& mesh) {
  const PolygonDescription& polygons = mesh.polygons;
  const std::size_t count = polygons.starts.size();
  if (count == 0) return;
  expect_size(polygons.sizes.size(), count, mesh.name, "sizes of polygons");
  expect_size(polygons.smooth.size(), count, mesh.name, "smooth flags of polygons");
  expect_size(polygons.of_triangles.size(), mesh.triangles.size(), mesh.name, "polygons of triangles");
  const auto beyond = [](const std::vector<std::uint32_t>& indices, std::size_t size) {
    return std::any_of(indices.begin(), indices.end(), [&](std::uint32_t index) { return index >= size; });
  };
  expect(!beyond(polygons.corners, mesh.positions.size()), mesh.name,
         "a polygon names a vertex beyond the " + std::to_string(mesh.positions.size()) + " there are");
  expect(!beyond(polygons.of_triangles, count), mesh.name,
         "a triangle names a polygon beyond the " + std::to_string(count) + " there are");
  bool fits = true;
  for (std::size_t i = 0; i < count; ++i)
    fits = fits && std::size_t{polygons.starts[i]} + polygons.sizes[i] <= polygons.corners.size();
  expect(fits, mesh.name,
         "a polygon reaches beyond the " + std::to_string(polygons.corners.size()) + " corners there are");
}

void check_frame(const FrameDescription& frame) {
  const std::string item = "frame";
  constexpr int max_side = 65536;
  expect(frame.width >= 1 && frame.width <= max_side && frame.height >= 1 && frame.height <= max_side, item,
         "size " + std::to_string(frame.width) + " x " + std::to_string(frame.height) +
             ", expected 1 to 65536 pixels a side");
  expect(0 <= frame.x0 && frame.x0 < frame.x1 && frame.x1 <= frame.width && 0 <= frame.y0 &&
             frame.y0 < frame.y1 && frame.y1 <= frame.height,
         item, "the border is empty or reaches beyond the frame");
  const auto usable = [](float x) { return std::isfinite(x) && x > 0; };
  expect(usable(frame.pixel_aspect_x) && usable(frame.pixel_aspect_y), item,
         "the pixel aspect must be above 0");
  expect(frame.filter_box || (usable(frame.filter_width) && frame.filter_width <= 100), item,
         "the filter width must be above 0 and at most 100 pixels");
}

void check_camera(const CameraDescription& camera) {
  const std::string item = camera.name.empty() ? "camera" : camera.name;
  expect(is_finite(camera.matrix), item, "the camera's matrix is not finite");
  for (int row = 0; row < 3; ++row)
    expect(V3d(camera.matrix[row][0], camera.matrix[row][1], camera.matrix[row][2]).length() > 0, item,
           "the camera's scale is 0");
  const auto usable = [](float x) { return std::isfinite(x) && x > 0; };
  if (camera.kind == CameraKind::Perspective)
    expect(usable(camera.lens) && usable(camera.sensor_width) && usable(camera.sensor_height), item,
           "focal length and sensor must be above 0");
  else
    expect(usable(camera.ortho_scale), item, "the orthographic scale must be above 0");
  expect(std::isfinite(camera.shift_x) && std::isfinite(camera.shift_y), item, "the shift is not finite");
  expect(std::isfinite(camera.clip_start) &&
             (camera.clip_start >= 0 || camera.kind == CameraKind::Orthographic) &&
             camera.clip_end > camera.clip_start,
         item, "the clip range is empty or negative");
  expect(std::isfinite(camera.aperture_radius) && camera.aperture_radius >= 0, item,
         "the aperture must not be negative");
  expect(camera.aperture_radius == 0 || usable(camera.focus_distance), item,
         "the focus distance must be above 0");
  expect(std::isfinite(camera.aperture_rotation) && std::isfinite(camera.aperture_ratio), item,
         "the aperture's shape is not finite");
}

}  // namespace

void check_mesh(const MeshDescription& mesh) {
  constexpr std::size_t max_count = 0xfffffff0u / 3;  // triangles and vertices are 32-bit numbers
  const std::size_t triangles = mesh.triangles.size(), corners = 3 * triangles;
  expect(triangles < max_count && mesh.positions.size() < max_count, mesh.name,
         "more than 1.4 billion triangles or vertices");
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t index : triangle)
      if (index >= mesh.positions.size())  // the words are made only if they are needed: triangles are many
        throw SceneError(mesh.name, "a triangle names vertex " + std::to_string(index) + " of " +
                                        std::to_string(mesh.positions.size()));
  if (!mesh.normals.empty()) expect_size(mesh.normals.size(), corners, mesh.name, "normals");
  check_polygons(mesh);
  if (!mesh.material_slots.empty())
    expect_size(mesh.material_slots.size(), triangles, mesh.name, "material slots");
  for (const UvMap& map : mesh.uv_maps)
    expect_size(map.corners.size(), corners, mesh.name, "UV map \"" + map.name + "\"");
  for (const ColorAttribute& layer : mesh.colors)
    expect_size(layer.corners.size(), corners, mesh.name, "colour attribute \"" + layer.name + "\"");
}

bool is_finite(const M44d& matrix) noexcept {
  for (int row = 0; row < 4; ++row)
    for (int i = 0; i < 4; ++i)
      if (!(std::abs(matrix[row][i]) < 1e18)) return false;  // beyond that rays meet nothing
  return true;
}

void check_description(const SceneDescription& description) {
  for (const MeshDescription& mesh : description.meshes) check_mesh(mesh);
  for (const InstanceDescription& instance : description.instances) {
    const std::string& name = first_name(instance.names);
    expect_index(instance.mesh, description.meshes.size(), name, "mesh");
    for (const int material : instance.materials)
      expect_index(material, description.materials.size(), name, "material");
  }
  for (const Image& image : description.images) {
    expect(image.width >= 0 && image.height >= 0, image.name, "an image's size is negative");
    if (!image.empty())
      expect_size(
          image.rgba.size(),
          std::size_t{4} * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
          image.name, "pixels");
  }
  expect_index(description.world.material, description.materials.size(), "world", "material");
  check_shot(description, description.images.size());
  expect(!std::isnan(description.specular_threshold), "settings", "the specular threshold is not a number");
}

void check_shot(const ShotDescription& shot, std::size_t images) {
  for (const EditDescription& edit : shot.edits)
    for (const ExitDescription& exit : edit.exits)
      for (const int image : {exit.intensity_texture, exit.hue_shift_texture, exit.normal_map})
        expect_index(image, images, exit.quad.name, "texture");
  check_frame(shot.frame);
  check_camera(shot.camera);
  expect(shot.max_gates >= 0, "settings", "max_gates is negative");
}

}  // namespace sluice
