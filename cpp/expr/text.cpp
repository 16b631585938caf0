// SPDX-License-Identifier: GPL-3.0-or-later
#include "expr/text.h"

#include <algorithm>
#include <cctype>
#include <limits>

#include "base/error.h"

namespace sluice {

std::u32string decode_utf8(std::string_view bytes, const std::string& item) {
  std::u32string out;
  out.reserve(bytes.size());
  for (std::size_t i = 0; i < bytes.size();) {
    const auto lead = static_cast<unsigned char>(bytes[i]);
    const std::size_t length = lead < 0x80                   ? 1
                               : lead >= 0xc2 && lead < 0xe0 ? 2
                               : lead >= 0xe0 && lead < 0xf0 ? 3
                               : lead >= 0xf0 && lead < 0xf5 ? 4
                                                             : 0;
    bool ok = length > 0 && i + length <= bytes.size();
    char32_t c = length == 1 ? lead : lead & (0x7fu >> length);
    for (std::size_t k = 1; ok && k < length; ++k) {
      const auto next = static_cast<unsigned char>(bytes[i + k]);
      ok = (next & 0xc0) == 0x80;
      c = (c << 6) | (next & 0x3fu);
    }
    constexpr char32_t min_of_length[] = {0, 0, 0x80, 0x800, 0x10000};
    if (!ok || c < min_of_length[length] || c > 0x10ffff || (c >= 0xd800 && c < 0xe000))
      throw ExpressionError(item, static_cast<int>(out.size()) + 1,
                            "this character is not valid UTF-8; write it anew");
    out.push_back(c);
    i += length;
  }
  return out;
}

std::string encode_utf8(char32_t c) {
  const auto tail = [c](int shift) { return static_cast<char>(0x80u | ((c >> shift) & 0x3fu)); };
  if (c < 0x80) return {static_cast<char>(c)};
  if (c < 0x800) return {static_cast<char>(0xc0u | (c >> 6)), tail(0)};
  if (c < 0x10000) return {static_cast<char>(0xe0u | (c >> 12)), tail(6), tail(0)};
  return {static_cast<char>(0xf0u | (c >> 18)), tail(12), tail(6), tail(0)};
}

namespace {

// Levenshtein distance in half letters.
int distance(std::string_view a, std::string_view b, std::vector<int>& row) {
  row.resize(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(2 * j);
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  for (std::size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0];
    row[0] += 2;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int change = a[i] == b[j] ? 0 : lower(a[i]) == lower(b[j]) ? 1 : 2;
      const int best = std::min({diagonal + change, row[j] + 2, row[j + 1] + 2});
      diagonal = row[j + 1];
      row[j + 1] = best;
    }
  }
  return row[b.size()];
}

}  // namespace

const std::string* nearest_name(std::string_view name, const std::vector<const std::string*>& names) {
  const std::string* best = nullptr;
  int smallest = std::numeric_limits<int>::max();
  std::vector<int> row;
  for (const std::string* candidate : names) {
    const int d = distance(name, *candidate, row);
    if (d < smallest) smallest = d, best = candidate;
  }
  const int half = static_cast<int>(name.size());  // of its letters at most may be others, or one of several
  return smallest <= std::max(2, half) && smallest < 2 * half ? best : nullptr;
}

}  // namespace sluice
