// SPDX-License-Identifier: GPL-3.0-or-later
// Text as expressions need it: code points (columns count them), and how near two names are.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

// Throws ExpressionError(item, column) where the bytes are not UTF-8.
[[nodiscard]] std::u32string decode_utf8(std::string_view bytes, const std::string& item);
[[nodiscard]] std::string encode_utf8(char32_t code_point);

[[nodiscard]] constexpr bool is_space(char32_t c) noexcept {
  return c == U' ' || (c >= U'\t' && c <= U'\r') || c == U'\u00a0' || c == U'\u3000';
}

// The name with the fewest changed letters (case counts half), the first of equals; null if there is none.
[[nodiscard]] const std::string* nearest_name(std::string_view name,
                                              const std::vector<const std::string*>& names);

}  // namespace sluice
