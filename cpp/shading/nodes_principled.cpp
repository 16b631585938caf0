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

// A socket of the node, read into the operand `input` of its closure.
struct Socket {
  int input;
  std::string_view name;
  Type type = Type::Number;
  float if_missing = 0;
};

// Rows of sockets stand in the order of the enum that names their operands.
template <std::size_t Count>
[[nodiscard]] consteval bool are_in_order(const Socket (&sockets)[Count]) {
  for (std::size_t i = 0; i < Count; ++i)
    if (sockets[i].input != static_cast<int>(i)) return false;
  return true;
}

// The closure's operands, by input; what is no plain socket is left to the caller.
template <int Count>
[[nodiscard]] std::array<Value, Count> read_sockets(ShaderReader& n, std::span<const Socket> sockets) {
  static_assert(Count <= std::tuple_size_v<decltype(Closure::in)>);
  std::array<Value, Count> in;
  for (const Socket& s : sockets)
    in[static_cast<std::size_t>(s.input)] =
        s.type == Type::Rgb ? n.color(s.name, Color(s.if_missing)) : n.number(s.name, s.if_missing);
  return in;
}

// A constant 1 (or more).
[[nodiscard]] bool is_one(const ShaderReader& n, const Value& v) {
  const auto known = n.value_of(v);
  return known && known->x >= 1;
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
  // no plain sockets
  tangent,
  has_coat_normal,
  coat_normal_input,
  input_count
};
constexpr Socket sockets[] = {
    {base_color, "Base Color", Type::Rgb, 0.8f},
    {subsurface, "Subsurface"},
    {subsurface_color, "Subsurface Color", Type::Rgb, 0.8f},
    {metallic, "Metallic"},
    {specular, "Specular", Type::Number, 0.5f},
    {specular_tint, "Specular Tint"},
    {roughness, "Roughness", Type::Number, 0.5f},
    {anisotropic, "Anisotropic"},
    {rotation, "Anisotropic Rotation"},
    {sheen, "Sheen"},
    {sheen_tint, "Sheen Tint", Type::Number, 0.5f},
    {clearcoat, "Clearcoat"},
    {clearcoat_roughness, "Clearcoat Roughness"},
    {ior, "IOR", Type::Number, 1.45f},
    {transmission, "Transmission"},
    {transmission_roughness, "Transmission Roughness"},
    {emission, "Emission", Type::Rgb, 0},
    {strength, "Emission Strength", Type::Number, 1},
    {alpha, "Alpha", Type::Number, 1},
};
static_assert(are_in_order(sockets) && std::size(sockets) == tangent);

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

EventMask events_of(const ShaderReader& n, const std::array<Value, input_count>& in) {
  if (n.is_zero(in[alpha])) return 0;
  EventMask events = 0;
  if (!is_one(n, in[metallic]) && !is_one(n, in[transmission])) events |= mask_of(Event::D);
  if (!(n.is_zero(in[specular]) && n.is_zero(in[metallic]) && n.is_zero(in[transmission])))
    events |= n.glossy_events(in[roughness]);
  if (!n.is_zero(in[transmission]))
    events |= n.is_zero(in[transmission_roughness]) ? n.refraction_events(in[roughness], in[ior])
                                                    : mask_of(Event::S) | mask_of(Event::G);
  if (!n.is_zero(in[clearcoat])) events |= n.glossy_events(in[clearcoat_roughness]);
  return events;
}

void node(ShaderReader& n) {
  std::array in = read_sockets<input_count>(n, sockets);
  const bool own_normal = n.is_linked("Clearcoat Normal");
  in[tangent] = n.is_zero(in[anisotropic]) ? n.constant(0.0f) : n.surface_tangent("Tangent");
  in[has_coat_normal] = n.constant(own_normal ? 1.0f : 0.0f);
  in[coat_normal_input] = own_normal ? n.vector("Clearcoat Normal") : n.constant(0.0f);
  n.add(add, in,
        {.events = events_of(n, in),
         .transparent = !is_one(n, in[alpha]),
         .emits = !n.is_zero(in[emission]) && !n.is_zero(in[strength]) && !n.is_zero(in[alpha]),
         .refracts = !n.is_zero(in[transmission]) && !is_one(n, in[metallic])},
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
  // no plain sockets
  tangent,
  has_coat_normal,
  coat_normal_input,
  diffuse_roughness,
  input_count
};
constexpr Socket sockets[] = {
    {base_color, "Base Color", Type::Rgb, 0.8f},
    {metallic, "Metallic"},
    {roughness, "Roughness", Type::Number, 0.5f},
    {ior, "IOR", Type::Number, 1.5f},
    {alpha, "Alpha", Type::Number, 1},
    {subsurface, "Subsurface Weight"},
    {level, "Specular IOR Level", Type::Number, 0.5f},
    {specular_tint, "Specular Tint", Type::Rgb, 1},
    {anisotropic, "Anisotropic"},
    {rotation, "Anisotropic Rotation"},
    {transmission, "Transmission Weight"},
    {coat, "Coat Weight"},
    {coat_roughness, "Coat Roughness", Type::Number, 0.03f},
    {coat_ior, "Coat IOR", Type::Number, 1.5f},
    {coat_tint, "Coat Tint", Type::Rgb, 1},
    {sheen, "Sheen Weight"},
    {sheen_roughness, "Sheen Roughness", Type::Number, 0.5f},
    {sheen_tint, "Sheen Tint", Type::Rgb, 1},
    {emission, "Emission Color", Type::Rgb, 1},
    {strength, "Emission Strength"},
};
static_assert(are_in_order(sockets) && std::size(sockets) == tangent);

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

EventMask events_of(const ShaderReader& n, const std::array<Value, input_count>& in) {
  if (n.is_zero(in[alpha])) return 0;
  EventMask events = n.glossy_events(in[roughness]);
  if ((!is_one(n, in[metallic]) && !is_one(n, in[transmission])) || !n.is_zero(in[sheen]))
    events |= mask_of(Event::D);
  if (!n.is_zero(in[transmission])) events |= n.refraction_events(in[roughness], in[ior]);
  if (!n.is_zero(in[coat])) events |= n.glossy_events(in[coat_roughness]);
  return events;
}

void node(ShaderReader& n) {
  std::array in = read_sockets<input_count>(n, sockets);
  const bool own_normal = n.is_linked("Coat Normal");
  in[tangent] = n.is_zero(in[anisotropic]) ? n.constant(0.0f) : n.surface_tangent("Tangent");
  in[has_coat_normal] = n.constant(own_normal ? 1.0f : 0.0f);
  in[coat_normal_input] = own_normal ? n.vector("Coat Normal") : n.constant(0.0f);
  // Older versions have no such socket, which is nothing to warn of.
  in[diffuse_roughness] = n.is_given("Diffuse Roughness") ? n.number("Diffuse Roughness") : n.constant(0.0f);
  n.add(add, in,
        {.events = events_of(n, in),
         .transparent = !is_one(n, in[alpha]),
         .emits = !n.is_zero(in[emission]) && !n.is_zero(in[strength]) && !n.is_zero(in[alpha]),
         .refracts = !n.is_zero(in[transmission]) && !is_one(n, in[metallic]),
         .layered = true},
        "Normal", n.option("distribution", "MULTI_GGX") == "MULTI_GGX");
}

}  // namespace v2

constexpr std::pair<std::string_view, ShaderBuilder> table[] = {{"BsdfPrincipled", v2::node},
                                                                {"BsdfPrincipledV1", v1::node}};

}  // namespace

ShaderBuilders principled_nodes() { return table; }

}  // namespace sluice
