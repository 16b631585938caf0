// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/embree.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <mutex>
#include <string>
#include <utility>

#include "base/error.h"

namespace sluice {
namespace {

// Embree's progress callbacks come from its own threads; the host's function is asked by one at a time.
struct CancelMonitor {
  const std::function<bool()>& cancelled;
  std::mutex mutex;
  bool stopped = false;

  bool stop() {
    const std::lock_guard lock(mutex);
    return stopped = stopped || (cancelled && cancelled());
  }
};

bool keep_building(void* monitor, double) { return !static_cast<CancelMonitor*>(monitor)->stop(); }

void check(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE || error == RTC_ERROR_CANCELLED) return;
  throw SceneError("scene", error == RTC_ERROR_OUT_OF_MEMORY
                                ? "not enough memory for the scene's triangles"
                                : "the acceleration structure could not be built (Embree error " +
                                      std::to_string(static_cast<int>(error)) + ")");
}

RTCScene make_scene(RTCDevice device, CancelMonitor& monitor) {
  RTCScene scene = rtcNewScene(device);
  // always: no leaks at any distance from the origin (numerics R2)
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneProgressMonitorFunction(scene, keep_building, &monitor);
  return scene;
}

void attach(RTCDevice device, RTCScene scene, RTCGeometry geometry, unsigned id, unsigned mask) {
  // set on every geometry: Embree 4's default is 0x1, Embree 3's all bits
  rtcSetGeometryMask(geometry, mask);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
  check(device);
}

void attach_triangles(RTCDevice device, RTCScene scene, const AcceleratorItem& item, unsigned id,
                      unsigned mask) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, item.positions.data(), 0,
                             sizeof(V3f), item.positions.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, item.triangles.data(), 0,
                             3 * sizeof(std::uint32_t), item.triangles.size());
  attach(device, scene, geometry, id, mask);
}

// Embree wants columns; Imath's rows are the images of the axes, which is the same order in memory.
void attach_instance(RTCDevice device, RTCScene scene, RTCScene prototype, const AcceleratorItem& item,
                     unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, prototype);
  rtcSetGeometryTimeStepCount(geometry, 1);
  float columns[12];
  for (int axis = 0; axis < 4; ++axis)
    for (int i = 0; i < 3; ++i) columns[3 * axis + i] = static_cast<float>(item.to_scene[axis][i]);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  attach(device, scene, geometry, id, item.mask);
}

// Embree drops rays beyond 1.844e18 and may abort on the rest of these.
bool is_traceable(const RaySegment& segment) noexcept {
  constexpr float limit = 1e18f;
  const auto inside = [](const V3f& v) {
    return std::abs(v.x) < limit && std::abs(v.y) < limit && std::abs(v.z) < limit;
  };
  // NaN fails each comparison
  return inside(segment.origin) && inside(segment.direction) && segment.direction.length2() > 1e-30f &&
         segment.t_max > 0;
}

template <class RayType>
void fill(RayType& ray, const RaySegment& segment, unsigned mask) noexcept {
  const auto& [origin, direction, t_max] = segment;
  ray.org_x = origin.x, ray.org_y = origin.y, ray.org_z = origin.z;
  ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
  ray.tnear = 0, ray.tfar = t_max, ray.time = 0;
  ray.mask = mask, ray.id = 0, ray.flags = 0;
}

}  // namespace

Accelerator::Accelerator(Accelerator&& other) noexcept { *this = std::move(other); }
Accelerator& Accelerator::operator=(Accelerator&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(top_, other.top_);
  std::swap(prototypes_, other.prototypes_);
  return *this;
}
Accelerator::~Accelerator() { release(); }

void Accelerator::release() noexcept {
  if (top_) rtcReleaseScene(top_);
  for (RTCScene scene : prototypes_) rtcReleaseScene(scene);
  if (device_) rtcReleaseDevice(device_);
  top_ = nullptr, device_ = nullptr;
  prototypes_.clear();
}

bool Accelerator::build(std::span<const AcceleratorItem> prototypes, std::span<const AcceleratorItem> items,
                        int threads, const std::function<bool()>& cancelled) {
  release();
  const std::string config = threads > 0 ? "threads=" + std::to_string(threads) : "";
  device_ = rtcNewDevice(config.c_str());
  if (!device_) throw SceneError("scene", "Embree does not start on this machine");
  CancelMonitor monitor{cancelled, {}};
  for (const AcceleratorItem& item : prototypes) {
    prototypes_.push_back(make_scene(device_, monitor));
    attach_triangles(device_, prototypes_.back(), item, 0, ~0u);  // who meets it is the instances' matter
    rtcCommitScene(prototypes_.back());
    check(device_);
    if (monitor.stop()) return false;
  }
  top_ = make_scene(device_, monitor);
  for (unsigned id = 0; id < items.size(); ++id) {
    const AcceleratorItem& item = items[id];
    if (item.prototype < 0)
      attach_triangles(device_, top_, item, id, item.mask);
    else
      attach_instance(device_, top_, prototypes_[static_cast<std::size_t>(item.prototype)], item, id);
  }
  rtcCommitScene(top_);
  check(device_);
  // the monitor lives on this stack: a committed scene must not keep it
  for (RTCScene scene : prototypes_) rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  rtcSetSceneProgressMonitorFunction(top_, nullptr, nullptr);
  return !monitor.stop();
}

std::optional<RawHit> Accelerator::nearest(const RaySegment& segment, unsigned mask) const noexcept {
  if (!is_traceable(segment)) return {};
  RTCRayHit query;
  fill(query.ray, segment, mask);
  query.hit.geomID = query.hit.primID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(top_, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(top_, &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const bool placed = query.hit.instID[0] != RTC_INVALID_GEOMETRY_ID;
  return RawHit{placed ? query.hit.instID[0] : query.hit.geomID, query.hit.primID, query.ray.tfar,
                query.hit.u, query.hit.v};
}

bool Accelerator::blocked(const RaySegment& segment, unsigned mask) const noexcept {
  if (!is_traceable(segment)) return false;
  RTCRay ray;
  fill(ray, segment, mask);
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(top_, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(top_, &context, &ray);
#endif
  return ray.tfar < 0;
}

unsigned Accelerator::blocked(std::span<const RaySegment> segments, unsigned mask) const noexcept {
  static_assert(packet_size == 8);
  RTCRay8 rays;
  alignas(32) int valid[packet_size] = {};  // -1: trace it
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!is_traceable(segments[i])) continue;
    const auto& [origin, direction, t_max] = segments[i];
    valid[i] = -1;
    rays.org_x[i] = origin.x, rays.org_y[i] = origin.y, rays.org_z[i] = origin.z;
    rays.dir_x[i] = direction.x, rays.dir_y[i] = direction.y, rays.dir_z[i] = direction.z;
    rays.tnear[i] = 0, rays.tfar[i] = t_max, rays.time[i] = 0;
    rays.mask[i] = mask, rays.id[i] = 0, rays.flags[i] = 0;
  }
#if RTC_VERSION_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcOccluded8(valid, top_, &rays, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcOccluded8(valid, top_, &context, &rays);
#endif
  unsigned blocked = 0;
  for (std::size_t i = 0; i < segments.size(); ++i)
    blocked |= static_cast<unsigned>(valid[i] != 0 && rays.tfar[i] < 0) << i;
  return blocked;
}

}  // namespace sluice
