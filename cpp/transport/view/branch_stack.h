// SPDX-License-Identifier: GPL-3.0-or-later
// Branches of a view sample that wait to be followed. The budget bounds how many there ever are, so there is
// room for all.
#pragma once
#include <array>

#include "transport/branching.h"
#include "transport/view/view_path.h"

namespace sluice {

class BranchStack {
 public:
  void start(const ViewPath& first) noexcept {
    branches_[0] = first;
    count_ = 1, budget = {};
  }
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  [[nodiscard]] const ViewPath& pop() noexcept { return branches_[--count_]; }
  // A copy, to be changed in place; drop() takes the last one back.
  ViewPath& push(const ViewPath& path) noexcept { return branches_[count_++] = path; }
  void drop() noexcept { --count_; }

  SplitBudget budget;

 private:
  std::array<ViewPath, split_budget> branches_;
  std::size_t count_ = 0;
};

}  // namespace sluice
