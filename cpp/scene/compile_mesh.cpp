// SPDX-License-Identifier: GPL-3.0-or-later
// Leaves out triangles that no ray can meet sensibly (vertices that are not finite, no area) and attributes
// that are not numbers.
#include <set>

#include "scene/normals.h"
#include "scene/parts.h"

namespace sluice {
namespace {

enum class Fault : std::uint8_t { None, NotFinite, NoArea };

Fault fault_of(const MeshDescription& mesh, const std::array<std::uint32_t, 3>& triangle) noexcept {
  V3d p[3];
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = V3d(mesh.positions[triangle[i]]);
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(p[i][axis]) < 1e15)) return Fault::NotFinite;
  }
  return (p[1] - p[0]).cross(p[2] - p[0]).length2() > 0 ? Fault::None : Fault::NoArea;
}

template <class T>
void keep_only(std::vector<T>& values, std::size_t per_triangle, const std::vector<Fault>& faults) {
  if (values.empty()) return;
  std::size_t out = 0;
  for (std::size_t triangle = 0; triangle < faults.size(); ++triangle) {
    if (faults[triangle] != Fault::None) continue;
    for (std::size_t i = 0; i < per_triangle; ++i) values[out++] = values[triangle * per_triangle + i];
  }
  values.resize(out);
}

template <class V>
std::size_t replace_non_finite(std::vector<V>& values) {
  std::size_t count = 0;
  for (V& value : values)
    for (unsigned i = 0; i < V::dimensions(); ++i)
      if (!std::isfinite(value[static_cast<int>(i)])) value[static_cast<int>(i)] = 0, ++count;
  return count;
}

void clean(MeshDescription& mesh, const std::string& object, Warnings& warnings, const CancelPoint& cancel) {
  cancel();
  make_normals(mesh, cancel);
  std::vector<Fault> faults(mesh.triangles.size());
  std::size_t not_finite = 0, no_area = 0;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    cancel.at(i);
    faults[i] = fault_of(mesh, mesh.triangles[i]);
    not_finite += faults[i] == Fault::NotFinite, no_area += faults[i] == Fault::NoArea;
  }
  if (not_finite + no_area > 0) {
    keep_only(mesh.triangles, 1, faults);
    keep_only(mesh.normals, 3, faults);
    keep_only(mesh.material_slots, 1, faults);
    for (UvMap& map : mesh.uv_maps) keep_only(map.corners, 3, faults);
    for (ColorAttribute& layer : mesh.colors) keep_only(layer.corners, 3, faults);
    std::string message =
        std::to_string(not_finite + no_area) + " of " + std::to_string(faults.size()) + " triangles left out";
    if (not_finite > 0)
      message.append(", ").append(std::to_string(not_finite)).append(" with vertices that are not finite");
    if (no_area > 0) message.append(", ").append(std::to_string(no_area)).append(" without area");
    warnings.push_back({object, message});
  }
  replace_non_finite(mesh.positions);
  std::size_t replaced = replace_non_finite(mesh.normals);
  for (UvMap& map : mesh.uv_maps) replaced += replace_non_finite(map.corners);
  for (ColorAttribute& layer : mesh.colors) replaced += replace_non_finite(layer.corners);
  if (replaced > 0)
    warnings.push_back({object, std::to_string(replaced) +
                                    " numbers in normals, UV maps or colours are not finite: taken as 0"});
}

}  // namespace

void clean_meshes(SceneDescription& description, Warnings& warnings, const CancelPoint& cancel) {
  std::set<int> done;
  for (const InstanceDescription& instance : description.instances)
    if (instance.mesh >= 0 && done.insert(instance.mesh).second)
      clean(description.meshes[static_cast<std::size_t>(instance.mesh)], first_name(instance.names), warnings,
            cancel);
}

}  // namespace sluice
