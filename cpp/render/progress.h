// SPDX-License-Identifier: GPL-3.0-or-later
// How far a render is, when it stops, and how long that will take.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/accuracy.h"
#include "render/settings.h"

namespace sluice {

enum class State : std::uint8_t { Idle, Compiling, Rendering, Finished, Cancelled, Failed };
[[nodiscard]] constexpr const char* name_of(State state) noexcept {
  switch (state) {
    case State::Idle: return "idle";
    case State::Compiling: return "compiling";
    case State::Rendering: return "rendering";
    case State::Finished: return "finished";
    case State::Cancelled: return "cancelled";
    case State::Failed: return "failed";
  }
  return nullptr;
}

enum class StopReason : std::uint8_t { None, Passes, Time, Error, Cancelled };
[[nodiscard]] constexpr const char* name_of(StopReason reason) noexcept {
  switch (reason) {
    case StopReason::None: return "";
    case StopReason::Passes: return "passes";
    case StopReason::Time: return "time";
    case StopReason::Error: return "error";
    case StopReason::Cancelled: return "cancelled";
  }
  return nullptr;
}

struct Failure {
  std::string message, item;  // item: the edit or object at fault, may be empty
  int column = 0;             // in the edit's expression, from 1; 0: none
};

struct Progress {
  State state = State::Idle;
  StopReason stop_reason = StopReason::None;
  int pass = 0, passes = 0;      // finished, wanted
  std::uint64_t photons = 0;     // light paths emitted
  double seconds = 0;            // of rendering
  double seconds_left = -1;      // estimate to the nearest stop; < 0: unknown
  double passes_to_target = -1;  // estimate of all that the error target takes; < 0: unknown, or no target
  Accuracy accuracy;             // the last that was measured
  std::optional<MainCause> main_cause;
  // the first of the lights and effects that it does not know of: the pilot found nothing of them
  std::vector<std::string> unmet;
  std::size_t memory = 0;  // bytes of film and photon maps
  std::optional<Failure> failure;
};

// How far a render is after a pass.
struct Pace {
  int passes = 0;  // finished
  double seconds = 0, last_pass_seconds = 0;
  double relative_error = -1;  // < 0: unknown, or not measured after this pass
};
// Why the render stops now; None: it goes on.
[[nodiscard]] StopReason stop_after(const Pace& pace, const RenderSettings& settings) noexcept;

// The picture's error is measured whenever all streams of the film have the same number of passes.
[[nodiscard]] bool measures_error_after(int passes) noexcept;

// Estimated seconds to the nearest stop, at the speed of the passes so far; < 0: unknown.
[[nodiscard]] double seconds_left(const Progress& progress, const RenderSettings& settings) noexcept;

}  // namespace sluice
