// SPDX-License-Identifier: GPL-3.0-or-later
// Values of enums by name, as they cross the binding and stand in logs. Beside such an enum stands
//
//   constexpr const char* name_of(Kind kind) noexcept { switch (kind) { case Kind::A: return "a"; … } return
//   nullptr; }
//
// A switch, so that the compiler refuses a value without a name (-Wswitch). The enum's type must be given,
// its values count from 0.
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace sluice {

// Empty: no value has this name.
template <class Enum>
[[nodiscard]] constexpr std::optional<Enum> value_named(std::string_view name) noexcept {
  for (int i = 0; const char* known = name_of(static_cast<Enum>(i)); ++i)
    if (name == known) return static_cast<Enum>(i);
  return std::nullopt;
}

}  // namespace sluice
