// SPDX-License-Identifier: GPL-3.0-or-later
// Colour ramps and curves: baked by the exporter to rows over an interval, read here.
#pragma once
#include "shading/compiler.h"

namespace sluice {

// Clamped to the ends.
[[nodiscard]] inline std::array<float, 4> read_table(const Table& table, float x) noexcept {
  const auto last = static_cast<float>(table.rows.size() - 1);
  const float s = std::clamp((x - table.low) / (table.high - table.low), 0.0f, 1.0f) * last;
  const auto low = static_cast<std::size_t>(s);
  const float f = table.constant ? 0.0f : s - static_cast<float>(low);
  const auto &a = table.rows[low], &b = table.rows[std::min(low + 1, table.rows.size() - 1)];
  std::array<float, 4> out;
  for (std::size_t k = 0; k < 4; ++k) out[k] = a[k] + (b[k] - a[k]) * f;
  return out;
}

// Index of the node's table; -1 with a warning if it has none.
[[nodiscard]] inline int curve_table(NodeReader& n) {
  const std::vector<float>& values = n.node().table;
  Table table;
  table.low = n.option_number("min", 0);
  table.high = n.option_number("max", 1);
  table.constant = n.option("interpolation", "LINEAR") == "CONSTANT";
  for (std::size_t k = 0; k + 4 <= values.size(); k += 4)
    table.rows.push_back({values[k], values[k + 1], values[k + 2], values[k + 3]});
  for (const auto& row : table.rows)
    for (const float x : row)
      if (!std::isfinite(x)) table.rows.clear();
  if (table.rows.size() < 2 || table.rows.size() > 65536 || !(table.high > table.low)) {
    n.warn("its table is missing or broken; the input is passed on");
    return -1;
  }
  return n.add_table(std::move(table));
}

}  // namespace sluice
