// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/quad_set.h"

#include <algorithm>
#include <bit>
#include <numeric>

#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#endif

namespace sluice {

namespace {

constexpr std::size_t loop_size = 2;   // so few are tested as fast without spheres
constexpr std::size_t leaf_size = 16;  // under a box
// of boxes and spheres, relative to that of all: more than floats round away between a ray and a box
constexpr double widening = 0x1p-19;
constexpr double no_cone = -1;
// of the squared distance between a ray and a middle, relative to that of the ray's origin
constexpr float rounding = 0x1p-19f;

// No members at all: every edit is meant.
bool is_member(EditSet members, int edit) noexcept { return members.empty() || contains(members, edit); }

// Halves a range at the median of the longest side of its middles.
std::size_t halve(std::span<std::uint32_t> range, const std::vector<V3d>& low, const std::vector<V3d>& high) {
  const auto middle = [&](std::uint32_t q) { return low[q] + high[q]; };
  V3d min_corner = middle(range[0]), max_corner = min_corner;
  for (const std::uint32_t q : range) {
    const V3d m = middle(q);
    for (int axis = 0; axis < 3; ++axis) {
      min_corner[axis] = std::min(min_corner[axis], m[axis]);
      max_corner[axis] = std::max(max_corner[axis], m[axis]);
    }
  }
  const V3d size = max_corner - min_corner;
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
  return size() * (sizeof(Test) + 2 * sizeof(int) + sizeof(QuadId)) + low_.size() * 2 * sizeof(V3d) +
         octets_.size() * sizeof(Octet) + nodes_.size() * sizeof(Node);
}

void QuadSet::build() {
  if (size() <= loop_size) return;
  V3d min_corner = low_[0], max_corner = high_[0];
  for (std::size_t q = 1; q < size(); ++q)
    for (int axis = 0; axis < 3; ++axis) {
      min_corner[axis] = std::min(min_corner[axis], low_[q][axis]);
      max_corner[axis] = std::max(max_corner[axis], high_[q][axis]);
    }
  const V3d size_of_all = max_corner - min_corner;
  const double wider = widening * std::max({size_of_all.x, size_of_all.y, size_of_all.z});
  for (V3d& low : low_) low -= V3d(wider);
  for (V3d& high : high_) high += V3d(wider);
  middle_ = (min_corner + max_corner) / 2, half_ = size_of_all / 2 + V3d(wider);
  std::vector<std::uint32_t> all(size());
  std::iota(all.begin(), all.end(), 0u);
  root_ = size() <= few ? make_leaf(all) : make_node(all);
  sort_by_octets();
  low_ = high_ = {};
}

std::int32_t QuadSet::make_leaf(std::span<const std::uint32_t> range) {
  const auto number = ~static_cast<std::int32_t>(octets_.size());
  for (std::size_t begin = 0; begin < range.size(); begin += width) {
    const auto part = range.subspan(begin, std::min(width, range.size() - begin));
    Octet octet{};
    octet.first = static_cast<std::uint32_t>(sorted_.size());
    octet.count = static_cast<std::uint32_t>(part.size());
    octet.ends_leaf = begin + width >= range.size();
    for (std::size_t i = 0; i < part.size(); ++i) {
      const V3d centre = (low_[part[i]] + high_[part[i]]) / 2 - middle_;
      for (int axis = 0; axis < 3; ++axis) octet.centre[axis][i] = static_cast<float>(centre[axis]);
      octet.radius[i] = static_cast<float>((high_[part[i]] - low_[part[i]]).length() / 2);
    }
    octets_.push_back(octet);
    sorted_.insert(sorted_.end(), part.begin(), part.end());
  }
  return number;
}

// Three halvings make eight children; depth is log8 of the number of leaves.
std::int32_t QuadSet::make_node(std::span<std::uint32_t> range) {
  const auto number = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  std::vector<std::span<std::uint32_t>> parts{range};
  for (int level = 0; level < 3; ++level) {
    std::vector<std::span<std::uint32_t>> halves;
    for (const auto& part : parts) {
      const std::size_t half = part.size() > width ? halve(part, low_, high_) : 0;
      if (half > 0) halves.push_back(part.first(half));
      halves.push_back(part.subspan(half));
    }
    parts = std::move(halves);
  }
  Node node{};
  for (std::size_t c = 0; c < width; ++c) {
    const auto part = c < parts.size() ? parts[c] : std::span<std::uint32_t>();
    for (int axis = 0; axis < 3; ++axis) {
      // of no quads: a box that nothing enters
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const std::uint32_t q : part) {
        low = std::min(low, low_[q][axis]);
        high = std::max(high, high_[q][axis]);
      }
      node.bounds[axis][c] = static_cast<float>(low - middle_[axis]);
      node.bounds[3 + axis][c] = static_cast<float>(high - middle_[axis]);
    }
    node.child[c] = part.size() > leaf_size ? make_node(part) : part.empty() ? ~0 : make_leaf(part);
  }
  nodes_[static_cast<std::size_t>(number)] = node;
  return number;
}

void QuadSet::sort_by_octets() {
  const auto sort = [&](auto& list) {
    auto sorted = list;
    for (std::size_t i = 0; i < size(); ++i) sorted[i] = list[sorted_[i]];
    list = std::move(sorted);
  };
  sort(tests_), sort(group_), sort(order_), sort(id_);
  sorted_ = {};
}

// The formula of quad.cpp's intersect(), operation by operation, so that every quad of a plane group gets the
// same bits for t. Most quads are missed by the first comparison: leaving early costs less than testing
// several side by side.
template <class Found>
void QuadSet::test(const Segment& segment, double t_max, std::size_t i, const Found& found) const noexcept {
  const V3d o = segment.origin, d = segment.direction;
  const Test& q = tests_[i];
  const double cosine = q.normal.x * d.x + q.normal.y * d.y + q.normal.z * d.z;
  const double t = (q.offset - (q.normal.x * o.x + q.normal.y * o.y + q.normal.z * o.z)) / cosine;
  if (!(std::abs(cosine) >= min_crossing_cosine && t > segment.t_min && t <= t_max)) return;
  const double x = o.x + t * d.x, y = o.y + t * d.y, z = o.z + t * d.z;
  const double u = q.dual_u.x * x + q.dual_u.y * y + q.dual_u.z * z - q.u0;
  if (!(u >= -q.slack_u && u <= 1 + q.slack_u)) return;
  const double v = q.dual_v.x * x + q.dual_v.y * y + q.dual_v.z * z - q.v0;
  if (!(v >= -q.slack_v && v <= 1 + q.slack_v) || group_[i] == segment.excluded_group ||
      !(t < std::numeric_limits<double>::infinity()))
    return;
  found(i, t, V2d(std::clamp(u, 0.0, 1.0), std::clamp(v, 0.0, 1.0)));
}

// A ray relative to the middle of all quads, or a cone round it, in floats.
struct QuadSet::Probe {
  // 1 / |direction|²: a direction in floats is a unit one only nearly
  float origin[3], direction[3], per_length2;
  float radius = 0, slope = 0;                     // of the cone, at the origin; by which it loses radius
  float inverse[3], from_enter[3], from_leave[3];  // these are for boxes alone
  std::size_t enter[3], leave[3];                  // by which of a box's bounds

  Probe(const V3d& from, const V3d& towards) noexcept
      : per_length2(static_cast<float>(1 / towards.length2())) {
    for (int axis = 0; axis < 3; ++axis)
      origin[axis] = static_cast<float>(from[axis]), direction[axis] = static_cast<float>(towards[axis]);
  }
  // To the cone of segments with one end, of which one is this; it began `start` before the origin. A point p
  // of another lies within slope · (length - along(p)) of the axis, slope = k / (1 - k), k = first_radius /
  // length, and along(p) >= along(centre) - radius for a sphere that holds it. A cone as wide as it is long
  // is taken for a cylinder.
  void widen(double first_radius, double length, double start) noexcept {
    const double k = first_radius / length;
    slope = k < 0.5 ? static_cast<float>(k / (1 - k)) : 0;
    const double here = k < 0.5 ? static_cast<double>(slope) * (length - start) : first_radius;
    radius = static_cast<float>(here + (first_radius + length) * static_cast<double>(rounding));
  }
  void prepare_for_boxes() noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      inverse[axis] = 1 / direction[axis];
      const float wider = std::copysign(radius, inverse[axis]);
      enter[axis] = inverse[axis] < 0 ? 3 + axis : axis, from_enter[axis] = origin[axis] + wider;
      leave[axis] = inverse[axis] < 0 ? axis : 3 + axis, from_leave[axis] = origin[axis] - wider;
    }
  }

  // Spheres that its line meets, or the cone, a bit for each. (Numbers that overflow make NaN, which is not
  // greater.)
  [[nodiscard]] unsigned meets(const Octet& octet) const noexcept {
#if defined(__AVX2__) && defined(__FMA__)
    __m256 along = _mm256_setzero_ps(), away2 = _mm256_setzero_ps();
    for (int axis = 0; axis < 3; ++axis) {
      const __m256 to = _mm256_sub_ps(_mm256_load_ps(octet.centre[axis]), _mm256_set1_ps(origin[axis]));
      along = _mm256_fmadd_ps(to, _mm256_set1_ps(direction[axis]), along);
      away2 = _mm256_fmadd_ps(to, to, away2);
    }
    const __m256 sphere = _mm256_load_ps(octet.radius),
                 cone = _mm256_fmadd_ps(_mm256_sub_ps(sphere, along), _mm256_set1_ps(slope),
                                        _mm256_set1_ps(radius));
    const __m256 reach = _mm256_add_ps(sphere, _mm256_max_ps(cone, _mm256_setzero_ps()));
    const __m256 most = _mm256_fmadd_ps(away2, _mm256_set1_ps(rounding), _mm256_mul_ps(reach, reach));
    const __m256 distance2 =
        _mm256_fnmadd_ps(_mm256_mul_ps(along, _mm256_set1_ps(per_length2)), along, away2);
    const auto met = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(distance2, most, _CMP_NGT_UQ)));
#else
    unsigned met = 0;
    for (std::size_t c = 0; c < width; ++c) {
      float along = 0, away2 = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const float to = octet.centre[axis][c] - origin[axis];
        along += to * direction[axis], away2 += to * to;
      }
      const float reach = octet.radius[c] + std::max((octet.radius[c] - along) * slope + radius, 0.0f);
      met |= (away2 - along * per_length2 * along > reach * reach + away2 * rounding ? 0u : 1u) << c;
    }
#endif
    return met & ((1u << octet.count) - 1);
  }

  // Children of a node that are met on [0, t_end], a bit for each. 0 · inf is NaN and narrows nothing.
  [[nodiscard]] unsigned enters(const Node& node, float t_end) const noexcept {
#if defined(__AVX2__) && defined(__FMA__)
    __m256 near = _mm256_setzero_ps(), far = _mm256_set1_ps(t_end);
    for (int axis = 0; axis < 3; ++axis) {
      const __m256 i = _mm256_set1_ps(inverse[axis]);
      near = _mm256_max_ps(
          _mm256_mul_ps(
              _mm256_sub_ps(_mm256_load_ps(node.bounds[enter[axis]]), _mm256_set1_ps(from_enter[axis])), i),
          near);
      far = _mm256_min_ps(
          _mm256_mul_ps(
              _mm256_sub_ps(_mm256_load_ps(node.bounds[leave[axis]]), _mm256_set1_ps(from_leave[axis])), i),
          far);
    }
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(near, far, _CMP_LE_OQ)));
#else
    unsigned met = 0;
    for (std::size_t c = 0; c < width; ++c) {
      float near = 0, far = t_end;
      for (int axis = 0; axis < 3; ++axis) {
        const float t0 = (node.bounds[enter[axis]][c] - from_enter[axis]) * inverse[axis],
                    t1 = (node.bounds[leave[axis]][c] - from_leave[axis]) * inverse[axis];
        near = t0 > near ? t0 : near;
        far = t1 < far ? t1 : far;
      }
      met |= (near <= far ? 1u : 0u) << c;
    }
    return met;
#endif
  }
};

template <class Act>
void QuadSet::visit(const Segment& segment, double radius, const double& t_max, const Act& act) const {
  if (octets_.empty()) {
    for (std::size_t i = 0; i < size(); ++i) act(i);
    return;
  }
  V3d from = segment.origin - middle_;
  double start = segment.t_min;
  if (root_ >= 0) {  // from where it enters the box of all, so that floats are as exact as that box is small
    double end = t_max;
    for (int axis = 0; axis < 3; ++axis) {
      const double inverse = 1 / segment.direction[axis],
                   half = std::copysign(half_[axis] + std::max(radius, 0.0), inverse),
                   near = (-half - from[axis]) * inverse, far = (half - from[axis]) * inverse;
      start = near > start ? near : start;
      end = far < end ? far : end;
    }
    if (!(start <= end)) return;
    from += start * segment.direction;
  }
  Probe probe(from, segment.direction);
  if (radius >= 0) probe.widen(radius, segment.t_max, start);
  if (root_ >= 0) probe.prepare_for_boxes();
  std::int32_t stack[width * 12];  // 8^12 quads
  std::size_t open = 0;
  stack[open++] = root_;
  while (open > 0 && t_max > segment.t_min) {
    const std::int32_t next = stack[--open];
    if (next >= 0) {
      const Node& node = nodes_[static_cast<std::size_t>(next)];
      for (unsigned met = probe.enters(node, static_cast<float>(t_max - start)); met; met &= met - 1)
        stack[open++] = node.child[std::countr_zero(met)];
    } else {
      for (const Octet* octet = &octets_[static_cast<std::size_t>(~next)];; ++octet) {
        for (unsigned met = probe.meets(*octet); met; met &= met - 1)
          act(octet->first + static_cast<std::size_t>(std::countr_zero(met)));
        if (octet->ends_leaf || !(t_max > segment.t_min)) break;
      }
    }
  }
}

template <class Found>
void QuadSet::search(const Segment& segment, double& t_max, const Found& found) const noexcept {
  visit(segment, no_cone, t_max, [&](std::size_t i) { test(segment, t_max, i, found); });
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

bool QuadSet::in_cone(const Segment& segment, double radius, EditSet members, std::size_t max_count,
                      std::vector<std::uint32_t>& out) const {
  double t_max = segment.t_max;
  visit(segment, radius, t_max, [&](std::size_t i) {
    if (!is_member(members, id_[i].edit)) return;
    out.push_back(static_cast<std::uint32_t>(i));
    if (out.size() > max_count) t_max = -std::numeric_limits<double>::infinity();  // ends the search
  });
  return out.size() <= max_count;
}

bool QuadSet::any_of(std::span<const std::uint32_t> numbers, const Segment& segment) const noexcept {
  bool hit = false;
  for (const std::uint32_t i : numbers)
    test(segment, segment.t_max, i, [&](std::size_t, double, const V2d&) { hit = true; });
  return hit;
}

void QuadSet::all(const Segment& segment, EditSet members, std::vector<Crossing>& out) const {
  double t_max = segment.t_max;
  search(segment, t_max, [&](std::size_t i, double t, const V2d& uv) {
    if (is_member(members, id_[i].edit))
      out.push_back({t, uv, id_[i].edit, id_[i].exit, group_[i], order_[i]});
  });
}

}  // namespace sluice
