// SPDX-License-Identifier: GPL-3.0-or-later
// Does an expression accept a word? The whole way of a render (parser, classes, automaton) on words given by
// name; for scripts and for the oracle test against Python's re. Any grammatical expression is taken,
// whatever its side.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

// `events` in the order of light, such as {"L", "S'Egg'", "D'Floor'"}. Throws ExpressionError (its item is
// the faulty text).
[[nodiscard]] bool accepts(std::string_view expression, std::span<const std::string> events);

// Many words at once: row i of `words` holds `length` numbers of events, ended early by word_end. One 0 or 1
// per row.
inline constexpr std::uint8_t word_end = 255;
[[nodiscard]] std::vector<std::uint8_t> accepts_many(std::string_view expression,
                                                     std::span<const std::string> events,
                                                     std::span<const std::uint8_t> words, std::size_t length);

}  // namespace sluice
