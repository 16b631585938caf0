// SPDX-License-Identifier: GPL-3.0-or-later
// Principled BSDF in its two shapes. Weights, Fresnel curves and layering follow Cycles (3.x: svm_closure.h
// before 4.0; 4.x: after), since unedited pictures are compared with it; only sheen has a simpler lobe of its
// own, and light under surfaces is diffuse.
#include "shading/compiler.h"
#include "shading/energy.h"

namespace sluice {
namespace {

using Type = Value::Type;

[[nodiscard]] float unit(float x) noexcept { return std::clamp(x, 0.0f, 1.0f); }
[[nodiscard]] Color positive(const Color& c) noexcept {
  return {std::max(0.0f, c.x), std::max(0.0f, c.y), std::max(0.0f, c.z)};
}
[[nodiscard]] Color mixed(const Color& a, const Color& b, float t) noexcept { return a * (1 - t) + b * t; }
[[nodiscard]] ggx::Alpha isotropic(float roughness) noexcept {
  return {roughness * roughness, roughness * roughness};
}

// What both shapes share while their lobes are added.
struct Surface {
  const Closure& closure;
  const Evaluation& e;
  Bsdf& out;
  V3f n;
  float roughness;
  ggx::Alpha alpha;
  V3f tangent;
  bool keeps_energy;  // "Multiscatter GGX"

  void reflect(const Color& weight, const Fresnel& fresnel, std::uint8_t under = 0) const noexcept {
    Reflection shape{.alpha = alpha, .tangent = tangent, .fresnel = fresnel};
    if (keeps_energy && !is_delta(shape)) shape.multiple = multiple_reflectance(fresnel, alpha);
    add_lobe(out, glossy_event(roughness, e), weight, n, shape, e.point.wo, under);
  }
  [[nodiscard]] float number(int k) const noexcept { return sluice::number(closure, e, k); }
  [[nodiscard]] Color color(int k) const noexcept { return positive(operand(closure, e, k)); }
};

// Disney's stretch: aspect = sqrt(1 - 0.9 anisotropic).
void stretch(Surface& s, float anisotropic, float rotation, const V3f& tangent) noexcept {
  s.alpha = isotropic(s.roughness);
  s.tangent = V3f(0);
  if (!(anisotropic > 0)) return;
  const float aspect = std::sqrt(1 - 0.9f * unit(anisotropic)), angle = rotation * 2 * pi;
  s.alpha = {s.alpha.x / aspect, s.alpha.y * aspect};
  s.tangent = tangent * std::cos(angle) + s.n.cross(tangent) * std::sin(angle);
}

// The normal of the coat: its own input if that is linked (operand `k` is its flag, k + 1 the normal).
[[nodiscard]] V3f coat_normal(const Surface& s, int k) noexcept {
  if (s.number(k) == 0) return s.n;
  Closure own = s.closure;
  own.normal = s.closure.in[static_cast<std::size_t>(k + 1)];
  return own.normal >= 0 ? closure_normal(own, s.e) : s.n;
}

namespace v1 {

enum Input : int {
  base_color,
  subsurface,
  subsurface_color,
  metallic,
  specular,
  specular_tint,
  roughness,
  anisotropic,
  rotation,
  sheen,
  sheen_tint,
  clearcoat,
  clearcoat_roughness,
  ior,
  transmission,
  transmission_roughness,
  emission,
  strength,
  alpha,
  tangent,
  has_coat_normal,
  coat_normal_input
};

void add_diffuse(const Surface& s, const Color& weight, const Color& base) noexcept {
  // scattering below the surface: diffuse here
  const Color under = mixed(base, s.color(subsurface_color), unit(s.number(subsurface)));
  add_lobe(s.out, Event::D, weight * under, s.n, Burley{s.roughness}, s.e.point.wo);
  const float amount = std::max(0.0f, s.number(sheen));
  if (!(amount > 0)) return;
  const float gray = luminance(base);
  const Color hue = gray > 0 ? base / gray : Color(1);
  add_lobe(s.out, Event::D, weight * mixed(Color(1), hue, s.number(sheen_tint)) * amount, s.n, DisneySheen{},
           s.e.point.wo);
}

void add_specular(const Surface& s, const Color& weight, const Color& base, float metal) noexcept {
  const float level = std::max(0.0f, s.number(specular));
  if (!(level > 0 || metal > 0)) return;
  const float gray = 0.3f * base.x + 0.6f * base.y + 0.1f * base.z;
  const Color hue = gray > 0 ? base / gray : Color(1);
  const Color f0 = mixed(mixed(Color(1), hue, s.number(specular_tint)) * (0.08f * level), base, metal);
  const float eta = 2 / (1 - std::sqrt(std::min(0.99f, 0.08f * level))) - 1;
  s.reflect(weight, {.kind = Fresnel::Kind::Tinted, .eta = eta, .f0 = clamp01(f0)});
}

void add_glass(const Surface& s, const Color& weight, const Color& base) noexcept {
  const float index = std::max(1e-5f, s.number(ior)), eta = s.e.point.front ? index : 1 / index;
  const Fresnel fresnel{.kind = Fresnel::Kind::Dielectric, .eta = eta};
  const bool rough = s.roughness * s.roughness >= ggx::smooth_alpha, balanced = s.keeps_energy && rough;
  const Color tint = mixed(Color(1), base, unit(s.number(specular_tint)));
  add_lobe(s.out, glossy_event(s.roughness, s.e), weight * tint, s.n,
           Reflection{
               .alpha = isotropic(s.roughness), .tangent = V3f(0), .fresnel = fresnel, .balanced = balanced},
           s.e.point.wo);
  const float blurred =
      s.keeps_energy ? s.roughness : 1 - (1 - s.roughness) * (1 - unit(s.number(transmission_roughness)));
  add_lobe(s.out, glossy_event(blurred, s.e), weight * base, s.n,
           Refraction{.alpha = blurred * blurred, .eta = eta, .fresnel = fresnel, .balanced = balanced},
           s.e.point.wo);
}

void add(const Closure& c, const Evaluation& e, const Color& closure_weight, Bsdf& out) noexcept {
  Surface s{c, e, out, closure_normal(c, e), unit(number(c, e, roughness)), {}, {}, c.choice != 0};
  stretch(s, s.number(anisotropic), s.number(rotation), operand(c, e, tangent));
  const float cover = unit(s.number(alpha)), metal = unit(s.number(metallic)),
              through = unit(s.number(transmission)) * (1 - metal);
  const Color weight = closure_weight * cover, base = s.color(base_color);
  out.transparency += closure_weight * (1 - cover);
  out.emission += weight * s.color(emission) * std::max(0.0f, s.number(strength));
  if (const float share = (1 - metal) * (1 - unit(s.number(transmission))); share > 0)
    add_diffuse(s, weight * share, base);
  if (through < 1) add_specular(s, weight * (1 - through), base, metal);
  if (through > 0) add_glass(s, weight * through, base);
  if (const float coat = std::max(0.0f, s.number(clearcoat)); coat > 0) {
    const float rough = unit(s.number(clearcoat_roughness));
    const Reflection shape{.alpha = isotropic(rough),
                           .tangent = V3f(0),
                           .fresnel = {.kind = Fresnel::Kind::Dielectric, .eta = 1.5f}};
    add_lobe(out, glossy_event(rough, e), weight * (0.25f * coat), coat_normal(s, has_coat_normal), shape,
             e.point.wo);
  }
}

void node(ShaderReader& n) {
  const Value metal = n.number("Metallic"), glass = n.number("Transmission"),
              rough = n.number("Roughness", 0.5f), coat = n.number("Clearcoat");
  const Value coat_rough = n.number("Clearcoat Roughness"), light = n.color("Emission", Color(0)),
              power = n.number("Emission Strength", 1), cover = n.number("Alpha", 1);
  const Value stretched = n.number("Anisotropic"), blur = n.number("Transmission Roughness"),
              level = n.number("Specular", 0.5f), index = n.number("IOR", 1.45f);
  const bool own_normal = n.is_linked("Clearcoat Normal");
  const auto is_one = [&](const Value& v) { return n.value_of(v) && n.value_of(v)->x >= 1; };
  EventMask events = 0;
  if (!is_one(metal) && !is_one(glass)) events |= mask_of(Event::D);
  if (!(n.is_zero(level) && n.is_zero(metal) && n.is_zero(glass))) events |= n.glossy_events(rough);
  if (!n.is_zero(glass))
    events |= n.is_zero(blur) ? n.refraction_events(rough, index) : mask_of(Event::S) | mask_of(Event::G);
  if (!n.is_zero(coat)) events |= n.glossy_events(coat_rough);
  if (n.is_zero(cover)) events = 0;
  n.add(add,
        {n.color("Base Color", Color(0.8f)),
         n.number("Subsurface"),
         n.color("Subsurface Color", Color(0.8f)),
         metal,
         level,
         n.number("Specular Tint"),
         rough,
         stretched,
         n.number("Anisotropic Rotation"),
         n.number("Sheen"),
         n.number("Sheen Tint", 0.5f),
         coat,
         coat_rough,
         index,
         glass,
         blur,
         light,
         power,
         cover,
         n.is_zero(stretched) ? n.constant(0.0f) : n.surface_tangent("Tangent"),
         n.constant(own_normal ? 1.0f : 0.0f),
         own_normal ? n.vector("Clearcoat Normal") : n.constant(0.0f)},
        {.events = events,
         .transparent = !is_one(cover),
         .emits = !n.is_zero(light) && !n.is_zero(power) && !n.is_zero(cover),
         .refracts = !n.is_zero(glass) && !is_one(metal)},
        "Normal", n.option("distribution", "GGX") == "MULTI_GGX");
}

}  // namespace v1

namespace v2 {

enum Input : int {
  base_color,
  metallic,
  roughness,
  ior,
  alpha,
  subsurface,
  level,
  specular_tint,
  anisotropic,
  rotation,
  transmission,
  coat,
  coat_roughness,
  coat_ior,
  coat_tint,
  sheen,
  sheen_roughness,
  sheen_tint,
  emission,
  strength,
  tangent,
  has_coat_normal,
  coat_normal_input,
  diffuse_roughness
};

// Puts a coating over what is added from now on: on view paths its loss goes into `weight`, on light paths
// the lobes remember it.
void cover_with(Bsdf& out, const Layer& layer, int index, const V3f& wo, Color& weight,
                std::uint8_t& under) noexcept {
  if (!out.photon) {
    weight *= layer_transmission(layer, wo);
    return;
  }
  out.layers[static_cast<std::size_t>(index)] = layer;
  under = static_cast<std::uint8_t>(under | (1u << index));
}

void add_coats(const Surface& s, Color& weight, std::uint8_t& under) noexcept {
  const V3f& wo = s.e.point.wo;
  if (const float amount = std::max(0.0f, s.number(sheen)); amount > 0) {
    const Sheen shape{unit(s.number(sheen_roughness))};
    const Color tint = s.color(sheen_tint) * amount;
    add_lobe(s.out, Event::D, weight * tint, s.n, shape, wo, under);
    cover_with(s.out, {shape, s.n, tint, Color(1), 1}, 0, wo, weight, under);
  }
  if (const float amount = unit(s.number(coat)); amount > 0) {
    const float rough = unit(s.number(coat_roughness)), eta = std::max(1.0f, s.number(coat_ior));
    const V3f n = coat_normal(s, has_coat_normal);
    const Reflection shape{.alpha = isotropic(rough),
                           .tangent = V3f(0),
                           .fresnel = {.kind = Fresnel::Kind::Dielectric, .eta = eta}};
    add_lobe(s.out, glossy_event(rough, s.e), weight * amount, n, shape, wo, under);
    cover_with(s.out, {shape, n, Color(amount), clamp01(s.color(coat_tint)), eta}, 1, wo, weight, under);
  }
}

void add_glass(const Surface& s, const Color& weight, const Color& base, std::uint8_t under) noexcept {
  const float index = std::max(1e-5f, s.number(ior)), eta = s.e.point.front ? index : 1 / index;
  const Fresnel fresnel{
      .kind = Fresnel::Kind::Tinted, .eta = eta, .f0 = clamp01(s.color(specular_tint) * f0_of_ior(eta))};
  const bool balanced = s.keeps_energy && s.roughness * s.roughness >= ggx::smooth_alpha;
  const Color tint(std::sqrt(base.x), std::sqrt(base.y), std::sqrt(base.z));
  const Event event = glossy_event(s.roughness, s.e);
  add_lobe(s.out, event, weight, s.n,
           Reflection{
               .alpha = isotropic(s.roughness), .tangent = V3f(0), .fresnel = fresnel, .balanced = balanced},
           s.e.point.wo, under);
  add_lobe(
      s.out, event, weight * tint, s.n,
      Refraction{.alpha = s.roughness * s.roughness, .eta = eta, .fresnel = fresnel, .balanced = balanced},
      s.e.point.wo, under);
}

void add_plastic(const Surface& s, Color weight, const Color& base, std::uint8_t under) noexcept {
  const float index = std::max(1e-5f, s.number(ior)), change = 2 * std::max(0.0f, s.number(level));
  float eta = s.e.point.front ? index : 1 / index, f0 = f0_of_ior(eta);
  if (change != 1) {
    f0 *= change;
    eta = eta < 1 ? 1 / ior_of_f0(f0) : ior_of_f0(f0);
  }
  if (eta != 1) {
    const Fresnel fresnel{
        .kind = Fresnel::Kind::Tinted, .eta = eta, .f0 = clamp01(s.color(specular_tint) * f0)};
    s.reflect(weight, fresnel, under);
    Reflection shape{.alpha = s.alpha, .tangent = s.tangent, .fresnel = fresnel};
    if (s.keeps_energy && !is_delta(shape)) shape.multiple = multiple_reflectance(fresnel, s.alpha);
    cover_with(s.out, {shape, s.n, Color(1), Color(1), 1}, 2, s.e.point.wo, weight, under);
  }
  const float rough = unit(s.number(diffuse_roughness));
  add_lobe(s.out, Event::D, weight * base, s.n,
           rough > 0 ? LobeShape(OrenNayar{rough}) : LobeShape(Lambert{}), s.e.point.wo, under);
}

void add(const Closure& c, const Evaluation& e, const Color& closure_weight, Bsdf& out) noexcept {
  Surface s{c, e, out, closure_normal(c, e), unit(number(c, e, roughness)), {}, {}, c.choice != 0};
  stretch(s, s.number(anisotropic), s.number(rotation), operand(c, e, tangent));
  const float opaque = unit(s.number(alpha)), metal = unit(s.number(metallic)),
              through = unit(s.number(transmission));
  Color weight = closure_weight * opaque;
  const Color base = s.color(base_color);
  out.transparency += closure_weight * (1 - opaque);
  std::uint8_t under = 0;
  add_coats(s, weight, under);
  Color emitted = weight;
  for (int k = 0; out.photon && k < max_layers; ++k)
    if (under & (1u << k)) emitted *= layer_transmission(out.layers[static_cast<std::size_t>(k)], e.point.wo);
  out.emission += emitted * s.color(emission) * std::max(0.0f, s.number(strength));
  if (metal > 0)
    s.reflect(weight * metal, metal_fresnel(clamp01(base), clamp01(s.color(specular_tint))), under);
  weight *= 1 - metal;
  if (through > 0 && metal < 1) add_glass(s, weight * through, base, under);
  weight *= 1 - through;
  if (metal < 1 && through < 1) add_plastic(s, weight, base, under);
}

void node(ShaderReader& n) {
  const Value metal = n.number("Metallic"), glass = n.number("Transmission Weight"),
              rough = n.number("Roughness", 0.5f), over = n.number("Coat Weight"),
              cover = n.number("Alpha", 1);
  const Value coat_rough = n.number("Coat Roughness", 0.03f), light = n.color("Emission Color", Color(1)),
              power = n.number("Emission Strength"), stretched = n.number("Anisotropic");
  const Value grain = n.is_given("Diffuse Roughness") ? n.number("Diffuse Roughness") : n.constant(0.0f);
  const Value index = n.number("IOR", 1.5f);
  const bool own_normal = n.is_linked("Coat Normal");
  const auto is_one = [&](const Value& v) { return n.value_of(v) && n.value_of(v)->x >= 1; };
  EventMask events = n.glossy_events(rough);
  if ((!is_one(metal) && !is_one(glass)) || !n.is_zero(n.number("Sheen Weight"))) events |= mask_of(Event::D);
  if (!n.is_zero(glass)) events |= n.refraction_events(rough, index);
  if (!n.is_zero(over)) events |= n.glossy_events(coat_rough);
  if (n.is_zero(cover)) events = 0;
  n.add(add,
        {n.color("Base Color", Color(0.8f)),
         metal,
         rough,
         index,
         cover,
         n.number("Subsurface Weight"),
         n.number("Specular IOR Level", 0.5f),
         n.color("Specular Tint", Color(1)),
         stretched,
         n.number("Anisotropic Rotation"),
         glass,
         over,
         coat_rough,
         n.number("Coat IOR", 1.5f),
         n.color("Coat Tint", Color(1)),
         n.number("Sheen Weight"),
         n.number("Sheen Roughness", 0.5f),
         n.color("Sheen Tint", Color(1)),
         light,
         power,
         n.is_zero(stretched) ? n.constant(0.0f) : n.surface_tangent("Tangent"),
         n.constant(own_normal ? 1.0f : 0.0f),
         own_normal ? n.vector("Coat Normal") : n.constant(0.0f),
         grain},
        {.events = events,
         .transparent = !is_one(cover),
         .emits = !n.is_zero(light) && !n.is_zero(power) && !n.is_zero(cover),
         .refracts = !n.is_zero(glass) && !is_one(metal),
         .layered = true},
        "Normal", n.option("distribution", "MULTI_GGX") == "MULTI_GGX");
}

}  // namespace v2

constexpr std::pair<std::string_view, ShaderBuilder> table[] = {{"BsdfPrincipled", v2::node},
                                                                {"BsdfPrincipledV1", v1::node}};

}  // namespace

ShaderBuilders principled_nodes() { return table; }

}  // namespace sluice
