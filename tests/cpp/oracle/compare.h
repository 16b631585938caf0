// SPDX-License-Identifier: GPL-3.0-or-later
// Holds the core against an oracle, part by part and region by region, and says where they differ.
#pragma once
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <iostream>

#include "edit/edits.h"
#include "oracle/core_render.h"
#include "oracle/eye_tracer.h"
#include "oracle/forward_tracer.h"
#include "oracle/stage.h"
#include "oracle/statistics.h"

namespace sluice::oracle {

inline bool is_full() {
  static const bool full = [] {
    const char* v = std::getenv("SLUICE_FULL");
    return v && *v && *v != '0';
  }();
  return full;
}

enum class Which { Forward, Eye };

// How much work, of both sides.
struct Effort {
  int seeds = 16, passes = 5;
  int batches = 16, paths = 50000;  // per batch: light paths, or eye paths
  int side = 2;                     // regions per side of the image
};

inline constexpr double family = 0.01;  // chance that one of all comparisons of the suite errs
inline constexpr int suite_comparisons = 4000;
inline constexpr double bound = 0.01;  // of density classes: their radius makes them inexact
inline constexpr int full_effort = 16;

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

inline std::vector<Regions> ask_oracle(const SceneDescription& description, const Scene& scene,
                                       const TransportSettings& settings, Which which, const Effort& effort,
                                       std::uint64_t first_seed) {
  std::vector<Regions> out(static_cast<std::size_t>(effort.batches), Regions(effort.side));
  pool().parallel_for(out.size(), [&](std::size_t b, int) {
    const std::uint64_t seed = first_seed + b;
    if (which == Which::Forward)
      out[b] = ForwardTracer(description, scene, settings).render(effort.side, effort.paths, seed);
    else
      out[b] = EyeTracer(description, scene, settings)
                   .render(effort.side,
                           std::max(1, effort.paths / (scene.frame().width * scene.frame().height)), seed);
  });
  return out;
}

inline V3d sum_of(const Parts& parts, const std::vector<Part>& wanted) {
  V3d sum(0);
  for (const Part p : wanted) sum += parts[static_cast<std::size_t>(p)];
  return sum;
}

inline Sample sample_of(const std::vector<Regions>& batches, std::size_t region,
                        const std::vector<Part>& parts, int channel) {
  std::vector<double> values;
  for (const Regions& r : batches) values.push_back(sum_of(r.mean[region], parts)[channel]);
  return summarise(values);
}

inline bool is_dark(const std::vector<Regions>& batches, Part part) {
  return std::ranges::all_of(batches, [&](const Regions& r) {
    return std::ranges::all_of(r.mean,
                               [&](const Parts& p) { return p[static_cast<std::size_t>(part)] == V3d(0); });
  });
}

// Mean over the regions, for the report.
inline std::string report_line(const std::string& name, const std::vector<Regions>& core,
                               const std::vector<Regions>& oracle, const std::vector<Part>& parts) {
  const auto whole = [&](const std::vector<Regions>& batches) {
    std::vector<double> values;
    for (const Regions& r : batches) {
      double sum = 0;
      for (const Parts& region : r.mean) sum += luma(sum_of(region, parts));
      values.push_back(sum / static_cast<double>(r.mean.size()));
    }
    return summarise(values);
  };
  const Sample a = whole(core), b = whole(oracle);
  const Difference d = difference(a, b);
  char line[200];
  const double percent = b.mean != 0 ? 100 / b.mean : 0;
  std::snprintf(line, sizeof line,
                "  %-10s core %.5f ± %.2f %%  oracle %.5f ± %.2f %%  difference %+.2f %% ± %.2f  p %.3g\n",
                name.c_str(), a.mean, percent * std::sqrt(a.variance), b.mean,
                percent * std::sqrt(b.variance), percent * d.value, percent * d.margin(0.05), d.p());
  return line;
}

// The mean of all regions as one.
inline std::vector<Regions> as_one(const std::vector<Regions>& batches) {
  std::vector<Regions> out(batches.size(), Regions(1));
  for (std::size_t b = 0; b < batches.size(); ++b)
    for (const Parts& region : batches[b].mean)
      for (std::size_t p = 0; p < part_count; ++p)
        out[b].mean[0][p] += region[p] / static_cast<double>(batches[b].mean.size());
  return out;
}

struct Compared {
  Difference difference;
  // 1 % of the part, or of a quarter of the picture where the part is less than that
  double core, oracle, tolerance;
  std::string where;
};

inline Compared compared(const std::vector<Regions>& core, const std::vector<Regions>& oracle,
                         std::size_t region, Part part, int channel) {
  static constexpr const char* channels[] = {"red", "green", "blue"};
  static const std::vector<Part> all{Part::Direct, Part::Caustics, Part::Edited, Part::Indirect,
                                     Part::Emission};
  const Sample a = sample_of(core, region, {part}, channel), b = sample_of(oracle, region, {part}, channel);
  Difference d = difference(a, b);
  d.error = std::hypot(d.error, 1e-5 * b.mean);  // floats
  const double picture = sample_of(oracle, region, all, channel).mean;
  return {d, a.mean, b.mean, bound * std::max(b.mean, picture / 4),
          "region " + std::to_string(region) + ", " + channels[channel]};
}

inline std::ostream& operator<<(std::ostream& out, const Compared& c) {
  return out << c.where << ": core " << c.core << ", oracle " << c.oracle << ", difference "
             << c.difference.value << " ± " << c.difference.margin(0.05);
}

// Parts without density must agree within noise. Density parts may not differ by more than 1 % of what
// counts; the full form asks for the picture's mean that the 95 % interval of the difference lies within
// that.
inline void expect_equal(const std::string& name, const std::vector<Regions>& core,
                         const std::vector<Regions>& oracle, Part part) {
  const double p_limit = sidak(family, suite_comparisons);
  const bool is_density = part != Part::Direct && part != Part::Emission;
  for (std::size_t region = 0; region < core[0].mean.size(); ++region)
    for (int c = 0; c < 3; ++c) {
      const Compared r = compared(core, oracle, region, part, c);
      if (is_density)
        EXPECT_LE(std::abs(r.difference.value) - r.difference.margin(p_limit), r.tolerance)
            << name << ", " << r;
      else
        EXPECT_GT(r.difference.p(), p_limit) << name << ", " << r;
    }
  if (!is_full() || !is_density) return;
  for (int c = 0; c < 3; ++c) {
    const Compared r = compared(as_one(core), as_one(oracle), 0, part, c);
    EXPECT_LE(std::abs(r.difference.value) + r.difference.margin(0.05), r.tolerance)
        << name << ", whole picture, " << r;
  }
}

// `parts`: those the oracle can answer for.
inline void compare(const std::string& name, const Stage& stage, Which which, const std::vector<Part>& parts,
                    Effort effort = {}) {
  if (is_full()) effort.passes *= full_effort, effort.paths *= full_effort;
  SceneDescription description = stage.scene;
  Warnings warnings;
  const auto scene = compile(description, warnings, {}, 1);
  Counts counts;
  const auto seconds = [begin = std::chrono::steady_clock::now()] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const std::vector<Regions> core = render_core(
      *scene, stage.settings, {effort.seeds, effort.passes, seed_of(name), is_full(), stage.gather_radius},
      effort.side, pool(), counts);
  const double core_seconds = seconds();
  const std::vector<Regions> oracle =
      ask_oracle(description, *scene, stage.settings, which, effort, seed_of(name) + 1000);
  std::printf("%s (core %.1f s, oracle %.1f s)\n", name.c_str(), core_seconds, seconds() - core_seconds);
  for (std::size_t e = 0; e < counts.edits.size(); ++e)
    std::printf("  %s took %llu paths\n", scene->edits()[static_cast<int>(e)].name.c_str(),
                static_cast<unsigned long long>(counts.edits[e].matched));
  for (const Part part : parts) {
    const std::string of = names_of(*scene)[static_cast<std::size_t>(part)];
    if (is_dark(core, part) && is_dark(oracle, part)) continue;
    std::cout << report_line(of, core, oracle, {part});
    expect_equal(name + " " + of, core, oracle, part);
  }
  std::cout << report_line("together", core, oracle, parts) << std::flush;
}

inline const std::vector<Part> lit{Part::Direct, Part::Caustics, Part::Edited, Part::Indirect};
inline const std::vector<Part> everything{Part::Direct, Part::Caustics, Part::Edited, Part::Indirect,
                                          Part::Emission};

}  // namespace sluice::oracle
