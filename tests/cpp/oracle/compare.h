// SPDX-License-Identifier: GPL-3.0-or-later
// Holds the core against an oracle, part by part and region by region, and says where they differ.
#pragma once
#include <gtest/gtest.h>

#include <cstdlib>

#include "oracle/core_render.h"
#include "oracle/eye_tracer.h"
#include "oracle/forward_tracer.h"
#include "oracle/stage.h"
#include "oracle/statistics.h"

namespace sluice::oracle {

inline bool is_full() {
  static const bool full = [] { const char* v = std::getenv("SLUICE_FULL"); return v && *v && *v != '0'; }();
  return full;
}

enum class Which { Forward, Eye };

// How much work, of both sides.
struct Effort {
  int seeds = 16, passes = 8;
  int batches = 16, paths = 100000;  // per batch: light paths, or eye paths
  int side = 2;                     // regions per side of the image
};

inline constexpr double family = 0.01;       // chance that one of all comparisons of the suite errs
inline constexpr int suite_comparisons = 4000;
inline constexpr double bound = 0.01;        // of density classes: their radius makes them inexact

inline ThreadPool& pool() {
  static ThreadPool threads(std::min(2, hardware_threads()));
  return threads;
}

// Scenes are independent of each other.
inline std::uint64_t seed_of(const std::string& name) {
  std::uint64_t h = 0;
  for (const char c : name) h = mix(h, static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
  return h >> 16;
}

inline std::vector<Regions> ask_oracle(const SceneDescription& description, const Scene& scene, const TransportSettings& settings, Which which, const Effort& effort, std::uint64_t first_seed) {
  std::vector<Regions> out(static_cast<std::size_t>(effort.batches), Regions(effort.side));
  pool().parallel_for(out.size(), [&](std::size_t b, int) {
    const std::uint64_t seed = first_seed + b;
    if (which == Which::Forward)
      out[b] = ForwardTracer(description, scene, settings).render(effort.side, effort.paths, seed);
    else
      out[b] = EyeTracer(description, scene, settings).render(effort.side, std::max(1, effort.paths / (scene.frame().width * scene.frame().height)), seed);
  });
  return out;
}

inline Sample sample_of(const std::vector<Regions>& batches, std::size_t region, const std::vector<Part>& parts, int channel) {
  std::vector<double> values;
  for (const Regions& r : batches) {
    double v = 0;
    for (const Part p : parts) v += r.mean[region][static_cast<std::size_t>(p)][channel];
    values.push_back(v);
  }
  return summarise(values);
}

inline bool is_dark(const std::vector<Regions>& batches, Part part) {
  return std::ranges::all_of(batches, [&](const Regions& r) { return std::ranges::all_of(r.mean, [&](const Parts& p) { return p[static_cast<std::size_t>(part)] == V3d(0); }); });
}

// Mean over the regions, for the report.
inline std::string report_line(const std::string& name, const std::vector<Regions>& core, const std::vector<Regions>& oracle, const std::vector<Part>& parts) {
  const auto whole = [&](const std::vector<Regions>& batches) {
    std::vector<double> values;
    for (const Regions& r : batches) {
      V3d sum(0);
      for (const Parts& region : r.mean)
        for (const Part p : parts) sum += region[static_cast<std::size_t>(p)];
      values.push_back(luma(sum) / static_cast<double>(r.mean.size()));
    }
    return summarise(values);
  };
  const Sample a = whole(core), b = whole(oracle);
  const Difference d = difference(a, b);
  char line[200];
  const double percent = b.mean != 0 ? 100 / b.mean : 0;
  std::snprintf(line, sizeof line, "  %-10s core %.5f ± %.2f %%  oracle %.5f ± %.2f %%  difference %+.2f %% ± %.2f  p %.3g\n", name.c_str(), a.mean, percent * std::sqrt(a.variance), b.mean,
                percent * std::sqrt(b.variance), percent * d.value, percent * d.margin(0.05), d.p());
  return line;
}

// Parts without density must agree within noise. For the others the interval of the difference must not lie beyond ±1 % of the part (of a
// tenth of the picture, where the part is less); the full form asks that all of the 95 % interval lies within it.
inline void expect_equal(const std::string& name, const std::vector<Regions>& core, const std::vector<Regions>& oracle, const std::vector<Part>& parts, bool density) {
  static constexpr const char* channels[] = {"red", "green", "blue"};
  const double p_limit = sidak(family, suite_comparisons);
  for (std::size_t region = 0; region < core[0].mean.size(); ++region)
    for (int c = 0; c < 3; ++c) {
      const Sample a = sample_of(core, region, parts, c), b = sample_of(oracle, region, parts, c);
      Difference d = difference(a, b);
      d.error = std::hypot(d.error, 1e-5 * b.mean);  // floats
      if (!density) {
        EXPECT_GT(d.p(), p_limit) << name << ", region " << region << ", " << channels[c] << ": core " << a.mean << ", oracle " << b.mean << ", off by " << d.value / d.error << " standard errors";
        continue;
      }
      const Sample all = sample_of(oracle, region, {Part::Direct, Part::Caustics, Part::Edited, Part::Indirect, Part::Emission}, c);
      const double tolerance = bound * std::max(b.mean, 0.1 * all.mean);
      EXPECT_LE(std::abs(d.value) - d.margin(p_limit), tolerance) << name << ", region " << region << ", " << channels[c] << ": core " << a.mean << ", oracle " << b.mean << " ± " << d.margin(0.05);
      if (is_full()) {
        EXPECT_LE(std::abs(d.value) + d.margin(0.05), tolerance) << name << ", region " << region << ", " << channels[c] << ": core " << a.mean << ", oracle " << b.mean;
      }
    }
}

// `parts`: those the oracle can answer for.
inline void compare(const std::string& name, const Stage& stage, Which which, const std::vector<Part>& parts, Effort effort = {}) {
  if (is_full()) effort.passes *= 16, effort.paths *= 16;
  SceneDescription description = stage.scene;
  Warnings warnings;
  const auto scene = compile(description, warnings, {}, 1);
  for (const Warning& w : warnings) std::cout << "  warning: " << w.item << ": " << w.message << "\n";
  Counts counts;
  const auto seconds = [begin = std::chrono::steady_clock::now()] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  const std::vector<Regions> core = render_core(*scene, stage.settings, {effort.seeds, effort.passes, seed_of(name), is_full(), stage.gather_radius}, effort.side, pool(), counts);
  const double core_seconds = seconds();
  const std::vector<Regions> oracle = ask_oracle(description, *scene, stage.settings, which, effort, seed_of(name) + 1000);
  std::printf("%s (core %.1f s, oracle %.1f s)\n", name.c_str(), core_seconds, seconds() - core_seconds);
  for (std::size_t e = 0; e < counts.edits.size(); ++e)
    std::printf("  edit %zu \"%s\": took %llu light paths\n", e, description.edits[e].expression.c_str(), static_cast<unsigned long long>(counts.edits[e].matched));
  static constexpr const char* names[] = {"Direct", "Caustics", "Edited", "Indirect", "Emission"};
  for (const Part part : parts) {
    const std::string of = names[static_cast<std::size_t>(part)];
    if (is_dark(core, part) && is_dark(oracle, part)) continue;
    std::cout << report_line(of, core, oracle, {part});
    expect_equal(name + " " + of, core, oracle, {part}, part != Part::Direct && part != Part::Emission);
  }
  std::cout << report_line("together", core, oracle, parts) << std::flush;
}

inline const std::vector<Part> lit{Part::Direct, Part::Caustics, Part::Edited, Part::Indirect};
inline const std::vector<Part> everything{Part::Direct, Part::Caustics, Part::Edited, Part::Indirect, Part::Emission};

}  // namespace sluice::oracle
