// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/arrivals.h"

#include <algorithm>
#include <map>

#include "transport/guide/targets.h"
#include "transport/pass.h"
#include "transport/photons/arrival_recorder.h"

namespace sluice {
namespace {

constexpr int all_paths = 1 << 15, min_paths = 1 << 7;
constexpr std::size_t max_targets = 32;
constexpr float own_share = 1.0f / 3;  // of the photons leave as they would anyway
constexpr std::size_t max_kinds = 5, max_symbols = 5;

// What light may come by on its way to an entry: things that mirror or refract, and entries far out.
std::vector<Target> places_on_the_way(const Scene& scene) {
  std::vector<Target> places = specular_targets(scene, max_targets);
  if (const auto far = find_far_entries(scene).target) places.push_back(*far);
  return places;
}

std::string quoted(const std::string& name) {
  std::string text = "'";
  for (const char c : name) {
    if (c == '\'' || c == ',' || c == '\\') text += '\\';
    text += c;
  }
  return text + "'";
}

std::string symbol(const Scene& scene, const ArrivalRecorder::Step& step) {
  static constexpr const char* letters[] = {"L", "E", "D", "S", "G", "F"};
  const std::string letter = letters[static_cast<int>(step.kind)];
  if (step.kind == Event::F) return letter + quoted(scene.edits()[step.thing].name);
  if (step.thing < 0 || scene.entities()[static_cast<std::size_t>(step.thing)].names.empty()) return letter;
  return letter + quoted(scene.entities()[static_cast<std::size_t>(step.thing)].names.front());
}

// An expression for a word and its like. The same event over and over is one with +. Of light that was
// scattered on its way only the end counts, what it met last: L.*D'Wall', or L.*[DF]S'Egg'+ after mirrors and
// glass. Of a long word without, the two ends.
std::string expression_for(const Scene& scene, const ArrivalRecorder& recorder, ArrivalRecorder::Word word) {
  std::vector<std::string> symbols;  // backwards
  std::vector<bool> repeats;
  bool scattered = false;
  bool followed_only = true;
  std::size_t followed_last = 0;  // symbols of mirrors and glass at the end
  for (; word.last >= 0; word = recorder.step(word).before) {
    const Event kind = recorder.step(word).kind;
    followed_only &= kind == Event::S;
    scattered |= kind == Event::D || kind == Event::G;
    std::string next = symbol(scene, recorder.step(word));
    if (!symbols.empty() && symbols.back() == next) {
      repeats.back() = true;
      continue;
    }
    symbols.push_back(std::move(next));
    repeats.push_back(false);
    if (followed_only) followed_last = symbols.size();
  }
  const auto written = [&](std::size_t i) { return symbols[i] + (repeats[i] ? "+" : ""); };
  if (scattered) {
    if (followed_last == 0) return "L.*" + symbols[0];
    std::string text = "L.*[DF]";
    for (std::size_t i = followed_last; i-- > 0;) text += symbols[i] + "+";
    return text;
  }
  if (symbols.size() > max_symbols) return written(symbols.size() - 1) + ".*" + written(0);
  std::string text;
  for (std::size_t i = symbols.size(); i-- > 0;) text += written(i);
  return text;
}

// What the paths to one entry add up to.
class ArrivalSums {
 public:
  ArrivalSums(const Scene& scene) : scene_(scene), takers_(static_cast<std::size_t>(scene.edits().size())) {}

  void add(const ArrivalRecorder& recorder) {
    crossed_ += !recorder.arrived().empty();
    if (recorder.taker() >= 0) ++taken_, ++takers_[static_cast<std::size_t>(recorder.taker())];
    for (const auto& [word, energy, along] : recorder.arrived())
      kinds_[along][expression_for(scene_, recorder, word)] += energy, energy_[along] += energy;
  }

  // Of `probed` paths.
  [[nodiscard]] Arrivals told(std::uint64_t probed) const {
    Arrivals found{.probed = probed, .crossed = crossed_, .taken = taken_, .taker = {}, .kinds = {}};
    if (taken_ > 0)
      found.taker =
          scene_.edits()[static_cast<int>(std::ranges::max_element(takers_) - takers_.begin())].name;
    const int side = energy_[1] > energy_[0] ? 1 : 0;
    for (const auto& [expression, energy] : kinds_[side])
      found.kinds.push_back({expression, energy_[side] > 0 ? energy / energy_[side] : 0});
    std::ranges::stable_sort(found.kinds, std::greater{}, &Arrivals::Kind::share);
    found.kinds.resize(std::min(found.kinds.size(), max_kinds));
    return found;
  }

 private:
  const Scene& scene_;
  std::uint64_t crossed_ = 0, taken_ = 0;
  std::vector<std::uint64_t> takers_;  // by edit
  // by side: what a surface sends back would hide what arrives at it
  std::map<std::string, double> kinds_[2];
  double energy_[2] = {0, 0};
};

}  // namespace

std::vector<Arrivals> find_arrivals(const Scene& scene, const TransportSettings& settings,
                                    const Effects& effects, int threads, const std::atomic<bool>& cancel) {
  const int edits = scene.edits().size();
  std::vector<Arrivals> found(static_cast<std::size_t>(edits));
  if (found.empty()) return found;
  const int paths = std::max(min_paths, all_paths / edits);
  const std::vector<Target> places = places_on_the_way(scene);
  LightTracer tracer(scene, settings, effects, threads, nullptr, ArrivalRecorder(scene));
  std::vector<Photon> photons;  // which nobody reads
  for (int e = 0; e < edits && !scene.lights().empty() && !cancel; ++e) {
    if (scene.edits()[e].side != Side::Light) continue;
    const EmissionGuide guide = aim_at(scene, sphere_around(scene.edits()[e].entry), places, own_share);
    const std::uint64_t key = key_of(settings.seed, PilotPurpose::Arrivals, static_cast<std::uint64_t>(e));
    ArrivalSums sums(scene);
    tracer.observer.watch(e);
    int path = 0;
    for (; path < paths && !cancel; ++path) {
      const Sampler sampler(key, static_cast<std::uint32_t>(path));
      const auto photon = emit_photon(scene, guide, sampler);
      if (!photon) continue;
      photons.clear(), tracer.observer.clear();
      tracer.trace(*photon, 1, sampler, static_cast<std::uint64_t>(path), photons);
      sums.add(tracer.observer);
    }
    found[static_cast<std::size_t>(e)] = sums.told(static_cast<std::uint64_t>(path));
  }
  return found;
}

}  // namespace sluice
