// SPDX-License-Identifier: GPL-3.0-or-later
// View samples of near pixels are traced together, as a bundle: what one finds at the far end of its gather
// segment lights the others too, as far as they see it (Bekaert, Sbert, Halton 2002, "Accelerating path
// tracing by re-using paths"). So where that is enough only every second sample sends a segment, and each
// gets the light of several. What is shared, and with which weight: shared_gather.h.
#pragma once
#include <algorithm>

#include "base/random.h"

namespace sluice {

inline constexpr std::size_t bundle_size = 16;

// Gather segments of a sample, from each v: where its bundle shares them they are points of one sequence,
// dealt out to all its samples.
struct SegmentPlan {
  float mean = 1;           // of their number, over the passes
  std::uint32_t count = 0;  // in this bundle
  Sampler first;            // of the bundle's points
  std::uint32_t place = 0;  // of its own first point

  [[nodiscard]] Sampler numbers(std::uint32_t segment) const noexcept { return first.after(place + segment); }
  // Of a v that shares nothing: where the others find no light for it, it must not wait for its turn.
  [[nodiscard]] std::uint32_t alone() const noexcept {
    return static_cast<std::uint32_t>(std::max(mean, 1.0f));
  }
};

// What a view sample looks for. Where lamps are seen, their edges are most of the noise and cheap to sample:
// a walk that looks for nothing else asks no light, no photon and sends no gather segment.
enum class Seeks : std::uint8_t { All, Emission, AllButEmission };

// What to trace: one sample of pixel (x, y) of the full frame.
struct ViewSample {
  int x, y;
  Sampler sampler;
  std::uint64_t key;  // of choices outside of the samplers' dimensions
  float share;        // in its pixel's mean; 0: traced for the others alone
  SegmentPlan segments = {};
  std::uint32_t light_samples = 1;  // by next-event estimation at each v
  Seeks seeks = Seeks::All;
  bool measures_lights = false;  // there are two of them, to see how far they lie apart
  bool is_probed = false;        // its light is told apart by edits, too (probes.h)
};

}  // namespace sluice
