// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/light_tree.h"

#include <array>
#include <bit>

namespace sluice {
namespace {

constexpr std::size_t most_clusters = 24;
// a doubt of a part of all light that is not worth a split (Walter et al. 2005, §3.2)
constexpr double known_well = 0.02;
constexpr double nearest = 0.1;  // of its reach: as near as a light in a node is feared to be
constexpr double least_cosine = 0.1, nearest2 = 1e-30;  // as in importance()
// of a child that can do something: bounds weights, and products down any path
constexpr double least_share = 0x1p-10;
constexpr double least_weight = 0x1p-126;  // of what is not nothing

// a box's
double along(const V3d& half, const V3d& n) noexcept {
  return half.x * std::abs(n.x) + half.y * std::abs(n.y) + half.z * std::abs(n.z);
}
// not a number: the least
double at_least(double x, double least) noexcept { return x >= least ? x : least; }

// The most doubtful of the clusters, by the bits of their doubts, which as whole numbers have the same order;
// the last few hold the cluster's own number, so that the largest tells it. One pass without branches.
struct Doubts {
  std::array<std::uint32_t, most_clusters> ranks{};

  static constexpr std::uint32_t numbers = std::bit_ceil(most_clusters) - 1;
  void set(std::size_t i, double doubt) noexcept {
    const float known = doubt > 0 ? static_cast<float>(std::min(doubt, 1e38)) : 0;
    ranks[i] = (std::bit_cast<std::uint32_t>(known) & ~numbers) | static_cast<std::uint32_t>(i);
  }
  [[nodiscard]] std::uint32_t most() const noexcept {
    std::uint32_t most = 0;
    for (const std::uint32_t rank : ranks) most = std::max(most, rank);
    return most;
  }
  [[nodiscard]] static std::size_t cluster(std::uint32_t rank) noexcept { return rank & numbers; }
  [[nodiscard]] static double doubt(std::uint32_t rank) noexcept {
    return std::bit_cast<float>(rank & ~numbers);
  }
};

}  // namespace

struct LightTree::Estimate {
  double weight = 0;  // about the irradiance; 0: none of the lights can
  double doubt = 0;   // how far bounds of it lie apart
};

struct LightTree::Query {
  std::span<const Light> lights;
  std::span<const std::uint32_t> order;
  V3d point, normal;
  V3f asked_normal;
  bool one_sided;

  Query(const LightTree& tree, std::span<const Light> of, const V3d& p, const V3f& n) noexcept
      : lights(of),
        order(tree.order_),
        point(p),
        normal(n),
        asked_normal(n),
        one_sided(n.x != 0 || n.y != 0 || n.z != 0) {}

  // A leaf is known as well as a light by itself.
  [[nodiscard]] double weight_of_leaf(const Node& leaf) const noexcept {
    const float own = importance(lights[order[leaf.begin]], point, asked_normal);
    return own > 0 ? std::min(static_cast<double>(own), 1e38) : 0;
  }

  // Does all of it shine another way? Slack on the side of "no".
  [[nodiscard]] static bool is_dark(const Node& node, const V3d& to) noexcept {
    if (node.cosine <= -1) return false;
    const double distance = to.length(), cosine = node.cosine, sine = node.sine,
                 ahead = -to.dot(V3d(node.axis));
    // behind all of them
    if (ahead + along(node.half, V3d(node.axis)) < std::min(0.0, cosine) * (distance + node.reach))
      return true;
    if (!(distance > node.reach)) return false;
    const double s = node.reach / distance, c = std::sqrt(1 - s * s);  // how large it looks
    // beyond both angles, unless they reach around
    return sine * c + cosine * s > 0 && ahead < distance * (cosine * c - sine * s);
  }

  [[nodiscard]] Estimate operator()(const Node& node) const noexcept {
    if (node.is_leaf()) return {weight_of_leaf(node), 0};
    return node.infinite ? estimate_infinite(node) : estimate_finite(node);
  }

  // By the mean square of distances, which the lights' middle and spread tell: no jump where a point enters a
  // node. The cosine is rounded off at the horizon, as far as the lights lie apart across it (as in Facings).
  [[nodiscard]] Estimate estimate_finite(const Node& node) const noexcept {
    const V3d to = node.middle - point;
    if (is_dark(node, to)) return {};
    const double strength = node.strength, reach = node.reach;
    const double far2 = at_least(to.length2() + node.spread2, nearest2), far = std::sqrt(far2),
                 near = std::max(far - reach, nearest * reach);
    double height = far, highest = far;  // times the distance: cosines; of the bound
    if (one_sided) {
      const double middle = to.dot(normal), across = along(node.half, normal), least = least_cosine * far;
      if (middle + across + 1e-12 * far < 0) return {};
      height = std::clamp((middle + std::sqrt(square(middle) + std::min(square(across), node.spread2))) / 2,
                          least, far);
      highest = std::clamp(middle + across, least, far);
    }
    return {at_least(strength * height / (far * far2), least_weight),
            strength * highest * std::min(4 * reach, far) / at_least(far2 * square(near), square(nearest2))};
  }

  [[nodiscard]] Estimate estimate_infinite(const Node& node) const noexcept {
    const double strength = node.strength, height = node.middle.dot(normal),
                 across = along(node.half, normal);
    if (!one_sided) return {strength, 0};
    if (height + across < 0) return {};
    const double cosine = std::clamp(
        (height + std::sqrt(square(height) + std::min(square(across), node.spread2))) / 2, least_cosine, 1.0);
    return {strength * cosine, strength * (std::min(height + across, 1.0) - std::max(height - across, 0.0))};
  }
};

struct LightTree::Cut {
  std::array<const Node*, most_clusters> clusters;
  std::array<double, most_clusters> weights;
  std::size_t count = 0;
  double sum = 0;
};

LightTree::Cut LightTree::cut(const Query& query) const noexcept {
  Cut cut;
  Doubts doubts;
  const auto put = [&](std::size_t at, const Node& node) {
    const Estimate estimate = query(node);
    cut.clusters[at] = &node, cut.weights[at] = estimate.weight;
    cut.sum += estimate.weight;
    doubts.set(at, estimate.doubt);
  };
  for (const std::uint32_t root : roots_) put(cut.count++, nodes_[root]);
  while (cut.count < most_clusters) {
    const std::uint32_t most = doubts.most();
    // by rounding the sum may end below 0
    if (!(Doubts::doubt(most) > std::max(0.0, known_well * cut.sum))) break;
    const std::size_t at = Doubts::cluster(most);
    const Node& parent = *cut.clusters[at];
    cut.sum -= cut.weights[at];
    put(at, nodes_[parent.children]);
    put(cut.count++, nodes_[parent.children + 1]);
  }
  cut.sum = 0;  // without what rounding left
  for (std::size_t i = 0; i < cut.count; ++i) cut.sum += cut.weights[i];
  return cut;
}

// Of a node's two children, how often the first is chosen. Where neither can do anything, which bounds of the
// node did not see, by strength.
double LightTree::first_share(const Query& query, const Node& node) const noexcept {
  const Node &first = nodes_[node.children], &second = nodes_[node.children + 1];
  const double a = query(first).weight, b = query(second).weight;
  if (a > 0 && b > 0) return std::clamp(a / (a + b), least_share, 1 - least_share);
  if (a > 0 || b > 0) return a > 0;
  return static_cast<double>(first.strength) /
         (static_cast<double>(first.strength) + static_cast<double>(second.strength));
}

std::optional<LightChoice> LightTree::choose(std::span<const Light> lights, const V3d& point,
                                             const V3f& normal, float u) const noexcept {
  const Query query(*this, lights, point, normal);
  const Cut cut = this->cut(query);
  if (!(cut.sum > 0)) return {};
  double rest = static_cast<double>(u) * cut.sum;
  std::size_t chosen = cut.count;
  for (std::size_t i = 0; i < cut.count; ++i) {
    if (!(cut.weights[i] > 0)) continue;
    if (chosen < cut.count) rest -= cut.weights[chosen];
    chosen = i;
    if (rest < cut.weights[i]) break;
  }
  constexpr double below_one = 1 - 0x1p-53;
  double pmf = cut.weights[chosen] / cut.sum;
  rest = std::clamp(rest / cut.weights[chosen], 0.0, below_one);
  const Node* node = cut.clusters[chosen];
  while (!node->is_leaf()) {
    const double first = first_share(query, *node);
    const bool goes_first = rest < first;
    const double share = goes_first ? first : 1 - first;
    rest = std::min((goes_first ? rest : rest - first) / share, below_one);
    pmf *= share;
    node = &nodes_[node->children + !goes_first];
  }
  const auto pmf_float = static_cast<float>(at_least(pmf, least_weight));
  return LightChoice{static_cast<int>(order_[node->begin]), pmf_float,
                     std::min(static_cast<float>(rest), 0x1.fffffep-1f)};
}

float LightTree::pmf(std::span<const Light> lights, const V3d& point, const V3f& normal,
                     int light) const noexcept {
  const Query query(*this, lights, point, normal);
  const Cut cut = this->cut(query);
  if (!(cut.sum > 0)) return 0;
  const std::uint32_t place = place_[static_cast<std::size_t>(light)];
  const auto holds = [place](const Node& node) { return node.begin <= place && place < node.end; };
  std::size_t of_light = 0;
  while (!holds(*cut.clusters[of_light])) ++of_light;
  double pmf = cut.weights[of_light] / cut.sum;
  const Node* node = cut.clusters[of_light];
  while (!node->is_leaf() && pmf > 0) {
    const double first = first_share(query, *node);
    const bool goes_first = holds(nodes_[node->children]);
    pmf *= goes_first ? first : 1 - first;
    node = &nodes_[node->children + !goes_first];
  }
  return pmf > 0 ? static_cast<float>(at_least(pmf, least_weight)) : 0;
}

}  // namespace sluice
