// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/quad_set.h"

#include <algorithm>
#include <numeric>

namespace sluice {

namespace {

constexpr std::size_t leaf_size = 4;  // most quads are missed: a box is cheaper than its quads

// No members at all: every edit is meant.
bool is_member(EditSet members, int edit) noexcept { return members.empty() || contains(members, edit); }

// Halves a range at the median of the longest side of its middles.
std::size_t halve(std::span<std::uint32_t> range, const std::vector<V3d>& low, const std::vector<V3d>& high) {
  const auto middle = [&](std::uint32_t q) { return low[q] + high[q]; };
  V3d least = middle(range[0]), most = least;
  for (const std::uint32_t q : range) {
    const V3d m = middle(q);
    for (int axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], m[axis]);
      most[axis] = std::max(most[axis], m[axis]);
    }
  }
  const V3d size = most - least;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto half = static_cast<std::ptrdiff_t>(range.size() / 2);
  std::nth_element(range.begin(), range.begin() + half, range.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double ma = middle(a)[axis], mb = middle(b)[axis];
    return ma < mb || (ma == mb && a < b);
  });
  return range.size() / 2;
}

}  // namespace

void QuadSet::add(const Quad& q, const QuadId& id) {
  tests_.push_back({q.plane_normal, q.plane_offset, q.dual_u, q.u0, q.slack_u, q.dual_v, q.v0, q.slack_v});
  group_.push_back(q.group);
  order_.push_back(q.order);
  id_.push_back(id);
  V3d low = q.corner, high = q.corner;
  for (const V3d& p : {q.point({1, 0}), q.point({0, 1}), q.point({1, 1})})
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  low_.push_back(low - V3d(16 * q.slack));
  high_.push_back(high + V3d(16 * q.slack));
}

std::size_t QuadSet::bytes() const noexcept {
  return size() * (sizeof(Test) + 2 * sizeof(int) + sizeof(QuadId) + 2 * sizeof(V3d)) + nodes_.size() * sizeof(Node);
}

void QuadSet::build() {
  nodes_.clear();
  if (size() <= leaf_size) return;
  std::vector<std::uint32_t> order(size());
  std::iota(order.begin(), order.end(), 0u);
  (void)make_node(order, 0);
  permute(order);
}

// Three halvings make eight children; depth is log8 of the number of quads.
std::uint32_t QuadSet::make_node(std::span<std::uint32_t> range, std::uint32_t begin) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  std::vector<std::span<std::uint32_t>> parts{range};
  for (int level = 0; level < 3; ++level) {
    std::vector<std::span<std::uint32_t>> halves;
    for (const auto& part : parts) {
      if (part.size() <= leaf_size) {
        halves.push_back(part);
        continue;
      }
      const std::size_t half = halve(part, low_, high_);
      halves.push_back(part.first(half));
      halves.push_back(part.subspan(half));
    }
    parts = std::move(halves);
  }
  Node node;
  for (std::size_t child = 0; child < Node::width; ++child) {
    const auto part = child < parts.size() ? parts[child] : std::span<std::uint32_t>();
    for (int axis = 0; axis < 3; ++axis) {
      double low = std::numeric_limits<double>::infinity(), high = -low;  // of no quads: a box that nothing enters
      for (const std::uint32_t q : part) {
        low = std::min(low, low_[q][axis]);
        high = std::max(high, high_[q][axis]);
      }
      node.low[axis][child] = low;
      node.high[axis][child] = high;
    }
    const bool is_leaf = part.size() <= leaf_size;
    node.first[child] = is_leaf ? begin : make_node(part, begin);
    node.count[child] = is_leaf ? static_cast<std::uint32_t>(part.size()) : 0;
    begin += static_cast<std::uint32_t>(part.size());
  }
  nodes_[number] = node;
  return number;
}

void QuadSet::permute(const std::vector<std::uint32_t>& order) {
  const auto sort = [&order](auto& values) {
    auto old = values;
    for (std::size_t i = 0; i < order.size(); ++i) values[i] = old[order[i]];
  };
  sort(tests_);
  sort(group_);
  sort(order_);
  sort(id_);
  sort(low_);
  sort(high_);
}

// The formula of quad.cpp's intersect(), operation by operation, so that every quad of a plane group gets the same bits for t. Most quads
// are missed by the first comparison: leaving early costs less than testing several side by side.
template <class Found>
void QuadSet::scan(const Segment& segment, double& t_max, std::size_t begin, std::size_t end, const Found& found) const noexcept {
  const V3d o = segment.origin, d = segment.direction;
  for (std::size_t i = begin; i < end; ++i) {
    const Test& q = tests_[i];
    const double cosine = q.normal.x * d.x + q.normal.y * d.y + q.normal.z * d.z;
    const double t = (q.offset - (q.normal.x * o.x + q.normal.y * o.y + q.normal.z * o.z)) / cosine;
    if (!(std::abs(cosine) >= least_cosine && t > segment.t_min && t <= t_max)) continue;
    const double x = o.x + t * d.x, y = o.y + t * d.y, z = o.z + t * d.z;
    const double u = q.dual_u.x * x + q.dual_u.y * y + q.dual_u.z * z - q.u0;
    if (!(u >= -q.slack_u && u <= 1 + q.slack_u)) continue;
    const double v = q.dual_v.x * x + q.dual_v.y * y + q.dual_v.z * z - q.v0;
    if (!(v >= -q.slack_v && v <= 1 + q.slack_v) || group_[i] == segment.excluded_group || !(t < std::numeric_limits<double>::infinity())) continue;
    found(i, t, V2d(std::clamp(u, 0.0, 1.0), std::clamp(v, 0.0, 1.0)));
  }
}

// Boxes are entered conservatively: roundings are relative to t, so widening the far end keeps every crossing (Ize 2013).
template <class Found>
void QuadSet::search(const Segment& segment, double& t_max, const Found& found) const noexcept {
  if (nodes_.empty()) return scan(segment, t_max, 0, size(), found);
  constexpr double never = std::numeric_limits<double>::infinity();
  const V3d o = segment.origin, inverse(1 / segment.direction.x, 1 / segment.direction.y, 1 / segment.direction.z);
  struct Open {
    std::uint32_t first, count;
    double near;
  };
  Open stack[Node::width * 12];  // 8^12 quads
  std::size_t open = 0;
  stack[open++] = {0, 0, segment.t_min};
  while (open > 0) {
    const Open next = stack[--open];
    if (next.near > t_max) continue;
    if (next.count > 0) {
      scan(segment, t_max, next.first, next.first + next.count, found);
      continue;
    }
    const Node& node = nodes_[next.first];
    double near[Node::width], far[Node::width];
    std::fill(near, near + Node::width, segment.t_min);
    std::fill(far, far + Node::width, t_max);
    for (int axis = 0; axis < 3; ++axis) {
      const double *enter = inverse[axis] < 0 ? node.high[axis] : node.low[axis], *leave = inverse[axis] < 0 ? node.low[axis] : node.high[axis];
      for (std::size_t c = 0; c < Node::width; ++c) {
        const double t0 = (enter[c] - o[axis]) * inverse[axis], t1 = (leave[c] - o[axis]) * inverse[axis];
        near[c] = t0 > near[c] ? t0 : near[c];  // 0 · inf is NaN and narrows nothing
        far[c] = t1 < far[c] ? t1 : far[c];
      }
    }
    const std::size_t base = open;
    for (std::size_t c = 0; c < Node::width; ++c) {
      if (!(near[c] <= far[c] * (1 + 0x1p-48)) || near[c] == never) continue;
      std::size_t at = open++;  // the nearest is popped first
      for (; at > base && stack[at - 1].near < near[c]; --at) stack[at] = stack[at - 1];
      stack[at] = {node.first[c], node.count[c], near[c]};
    }
  }
}

Crossing QuadSet::first(const Segment& segment, EditSet members) const noexcept {
  Crossing best;
  double t_max = segment.t_max;
  search(segment, t_max, [&](std::size_t i, double t, const V2d& uv) {
    const QuadId& id = id_[i];
    if (!is_member(members, id.edit)) return;
    const bool lower = order_[i] != best.order ? order_[i] < best.order : id.edit < best.edit;
    if (best.edit >= 0 && (t > best.t || (t == best.t && !lower))) return;
    best = {t, uv, id.edit, id.exit, group_[i], order_[i]};
    t_max = t;
  });
  return best;
}

bool QuadSet::any(const Segment& segment, EditSet members) const noexcept {
  bool hit = false;
  double t_max = segment.t_max;
  search(segment, t_max, [&](std::size_t i, double, const V2d&) {
    if (!is_member(members, id_[i].edit)) return;
    hit = true;
    t_max = -std::numeric_limits<double>::infinity();  // ends the search
  });
  return hit;
}

void QuadSet::all(const Segment& segment, EditSet members, std::vector<Crossing>& out) const {
  double t_max = segment.t_max;
  search(segment, t_max, [&](std::size_t i, double t, const V2d& uv) {
    if (is_member(members, id_[i].edit)) out.push_back({t, uv, id_[i].edit, id_[i].exit, group_[i], order_[i]});
  });
}

}  // namespace sluice
