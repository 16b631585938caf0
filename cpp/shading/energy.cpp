// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/energy.h"

#include <array>

#include "base/random.h"
#include "shading/fresnel.h"
#include "shading/ggx.h"

namespace sluice::energy {
namespace {

// Grids are even in sqrt(mu) (albedos turn fast at grazing), in roughness, and in (eta - 1) / (eta + 1),
// whose square is the reflectance at normal incidence and whose sign turns with the side.
struct Position {
  int low;
  float f;  // between low and low + 1
};
[[nodiscard]] Position locate(float x, int nodes) noexcept {  // x in [0, 1]
  const float s = std::clamp(x, 0.0f, 1.0f) * static_cast<float>(nodes - 1);
  const int low = std::min(static_cast<int>(s), nodes - 2);
  return {low, s - static_cast<float>(low)};
}
[[nodiscard]] float lerp(float a, float b, float f) noexcept { return a + (b - a) * f; }

// A direction o of a grid node, and the roughness of one.
[[nodiscard]] V3f grid_direction(int node, int nodes) noexcept {
  const float mu = std::clamp(square(static_cast<float>(node) / static_cast<float>(nodes - 1)), 1e-4f, 1.0f);
  return {std::sqrt(1 - mu * mu), 0, mu};
}
[[nodiscard]] ggx::Alpha grid_alpha(int node, int nodes) noexcept {
  const float alpha =
      std::max(ggx::smooth_alpha, square(static_cast<float>(node) / static_cast<float>(nodes - 1)));
  return {alpha, alpha};
}

// What leaves each grid direction, by the grid direction at which it arrives.
template <int size>
struct Kernel {
  using Row = std::array<float, size>;
  std::array<Row, size> from{};

  void add(int o, const Position& i, float weight) noexcept {
    from[static_cast<std::size_t>(o)][static_cast<std::size_t>(i.low)] += weight * (1 - i.f);
    from[static_cast<std::size_t>(o)][static_cast<std::size_t>(i.low + 1)] += weight * i.f;
  }

  [[nodiscard]] Row applied_to(const Row& a) const noexcept {
    Row sums{};
    for (std::size_t o = 0; o < size; ++o)
      for (std::size_t i = 0; i < size; ++i) sums[o] += from[o][i] * a[i];
    return sums;
  }

  // Sinkhorn's iteration: a with a(o) (Σ w a(i) + besides(o)) = wanted(o). w is symmetric in its natural
  // measure, so the root converges.
  [[nodiscard]] Row balance(const Row& besides, const Row& wanted) const noexcept {
    Row a;
    a.fill(1);
    for (int round = 0; round < 40; ++round) {
      const Row sums = applied_to(a);
      for (std::size_t o = 0; o < size; ++o)
        a[o] = std::clamp(std::sqrt(a[o] * wanted[o] / std::max(sums[o] + besides[o], 1e-4f)), 0.05f, 20.0f);
    }
    return a;
  }
};

constexpr int mu_nodes = 32, roughness_nodes = 32, reflecting_samples = 256;

struct ReflectingTable {
  struct Node {
    Reflecting albedo;
    float balance;
  };
  std::array<std::array<Node, mu_nodes>, roughness_nodes> nodes;
  std::array<float, roughness_nodes> mean;

  ReflectingTable() {
    for (int r = 0; r < roughness_nodes; ++r) fill(r);
  }

  void fill(int r) {
    const ggx::Alpha alpha = grid_alpha(r, roughness_nodes);
    Kernel<mu_nodes> kernel;
    for (int m = 0; m < mu_nodes; ++m) {
      Reflecting sum{0, 0, 0};
      const V3f o = grid_direction(m, mu_nodes);
      for (std::uint32_t k = 0; k < reflecting_samples; ++k) {
        const V3f h = ggx::sample_visible(o, alpha, Sampler(7, k).pair(0)), i = ggx::reflect(o, h);
        if (!(i.z > 0)) continue;
        const float w = ggx::shadowing_ratio(o, i, alpha) / reflecting_samples,
                    c = std::clamp(o.dot(h), 0.0f, 1.0f);
        const float m5 = square(square(1 - c)) * (1 - c);
        sum = {sum.total + w, sum.schlick + w * m5, sum.edge + w * c * m5 * (1 - c)};
        kernel.add(m, locate(std::sqrt(i.z), mu_nodes), w);
      }
      nodes[r][m].albedo = sum;
    }
    std::array<float, mu_nodes> nothing{}, all;
    all.fill(1);
    const std::array<float, mu_nodes> a = kernel.balance(nothing, all);
    for (int m = 0; m < mu_nodes; ++m) nodes[r][m].balance = a[m];
    // ∫ E 2 mu dmu with mu = t²: trapezium rule in t
    double sum = 0, weights = 0;
    for (int m = 0; m < mu_nodes; ++m) {
      const double t = static_cast<double>(m) / (mu_nodes - 1), w = (m == mu_nodes - 1 ? 0.5 : 1) * t * t * t;
      sum += w * nodes[r][m].albedo.total;
      weights += w;
    }
    mean[r] = static_cast<float>(sum / weights);
  }

  template <class Read>
  [[nodiscard]] float read(float mu, float roughness, Read&& member) const noexcept {
    const Position m = locate(std::sqrt(std::max(mu, 0.0f)), mu_nodes),
                   r = locate(roughness, roughness_nodes);
    const auto& low = nodes[r.low];
    const auto& high = nodes[r.low + 1];
    return lerp(lerp(member(low[m.low]), member(low[m.low + 1]), m.f),
                lerp(member(high[m.low]), member(high[m.low + 1]), m.f), r.f);
  }
};

[[nodiscard]] const ReflectingTable& reflecting_table() {
  static const ReflectingTable table;
  return table;
}

constexpr int glass_mu_nodes = 24, glass_roughness_nodes = 16, glass_eta_nodes = 25, glass_samples = 64;
constexpr float max_tilt = 0.5f;  // (eta - 1) / (eta + 1) of eta = 3

struct DielectricTable {
  using Row = std::array<Dielectric, glass_mu_nodes>;
  using GlassKernel = Kernel<glass_mu_nodes>;
  std::array<std::array<Row, glass_eta_nodes>, glass_roughness_nodes> nodes;

  DielectricTable() {
    for (int r = 0; r < glass_roughness_nodes; ++r)
      for (int e = glass_eta_nodes / 2; e < glass_eta_nodes; ++e) fill(r, e);
  }

  [[nodiscard]] static float grid_eta(int e) noexcept {
    const float tilt = max_tilt * (2 * static_cast<float>(e) / (glass_eta_nodes - 1) - 1);
    return (1 + tilt) / (1 - tilt);
  }

  // Both sides of one interface at once. Seen from the thin side (eta > 1) reflection and transmission are
  // raised alike, as far as no energy is lost. Reciprocity then says what is transmitted from the dense side;
  // what is missing there is reflected.
  void fill(int r, int e) {
    const int mirror = glass_eta_nodes - 1 - e;
    GlassKernel reflected_outside, transmitted_inwards, reflected_inside, transmitted_outwards;
    for (int m = 0; m < glass_mu_nodes; ++m) {
      nodes[r][e][m] = scatter(r, grid_eta(e), m, reflected_outside, transmitted_inwards);
      if (e != mirror)
        nodes[r][mirror][m] = scatter(r, grid_eta(mirror), m, reflected_inside, transmitted_outwards);
    }
    if (e == mirror) return;
    GlassKernel::Row all, nothing{}, rest;
    all.fill(1);
    const GlassKernel::Row outside = reflected_outside.balance(transmitted_inwards.applied_to(all), all);
    const GlassKernel::Row outwards = transmitted_outwards.applied_to(outside);
    for (std::size_t m = 0; m < glass_mu_nodes; ++m) rest[m] = std::max(0.0f, 1 - outwards[m]);
    const GlassKernel::Row inside = reflected_inside.balance(nothing, rest);
    for (int m = 0; m < glass_mu_nodes; ++m) {
      nodes[r][e][m].balance = nodes[r][e][m].transmitted_balance = outside[m];
      nodes[r][mirror][m].balance = inside[m];
    }
  }

  [[nodiscard]] static Dielectric scatter(int r, float eta, int m, GlassKernel& reflected,
                                          GlassKernel& transmitted) {
    const ggx::Alpha alpha = grid_alpha(r, glass_roughness_nodes);
    const V3f o = grid_direction(m, glass_mu_nodes);
    Dielectric sum{0, 0, 1, 1};
    for (std::uint32_t k = 0; k < glass_samples; ++k) {
      const V3f h = ggx::sample_visible(o, alpha, Sampler(7, k).pair(0));
      const float f = fresnel_dielectric(std::clamp(o.dot(h), 0.0f, 1.0f), eta);
      V3f i = ggx::reflect(o, h);
      if (i.z > 0) {
        const float w = f * ggx::shadowing_ratio(o, i, alpha) / glass_samples;
        sum.reflected += w;
        reflected.add(m, locate(std::sqrt(i.z), glass_mu_nodes), w);
      }
      if (ggx::refract(o, h, eta, i) && i.z < 0) {
        const float w = (1 - f) * ggx::shadowing_ratio(o, i, alpha) / glass_samples;
        sum.transmitted += w;
        transmitted.add(m, locate(std::sqrt(std::min(1.0f, -i.z)), glass_mu_nodes), w);
      }
    }
    return sum;
  }
};

[[nodiscard]] const DielectricTable& dielectric_table() {
  static const DielectricTable table;
  return table;
}

[[nodiscard]] Dielectric mix_of(const Dielectric& a, const Dielectric& b, float f) noexcept {
  return {lerp(a.reflected, b.reflected, f), lerp(a.transmitted, b.transmitted, f),
          lerp(a.balance, b.balance, f), lerp(a.transmitted_balance, b.transmitted_balance, f)};
}

}  // namespace

Reflecting reflecting(float mu, float roughness) noexcept {
  const ReflectingTable& table = reflecting_table();
  using Node = ReflectingTable::Node;
  return {table.read(mu, roughness, [](const Node& n) { return n.albedo.total; }),
          table.read(mu, roughness, [](const Node& n) { return n.albedo.schlick; }),
          table.read(mu, roughness, [](const Node& n) { return n.albedo.edge; })};
}

float mean_reflecting(float roughness) noexcept {
  const Position r = locate(roughness, roughness_nodes);
  const auto& mean = reflecting_table().mean;
  return lerp(mean[r.low], mean[r.low + 1], r.f);
}

float reflecting_balance(float mu, float roughness) noexcept {
  return reflecting_table().read(mu, roughness, [](const ReflectingTable::Node& n) { return n.balance; });
}

Dielectric dielectric(float mu, float roughness, float eta) noexcept {
  const auto& nodes = dielectric_table().nodes;
  const float tilt = (eta - 1) / (eta + 1);
  const Position m = locate(std::sqrt(std::max(mu, 0.0f)), glass_mu_nodes),
                 r = locate(roughness, glass_roughness_nodes);
  const Position e = locate(0.5f + 0.5f * tilt / max_tilt, glass_eta_nodes);
  const auto along_mu = [&](int rough, int node) {
    const auto& row = nodes[rough][node];
    return mix_of(row[m.low], row[m.low + 1], m.f);
  };
  const auto along_eta = [&](int rough) {
    return mix_of(along_mu(rough, e.low), along_mu(rough, e.low + 1), e.f);
  };
  return mix_of(along_eta(r.low), along_eta(r.low + 1), r.f);
}

}  // namespace sluice::energy
