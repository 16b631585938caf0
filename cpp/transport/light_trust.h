// SPDX-License-Identifier: GPL-3.0-or-later
// How next-event estimation chooses of a few lights, by places: a wall that the sun never reaches asks the
// lamp. Found out by light_probing.h.
#pragma once
#include <bit>
#include <cstdint>
#include <vector>

#include "scene/light.h"
#include "transport/cells.h"

namespace sluice {

class LightTrusts {
 public:
  LightTrusts() = default;
  // One row of numbers, a number per light, for anywhere; then one for each of the cells, which tell their
  // rows. `hidden`: per light, whether photon density has its straight light at y.
  LightTrusts(NumberedCells<std::uint32_t> cells, std::vector<float> rows, std::vector<char> hidden)
      : cells_(std::move(cells)), hidden_(std::move(hidden)), at_v_(std::move(rows)), at_y_(at_v_) {
    for (std::size_t i = 0; i < at_y_.size(); ++i)
      if (hidden_[i % hidden_.size()]) at_y_[i] = 0;
  }

  [[nodiscard]] LightTrust at_v(const V3d& p) const noexcept { return row(at_v_, p); }
  // 0 for the hidden ones
  [[nodiscard]] LightTrust at_y(const V3d& p) const noexcept { return row(at_y_, p); }
  [[nodiscard]] bool is_hidden(int light) const noexcept {
    return !hidden_.empty() && hidden_[static_cast<std::size_t>(light)];
  }
  [[nodiscard]] std::uint64_t hash() const noexcept {
    std::uint64_t h = cells_.hash();
    for (const float t : at_v_) h = mix(h, std::bit_cast<std::uint32_t>(t));
    for (const char is : hidden_) h = mix(h, static_cast<std::uint64_t>(is));
    return h;
  }

 private:
  [[nodiscard]] LightTrust row(const std::vector<float>& rows, const V3d& p) const noexcept {
    // a light alone is chosen anyway
    const std::uint32_t* cell = hidden_.size() > 1 ? cells_.find(p) : nullptr;
    return LightTrust(rows).subspan((cell ? *cell : 0) * hidden_.size(), hidden_.size());
  }

  NumberedCells<std::uint32_t> cells_;
  std::vector<char> hidden_;
  std::vector<float> at_v_, at_y_;
};

}  // namespace sluice
