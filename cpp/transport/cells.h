// SPDX-License-Identifier: GPL-3.0-or-later
// A number for each of the cells of space that matter, in an open hash table: grows while it is filled, then
// is only read.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/math.h"
#include "base/random.h"
#include "base/threads.h"

namespace sluice {

template <class Number>  // of 32 bits
class NumberedCells {
 public:
  NumberedCells() = default;
  explicit NumberedCells(double edge) : inverse_edge_(1 / edge) {}

  [[nodiscard]] double edge() const noexcept { return 1 / inverse_edge_; }
  // The cell's number; null if it has none.
  [[nodiscard]] const Number* find(const V3d& p) const noexcept { return find(key(p)); }
  // The same, begun with 0.
  Number& at(const V3d& p) {
    if (2 * (count_ + 1) > table_.size()) grow();
    const std::uint64_t wanted = key(p);
    const std::size_t i = place(wanted);
    if (table_[i].first == none) table_[i] = {wanted, Number{0}}, ++count_;
    return table_[i].second;
  }
  // Calls act(p) for each, p in the middle of the cell.
  template <class Act>
  void for_each(Act&& act) const {
    for (const auto& [cell, value] : table_)
      if (cell != none) act(middle(cell));
  }
  // Sets each number to make(p, thread), p in the middle of the cell, on the pool's threads.
  template <class Make>
  void set_all(ThreadPool& pool, Make&& make) {
    constexpr std::size_t run = 256;  // of the table
    pool.parallel_for((table_.size() + run - 1) / run, [&](std::size_t part, int thread) {
      for (auto& [cell, value] :
           std::span(table_).subspan(part * run, std::min(run, table_.size() - part * run)))
        if (cell != none) value = make(middle(cell), thread);
    });
  }
  [[nodiscard]] std::uint64_t hash() const noexcept {
    std::uint64_t h = 0;
    for (const auto& [cell, value] : table_)
      if (cell != none) h += mix(cell, std::bit_cast<std::uint32_t>(value));
    return h;
  }

 private:
  static constexpr std::uint64_t none = ~0ull;
  static constexpr int bits = 21;  // of a coordinate

  [[nodiscard]] std::uint64_t key(const V3d& p) const noexcept {
    const auto cell = [this](double x) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x * inverse_edge_)) &
                                        ((1 << bits) - 1));
    };
    return cell(p.x) | (cell(p.y) << bits) | (cell(p.z) << (2 * bits));
  }
  [[nodiscard]] V3d middle(std::uint64_t cell) const noexcept {
    const auto coordinate = [&](int axis) {
      return (static_cast<double>(static_cast<std::int64_t>(cell << (64 - bits * (axis + 1))) >>
                                  (64 - bits)) +
              0.5) /
             inverse_edge_;
    };
    return {coordinate(0), coordinate(1), coordinate(2)};
  }
  [[nodiscard]] std::size_t place(std::uint64_t wanted) const noexcept {
    std::size_t i = mix(wanted) & (table_.size() - 1);
    while (table_[i].first != none && table_[i].first != wanted) i = (i + 1) & (table_.size() - 1);
    return i;
  }
  [[nodiscard]] const Number* find(std::uint64_t wanted) const noexcept {
    if (table_.empty()) return nullptr;
    const auto& entry = table_[place(wanted)];
    return entry.first == wanted ? &entry.second : nullptr;
  }
  void grow() {
    std::vector<std::pair<std::uint64_t, Number>> old(std::max<std::size_t>(64, 2 * table_.size()),
                                                      {none, Number{0}});
    old.swap(table_);
    for (const auto& entry : old)
      if (entry.first != none) table_[place(entry.first)] = entry;
  }

  double inverse_edge_ = 1;
  std::size_t count_ = 0;
  std::vector<std::pair<std::uint64_t, Number>> table_;
};

using Cells = NumberedCells<float>;

}  // namespace sluice
