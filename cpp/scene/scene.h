// SPDX-License-Identifier: GPL-3.0-or-later
// The compiled scene: immutable, thread-safe, all indices checked. Answers what a ray meets, what the surface
// there is like, and which lights, edits and camera there are. All positions are re-centred: world = position
// + centre(). Knows nothing of paths or photons.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/error.h"
#include "base/event.h"
#include "scene/camera.h"
#include "scene/description.h"
#include "scene/light.h"
#include "scene/ray.h"

namespace sluice {

enum class Side : std::uint8_t;
class Edits;
class GatesInView;
class Material;
struct Entity;
struct SurfacePoint;

struct Bounds {
  V3d low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};

  [[nodiscard]] bool empty() const noexcept { return !(low.x <= high.x); }
  [[nodiscard]] V3d middle() const noexcept { return empty() ? V3d(0) : (low + high) * 0.5; }
  [[nodiscard]] double diagonal() const noexcept { return empty() ? 0 : (high - low).length(); }
  void add(const V3d& p) noexcept;
};

// The most transparent surfaces on one straight segment, of light and of shadows alike: a bound on what it
// may cost.
inline constexpr int max_alpha_layers = 256;

class Scene {
 public:
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  // Nearest surface in front of the ray, transparent ones too. Rays that are not finite, or shorter than
  // nothing, meet nothing.
  [[nodiscard]] std::optional<Hit> intersect(const Ray& ray) const noexcept;
  // What is left of light along the segment [0, t_max]: the product of the transparencies of the
  // shadow-casting surfaces on it, black if one is opaque. Lamps block nothing. Empty: more transparent
  // surfaces than are followed.
  [[nodiscard]] std::optional<Color> transmittance(const Ray& ray) const noexcept;
  // clear[i]: no surface at all on the segment [0, t_max] of rays[i], opaque or not: what intersect() would
  // not meet either. Fast if the rays run side by side.
  void find_clear(std::span<const Ray> rays, std::span<bool> clear) const noexcept;

  [[nodiscard]] const Material& material(const Hit& hit) const noexcept;
  // What shade() needs to know at a hit seen from `wo` (unit, away from the surface). Photons set
  // point.photon themselves.
  void surface_point(const Hit& hit, const V3f& wo, bool camera_ray, SurfacePoint& point) const noexcept;

  [[nodiscard]] std::span<const Light> lights() const noexcept;
  // the light that this instance is, -1 = it does not emit
  [[nodiscard]] int mesh_light(std::uint32_t instance) const noexcept;
  [[nodiscard]] int world_light() const noexcept;  // -1 = black world
  // the world and the suns: what a ray that meets nothing sees
  [[nodiscard]] std::span<const int> infinite_lights() const noexcept;

  // The things that expressions can name: objects, lights, the world. Edits' entries are gates, which
  // Edits::gate_class knows.
  [[nodiscard]] const std::vector<Entity>& entities() const noexcept;
  [[nodiscard]] int entity(const Hit& hit) const noexcept;
  [[nodiscard]] EventClass event_class(Event kind, const Hit& hit) const noexcept;  // D, S, G or L there
  // May some light edit take light that was emitted or scattered here?
  [[nodiscard]] bool may_be_taken_from(const Hit& hit) const noexcept;
  [[nodiscard]] int light_entity(int light) const noexcept;  // of an emissive object: the object's
  [[nodiscard]] const Edits& edits() const noexcept;

  [[nodiscard]] const GatesInView& gates_in_view() const noexcept;

  [[nodiscard]] const Camera& camera() const noexcept;
  [[nodiscard]] const FrameDescription& frame() const noexcept;
  [[nodiscard]] const PixelFilter& pixel_filter() const noexcept;
  [[nodiscard]] const V3d& centre() const noexcept;              // world position of the re-centred origin
  [[nodiscard]] const Bounds& geometry_bounds() const noexcept;  // surfaces alone
  [[nodiscard]] const Bounds& bounds() const noexcept;           // surfaces and the quads of enabled edits
  // diagonal of geometry_bounds(); 1 when there is nothing
  [[nodiscard]] double extent() const noexcept;
  // in use or not; the last is the neutral one
  [[nodiscard]] std::span<const Material> materials() const noexcept;
  [[nodiscard]] bool material_used(std::size_t material) const noexcept;  // on a surface that a ray can meet
  [[nodiscard]] std::size_t triangle_count() const noexcept;              // of all instances
  [[nodiscard]] std::size_t instance_count() const noexcept;              // Hit::instance is below it
  [[nodiscard]] const Bounds& instance_bounds(std::size_t instance) const noexcept;  // re-centred
  // those its triangles use
  [[nodiscard]] std::span<const std::uint32_t> instance_materials(std::size_t instance) const noexcept;

  // What compile() puts together; scene/parts.h. Scenes that differ in their shots alone share their parts.
  struct Parts;
  struct Shot;
  Scene(std::shared_ptr<const Parts> parts, std::unique_ptr<const Shot> shot) noexcept;

 private:
  std::shared_ptr<const Parts> parts_;
  std::unique_ptr<const Shot> shot_;
  friend const Parts& parts_of(const Scene& scene) noexcept;
  friend std::unique_ptr<const Scene> recompile(const Scene& base, const ShotDescription& shot,
                                                Warnings& warnings, const std::function<bool()>& cancelled);
};

// Checks everything in the description, then builds. What is merely wrong (degenerate triangles, singular
// matrices, missing materials, no light) is left out with a warning that names it; what makes no sense
// (indices out of range, arrays that do not fit) is a SceneError. ExpressionError: an edit's expression.
// Null: `cancelled` said so (asked from any thread, one at a time). threads: 0 = all.
[[nodiscard]] std::unique_ptr<const Scene> compile(SceneDescription description, Warnings& warnings,
                                                   const std::function<bool()>& cancelled = {},
                                                   int threads = 0);

// Another shot of a scene that is compiled: bit by bit what compile() makes of the same things with this
// shot, in a fraction of the time. Textures of exits are numbers of the base's images. Only where
// can_recompile(): far away quads may need another origin.
[[nodiscard]] bool can_recompile(const Scene& base, const ShotDescription& shot);
[[nodiscard]] std::unique_ptr<const Scene> recompile(const Scene& base, const ShotDescription& shot,
                                                     Warnings& warnings,
                                                     const std::function<bool()>& cancelled = {});

}  // namespace sluice
