// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/bsdf.h"

namespace sluice {
namespace {

[[nodiscard]] bool in_mask(const Lobe& lobe, EventMask mask) noexcept {
  return (mask_of(lobe.event) & mask) != 0;
}

// Along the tangent of a shape that has one and is not the same all round.
template <class Shape>
[[nodiscard]] Frame frame_of(const Shape& shape, const V3f& n) noexcept {
  if constexpr (requires { shape.tangent; }) {
    if (shape.alpha.x != shape.alpha.y) {
      const V3f t = shape.tangent - n * shape.tangent.dot(n);
      if (const float length = t.length(); length > 1e-6f) return {t / length, n.cross(t / length), n};
    }
  }
  return Frame(n);
}

// Losses of the coatings above a lobe, read on the eye's side (photon paths; see Lobe::under).
[[nodiscard]] Color through_layers(const Bsdf& bsdf, const Lobe& lobe, const V3f& wi) noexcept {
  Color through(1);
  for (int k = 0; k < max_layers; ++k)
    if (lobe.under & (1u << k)) through *= layer_transmission(bsdf.layers[static_cast<std::size_t>(k)], wi);
  return through;
}

// f·|cos| of one lobe, flux convention, and its density. `other_side`: wi is beyond the geometric surface.
[[nodiscard]] Color eval_lobe(const Bsdf& bsdf, const Lobe& lobe, const V3f& wo, const V3f& wi,
                              bool other_side) noexcept {
  if (lobe.transmits != other_side) return Color(0);
  Color f = lobe.weight;
  if (std::holds_alternative<Lambert>(lobe.shape)) {
    f *= std::max(0.0f, wi.dot(lobe.n)) / pi;
  } else {
    const auto visit = [&](const auto& shape) {
      const Frame frame = frame_of(shape, lobe.n);
      return eval_shape(shape, frame.to_local(wo), frame.to_local(wi));
    };
    f *= std::visit(visit, lobe.shape);
  }
  return lobe.under && bsdf.photon ? f * through_layers(bsdf, lobe, wi) : f;
}

[[nodiscard]] float pdf_lobe(const Lobe& lobe, const V3f& wo, const V3f& wi, bool other_side) noexcept {
  if (lobe.transmits != other_side) return 0;
  if (std::holds_alternative<Lambert>(lobe.shape)) return std::max(0.0f, wi.dot(lobe.n)) / pi;
  const auto visit = [&](const auto& shape) {
    const Frame frame = frame_of(shape, lobe.n);
    return pdf_shape(shape, frame.to_local(wo), frame.to_local(wi));
  };
  return std::visit(visit, lobe.shape);
}

[[nodiscard]] float eta_of(const Lobe& lobe) noexcept {
  return std::visit([](const auto& shape) { return eta_of(shape); }, lobe.shape);
}

[[nodiscard]] float total_choice(const Bsdf& bsdf, EventMask mask) noexcept {
  float total = 0;
  for (int k = 0; k < bsdf.count; ++k)
    if (const Lobe& lobe = bsdf.lobes[static_cast<std::size_t>(k)]; in_mask(lobe, mask)) total += lobe.choice;
  return total;
}

}  // namespace

EventMask Bsdf::events() const noexcept {
  EventMask mask = 0;
  for (int k = 0; k < count; ++k) mask |= mask_of(lobes[static_cast<std::size_t>(k)].event);
  return mask;
}

bool Bsdf::is_exact() const noexcept {
  return std::all_of(lobes.begin(), lobes.begin() + count,
                     [](const Lobe& lobe) { return lobe.event == Event::S && lobe.delta; });
}

Color eval(const Bsdf& bsdf, const V3f& wo, const V3f& wi, EventMask mask) noexcept {
  assert(is_unit(wo) && is_unit(wi));
  const bool other_side = wi.dot(bsdf.ng) < 0;
  Color sum(0);
  for (int k = 0; k < bsdf.count; ++k) {
    const Lobe& lobe = bsdf.lobes[static_cast<std::size_t>(k)];
    if (!in_mask(lobe, mask) || lobe.delta) continue;
    const Color f = eval_lobe(bsdf, lobe, wo, wi, other_side);
    sum += other_side ? f / square(eta_of(lobe)) : f;
  }
  return sum;
}

float pdf(const Bsdf& bsdf, const V3f& wo, const V3f& wi, EventMask mask) noexcept {
  assert(is_unit(wo) && is_unit(wi));
  const bool other_side = wi.dot(bsdf.ng) < 0;
  float sum = 0, total = 0;
  for (int k = 0; k < bsdf.count; ++k) {
    const Lobe& lobe = bsdf.lobes[static_cast<std::size_t>(k)];
    if (!in_mask(lobe, mask)) continue;
    total += lobe.choice;
    if (!lobe.delta && lobe.choice > 0) sum += lobe.choice * pdf_lobe(lobe, wo, wi, other_side);
  }
  return total > 0 ? sum / total : 0;
}

std::optional<BsdfSample> sample_lobe(const Bsdf& bsdf, int index, const V3f& wo, const V2f& u) noexcept {
  assert(index >= 0 && index < bsdf.count && is_unit(wo));
  const Lobe& lobe = bsdf.lobes[static_cast<std::size_t>(index)];
  ShapeSample s;
  V3f wi;
  const auto visit = [&](const auto& shape) {
    const Frame frame = frame_of(shape, lobe.n);
    if (!sample_shape(shape, frame.to_local(wo), u, s)) return false;
    wi = frame.to_world(s.i);
    return (wi.dot(bsdf.ng) < 0) == transmits(shape);  // else the true surface hides it
  };
  if (!std::visit(visit, lobe.shape)) return {};
  Color weight = lobe.weight * s.weight;
  if (lobe.under && bsdf.photon) weight *= through_layers(bsdf, lobe, wi);
  return BsdfSample{wi, weight, s.pdf, lobe.event, index, lobe.delta, eta_of(lobe)};
}

std::optional<BsdfSample> sample(const Bsdf& bsdf, const V3f& wo, float u_lobe, const V2f& u,
                                 EventMask mask) noexcept {
  const float total = total_choice(bsdf, mask);
  if (!(total > 0)) return {};
  float left = u_lobe * total;
  int chosen = -1;
  for (int k = 0; k < bsdf.count; ++k) {
    const Lobe& lobe = bsdf.lobes[static_cast<std::size_t>(k)];
    if (!in_mask(lobe, mask) || !(lobe.choice > 0)) continue;
    chosen = k;
    left -= lobe.choice;
    if (left < 0) break;
  }
  std::optional<BsdfSample> s = sample_lobe(bsdf, chosen, wo, u);
  if (!s) return s;
  const float probability = bsdf.lobes[static_cast<std::size_t>(chosen)].choice / total;
  if (s->delta) {
    s->weight /= probability;
    s->pdf = probability;
    return s;
  }
  // The light that leaves by this event is what the lobes of this event scatter, over the density with which
  // they made wi.
  const bool other_side = s->wi.dot(bsdf.ng) < 0;
  Color f = s->weight * s->pdf;
  float same_event = s->pdf * probability, all = same_event;
  for (int k = 0; k < bsdf.count; ++k) {
    const Lobe& lobe = bsdf.lobes[static_cast<std::size_t>(k)];
    if (k == chosen || !in_mask(lobe, mask) || lobe.delta || !(lobe.choice > 0)) continue;
    const float density = pdf_lobe(lobe, wo, s->wi, other_side) * lobe.choice / total;
    all += density;
    if (lobe.event != s->event || eta_of(lobe) != s->eta) continue;
    same_event += density;
    f += eval_lobe(bsdf, lobe, wo, s->wi, other_side);
  }
  s->weight = f / same_event;
  s->pdf = all;
  return s;
}

Color albedo(const Bsdf& bsdf, const V3f&, EventMask mask) noexcept {
  Color sum(0);
  for (int k = 0; k < bsdf.count; ++k)
    if (const Lobe& lobe = bsdf.lobes[static_cast<std::size_t>(k)]; in_mask(lobe, mask)) sum += lobe.albedo;
  return sum;
}

float adjoint_factor(const Bsdf& bsdf, int index, const V3f& wo, const V3f& wi) noexcept {
  const V3f& n = bsdf.lobes[static_cast<std::size_t>(index)].n;
  const float factor = std::abs(wo.dot(n) * wi.dot(bsdf.ng)) / std::abs(wo.dot(bsdf.ng) * wi.dot(n));
  return std::isfinite(factor) ? factor : 0;
}

Color layer_transmission(const Layer& layer, const V3f& w) noexcept {
  const float mu = std::min(1.0f, std::abs(w.dot(layer.n)));
  const Color reflected =
      std::visit([mu](const auto& shape) { return albedo_shape(shape, mu); }, layer.shape) * layer.weight;
  const float kept = std::max(0.0f, 1 - max_component(reflected));
  if (layer.tint == Color(1)) return Color(kept);
  // Cycles: optical depth 1 / cos θ_t
  const float way = 1 / std::sqrt(std::max(1e-4f, 1 - (1 - mu * mu) / square(layer.eta)));
  const Color tint(std::pow(layer.tint.x, way), std::pow(layer.tint.y, way), std::pow(layer.tint.z, way));
  return (Color(1) + (tint - Color(1)) * max_component(layer.weight)) * kept;
}

void add_lobe(Bsdf& bsdf, Event event, const Color& weight, const V3f& n, const LobeShape& shape,
              const V3f& wo, std::uint8_t under) noexcept {
  const float mu = std::clamp(wo.dot(n), 0.0f, 1.0f);
  Lobe lobe{event, false, false, under, 0, weight, weight, n, shape};
  std::visit(
      [&](const auto& s) {
        lobe.delta = is_delta(s), lobe.transmits = transmits(s);
        if (lobe.delta) lobe.event = Event::S;
        lobe.albedo *= albedo_shape(s, mu);
      },
      shape);
  for (int k = 0; under && bsdf.photon && k < max_layers; ++k)
    if (under & (1u << k)) lobe.albedo *= layer_transmission(bsdf.layers[static_cast<std::size_t>(k)], wo);
  lobe.choice = (lobe.albedo.x + lobe.albedo.y + lobe.albedo.z) / 3;
  if (!(lobe.choice > 0) || !std::isfinite(lobe.choice)) return;
  if (bsdf.count < max_lobes) {
    bsdf.lobes[static_cast<std::size_t>(bsdf.count++)] = lobe;
    return;
  }
  Lobe* weakest = &bsdf.lobes[0];
  for (Lobe& other : bsdf.lobes)
    if (other.choice < weakest->choice) weakest = &other;
  if (weakest->choice < lobe.choice) *weakest = lobe;
}

}  // namespace sluice
