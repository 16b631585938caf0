// SPDX-License-Identifier: GPL-3.0-or-later
// The side of an expression (design §3): whether it reads a path from its light or from the eye.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "expr/expression.h"

namespace sluice {

enum class Side : std::uint8_t { Light, View };
[[nodiscard]] constexpr const char* name_of(Side side) noexcept {
  switch (side) {
    case Side::Light: return "light";
    case Side::View: return "view";
  }
  return nullptr;
}
[[nodiscard]] constexpr std::size_t index(Side side) noexcept { return static_cast<std::size_t>(side); }

// Light: every word begins with L and none contains E. View: every word ends with E, none contains L, and
// some word is of S, F and E alone, as view paths end at their first D or G. Anything else throws.
[[nodiscard]] Side side_of(const Expression& expression, const std::string& item = {});
[[nodiscard]] Side check_edit_expression(std::string_view text, const std::string& item = {});

// Layers select whole paths: every word begins with L and ends with E. Throws otherwise.
void check_layer(const Expression& expression, const std::string& item = {});
[[nodiscard]] Expression parse_layer_expression(std::string_view text, const std::string& item = {});

}  // namespace sluice
