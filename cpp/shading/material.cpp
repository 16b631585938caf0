// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/material.h"

#include <algorithm>

#include "base/random.h"
#include "shading/compiler.h"
#include "shading/program.h"

namespace sluice {

Material::Material() = default;
Material::~Material() = default;
Material::Material(Material&&) noexcept = default;
Material& Material::operator=(Material&&) noexcept = default;

bool Material::is_constant() const noexcept { return program_ && program_->is_folded; }

void run(const Evaluation& e) noexcept {
  for (const Instruction& instruction : e.program.instructions)
    e.registers[instruction.out] = instruction.operation(instruction, e);
}

V3f closure_normal(const Closure& closure, const Evaluation& e) noexcept {
  const SurfacePoint& p = e.point;
  if (closure.normal == Closure::no_normal) return p.ns;
  const V3f& given = e.read(closure.normal);
  const float length = given.length();
  if (!(length > 0) || !std::isfinite(length)) return p.ns;
  V3f n = given / length;
  if (n.dot(p.ng) < 0) n = -n;
  // A normal whose mirror direction goes below the surface, or that is itself seen from below, is bent up to
  // where it just does not.
  constexpr float min_rise = 0.01f;
  V3f mirrored = n * (2 * n.dot(p.wo)) - p.wo;
  const float above = mirrored.dot(p.ng), wanted = std::min(min_rise, 0.9f * p.wo.dot(p.ng));
  if (above >= wanted && n.dot(p.wo) > 0) return n;
  if (above < wanted) mirrored = (mirrored + p.ng * (wanted - above)).normalized();
  const V3f bent = mirrored + p.wo;
  return bent.dot(p.ng) > 1e-6f ? bent.normalized() : p.ns;
}

namespace {

void clear(Bsdf& out, const SurfacePoint& point) noexcept {
  out.count = 0;
  out.photon = point.photon;
  out.emission = out.transparency = Color(0);
  out.ng = point.ng;
}

// Nothing that is not a finite, non-negative number leaves a material.
[[nodiscard]] Color sane(const Color& c) noexcept {
  const auto channel = [](float x) { return x > 0 && std::isfinite(x) ? x : 0.0f; };
  return {channel(c.x), channel(c.y), channel(c.z)};
}

void add_closures(const Evaluation& e, Bsdf& out, bool transparent_only) noexcept {
  for (const Closure& closure : e.program.closures) {
    if (transparent_only && !closure.transparent) continue;
    const Color weight = sane(e.read(closure.weight));
    if (!is_black(weight)) closure.add(closure, e, weight, out);
  }
  out.emission = sane(out.emission);
  out.transparency = sane(out.transparency);
}

// Folded lobes: the normal is the point's, and albedos follow wo.
void copy_folded(const Bsdf& folded, const SurfacePoint& point, Bsdf& out) noexcept {
  clear(out, point);
  out.emission = folded.emission;
  out.transparency = folded.transparency;
  for (int k = 0; k < folded.count; ++k) {
    const Lobe& from = folded.lobes[static_cast<std::size_t>(k)];
    const auto is_uniform = [](const auto& shape) { return shape.response == Response::Uniform; };
    if (std::visit(is_uniform, from.shape)) {
      Lobe& to = out.lobes[static_cast<std::size_t>(out.count++)];
      to = from;
      to.n = point.ns;
    } else {
      add_lobe(out, from.event, from.weight, point.ns, from.shape, point.wo);
    }
  }
}

}  // namespace

void shade(const Material& material, const SurfacePoint& point, Bsdf& out) noexcept {
  if (!material.program_) return clear(out, point);
  const Program& program = *material.program_;
  if (program.is_folded) return copy_folded(program.folded[point.front], point, out);
  clear(out, point);
  std::array<Register, max_registers> registers;
  const Evaluation e{program, point, registers.data(), program.specular_threshold};
  run(e);
  add_closures(e, out, false);
}

Color eval_transparency(const Material& material, const SurfacePoint& point) noexcept {
  if (!material.program_ || material.opaque_) return Color(0);
  const Program& program = *material.program_;
  if (program.is_folded) return program.folded[point.front].transparency;
  std::array<Register, max_registers> registers;
  const Evaluation e{program, point, registers.data(), program.specular_threshold};
  run(e);
  Bsdf out;
  clear(out, point);
  add_closures(e, out, true);
  return out.transparency;
}

// A world is shaded as Cycles does: the position is the direction of view, the normal looks back.
Color eval_background(const Material& material, const V3f& direction, bool camera_ray) noexcept {
  SurfacePoint point;
  point.position = direction;
  point.ng = point.ns = point.wo = -direction;
  point.camera_ray = camera_ray;
  Bsdf out;
  shade(material, point, out);
  return out.emission;
}

// A program without instructions whose lobes depend on no direction but the side is shaded once, here. wo =
// n: a lobe that is black there would be lost, so such programs stay as they are.
void MaterialCompiler::fold() {
  // its normal, to the viewer
  const auto bends = [](const Closure& closure) { return closure.normal != Closure::no_normal; };
  material_.sees_direction_ = sees_direction_ || layered_ || std::ranges::any_of(program_.closures, bends);
  if (!program_.instructions.empty() || material_.sees_direction_) return;
  std::array<Bsdf, 2> folded;
  for (std::size_t front = 0; front < 2; ++front) {
    SurfacePoint point;
    point.front = front != 0;
    clear(folded[front], point);
    folded[front].photon = false;
    add_closures(Evaluation{program_, point, nullptr, program_.specular_threshold}, folded[front], false);
    if (folded[front].count >= max_lobes) return;
    for (int k = 0; k < folded[front].count; ++k) folded[front].lobes[static_cast<std::size_t>(k)].under = 0;
  }
  program_.folded = folded;
  program_.is_folded = true;
}

void MaterialCompiler::average_emission() {
  if (!material_.emits_) return;
  material_.constant_emission_ = material_.program_->instructions.empty();
  constexpr std::uint32_t max_samples = 256;
  const std::uint32_t samples = material_.constant_emission_ ? 1 : max_samples;
  ObjectShading object;
  object.object_to_world.makeIdentity();
  object.world_to_object.makeIdentity();
  V3d sum(0);
  for (std::uint32_t k = 0; k < samples; ++k) {
    const Sampler sampler(11, k);
    const V2f uv = sampler.pair(0), more = sampler.pair(1);
    SurfacePoint point;
    point.object = &object;
    point.position = V3f(uv.x, uv.y, more.x);
    for (UvPoint& map : point.uv) map.uv = uv;
    point.colors.fill(Color(1));
    Bsdf out;
    shade(material_, point, out);
    sum += V3d(out.emission);
  }
  material_.average_emission_ = Color(sum / samples);
}

}  // namespace sluice
