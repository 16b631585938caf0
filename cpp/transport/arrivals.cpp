// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/arrivals.h"

#include <algorithm>
#include <map>

#include "transport/light_path.h"
#include "transport/pass.h"
#include "transport/targets.h"

namespace sluice {
namespace {

constexpr int all_paths = 1 << 15, fewest_paths = 1 << 7;
constexpr std::size_t max_targets = 32;
constexpr float own_share = 1.0f / 3;  // of the photons leave as they would anyway
constexpr std::size_t most_kinds = 5, longest = 5;

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

std::string symbol(const Scene& scene, const Witness::Step& step) {
  static constexpr const char* letters[] = {"L", "E", "D", "S", "G", "F"};
  const std::string letter = letters[static_cast<int>(step.kind)];
  if (step.kind == Event::F) return letter + quoted(scene.edits()[step.thing].name);
  if (step.thing < 0 || scene.entities()[static_cast<std::size_t>(step.thing)].names.empty()) return letter;
  return letter + quoted(scene.entities()[static_cast<std::size_t>(step.thing)].names.front());
}

// An expression for a word and its like. The same event over and over is one with +. Of light that was
// scattered on its way only the end counts, what it met last: L.*D'Wall', or L.*[DF]S'Egg'+ after mirrors and
// glass. Of a long word without, the two ends.
std::string expression_for(const Scene& scene, const Witness& witness, int word) {
  std::vector<std::string> symbols;  // backwards
  std::vector<bool> repeats;
  bool scattered = false;
  bool followed_only = true;
  std::size_t followed_last = 0;  // symbols of mirrors and glass at the end
  for (int at = word; at >= 0; at = witness.step(at).before) {
    const Event kind = witness.step(at).kind;
    followed_only &= kind == Event::S;
    scattered |= kind == Event::D || kind == Event::G;
    std::string next = symbol(scene, witness.step(at));
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
  if (symbols.size() > longest) return written(symbols.size() - 1) + ".*" + written(0);
  std::string text;
  for (std::size_t i = symbols.size(); i-- > 0;) text += written(i);
  return text;
}

}  // namespace

int Witness::after(int word, Event kind, int thing) noexcept {
  if (event_count_ == static_cast<int>(events_.size())) return word;
  events_[static_cast<std::size_t>(event_count_)] = {word, kind, thing};
  return event_count_++;
}

void Witness::look(int word, double energy, const Segment& segment,
                   const std::optional<Crossing>& capture) noexcept {
  const Quad& quad = edits_[edit_].entry;
  if (segment.excluded_group == quad.group) return;
  const auto hit = intersect(quad, segment.origin, segment.direction);
  if (!hit || hit->t <= segment.t_min || hit->t > segment.t_max) return;
  const bool is_taken = capture && (capture->group == quad.group ? is_first(*capture) : capture->t < hit->t);
  note({word, energy, segment.direction.dot(quad.frame.n) > 0}, is_taken ? capture : std::nullopt);
}

void Witness::look_at_exit(const LightPath& path, const std::optional<Crossing>& capture) noexcept {
  const Quad& quad = edits_[edit_].entry;
  if (path.at_edit == edit_ || edits_.quad(path.at_edit, path.at_exit).group != quad.group ||
      !locate(quad, path.origin))
    return;
  const bool is_taken = capture && is_first(*capture);
  note({path.word, luminance(path.flux), V3d(path.direction).dot(quad.frame.n) > 0},
       is_taken ? capture : std::nullopt);
}

bool Witness::is_first(const Crossing& capture) const noexcept {
  return std::pair(capture.order, capture.edit) < std::pair(edits_[edit_].order, edit_);
}

void Witness::note(const Crossed& crossed, const std::optional<Crossing>& taken_before) noexcept {
  if (crossed.word < 0 || crossing_count_ == static_cast<int>(crossings_.size())) return;
  if (taken_before)
    taker_ = taken_before->edit;
  else
    crossings_[static_cast<std::size_t>(crossing_count_++)] = crossed;
}

std::vector<Arrivals> find_arrivals(const Scene& scene, const TransportSettings& settings,
                                    const Effects& effects, int threads, const std::atomic<bool>& cancel) {
  std::vector<Arrivals> found(static_cast<std::size_t>(scene.edits().size()));
  if (found.empty()) return found;
  const int paths = std::max(fewest_paths, all_paths / static_cast<int>(found.size()));
  const std::vector<Target> places = places_on_the_way(scene);
  LightTracer tracer(scene, settings, effects, threads);
  for (std::size_t e = 0; e < found.size() && !scene.lights().empty() && !cancel; ++e) {
    const Edit& edit = scene.edits()[static_cast<int>(e)];
    if (edit.side != Side::Light) continue;
    const Guide guide = aim_at(scene, sphere_around(edit.entry), places, own_share);
    Witness witness(scene.edits(), static_cast<int>(e));
    // by side: what a surface sends back would hide what arrives at it
    std::map<std::string, double> kinds[2];
    double total[2] = {0, 0};
    std::vector<std::uint64_t> takers(found.size(), 0);
    std::vector<Photon> photons;
    for (int path = 0; path < paths && !cancel; ++path, ++found[e].probed) {
      const Sampler sampler(key_of(settings.seed, PilotPurpose::Arrivals, e),
                            static_cast<std::uint32_t>(path));
      const auto photon = emit_photon(scene, guide, sampler);
      if (!photon) continue;
      photons.clear(), witness.clear();
      tracer.trace(*photon, 1, sampler, static_cast<std::uint64_t>(path), photons, &witness);
      found[e].crossed += !witness.crossed().empty();
      if (witness.taker() >= 0) ++found[e].taken, ++takers[static_cast<std::size_t>(witness.taker())];
      for (const auto& [word, energy, along] : witness.crossed())
        kinds[along][expression_for(scene, witness, word)] += energy, total[along] += energy;
    }
    if (found[e].taken > 0)
      found[e].taker =
          scene.edits()[static_cast<int>(std::ranges::max_element(takers) - takers.begin())].name;
    const int side = total[1] > total[0] ? 1 : 0;
    for (const auto& [expression, energy] : kinds[side])
      found[e].kinds.push_back({expression, total[side] > 0 ? energy / total[side] : 0});
    std::ranges::stable_sort(found[e].kinds, std::greater{}, &Arrivals::Kind::share);
    found[e].kinds.resize(std::min(found[e].kinds.size(), most_kinds));
  }
  return found;
}

}  // namespace sluice
