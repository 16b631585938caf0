// SPDX-License-Identifier: GPL-3.0-or-later
// Shader nodes except Principled: what each adds to the lobes of a point.
#include "shading/compiler.h"
#include "shading/energy.h"

namespace sluice {
namespace {

using Type = Value::Type;
constexpr EventMask diffuse_event = mask_of(Event::D);

[[nodiscard]] float roughness_of(const Closure& c, const Evaluation& e, int k) noexcept {
  return std::clamp(number(c, e, k), 0.0f, 1.0f);
}
[[nodiscard]] Color color_of(const Closure& c, const Evaluation& e, int k) noexcept {
  const Color& color = operand(c, e, k);
  return {std::max(0.0f, color.x), std::max(0.0f, color.y), std::max(0.0f, color.z)};
}
[[nodiscard]] float eta_of(const Closure& c, const Evaluation& e, int k) noexcept {
  const float ior = std::clamp(number(c, e, k), 1e-5f, 1e5f);
  return e.point.front ? ior : 1 / ior;
}

void diffuse(const Closure& c, const Evaluation& e, const Color& weight, Bsdf& out) noexcept {
  const float roughness = roughness_of(c, e, 1);
  const LobeShape shape = roughness < 1e-5f ? LobeShape(Lambert{}) : LobeShape(OrenNayar{roughness});
  add_lobe(out, Event::D, weight * color_of(c, e, 0), closure_normal(c, e), shape, e.point.wo);
}
void diffuse_node(ShaderReader& n) {
  n.add(diffuse, {n.color("Color", Color(0.8f)), n.number("Roughness")}, {.events = diffuse_event}, "Normal");
}
void subsurface_node(ShaderReader& n) {
  n.warn("light does not travel under surfaces here; it is drawn as diffuse");
  n.add(diffuse, {n.color("Color", Color(0.8f)), n.constant(0.0f)}, {.events = diffuse_event}, "Normal");
}
void neutral_node(ShaderReader& n) {
  n.add(diffuse, {n.constant(V3f(0.5f)), n.constant(0.0f)}, {.events = diffuse_event});
}

void translucent(const Closure& c, const Evaluation& e, const Color& weight, Bsdf& out) noexcept {
  add_lobe(out, Event::D, weight * color_of(c, e, 0), closure_normal(c, e), Translucent{}, e.point.wo);
}
void translucent_node(ShaderReader& n) {
  n.add(translucent, {n.color("Color", Color(0.8f))}, {.events = diffuse_event, .transmits = true}, "Normal");
}

// Choice 0: Ashikhmin's, by a sigma; 1: microfibres, by a roughness.
void velvet(const Closure& c, const Evaluation& e, const Color& weight, Bsdf& out) noexcept {
  const float x = roughness_of(c, e, 1);
  add_lobe(out, Event::D, weight * color_of(c, e, 0), closure_normal(c, e),
           c.choice == 0 ? LobeShape(Velvet{x}) : LobeShape(Sheen{x}), e.point.wo);
}
void velvet_node(ShaderReader& n) {  // Blender 3
  n.add(velvet, {n.color("Color", Color(0.8f)), n.number("Sigma", 1)}, {.events = diffuse_event}, "Normal");
}
void sheen_node(ShaderReader& n) {  // Blender 4
  const int choice = n.option("distribution", "MICROFIBER") == "ASHIKHMIN" ? 0 : 1;
  n.add(velvet, {n.color("Color", Color(0.8f)), n.number("Roughness", 0.5f)}, {.events = diffuse_event},
        "Normal", choice);
}

// Choice 0: energy lost between facets stays lost ("GGX"); 1: kept ("Multiscatter GGX"); 2: roughness 0
// ("Sharp").
[[nodiscard]] int distribution_of(ShaderReader& n, const Value& roughness) {
  const std::string word = n.option("distribution", "MULTI_GGX");
  if (word == "SHARP") return 2;
  if (word == "MULTI_GGX") return 1;
  if (word != "GGX" && !n.is_zero(roughness)) n.warn("the distribution " + word + " is drawn as GGX");
  return 0;
}

void glossy(const Closure& c, const Evaluation& e, const Color& weight, Bsdf& out) noexcept {
  const float roughness = c.choice == 2 ? 0.0f : roughness_of(c, e, 1),
              stretch = std::clamp(number(c, e, 2), -0.99f, 0.99f);
  const V3f n = closure_normal(c, e);
  Reflection shape{.alpha = {roughness * roughness, roughness * roughness},
                   .tangent = V3f(0),
                   .fresnel = {.f0 = clamp01(color_of(c, e, 0))}};
  if (stretch != 0) {  // Cycles' svm_node_closure_bsdf, anisotropic
    shape.alpha = stretch < 0 ? ggx::Alpha{shape.alpha.x / (1 + stretch), shape.alpha.y * (1 + stretch)}
                              : ggx::Alpha{shape.alpha.x * (1 - stretch), shape.alpha.y / (1 - stretch)};
    const float angle = number(c, e, 3) * 2 * pi;
    const V3f t = operand(c, e, 4);
    shape.tangent = t * std::cos(angle) + n.cross(t) * std::sin(angle);
  }
  if (c.choice == 1 && roughness * roughness >= ggx::smooth_alpha)
    shape.multiple = multiple_reflectance(shape.fresnel, shape.alpha);
  add_lobe(out, glossy_event(roughness, e), weight, n, shape, e.point.wo);
}
void glossy_node(ShaderReader& n) {
  const Value roughness = n.number("Roughness", 0.5f);
  const Value stretch = n.is_given("Anisotropy") ? n.number("Anisotropy") : n.constant(0.0f);
  const Value rotation = n.is_given("Rotation") ? n.number("Rotation") : n.constant(0.0f);
  const Value tangent =
      n.value_of(stretch) == V3f(0) ? n.constant(V3f(0), Type::Vector) : n.surface_tangent("Tangent");
  const int distribution = distribution_of(n, roughness);
  const EventMask events = distribution == 2 ? mask_of(Event::S) : n.glossy_events(roughness);
  n.add(glossy, {n.color("Color", Color(0.8f)), roughness, stretch, rotation, tangent}, {.events = events},
        "Normal", distribution);
}

// Two lobes, so that transport may follow both: Fresnel's share is reflected, the rest refracted.
void glass(const Closure& c, const Evaluation& e, const Color& weight, Bsdf& out) noexcept {
  const float roughness = c.choice == 2 ? 0.0f : roughness_of(c, e, 1), alpha = roughness * roughness,
              eta = eta_of(c, e, 2);
  const bool balanced = c.choice == 1 && alpha >= ggx::smooth_alpha;
  const Fresnel fresnel{.kind = Fresnel::Kind::Dielectric, .eta = eta};
  const Color tinted = weight * color_of(c, e, 0);
  const V3f n = closure_normal(c, e);
  add_lobe(out, glossy_event(roughness, e), tinted, n,
           Reflection{.alpha = {alpha, alpha}, .tangent = V3f(0), .fresnel = fresnel, .balanced = balanced},
           e.point.wo);
  add_lobe(out, glossy_event(roughness, e), tinted, n,
           Refraction{.alpha = alpha, .eta = eta, .fresnel = fresnel, .balanced = balanced}, e.point.wo);
}
void glass_node(ShaderReader& n) {
  const Value roughness = n.number("Roughness"), ior = n.number("IOR", 1.45f);
  const int distribution = distribution_of(n, roughness);
  const EventMask events = distribution == 2 ? mask_of(Event::S) : n.refraction_events(roughness, ior);
  n.add(glass, {n.color("Color", Color(1)), roughness, ior}, {.events = events, .refracts = true}, "Normal",
        distribution);
}

void refraction(const Closure& c, const Evaluation& e, const Color& weight, Bsdf& out) noexcept {
  const float roughness = c.choice == 2 ? 0.0f : roughness_of(c, e, 1);
  const Refraction shape{
      .alpha = roughness * roughness, .eta = eta_of(c, e, 2), .fresnel = {}, .lossless = true};
  add_lobe(out, glossy_event(roughness, e), weight * color_of(c, e, 0), closure_normal(c, e), shape,
           e.point.wo);
}
void refraction_node(ShaderReader& n) {
  const Value roughness = n.number("Roughness"), ior = n.number("IOR", 1.45f);
  const int distribution = distribution_of(n, roughness);
  const EventMask events = distribution == 2 ? mask_of(Event::S) : n.refraction_events(roughness, ior);
  n.add(refraction, {n.color("Color", Color(1)), roughness, ior}, {.events = events, .refracts = true},
        "Normal", distribution);
}

void transparent(const Closure& c, const Evaluation& e, const Color& weight, Bsdf& out) noexcept {
  out.transparency += weight * color_of(c, e, 0);
}
void transparent_node(ShaderReader& n) {
  const Value color = n.color("Color", Color(1));
  if (!n.is_zero(color)) n.add(transparent, {color}, {.transparent = true});
}

void emission(const Closure& c, const Evaluation& e, const Color& weight, Bsdf& out) noexcept {
  out.emission += weight * color_of(c, e, 0) * std::max(0.0f, number(c, e, 1));
}
void emission_node(ShaderReader& n) {
  const Value color = n.color("Color", Color(1)), strength = n.number("Strength", 1);
  if (!n.is_zero(color) && !n.is_zero(strength)) n.add(emission, {color, strength}, {.emits = true});
}
// A colour linked to a shader socket shines, as in Blender.
void value_emission(ShaderReader& n) { n.add(emission, {n.own_output(), n.constant(1.0f)}, {.emits = true}); }

Register keep(const Instruction& i, const Evaluation& e) noexcept {
  return operand(i, e, 0) * (1 - std::clamp(number(i, e, 1), 0.0f, 1.0f));
}
Register take(const Instruction& i, const Evaluation& e) noexcept {
  return operand(i, e, 0) * std::clamp(number(i, e, 1), 0.0f, 1.0f);
}
void mix_node(ShaderReader& n) {
  const Value factor = n.number("Fac", 0.5f);
  n.child("Shader", n.emit(keep, Type::Number, {n.weight(), factor}));
  n.child("Shader_001", n.emit(take, Type::Number, {n.weight(), factor}));
}
void add_node(ShaderReader& n) {
  n.child("Shader", n.weight());
  n.child("Shader_001", n.weight());
}

constexpr std::pair<std::string_view, ShaderBuilder> table[] = {
    {"BsdfDiffuse", diffuse_node},
    {"SubsurfaceScattering", subsurface_node},
    {"neutral", neutral_node},
    {"BsdfTranslucent", translucent_node},
    {"BsdfVelvet", velvet_node},
    {"BsdfSheen", sheen_node},
    {"BsdfGlossy", glossy_node},
    {"BsdfAnisotropic", glossy_node},
    {"BsdfGlass", glass_node},
    {"BsdfRefraction", refraction_node},
    {"BsdfTransparent", transparent_node},
    {"Emission", emission_node},
    {"Background", emission_node},
    {"Emission from value", value_emission},
    {"MixShader", mix_node},
    {"AddShader", add_node},
};

}  // namespace

ShaderBuilders shader_nodes() { return table; }

}  // namespace sluice
