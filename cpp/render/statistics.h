// SPDX-License-Identifier: GPL-3.0-or-later
// What a render did and what it cost, for the log and for the host.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "render/accuracy.h"
#include "scene/scene.h"
#include "transport/guide/arrivals.h"
#include "transport/counts.h"
#include "transport/effects.h"
#include "transport/film.h"
#include "transport/guide.h"

namespace sluice {

struct LayerShare {
  std::string name, expression;
  double share = 0;  // of the picture's luminance
};

// What layers and edits make up of the picture.
struct PictureShares {
  std::vector<LayerShare> layers;
  std::vector<double>
      edits;  // of Counts::edits: of the picture's luminance, light that the edit took on its way
};
[[nodiscard]] PictureShares shares_of(const Scene& scene, const Film& film, const Counts& counts, int passes);

// A light or an effect of which the pilot found nothing where the camera looks.
struct UnmetShare {
  std::string name;
  double share = 0;  // of the photons, kept for it all the same
};

// How far an entry floats in front of its own plane, and its shorter side (m).
struct Floating {
  double distance = 0, side = 0;
};

enum class Phase : std::uint8_t { Compile, Guide, Photons, View };
inline constexpr int phase_count = 4;
[[nodiscard]] constexpr const char* name_of(Phase phase) noexcept {
  switch (phase) {
    case Phase::Compile: return "compile";
    case Phase::Guide: return "guide";
    case Phase::Photons: return "photons";
    case Phase::View: return "view";
  }
  return nullptr;
}
static_assert(name_of(Phase{phase_count - 1}) && !name_of(Phase{phase_count}),
              "phase_count counts the phases");

// What one pass was and took.
struct PassRecord {
  const Counts& counts;
  std::size_t photons = 0, map_bytes = 0;
  double photon_seconds = 0, view_seconds = 0;
};

struct RenderStatistics {
  Counts counts;
  std::array<double, phase_count> seconds{};
  std::vector<Accuracy> accuracy;  // as it was measured from pass to pass
  std::vector<Effects::Reason> reasons;
  std::vector<std::string> edit_names;  // of counts.edits
  std::vector<Floating> edit_floats;    // of counts.edits
  PictureShares shares;                 // empty until the picture is done
  std::vector<UnmetShare> unmet;        // what relative_error does not know of
  std::vector<Arrivals> arrivals;       // at the edits' entries; empty unless the settings ask
  std::uint64_t guide_hash = 0;
  double worst_ledger_residual = 0;  // of a pass, relative to what it emitted
  double bytes_per_photon = 0;       // of the maps, all included
  std::size_t triangles = 0;
  int threads = 0;
  std::array<float, 2> radius{};  // of the first pass (m): in general, caustics

  [[nodiscard]] double& seconds_of(Phase phase) noexcept { return seconds[static_cast<std::size_t>(phase)]; }
  // What is known before the first pass.
  void start(const Scene& scene, const Effects& effects, int thread_count);
  void record(const PassRecord& pass);
};

// What the pilot did not find, by the names that the artist knows it by.
[[nodiscard]] std::vector<UnmetShare> unmet_of(const Scene& scene, const Guide& guide);

}  // namespace sluice
