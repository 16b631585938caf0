// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/accuracy.h"

#include <algorithm>
#include <cmath>

#include "base/math.h"

namespace sluice {

double Accuracy::error() const noexcept { return is_known() ? std::sqrt(square(noise) + square(bias)) : -1; }

// The film knows the noise of all pixels, the probes its shares; so these are scaled to it.
Accuracy measure_accuracy(const Film& film, const Probes& probes) {
  Accuracy now{.pass = film.finished_passes()};
  now.noise = film.relative_error();
  if (!now.is_known()) return now;
  now.shares = probes.shares(film);
  now.bias = std::sqrt(now.shares.picture.bias);
  const double scale = now.shares.picture.noise > 0 ? square(now.noise) / now.shares.picture.noise : 0;
  now.shares.picture.noise *= scale;
  for (ErrorSquares& part : now.shares.parts) part.noise *= scale;
  for (ErrorSquares& edit : now.shares.edits) edit.noise *= scale;
  return now;
}

double passes_to(double target, const Accuracy& now) noexcept {
  if (!now.is_known() || !(target > 0) || now.pass == 0) return -1;
  const auto error2 = [&](double factor) {
    return square(now.noise) / factor + square(now.bias) * std::pow(factor, -2.0 / 3);
  };
  // By halving, in logarithms: the error falls with each pass.
  double low = -20, high = 40;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (error2(std::exp2(middle)) > square(target) ? low : high) = middle;
  }
  return now.pass * std::exp2(high);
}

// An edit's light is part of other light, mostly of edited light: where nearly all of that is one edit's, the
// edit is the better name.
std::optional<MainCause> main_cause(const Accuracy& now, const std::vector<std::string>& edit_names) {
  if (!now.is_known()) return {};
  double sum = 0;
  for (const ErrorSquares& part : now.shares.parts) sum += part.total();
  if (!(sum > 0)) return {};
  const auto most = std::ranges::max_element(now.shares.parts, {}, &ErrorSquares::total);
  MainCause cause{name_of(static_cast<Part>(most - now.shares.parts.begin())), most->total() / sum};
  for (std::size_t e = 0; e < now.shares.edits.size() && e < edit_names.size(); ++e)
    if (now.shares.edits[e].total() > 0.8 * most->total())
      return MainCause{cause.name + " of " + edit_names[e], cause.share};
  return cause;
}

}  // namespace sluice
