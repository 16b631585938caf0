// SPDX-License-Identifier: GPL-3.0-or-later
// Many quads asked at once: a plain loop for a few, a BVH of their own beyond that (design §2: quads are not in the
// scene's acceleration structure). Boxes are of floats and only widen the search; every answer is computed in double by the formula of
// quad.h, so both ways agree bit for bit.
#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "edit/edit_set.h"
#include "edit/quad.h"

namespace sluice {

struct Segment {
  V3d origin;
  V3d direction;
  double t_min = 0, t_max = std::numeric_limits<double>::infinity();  // crossings with t_min < t <= t_max count
  int excluded_group = -1;  // the plane group that the segment starts in
};

// Which quad: an edit's entry, or one of its exits.
struct QuadId {
  static constexpr int entry = -1;
  int edit = -1, exit = entry;
};

struct Crossing {
  double t = 0;
  V2d uv;
  int edit = -1;
  int exit = QuadId::entry;
  int group = -1;
  int order = 0;  // of the quad
};

class QuadSet {
 public:
  static constexpr std::size_t few = 32;

  void add(const Quad& quad, const QuadId& id);  // then build() once
  void build();
  [[nodiscard]] std::size_t size() const noexcept { return id_.size(); }
  [[nodiscard]] bool empty() const noexcept { return id_.empty(); }
  [[nodiscard]] std::size_t bytes() const noexcept;

  // The first crossing by (t, order) among edits whose bit is set (members empty: all edits); Crossing::edit < 0 if there is none.
  [[nodiscard]] Crossing first(const Segment& segment, EditSet members = {}) const noexcept;
  [[nodiscard]] bool any(const Segment& segment, EditSet members = {}) const noexcept;
  // Appends all crossings, in no order.
  void all(const Segment& segment, EditSet members, std::vector<Crossing>& out) const;

 private:
  // Eight children side by side, so that their boxes are tested at once. Relative to the middle of all quads.
  struct Node {
    static constexpr std::size_t width = 8;
    alignas(32) float low[3][width], high[3][width];
    std::int32_t child[width];  // a node, or ~quad
  };
  struct Ray;
  // Calls found(index, t, u, v) for crossings with t_min < t <= t_max; t_max may shrink meanwhile.
  template <class Found>
  void search(const Segment& segment, double& t_max, const Found& found) const noexcept;
  template <class Found>
  void test(const Segment& segment, double t_max, std::size_t quad, const Found& found) const noexcept;
  std::int32_t make_node(std::span<std::uint32_t> range);

  struct Test {  // what a crossing is computed from (quad.h)
    V3d normal;
    double offset;
    V3d dual_u;
    double u0, slack_u;
    V3d dual_v;
    double v0, slack_v;
  };
  std::vector<Test> tests_;
  std::vector<int> group_, order_;
  std::vector<QuadId> id_;
  std::vector<V3d> low_, high_;  // boxes; gone when nodes are built
  std::vector<Node> nodes_;      // empty when a loop does
  V3d middle_{0}, half_{0};      // of the box of all
};

}  // namespace sluice
