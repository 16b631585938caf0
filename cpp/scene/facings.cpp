// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/facings.h"

#include <algorithm>
#include <cmath>

namespace sluice {
namespace {

// Of max(0, cosine) over a disk of normals that stands on edge, the root of the mean square is 0.35 of the
// disk's sine: what may be seen of a group there, by the second moment, as that has the least variance. Twice
// it rounds off the corner of max(0, cosine).
constexpr float roundness = 0.7f;
// a closed surface is seen through where it is transparent, and from within
constexpr float min_part = 0.03f;

}  // namespace

int Facings::bin_of(const V3f& n) noexcept {
  const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
  return axis * 8 + (n[axis] < 0) * 4 + (n[(axis + 1) % 3] < 0) * 2 + (n[(axis + 2) % 3] < 0);
}

Facings::Facings(std::span<const EmissiveTriangle> triangles, std::size_t mesh_triangles, int front)
    : of_(mesh_triangles), front_(front) {
  double all = 0, before = 0;
  for (const EmissiveTriangle& t : triangles) all += static_cast<double>(t.light);
  for (std::size_t begin = 0; begin < triangles.size();) {
    const int bin = bin_of(triangles[begin].normal);
    std::size_t end = begin;
    while (end < triangles.size() && bin_of(triangles[end].normal) == bin) ++end;
    const auto members = triangles.subspan(begin, end - begin);
    double light = 0;
    for (const EmissiveTriangle& t : members)
      of_[t.triangle] = static_cast<std::uint8_t>(groups_.size()), light += static_cast<double>(t.light);
    Group& group = groups_.emplace_back(group_of(members));
    group.before = before / all, group.share = light / all;
    before += light, begin = end;
  }
}

Facings::Group Facings::group_of(std::span<const EmissiveTriangle> triangles) {
  V3d normals(0), middle(0);
  double area = 0;
  for (const EmissiveTriangle& t : triangles) {
    normals += V3d(t.normal) * t.area, area += static_cast<double>(t.area);
    middle += (t.corners[0] + t.corners[1] + t.corners[2]) * (static_cast<double>(t.area) / 3);
  }
  Group group{.axis = V3f(normals.normalized()),
              .cosine = 1,
              .sine = 0,
              .middle = middle / area,
              .reach = 0,
              .before = 0,
              .share = 1};
  for (const EmissiveTriangle& t : triangles) {
    group.cosine = std::min(group.cosine, group.axis.dot(t.normal));
    for (const V3d& p : t.corners) group.reach = std::max(group.reach, (p - group.middle).length());
  }
  group.sine = std::sqrt(std::max(0.0f, 1 - square(group.cosine)));
  return group;
}

float Facings::part(const Group& group, const V3d& point) const noexcept {
  const V3d to = point - group.middle;
  const double distance2 = to.length2(), nearness2 = 1 / std::max(distance2, square(group.reach));
  float sine = 1, cosine = 1;  // within the sphere no way is the way to it
  if (distance2 > square(group.reach)) {
    const double distance = std::sqrt(distance2);
    // how large it looks
    const float wide_sine = static_cast<float>(group.reach / distance),
                wide_cosine = std::sqrt(1 - square(wide_sine));
    const float axis = static_cast<float>(V3d(group.axis).dot(to) / distance);
    cosine = front_ == 0 ? std::abs(axis) : front_ < 0 ? -axis : axis;
    // of both angles
    if (group.cosine * wide_cosine > group.sine * wide_sine)
      sine = group.sine * wide_cosine + group.cosine * wide_sine;
  }
  const float rounded = 0.5f * (cosine + std::sqrt(square(cosine) + square(roundness * sine)));
  return std::max(min_part, rounded) * static_cast<float>(nearness2);
}

Facings::Seen Facings::seen_from(const V3d& point) const noexcept {
  Seen seen{{}, 0};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    seen.part[g] = groups_.size() == 1 ? 1 : part(groups_[g], point);
    seen.all += groups_[g].share * static_cast<double>(seen.part[g]);
  }
  return seen;
}

double Facings::choose(const Seen& seen, float u) const noexcept {
  const auto weight = [&](std::size_t g) { return groups_[g].share * static_cast<double>(seen.part[g]); };
  double left = static_cast<double>(u) * seen.all;
  std::size_t g = 0;
  while (g + 1 < groups_.size() && left >= weight(g)) left -= weight(g), ++g;
  return groups_[g].before + groups_[g].share * std::clamp(left / weight(g), 0.0, 1 - 0x1p-50);
}

}  // namespace sluice
