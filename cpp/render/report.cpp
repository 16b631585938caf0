// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/report.h"

#include <algorithm>
#include <cstdio>
#include <span>
#include <string_view>

namespace sluice {
namespace {

template <class... Args>
std::string format(const char* pattern, Args... args) {
  char text[512];
  std::snprintf(text, sizeof text, pattern, args...);
  return text;
}

// Of an edit. View paths carry no energy.
std::string figures(const RenderStatistics& s, std::size_t e) {
  const EditCounts& edit = s.counts.edits[e];
  std::string text =
      "edit " + s.edit_names[e] +
      format(": took %llu paths, sent on %llu, capped %llu", static_cast<unsigned long long>(edit.matched),
             static_cast<unsigned long long>(edit.moved), static_cast<unsigned long long>(edit.capped));
  if (edit.energy_in > 0)
    text += format(", energy out / in %.4g, took %.3g %% of the lamps' light",
                   edit.energy_out / edit.energy_in, 100 * edit.energy_in / s.counts.ledger.emitted);
  if (edit.matched == 0 && edit.has_acted()) text += ", took light on its way to the eye";
  if (e < s.shares.edits.size() && (edit.moved > 0 || edit.shown > 0))
    text += format(", makes %.3g %% of the picture's light, about %.2g s", 100 * s.shares.edits[e],
                   edit.seconds / s.threads);
  return text + '\n';
}

// Edits that took no light, and what light there was.
std::string missed(const RenderStatistics& s) {
  std::string text;
  for (std::size_t e = 0; e < s.arrivals.size() && e < s.counts.edits.size(); ++e) {
    const Arrivals& found = s.arrivals[e];
    if (s.counts.edits[e].has_acted() || found.probed == 0) continue;
    text +=
        "edit " + s.edit_names[e] +
        format(": no light that matches crossed the entry; %llu of %llu test paths crossed it",
               static_cast<unsigned long long>(found.crossed), static_cast<unsigned long long>(found.probed));
    if (found.taken > 0)
      text += format("; %llu were taken before, most by ", static_cast<unsigned long long>(found.taken)) +
              found.taker;
    for (const auto& kind : found.kinds) text += format("; %.0f %% as ", 100 * kind.share) + kind.expression;
    text += '\n';
  }
  return text;
}

std::string times(const RenderStatistics& s) {
  std::string text = "time: ";
  for (int i = 0; i < phase_count; ++i)
    text += format("%s%s %.2f s", i > 0 ? ", " : "", name_of(static_cast<Phase>(i)),
                   s.seconds[static_cast<std::size_t>(i)]);
  return text + format(" on %d threads\n", s.threads);
}

// "dropped: 3 not finite; clamped: …": every counter, also those of nothing.
std::string drops(const Counters& counters) {
  std::string text;
  std::string_view last;
  for (const DropCounter& counter : drop_counters) {
    if (counter.fate != last)
      text += (text.empty() ? "" : "; ") + std::string(counter.fate) + ": ";
    else
      text += ", ";
    text += std::to_string(counters.*counter.value) + counter.how;
    last = counter.fate;
  }
  return text + '\n';
}

double millions(std::uint64_t n) { return static_cast<double>(n) * 1e-6; }

}  // namespace

std::string hex(std::uint64_t hash) { return format("%016llx", static_cast<unsigned long long>(hash)); }

std::string describe(const RenderStatistics& s) {
  const Counts& c = s.counts;
  std::string text;
  for (const auto& reason : s.reasons)
    text +=
        format("%s: %s (%s)\n", reason.effect.c_str(), reason.runs ? "ran" : "skipped", reason.why.c_str());
  text += times(s);
  text += format(
      "work: %zu triangles, %.2f M rays, %.2f M photon paths, %.2f M photons stored, %.2f M view paths, %.2f "
      "M gathers of %.1f photons\n",
      s.triangles, millions(c.rays + c.shadow_rays), millions(c.photon_paths), millions(c.photons_stored),
      millions(c.view_paths), millions(c.gathers),
      c.gathers ? static_cast<double>(c.photons_gathered) / static_cast<double>(c.gathers) : 0.0);
  text += format("radius: %.4g m, caustics %.4g m (first pass)\n", static_cast<double>(s.radius[0]),
                 static_cast<double>(s.radius[1]));
  for (std::size_t e = 0; e < c.edits.size() && e < s.edit_names.size(); ++e) text += figures(s, e);
  for (const LayerShare& layer : s.shares.layers)
    text += "layer " + layer.name + ": " + layer.expression +
            format(", %.3g %% of the picture's light\n", 100 * layer.share);
  text += missed(s);
  constexpr std::size_t told = 8;
  for (const UnmetShare& unmet : std::span(s.unmet).first(std::min(told, s.unmet.size())))
    text += "not met: " + unmet.name +
            format(
                ": the pilot found nothing of it where the camera looks; %.2g %% of the photons look on, and "
                "the noise told does not know of it\n",
                100 * unmet.share);
  if (s.unmet.size() > told) text += format("not met: %zu more\n", s.unmet.size() - told);
  text += drops(c);
  text += format("energy ledger: closes to %.1e of what was emitted\n", s.worst_ledger_residual);
  return text;
}

}  // namespace sluice
