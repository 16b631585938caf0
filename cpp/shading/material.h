// SPDX-License-Identifier: GPL-3.0-or-later
// A compiled material: a flat program over registers that turns a SurfacePoint into a Bsdf. Constant parts
// are folded at compile time. Immutable, thread-safe; evaluation neither allocates nor throws.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/event.h"
#include "base/image.h"
#include "shading/bsdf.h"
#include "shading/nodes.h"
#include "shading/surface_point.h"

namespace sluice {

struct Program;

// What the scene must fill: SurfacePoint::uv[i] is the map uv_maps[i], colors[i] the layer color_layers[i];
// "" = the active one.
struct MaterialNeeds {
  std::vector<std::string> uv_maps, color_layers;
  bool uv_gradients = false;  // normal map, bump, tangent
};

class Material {
 public:
  Material();  // no lobes, black
  ~Material();
  Material(Material&&) noexcept;
  Material& operator=(Material&&) noexcept;

  // Answers for every point and direction: what could happen, not what does.
  [[nodiscard]] bool is_opaque() const noexcept { return opaque_; }
  [[nodiscard]] bool emits() const noexcept { return emits_; }
  [[nodiscard]] bool emission_is_constant() const noexcept { return constant_emission_; }
  // the same lobes everywhere and from everywhere, on one side
  [[nodiscard]] bool is_constant() const noexcept;
  [[nodiscard]] bool transmits() const noexcept { return transmits_; }  // has lobes to the other side
  // else the same lobes from all directions, on one side
  [[nodiscard]] bool sees_direction() const noexcept { return sees_direction_; }
  [[nodiscard]] EventMask lobe_events() const noexcept { return events_; }
  [[nodiscard]] bool has_lobes(EventMask mask) const noexcept { return (events_ & mask) != 0; }
  [[nodiscard]] const MaterialNeeds& needs() const noexcept { return needs_; }
  // Mean radiance emitted over the unit square of UV and the unit cube of generated coordinates; exact when
  // constant.
  [[nodiscard]] const Color& average_emission() const noexcept { return average_emission_; }

 private:
  friend class MaterialCompiler;
  friend class NodeReader;
  friend class ShaderReader;
  friend void shade(const Material&, const SurfacePoint&, Bsdf&) noexcept;
  friend Color eval_transparency(const Material&, const SurfacePoint&) noexcept;

  std::unique_ptr<const Program> program_;
  MaterialNeeds needs_;
  Color average_emission_{0};
  EventMask events_ = 0;
  bool opaque_ = true, emits_ = false, constant_emission_ = true, transmits_ = false, sees_direction_ = false;
};

// Never throws for what a node tree says: unknown nodes, loops, missing images and sockets become warnings
// (item = material, text names the node) and something neutral. `images` must outlive the material and stay
// where they are.
[[nodiscard]] Material compile_material(const MaterialDescription& description, std::span<const Image> images,
                                        float specular_threshold, Warnings& warnings);

// A plain grey diffuse material: what objects without material slots get (Blender's default surface, 0.8).
[[nodiscard]] MaterialDescription default_material();

// The lobes, emission and transparency at a point seen from point.wo. `out` may hold anything before.
void shade(const Material& material, const SurfacePoint& point, Bsdf& out) noexcept;

// Bsdf::transparency alone, for shadow segments.
[[nodiscard]] Color eval_transparency(const Material& material, const SurfacePoint& point) noexcept;

// Radiance of a world seen along `direction` (from the eye outwards).
[[nodiscard]] Color eval_background(const Material& material, const V3f& direction, bool camera_ray) noexcept;

}  // namespace sluice
