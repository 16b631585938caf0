// SPDX-License-Identifier: GPL-3.0-or-later
// How wrong a picture still is, told without a reference, as error.h defines noise and bias, without the
// worst 0.1 % of the pixels. And what less would cost.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "transport/film.h"
#include "transport/probes.h"

namespace sluice {

struct Accuracy {
  int pass = 0;                         // finished then
  double seconds = 0;                   // of rendering, then
  std::uint64_t rays = 0, photons = 0;  // traced, emitted until then
  double noise = -1, bias = 0;          // relative, 0.01 = 1 %; noise < 0: not known yet
  ErrorShares shares = {};              // of noise² and bias²

  [[nodiscard]] bool is_known() const noexcept { return noise >= 0; }
  // What is told as *the* error: the root of the mean square of both together.
  [[nodiscard]] double error() const noexcept;
};

// After a pass that all streams have finished.
[[nodiscard]] Accuracy measure_accuracy(const Film& film, const Probes& probes);

// Passes after which the error would be `target`, of noise² that falls as 1 / n and bias² as n^(-2/3)
// (Knaus & Zwicker 2011 with α = 2/3); < 0: unknown.
[[nodiscard]] double passes_to(double target, const Accuracy& now) noexcept;

// What makes most of the error, by the name that the artist knows it by, and its share of the square.
struct MainCause {
  std::string name;
  double share = 0;
};
[[nodiscard]] std::optional<MainCause> main_cause(const Accuracy& now,
                                                  const std::vector<std::string>& edit_names);

}  // namespace sluice
