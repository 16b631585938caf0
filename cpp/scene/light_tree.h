// SPDX-License-Identifier: GPL-3.0-or-later
// A choice of one among many lights for a point. A binary tree over the lights tells of each of its nodes
// what the lights in it may do there (Estevez & Kulla 2018, "Importance Sampling of Many Lights with Adaptive
// Tree Splitting"). Its top is split for each point anew, first where least is known, into few clusters, as
// by Walter et al. 2005 ("Lightcuts"): near lamps stand alone and far ones in crowds. A cluster is chosen by
// what it may do, then a light in it on the way down.
#pragma once
#include "scene/light.h"

namespace sluice {

class LightTree {
 public:
  LightTree() = default;
  explicit LightTree(std::span<const Light> lights);

  // As choose_light() and choice_pmf() without trust; `lights`: those that the tree was made of.
  [[nodiscard]] std::optional<LightChoice> choose(std::span<const Light> lights, const V3d& point,
                                                  const V3f& normal, float u) const noexcept;
  [[nodiscard]] float pmf(std::span<const Light> lights, const V3d& point, const V3f& normal,
                          int light) const noexcept;

 private:
  // Lights at places [begin, end) of order_. Of finite lights: all of them within `reach` of `middle`, and
  // within the box (±half) around it. Of those at infinity the directions to them stand for places.
  struct Node {
    std::uint32_t begin, end;
    std::uint32_t children = 0;  // the first of two that lie side by side
    bool infinite = false;
    float strength;  // of all together
    V3d middle;      // mean by strength
    double spread2;  // mean square of distances to it
    double reach;
    V3d half;
    V3f axis;            // they shine around it
    float cosine, sine;  // of the half angle; cosine -1: everywhere

    [[nodiscard]] bool is_leaf() const noexcept { return end - begin == 1; }
  };
  struct Estimate;
  struct Query;
  struct Cut;
  struct Builder;

  [[nodiscard]] Cut cut(const Query& query) const noexcept;
  [[nodiscard]] double first_share(const Query& query, const Node& node) const noexcept;

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> roots_;          // of finite lights, of infinite ones
  std::vector<std::uint32_t> order_, place_;  // lights as leaves from left to right; where each is
};

}  // namespace sluice
