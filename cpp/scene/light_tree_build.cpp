// SPDX-License-Identifier: GPL-3.0-or-later
// How a light tree is made: from the top, each node cut in two across its longest side, where strength times
// size of both halves, in space and in directions, is least (Walter et al. 2005, §3.1; from the top by
// Estevez & Kulla 2018, §4.3).
#include <numeric>

#include "scene/light_kinds.h"
#include "scene/light_tree.h"
#include "scene/scene.h"

namespace sluice {
namespace {

using Cone = kinds::DirectionCone;

constexpr int max_halved_depth = 40;  // below it nodes are halved by number, so that none is much deeper

// The smallest cone around both.
Cone join(const Cone& a, const Cone& b) {
  const bool first = a.half >= b.half;
  const Cone &wide = first ? a : b, &narrow = first ? b : a;
  if (narrow.half < 0 || wide.half >= std::numbers::pi) return wide;
  const V3d across = wide.axis.cross(narrow.axis);
  const double between = std::atan2(across.length(), wide.axis.dot(narrow.axis));
  if (between + narrow.half <= wide.half) return wide;
  const double half = (wide.half + between + narrow.half) / 2, turn = half - wide.half;
  if (half >= std::numbers::pi || !(across.length2() > 0)) return {};
  const V3d aside = across.cross(wide.axis).normalized();
  return {(wide.axis * std::cos(turn) + aside * std::sin(turn)).normalized(), half};
}

// A light as the tree sees it. Of one at infinity `place` and `reach` are those of the directions to it.
struct Item {
  V3d place;
  double reach, strength;
  Cone cone;
};

template <kinds::Infinite Kind>
Item item_of(const Light&, double strength, const Kind& kind) {
  const kinds::DirectionBall directions = kinds::directions_to(kind);
  return {directions.middle, directions.reach, strength, {}};
}
template <kinds::Finite Kind>
Item item_of(const Light& light, double strength, const Kind& kind) {
  return {light.middle, light.reach * (1 + 2 * kinds::bound_slack), strength, kinds::emission_cone(kind)};
}

Item item_of(const Light& light) {
  const double strength = std::isfinite(light.strength) ? std::max(light.strength, 1e-30f) : 1e-30f;
  return std::visit([&](const auto& kind) { return item_of(light, strength, kind); }, light.kind);
}

// What is known of some items together.
struct Group {
  Bounds bounds;
  double strength = 0;
  Cone cone{.half = -1};

  void add(const Item& item) {
    bounds.add(item.place - V3d(item.reach)), bounds.add(item.place + V3d(item.reach));
    strength += item.strength;
    cone = join(cone, item.cone);
  }
  // `size`: that a turn of directions counts like (m).
  [[nodiscard]] double cost(double size) const {
    return strength * ((bounds.high - bounds.low).length2() +
                       square(size * (1 - std::cos(std::min(cone.half, std::numbers::pi)))));
  }
};

int longest_axis(std::span<const Item> items, std::span<const std::uint32_t> members) {
  Bounds bounds;
  for (const std::uint32_t i : members) bounds.add(items[i].place);
  const V3d size = bounds.high - bounds.low;
  return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

// Sorts the members along their longest axis, and says how many go into the first half. Ties fall to the
// middle.
std::size_t split(std::span<const Item> items, std::span<std::uint32_t> members, int depth) {
  const int axis = longest_axis(items, members);
  std::ranges::sort(members, {}, [&](std::uint32_t i) { return std::pair(items[i].place[axis], i); });
  const std::size_t count = members.size(), half = count / 2;
  if (depth >= max_halved_depth) return half;
  Group all;
  for (const std::uint32_t i : members) all.add(items[i]);
  const double size = all.bounds.diagonal();
  std::vector<double> cost(count, 0);  // of a cut before each
  Group before, behind;
  for (std::size_t i = 1; i < count; ++i) before.add(items[members[i - 1]]), cost[i] += before.cost(size);
  for (std::size_t i = count - 1; i > 0; --i) behind.add(items[members[i]]), cost[i] += behind.cost(size);
  std::size_t best = half;
  const auto off = [half](std::size_t i) { return i > half ? i - half : half - i; };
  for (std::size_t i = 1; i < count; ++i)
    if (cost[i] < cost[best] || (cost[i] == cost[best] && off(i) < off(best))) best = i;
  return best;
}

}  // namespace

struct LightTree::Builder {
  LightTree& tree;
  std::vector<Item> items;

  [[nodiscard]] Node node(std::uint32_t begin, std::uint32_t end, bool infinite) const {
    const auto members = std::span(tree.order_).subspan(begin, end - begin);
    V3d sum(0);
    Group group;
    for (const std::uint32_t i : members) group.add(items[i]), sum += items[i].place * items[i].strength;
    Node node{.begin = begin,
              .end = end,
              .infinite = infinite,
              .strength = static_cast<float>(group.strength),
              .middle = sum / group.strength,
              .spread2 = 0,
              .reach = 0,
              .half = V3d(0),
              .axis = V3f(group.cone.axis),
              .cosine = -1,
              .sine = 0};
    for (const std::uint32_t i : members) {
      const V3d aside = items[i].place - node.middle;
      node.spread2 += items[i].strength / group.strength * aside.length2();
      node.reach = std::max(node.reach, (aside.length() + items[i].reach) * (1 + 1e-6));
      for (int k = 0; k < 3; ++k)
        node.half[k] = std::max(node.half[k], (std::abs(aside[k]) + items[i].reach) * (1 + 1e-6));
    }
    if (group.cone.half < std::numbers::pi)
      node.cosine = static_cast<float>(std::cos(group.cone.half)),
      node.sine = static_cast<float>(std::sin(group.cone.half));
    return node;
  }

  void grow(std::uint32_t begin, std::uint32_t end, bool infinite) {
    if (begin == end) return;
    struct Task {
      std::uint32_t node;
      int depth;
    };
    std::vector<Task> tasks{{static_cast<std::uint32_t>(tree.nodes_.size()), 0}};
    tree.roots_.push_back(tasks.back().node);
    tree.nodes_.push_back(node(begin, end, infinite));
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      const Node parent = tree.nodes_[task.node];
      if (parent.is_leaf()) continue;
      const auto members = std::span(tree.order_).subspan(parent.begin, parent.end - parent.begin);
      const std::uint32_t middle =
          parent.begin + static_cast<std::uint32_t>(split(items, members, task.depth));
      const auto children = tree.nodes_[task.node].children = static_cast<std::uint32_t>(tree.nodes_.size());
      tree.nodes_.push_back(node(parent.begin, middle, infinite));
      tree.nodes_.push_back(node(middle, parent.end, infinite));
      for (const std::uint32_t child : {children, children + 1}) tasks.push_back({child, task.depth + 1});
    }
  }
};

LightTree::LightTree(std::span<const Light> lights) : order_(lights.size()), place_(lights.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  const auto infinite =
      std::ranges::stable_partition(order_, [&](std::uint32_t i) { return !is_infinite(lights[i]); });
  const auto finite_count = static_cast<std::uint32_t>(infinite.begin() - order_.begin()),
             count = static_cast<std::uint32_t>(order_.size());
  Builder builder{*this, {}};
  for (const Light& light : lights) builder.items.push_back(item_of(light));
  builder.grow(0, finite_count, false);
  builder.grow(finite_count, count, true);
  for (std::uint32_t i = 0; i < count; ++i) place_[order_[i]] = i;
}

}  // namespace sluice
