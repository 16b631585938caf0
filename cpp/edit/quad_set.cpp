// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/quad_set.h"

#include <algorithm>
#include <numeric>

namespace sluice {

namespace {

// Columns of the arrays.
enum : std::size_t { NX, NY, NZ, Offset, UX, UY, UZ, U0, SlackU, VX, VY, VZ, V0, SlackV };

constexpr std::size_t chunk = QuadSet::few;
constexpr std::size_t leaf_size = 4;

bool is_member(std::span<const std::uint64_t> members, int edit) noexcept {
  const auto e = static_cast<std::size_t>(edit);
  return members.empty() || (e / 64 < members.size() && ((members[e / 64] >> (e % 64)) & 1));
}

// Where the segment enters the box, or infinity. Roundings are relative to t, so widening the far end keeps every crossing (Ize 2013).
double enter_box(const V3d& low, const V3d& high, const V3d& origin, const V3d& inverse, double t_min, double t_max) noexcept {
  double near = t_min, far = t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const bool back = inverse[axis] < 0;
    const double t0 = ((back ? high : low)[axis] - origin[axis]) * inverse[axis];
    const double t1 = ((back ? low : high)[axis] - origin[axis]) * inverse[axis];
    if (t0 > near) near = t0;  // 0 · inf is NaN and narrows nothing
    if (t1 < far) far = t1;
  }
  return near <= far * (1 + 0x1p-48) ? near : std::numeric_limits<double>::infinity();
}

}  // namespace

void QuadSet::add(const Quad& q, const QuadId& id) {
  const double values[] = {q.plane_normal.x, q.plane_normal.y, q.plane_normal.z, q.plane_offset, q.dual_u.x, q.dual_u.y, q.dual_u.z,
                           q.u0,             q.slack_u,        q.dual_v.x,       q.dual_v.y,     q.dual_v.z, q.v0,       q.slack_v};
  for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i].push_back(values[i]);
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

void QuadSet::build() {
  nodes_.clear();
  if (size() <= few) return;
  std::vector<std::uint32_t> order(size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.push_back({{}, {}, 0, static_cast<std::uint32_t>(size())});
  for (std::size_t node = 0; node < nodes_.size(); ++node) split(node, order);
  permute(order);
}

// Halves a node at the median of its longest side until it is a leaf: depth is log2 of the number of quads.
void QuadSet::split(std::size_t node, std::vector<std::uint32_t>& order) {
  const std::uint32_t begin = nodes_[node].first, count = nodes_[node].count;
  const auto range = std::span(order).subspan(begin, count);
  V3d low(std::numeric_limits<double>::infinity()), high = -low;
  V3d low_middle = low, high_middle = high;
  for (const std::uint32_t q : range) {
    for (int axis = 0; axis < 3; ++axis) {
      const double middle = low_[q][axis] + high_[q][axis];
      low[axis] = std::min(low[axis], low_[q][axis]);
      high[axis] = std::max(high[axis], high_[q][axis]);
      low_middle[axis] = std::min(low_middle[axis], middle);
      high_middle[axis] = std::max(high_middle[axis], middle);
    }
  }
  nodes_[node].low = low;
  nodes_[node].high = high;
  if (count <= leaf_size) return;
  const V3d size = high_middle - low_middle;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::uint32_t half = count / 2;
  std::nth_element(range.begin(), range.begin() + half, range.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double ma = low_[a][axis] + high_[a][axis], mb = low_[b][axis] + high_[b][axis];
    return ma < mb || (ma == mb && a < b);
  });
  nodes_[node].first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].count = 0;
  nodes_.push_back({{}, {}, begin, half});
  nodes_.push_back({{}, {}, begin + half, count - half});
}

void QuadSet::permute(const std::vector<std::uint32_t>& order) {
  const auto sort = [&order](auto& values) {
    auto old = values;
    for (std::size_t i = 0; i < order.size(); ++i) values[i] = old[order[i]];
  };
  for (auto& column : columns_) sort(column);
  sort(group_);
  sort(order_);
  sort(id_);
  sort(low_);
  sort(high_);
}

// The formula of quad.cpp's intersect(), operation by operation, so that every quad of a plane group gets the same bits for t.
template <class Found>
void QuadSet::scan(const Segment& segment, double& t_max, std::size_t begin, std::size_t end, const Found& found) const noexcept {
  const V3d o = segment.origin, d = segment.direction;
  for (std::size_t base = begin; base < end; base += chunk) {
    const std::size_t n = std::min(chunk, end - base);
    const auto at = [&](std::size_t column) { return columns_[column].data() + base; };
    const double *nx = at(NX), *ny = at(NY), *nz = at(NZ), *offset = at(Offset), *slack_u = at(SlackU), *slack_v = at(SlackV);
    const double *ux = at(UX), *uy = at(UY), *uz = at(UZ), *u0 = at(U0), *vx = at(VX), *vy = at(VY), *vz = at(VZ), *v0 = at(V0);
    double hit_t[chunk], hit_u[chunk], hit_v[chunk];
    const double t_min = segment.t_min, t_end = t_max;
    for (std::size_t i = 0; i < n; ++i) {
      const double cosine = nx[i] * d.x + ny[i] * d.y + nz[i] * d.z;
      const double t = (offset[i] - (nx[i] * o.x + ny[i] * o.y + nz[i] * o.z)) / cosine;
      const double x = o.x + t * d.x, y = o.y + t * d.y, z = o.z + t * d.z;
      const double u = ux[i] * x + uy[i] * y + uz[i] * z - u0[i];
      const double v = vx[i] * x + vy[i] * y + vz[i] * z - v0[i];
      const bool hit = (std::abs(cosine) >= least_cosine) & (t > t_min) & (t <= t_end) & (u >= -slack_u[i]) & (u <= 1 + slack_u[i]) & (v >= -slack_v[i]) &
                       (v <= 1 + slack_v[i]);
      hit_t[i] = hit ? t : std::numeric_limits<double>::infinity();
      hit_u[i] = u;
      hit_v[i] = v;
    }
    for (std::size_t i = 0; i < n; ++i)
      if (hit_t[i] <= t_max && hit_t[i] < std::numeric_limits<double>::infinity() && group_[base + i] != segment.excluded_group)
        found(base + i, hit_t[i], V2d(std::clamp(hit_u[i], 0.0, 1.0), std::clamp(hit_v[i], 0.0, 1.0)));
  }
}

template <class Found>
void QuadSet::search(const Segment& segment, double& t_max, const Found& found) const noexcept {
  if (nodes_.empty()) return scan(segment, t_max, 0, size(), found);
  const V3d& d = segment.direction;
  const V3d inverse(1 / d.x, 1 / d.y, 1 / d.z);
  const auto enter = [&](const Node& node) { return enter_box(node.low, node.high, segment.origin, inverse, segment.t_min, t_max); };
  struct Open {
    std::uint32_t node;
    double near;
  };
  Open stack[64];
  int count = 0;
  if (const double near = enter(nodes_[0]); near < std::numeric_limits<double>::infinity()) stack[count++] = {0, near};
  while (count > 0) {
    const Open open = stack[--count];
    if (open.near > t_max) continue;
    const Node& node = nodes_[open.node];
    if (node.count > 0) {
      scan(segment, t_max, node.first, node.first + node.count, found);
      continue;
    }
    Open a{node.first, enter(nodes_[node.first])}, b{node.first + 1, enter(nodes_[node.first + 1])};
    if (a.near < b.near) std::swap(a, b);  // the nearer one is popped first
    if (a.near < std::numeric_limits<double>::infinity()) stack[count++] = a;
    if (b.near < std::numeric_limits<double>::infinity()) stack[count++] = b;
  }
}

Crossing QuadSet::first(const Segment& segment, std::span<const std::uint64_t> members) const noexcept {
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

bool QuadSet::any(const Segment& segment, std::span<const std::uint64_t> members) const noexcept {
  bool hit = false;
  double t_max = segment.t_max;
  search(segment, t_max, [&](std::size_t i, double, const V2d&) {
    if (!is_member(members, id_[i].edit)) return;
    hit = true;
    t_max = -std::numeric_limits<double>::infinity();  // ends the search
  });
  return hit;
}

void QuadSet::all(const Segment& segment, std::span<const std::uint64_t> members, std::vector<Crossing>& out) const {
  double t_max = segment.t_max;
  search(segment, t_max, [&](std::size_t i, double t, const V2d& uv) {
    if (is_member(members, id_[i].edit)) out.push_back({t, uv, id_[i].edit, id_[i].exit, group_[i], order_[i]});
  });
}

}  // namespace sluice
