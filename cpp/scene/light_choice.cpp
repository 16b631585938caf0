// SPDX-License-Identifier: GPL-3.0-or-later
// Which light to ask from a point. Few lights: by a bound on their irradiance there (strength / distance²,
// both sides of the horizon told apart), so that a lamp next door does not starve behind the sun. Many: by
// the same bounds, of groups of them (light_tree.h).
#include "scene/light_kinds.h"

namespace sluice {
namespace {

template <kinds::Finite Kind>
float bound_at(const Light& light, const Kind& kind, const V3d& point, const V3f& normal,
               bool one_sided) noexcept {
  const V3d to = light.middle - point;
  if (kinds::is_dark(kind, -to)) return 0;
  const double reach = light.reach, distance2 = std::max({to.length2(), reach * reach, 1e-30});
  double cosine = 1;
  if (one_sided) {
    const double height = to.dot(V3d(normal)) + reach * 1.001;
    if (height < 0) return 0;
    cosine = std::clamp(height / std::sqrt(distance2), 0.1, 1.0);
  }
  return static_cast<float>(light.strength * cosine / distance2);
}
template <kinds::Infinite Kind>
float bound_at(const Light& light, const Kind& kind, const V3d&, const V3f& normal, bool one_sided) noexcept {
  return one_sided ? kinds::irradiance_bound(kind, light.strength, normal) : light.strength;
}

}  // namespace

float importance(const Light& light, const V3d& point, const V3f& normal) noexcept {
  const bool one_sided = normal.x != 0 || normal.y != 0 || normal.z != 0;
  return std::visit([&](const auto& kind) { return bound_at(light, kind, point, normal, one_sided); },
                    light.kind);
}

namespace {

// With which one of few lights is chosen.
struct Weight {
  const Scene::Parts& parts;
  const V3d& point;
  const V3f& normal;
  LightTrust trust;
  float operator()(std::size_t light) const noexcept {
    return importance(parts.lights[light], point, normal) * (trust.empty() ? 1 : trust[light]);
  }
};

bool is_alone(std::size_t count, LightTrust trust) noexcept {
  return count == 1 && (trust.empty() || trust[0] > 0);
}

}  // namespace

std::optional<LightChoice> choose_light(const Scene& scene, const V3d& point, const V3f& normal, float u,
                                        LightTrust trust) noexcept {
  const Scene::Parts& parts = parts_of(scene);
  const std::size_t count = parts.lights.size();
  if (count == 0) return {};
  if (is_alone(count, trust)) return LightChoice{0, 1, u};
  if (count > few_lights) return parts.light_tree.choose(parts.lights, point, normal, u);
  const Weight weight{parts, point, normal, trust};
  float cumulative[few_lights], sum = 0;
  for (std::size_t i = 0; i < count; ++i) cumulative[i] = sum += weight(i);
  if (!(sum > 0)) return {};
  std::size_t i = 0;
  const float target = u * sum;
  while (i + 1 < count && !(target < cumulative[i])) ++i;
  while (i > 0 && cumulative[i] == cumulative[i - 1]) --i;  // rounding at the end: back to a light that can
  const float low = i ? cumulative[i - 1] : 0, width = cumulative[i] - low;
  return LightChoice{static_cast<int>(i), width / sum,
                     std::clamp((target - low) / width, 0.0f, 0x1.fffffep-1f)};
}

float choice_pmf(const Scene& scene, const V3d& point, const V3f& normal, int light,
                 LightTrust trust) noexcept {
  const Scene::Parts& parts = parts_of(scene);
  const std::size_t count = parts.lights.size(), asked = static_cast<std::size_t>(light);
  if (is_alone(count, trust)) return 1;
  if (count > few_lights) return parts.light_tree.pmf(parts.lights, point, normal, light);
  const Weight weight{parts, point, normal, trust};
  // the same sums as in choose_light, so the same pmf to the last bit
  float before = 0, through = 0, sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == asked) before = sum;
    sum += weight(i);
    if (i == asked) through = sum;
  }
  return sum > 0 ? (through - before) / sum : 0;
}

}  // namespace sluice
