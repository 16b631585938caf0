// SPDX-License-Identifier: GPL-3.0-or-later
// Two vertices that share what their gather segments find, under a disk that glows: whoever finds a point of
// it, and however many segments each sends, both receive what one alone would, which has a closed form.
#include <gtest/gtest.h>

#include "base/sampling.h"
#include "transport/view/sharing_vertex.h"

namespace sluice {
namespace {

constexpr double height = 1.5, radius = 2;
constexpr int side = 600;  // directions of a vertex: a square grid on the unit square

// Irradiance under a disk of radiance 1, `off` beside its axis (Siegel & Howell, Thermal Radiation Heat
// Transfer, configuration B-13).
double irradiance(double off) {
  const double square_sum = off * off + height * height, r2 = radius * radius;
  return pi / 2 *
         (1 - (square_sum - r2) / std::sqrt((square_sum + r2) * (square_sum + r2) - 4 * r2 * off * off));
}

SharingVertex vertex_at(std::size_t sample, const V3d& place) {
  SharingVertex vertex;
  vertex.sample = sample;
  vertex.v.hit.position = place;
  return vertex;
}

// Of a connection to a vertex that looks up, a diffuse one of f = 1 / π.
float cosine(const Connection& c) { return std::max(0.0f, c.wi.z); }

struct Pair {
  std::array<SharingVertex, 2> vertices{vertex_at(0, {0, 0, 0}), vertex_at(1, {0.8, 0.3, 0})};
  std::array<float, 2> mean_segments{1, 1};
  // the second does not see the half of the disk with x > 0
  bool is_half_hidden = false;

  [[nodiscard]] double off_axis(std::size_t i) const {
    const V3d& p = vertices[i].v.hit.position;
    return std::hypot(p.x, p.y);
  }
  [[nodiscard]] bool is_open(std::size_t i, const V3d& y) const {
    return !(is_half_hidden && i == 1 && y.x > 0);
  }

  // What each receives of all that both find, in the mean.
  [[nodiscard]] std::array<double, 2> received() const {
    std::array<double, 2> sums{};
    for (std::size_t finder = 0; finder < 2; ++finder)
      for (int i = 0; i < side * side; ++i) {
        const V2f uv((static_cast<float>(i % side) + 0.5f) / side,
                     (static_cast<float>(i / side) + 0.5f) / side);
        const V3f wi = sample_cosine(uv);
        Vertex y;
        y.hit.position = vertices[finder].v.hit.position + V3d(wi) * (height / static_cast<double>(wi.z));
        y.point.ng = y.point.ns = V3f(0, 0, -1);
        if (std::hypot(y.hit.position.x, y.hit.position.y) > radius || !is_open(finder, y.hit.position))
          continue;
        share(y, mean_segments[finder] / (side * side), sums);
      }
    return sums;
  }

 private:
  // `segments`: that such a y stands for.
  void share(const Vertex& y, float segments, std::array<double, 2>& sums) const {
    std::array<Connection, 2> connections;
    for (std::size_t i = 0; i < 2; ++i) {
      Connection& c = connections[i];
      ASSERT_TRUE(connect(vertices[i], y, c));
      c.pdf = cosine(c) / pi;
      c.is_open = is_open(i, y.hit.position);
    }
    const float density =
        density_of(connections, [&](const SharingVertex& v) { return mean_segments[v.sample]; });
    for (const Connection& c : connections)
      if (c.is_open) sums[c.to->sample] += static_cast<double>(segments * cosine(c) * c.geometry / density);
  }
};

TEST(ViewSharing, BothReceiveWhatOneAloneWould) {
  for (const auto& means :
       {std::array<float, 2>{1, 1}, {0.5f, 0.5f}, {1, 0.25f}, {0.5f, 4}, {1, 0}, {0, 1}}) {
    Pair pair;
    pair.mean_segments = means;
    const auto received = pair.received();
    for (std::size_t i = 0; i < 2; ++i) {
      const double expected = irradiance(pair.off_axis(i));
      EXPECT_NEAR(received[i], expected, 2e-3 * expected)
          << i << " of means " << means[0] << ", " << means[1];
    }
  }
}

// Connections that are not open are left out of the light and of the density, whoever found y.
TEST(ViewSharing, WhatOneDoesNotSeeIsLeftToTheOther) {
  for (const auto& means : {std::array<float, 2>{1, 1}, {1, 0.25f}, {0.5f, 4}}) {
    Pair pair;
    pair.mean_segments = means;
    pair.is_half_hidden = true;
    pair.vertices[1].v.hit.position.x = 0;  // beside the edge of what is hidden: it sees one half
    const auto received = pair.received();
    EXPECT_NEAR(received[0], irradiance(pair.off_axis(0)), 2e-3 * received[0])
        << means[0] << ", " << means[1];
    EXPECT_NEAR(received[1], irradiance(pair.off_axis(1)) / 2, 4e-3 * received[1])
        << means[0] << ", " << means[1];
  }
}

TEST(ViewSharing, NobodySeesAPointFromBehindOrAtItsHorizon) {
  const SharingVertex vertex = vertex_at(0, {0, 0, 0});
  Connection c;
  Vertex y;
  y.point.ng = y.point.ns = V3f(0, 0, -1);
  y.hit.position = {0, 0, 2};
  ASSERT_TRUE(connect(vertex, y, c));
  EXPECT_EQ(c.distance, 2);
  EXPECT_EQ(c.wi, V3f(0, 0, 1));
  EXPECT_FLOAT_EQ(c.geometry, 0.25f);
  y.hit.position = {0, 0, -2};
  EXPECT_FALSE(connect(vertex, y, c));
  y.hit.position = {100, 0, 1};  // at a cosine of 0.01
  EXPECT_FALSE(connect(vertex, y, c));
  y.hit.position = {0, 0, 0};
  EXPECT_FALSE(connect(vertex, y, c));
  y.hit.position = {0, 0, 2}, y.point.ns = V3f(1, 0, 0);  // seen from behind its shading normal
  EXPECT_FALSE(connect(vertex, y, c));
}

}  // namespace
}  // namespace sluice
