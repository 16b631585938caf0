// SPDX-License-Identifier: GPL-3.0-or-later
// A render's statistics as text for the log: what ran and why, what it cost, everything dropped or capped.
#pragma once
#include <cstdint>
#include <string>

#include "render/statistics.h"

namespace sluice {

[[nodiscard]] std::string describe(const RenderStatistics& statistics);
[[nodiscard]] std::string hex(std::uint64_t hash);

}  // namespace sluice
