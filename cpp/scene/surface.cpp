// SPDX-License-Identifier: GPL-3.0-or-later
// From a hit to what a material may ask about it. Costs only what the material's program reads.
#include "scene/parts.h"

namespace sluice {
namespace {

template <class T>
T blend(const T* corners, const Hit& hit) noexcept {
  return corners[0] * (1 - hit.u - hit.v) + corners[1] * hit.u + corners[2] * hit.v;
}

// Interpolated corner normals, by the inverse transpose of the object's matrix; the geometric normal where
// they cancel out.
V3f smooth_normal(const MeshDescription& mesh, const Instance& instance, const Hit& hit) noexcept {
  const V3f local = blend(&mesh.normals[std::size_t{3} * hit.triangle], hit);
  const Imath::M44f& m = instance.shading.world_to_object;
  const V3f n(m[0][0] * local.x + m[0][1] * local.y + m[0][2] * local.z,
              m[1][0] * local.x + m[1][1] * local.y + m[1][2] * local.z,
              m[2][0] * local.x + m[2][1] * local.y + m[2][2] * local.z);
  const float length = n.length();
  return length > 0 && std::isfinite(length) ? n / length : hit.ng;
}

// Low-poly silhouettes: where wo is below the interpolated surface, the normal is bent until wo just grazes
// it.
V3f seen_from(const V3f& ns, const V3f& ng, const V3f& wo) noexcept {
  constexpr float grazing = 0.01f;
  const float cosine = ns.dot(wo);
  if (cosine >= grazing) return ns.dot(ng) > 0 ? ns : ng;
  const V3f bent = (ns + wo * (grazing - cosine)).normalized();
  return bent.dot(ng) > 0 && bent.dot(wo) > 0 ? bent : ng;
}

// Gradients of the weights u and v over the triangle: moving by dp changes u by grad_u · dp.
struct WeightGradients {
  V3f of_u, of_v;
};
WeightGradients weight_gradients(const std::array<V3d, 3>& p) noexcept {
  const V3d e1 = p[1] - p[0], e2 = p[2] - p[0], n = e1.cross(e2);
  const double squared = n.length2();
  if (!(squared > 0)) return {V3f(0), V3f(0)};
  return {V3f(e2.cross(n) / squared), V3f(n.cross(e1) / squared)};
}

void fill_uvs(const Scene::Parts& parts, const Instance& instance, const MaterialBinding& binding,
              const Hit& hit, SurfacePoint& point) noexcept {
  WeightGradients gradients{V3f(0), V3f(0)};
  if (binding.gradients) gradients = weight_gradients(parts.corners(instance, hit.triangle));
  const MeshDescription& mesh = parts.mesh(instance);
  for (std::size_t i = 0; i < static_cast<std::size_t>(binding.uv_count); ++i) {
    UvPoint& out = point.uv[i];
    out = UvPoint{};
    if (binding.uv[i] < 0) continue;
    const V2f* corners =
        &mesh.uv_maps[static_cast<std::size_t>(binding.uv[i])].corners[std::size_t{3} * hit.triangle];
    out.uv = blend(corners, hit);
    if (!binding.gradients) continue;
    const V2f along_u = corners[1] - corners[0], along_v = corners[2] - corners[0];
    out.grad_u = gradients.of_u * along_u.x + gradients.of_v * along_v.x;
    out.grad_v = gradients.of_u * along_u.y + gradients.of_v * along_v.y;
  }
}

}  // namespace

void surface_point_of(const Scene::Parts& parts, const Hit& hit, const V3f& wo, bool camera_ray,
                      SurfacePoint& point) noexcept {
  const Instance& instance = parts.instances[hit.instance];
  const MeshDescription& mesh = parts.mesh(instance);
  point.position = V3f(hit.position + parts.centre);
  point.wo = wo;
  point.front = hit.ng.dot(wo) >= 0;
  point.ng = point.front ? hit.ng : -hit.ng;
  point.ns = point.ng;
  if (!mesh.normals.empty()) {
    const V3f ns = smooth_normal(mesh, instance, hit);
    point.ns = seen_from(point.front ? ns : -ns, point.ng, wo);
  }
  point.camera_ray = camera_ray;
  point.photon = false;
  const MaterialBinding& binding = parts.binding(instance, hit.triangle);
  point.object = &instance.slot_shading[static_cast<std::size_t>(&binding - instance.slots.data())];
  if (binding.uv_count > 0) fill_uvs(parts, instance, binding, hit, point);
  for (std::size_t i = 0; i < static_cast<std::size_t>(binding.color_count); ++i)
    point.colors[i] = binding.color[i] < 0 ? Color(0)
                                           : blend(&mesh.colors[static_cast<std::size_t>(binding.color[i])]
                                                        .corners[std::size_t{3} * hit.triangle],
                                                   hit);
}

}  // namespace sluice
