// SPDX-License-Identifier: GPL-3.0-or-later
// Many quads asked at once (design §2: they are not in the scene's acceleration structure): spheres round
// them, eight at a time, and above those a BVH of boxes where there are many. Spheres and boxes are of floats
// and only widen the search; every answer is computed in double by the formula of quad.h, so all ways agree
// bit for bit.
#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "edit/quad.h"
#include "expr/edit_set.h"

namespace sluice {

struct Segment {
  V3d origin;
  V3d direction;
  // Crossings count if t_min < t <= t_max.
  double t_min = 0, t_max = std::numeric_limits<double>::infinity();
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
  static constexpr std::size_t few = 32;  // So many quads are found by their spheres alone, without a BVH.

  void add(const Quad& quad, const QuadId& id);  // then build() once
  void build();
  [[nodiscard]] std::size_t size() const noexcept { return id_.size(); }
  [[nodiscard]] bool empty() const noexcept { return id_.empty(); }
  [[nodiscard]] std::size_t bytes() const noexcept;

  // The first crossing by (t, order) among edits whose bit is set (members empty: all edits); Crossing::edit
  // < 0 if there is none.
  [[nodiscard]] Crossing first(const Segment& segment, EditSet members = {}) const noexcept;
  [[nodiscard]] bool any(const Segment& segment, EditSet members = {}) const noexcept;
  // Appends the numbers of all quads (and of a few more) that can be crossed by any segment that ends where
  // this one ends and begins within `radius` (m) of its origin. False if there are more than `max_count`:
  // then some are missing.
  [[nodiscard]] bool in_cone(const Segment& segment, double radius, EditSet members, std::size_t max_count,
                             std::vector<std::uint32_t>& out) const;
  [[nodiscard]] bool any_of(std::span<const std::uint32_t> numbers, const Segment& segment) const noexcept;
  // Appends all crossings, in no order.
  void all(const Segment& segment, EditSet members, std::vector<Crossing>& out) const;

 private:
  static constexpr std::size_t width = 8;  // tested side by side
  // Spheres round up to eight quads that follow each other; relative to the middle of all, as boxes are.
  struct Octet {
    alignas(32) float centre[3][width], radius[width];
    std::uint32_t first, count;
    bool ends_leaf;
  };
  struct Node {
    alignas(32) float bounds[6][width];  // of the children's boxes: least x, y, z, greatest x, y, z
    std::int32_t child[width];           // a node, or ~the first octet of a leaf
  };
  struct Probe;
  // Calls act(index) for quads that may touch the segment, or the cone round it that begins with `radius`;
  // t_max may shrink meanwhile.
  template <class Act>
  void visit(const Segment& segment, double radius, const double& t_max, const Act& act) const;
  // Calls found(index, t, u, v) for crossings with t_min < t <= t_max; t_max may shrink meanwhile.
  template <class Found>
  void search(const Segment& segment, double& t_max, const Found& found) const noexcept;
  template <class Found>
  void test(const Segment& segment, double t_max, std::size_t quad, const Found& found) const noexcept;
  std::int32_t make_node(std::span<std::uint32_t> range);
  std::int32_t make_leaf(std::span<const std::uint32_t> range);
  void sort_by_octets();

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
  std::vector<V3d> low_, high_;        // boxes; gone when octets are made
  std::vector<std::uint32_t> sorted_;  // by octets; gone then, too
  std::vector<Octet> octets_;          // empty when a plain loop does
  std::vector<Node> nodes_;
  std::int32_t root_ = 0;    // as a node's child
  V3d middle_{0}, half_{0};  // of the box of all
};

}  // namespace sluice
