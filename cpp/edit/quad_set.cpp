// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/quad_set.h"

#include <algorithm>
#include <bit>
#include <numeric>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace sluice {

namespace {

constexpr std::size_t loop_size = 4;  // so few are tested as fast without boxes
constexpr double widening = 0x1p-19;  // of boxes, relative to that of all: more than floats round away between a ray and a box

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
  return size() * (sizeof(Test) + 2 * sizeof(int) + sizeof(QuadId)) + low_.size() * 2 * sizeof(V3d) + nodes_.size() * sizeof(Node);
}

void QuadSet::build() {
  nodes_.clear();
  if (size() <= loop_size) return;
  V3d least = low_[0], most = high_[0];
  for (std::size_t q = 1; q < size(); ++q)
    for (int axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], low_[q][axis]);
      most[axis] = std::max(most[axis], high_[q][axis]);
    }
  const V3d size_of_all = most - least;
  const double wider = widening * std::max({size_of_all.x, size_of_all.y, size_of_all.z});
  for (V3d& low : low_) low -= V3d(wider);
  for (V3d& high : high_) high += V3d(wider);
  middle_ = (least + most) / 2, half_ = size_of_all / 2 + V3d(wider);
  std::vector<std::uint32_t> order(size());
  std::iota(order.begin(), order.end(), 0u);
  (void)make_node(order);
  low_ = high_ = {};
}

// Three halvings make eight children; depth is log8 of the number of quads.
std::int32_t QuadSet::make_node(std::span<std::uint32_t> range) {
  const auto number = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  std::vector<std::span<std::uint32_t>> parts{range};
  for (int level = 0; level < 3; ++level) {
    std::vector<std::span<std::uint32_t>> halves;
    for (const auto& part : parts) {
      const std::size_t half = part.size() > 1 ? halve(part, low_, high_) : 0;
      if (half > 0) halves.push_back(part.first(half));
      halves.push_back(part.subspan(half));
    }
    parts = std::move(halves);
  }
  Node node;
  for (std::size_t c = 0; c < Node::width; ++c) {
    const auto part = c < parts.size() ? parts[c] : std::span<std::uint32_t>();
    for (int axis = 0; axis < 3; ++axis) {
      double low = std::numeric_limits<double>::infinity(), high = -low;  // of no quads: a box that nothing enters
      for (const std::uint32_t q : part) {
        low = std::min(low, low_[q][axis]);
        high = std::max(high, high_[q][axis]);
      }
      node.low[axis][c] = static_cast<float>(low - middle_[axis]);
      node.high[axis][c] = static_cast<float>(high - middle_[axis]);
    }
    node.child[c] = part.size() > 1 ? make_node(part) : part.empty() ? 0 : ~static_cast<std::int32_t>(part[0]);
  }
  nodes_[static_cast<std::size_t>(number)] = node;
  return number;
}

// The formula of quad.cpp's intersect(), operation by operation, so that every quad of a plane group gets the same bits for t. Most quads
// are missed by the first comparison: leaving early costs less than testing several side by side.
template <class Found>
void QuadSet::test(const Segment& segment, double t_max, std::size_t i, const Found& found) const noexcept {
  const V3d o = segment.origin, d = segment.direction;
  const Test& q = tests_[i];
  const double cosine = q.normal.x * d.x + q.normal.y * d.y + q.normal.z * d.z;
  const double t = (q.offset - (q.normal.x * o.x + q.normal.y * o.y + q.normal.z * o.z)) / cosine;
  if (!(std::abs(cosine) >= least_cosine && t > segment.t_min && t <= t_max)) return;
  const double x = o.x + t * d.x, y = o.y + t * d.y, z = o.z + t * d.z;
  const double u = q.dual_u.x * x + q.dual_u.y * y + q.dual_u.z * z - q.u0;
  if (!(u >= -q.slack_u && u <= 1 + q.slack_u)) return;
  const double v = q.dual_v.x * x + q.dual_v.y * y + q.dual_v.z * z - q.v0;
  if (!(v >= -q.slack_v && v <= 1 + q.slack_v) || group_[i] == segment.excluded_group || !(t < std::numeric_limits<double>::infinity())) return;
  found(i, t, V2d(std::clamp(u, 0.0, 1.0), std::clamp(v, 0.0, 1.0)));
}

// A segment inside the box of all quads, in floats: it starts where it enters, so that floats are as exact as that box is small.
struct QuadSet::Ray {
  float origin[3], inverse[3];
  // Children of a node that are met on [0, t_end], a bit for each. 0 · inf is NaN and narrows nothing.
  [[nodiscard]] unsigned enters(const Node& node, float t_end) const noexcept {
#if defined(__AVX2__)
    __m256 near = _mm256_setzero_ps(), far = _mm256_set1_ps(t_end);
    for (int axis = 0; axis < 3; ++axis) {
      const float *enter = inverse[axis] < 0 ? node.high[axis] : node.low[axis], *leave = inverse[axis] < 0 ? node.low[axis] : node.high[axis];
      const __m256 o = _mm256_set1_ps(origin[axis]), i = _mm256_set1_ps(inverse[axis]);
      near = _mm256_max_ps(_mm256_mul_ps(_mm256_sub_ps(_mm256_load_ps(enter), o), i), near);
      far = _mm256_min_ps(_mm256_mul_ps(_mm256_sub_ps(_mm256_load_ps(leave), o), i), far);
    }
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(near, far, _CMP_LE_OQ)));
#else
    unsigned met = 0;
    for (std::size_t c = 0; c < Node::width; ++c) {
      float near = 0, far = t_end;
      for (int axis = 0; axis < 3; ++axis) {
        const bool back = inverse[axis] < 0;
        const float t0 = ((back ? node.high : node.low)[axis][c] - origin[axis]) * inverse[axis], t1 = ((back ? node.low : node.high)[axis][c] - origin[axis]) * inverse[axis];
        near = t0 > near ? t0 : near;
        far = t1 < far ? t1 : far;
      }
      met |= (near <= far ? 1u : 0u) << c;
    }
    return met;
#endif
  }
};

template <class Found>
void QuadSet::search(const Segment& segment, double& t_max, const Found& found) const noexcept {
  if (nodes_.empty()) {
    for (std::size_t i = 0; i < size(); ++i) test(segment, t_max, i, found);
    return;
  }
  double start = segment.t_min, end = t_max;
  const V3d from = segment.origin - middle_;
  for (int axis = 0; axis < 3; ++axis) {
    const double inverse = 1 / segment.direction[axis], near = (-std::copysign(half_[axis], inverse) - from[axis]) * inverse, far = (std::copysign(half_[axis], inverse) - from[axis]) * inverse;
    start = near > start ? near : start;
    end = far < end ? far : end;
  }
  if (!(start <= end)) return;
  Ray ray;
  for (int axis = 0; axis < 3; ++axis) {
    ray.origin[axis] = static_cast<float>(from[axis] + start * segment.direction[axis]);
    ray.inverse[axis] = 1 / static_cast<float>(segment.direction[axis]);
  }
  std::int32_t stack[Node::width * 12];  // 8^12 quads
  std::size_t open = 0;
  stack[open++] = 0;
  while (open > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[--open])];
    for (unsigned met = ray.enters(node, static_cast<float>(t_max - start)); met; met &= met - 1) {
      const std::int32_t child = node.child[std::countr_zero(met)];
      if (child >= 0)
        stack[open++] = child;
      else
        test(segment, t_max, static_cast<std::size_t>(~child), found);
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
