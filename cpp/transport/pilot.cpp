// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/pilot.h"

#include <algorithm>
#include <numeric>

#include "transport/density.h"
#include "transport/light_path.h"
#include "transport/light_trust.h"
#include "transport/pass.h"
#include "transport/radii.h"
#include "transport/targets.h"

namespace sluice {
namespace {

constexpr float own_share = 0.25f;     // least share of a light's own distribution (design §5)
constexpr float close_share = 0.25f;   // of the photons of a light go towards what sends them on to caustics and edits
constexpr float far_share = 0.1f;      // of a light from infinity towards entries outside of all surfaces, at least
constexpr float seen_share = 0.5f;     // towards what the camera sees: by directions, or from infinity towards a sphere around it
constexpr std::size_t most_targets = 64;
constexpr int paths_per_entry = 256;  // that find out whether it takes light that is aimed at it
// Photons that a gather at y should find in the first pass. View samples are the noise, so more cost time and blur for nothing; far
// fewer are noise themselves.
constexpr double fewest_photons = 8, most_photons = 32;
constexpr double photons_on_disk = 16, photons_on_soft_disk = 32;  // at v in the first pass
constexpr unsigned close_arrivals = caustic_arrivals | edited_arrivals;
constexpr int paths_per_view_sample = 8, paths_per_chunk = 2048;

// What the camera sees, coarsely: cells that hold a vertex v or y of some view path.
class VisibleCells {
 public:
  explicit VisibleCells(double extent) : cells_(0.04 * extent) {}
  // Met by a ray in that direction.
  void add(const Hit& hit, const V3f& direction) {
    cells_.at(hit.position);
    hits_.push_back(hit);
    if (hit.ng.dot(direction) > 0) hits_.back().ng = -hit.ng;
  }
  [[nodiscard]] bool contains(const V3f& p) const { return cells_.find(V3d(p)); }
  [[nodiscard]] bool empty() const noexcept { return hits_.empty(); }
  [[nodiscard]] const std::vector<Hit>& hits() const noexcept { return hits_; }  // ng on the side that was seen

  // A sphere around all but the outermost 2 % of the points.
  [[nodiscard]] Target sphere() const {
    V3d middle(0);
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> x;
      for (const Hit& hit : hits_) x.push_back(hit.position[axis]);
      std::ranges::sort(x);
      middle[axis] = 0.5 * (x[x.size() / 100] + x[x.size() - 1 - x.size() / 100]);
    }
    std::vector<double> distance;
    for (const Hit& hit : hits_) distance.push_back((hit.position - middle).length());
    std::ranges::sort(distance);
    return {middle, static_cast<float>(distance[distance.size() * 98 / 100])};
  }

 private:
  Cells cells_;
  std::vector<Hit> hits_;
};

// Camera rays through mirrors and glass to v, and one diffuse segment on to y.
struct Distances {
  double footprint = 0;  // of a pixel at v: half of all see a smaller one (a mean would be the horizon's)
  double length = 0;     // from v to y, in the mean
};

VisibleCells look_around(const Scene& scene, const TransportSettings& settings, const std::atomic<bool>& cancel, Distances& typical) {
  VisibleCells seen(scene.extent());
  const FrameDescription& frame = scene.frame();
  std::vector<double> footprints;
  int far_count = 0;
  Vertex vertex;
  for (int i = 0; i < settings.pilot_paths / paths_per_view_sample && !cancel; ++i) {
    const Sampler sampler(key_of(settings.seed, PilotPurpose::View), static_cast<std::uint32_t>(i));
    const V2f pixel = sampler.pair(0);
    Ray ray = scene.camera().generate(pixel.x * static_cast<float>(frame.width), pixel.y * static_cast<float>(frame.height), sampler.pair(1));
    bool ended = false;
    for (std::uint32_t depth = 0; depth < 12 && !ended; ++depth) {
      const auto hit = scene.intersect(ray);
      if (!hit) break;
      make_vertex(scene, *hit, -ray.direction, ray.from_camera, Carries::Radiance, vertex);
      V3f onward = ray.direction;
      if (vertex.bsdf.events() & gathering) {
        seen.add(*hit, ray.direction);
        footprints.push_back(scene.camera().footprint(hit->position));
        ended = true;
        onward = Frame(vertex.bsdf.ng).to_world(sample_cosine(sampler.pair(2 + 2 * depth)));
        if (const auto far = scene.intersect(ray_from(*hit, onward))) {
          seen.add(*far, onward);
          typical.length += far->t;
          ++far_count;
        }
      } else if (const auto sample = sluice::sample(vertex.bsdf, vertex.point.wo, sampler.pair(3 + 2 * depth).x, sampler.pair(2 + 2 * depth), followed)) {
        onward = sample->wi;
      } else if (is_black(vertex.bsdf.transparency)) {
        break;
      }
      ray = ray_from(*hit, onward);
    }
  }
  typical.length /= std::max(far_count, 1);
  if (footprints.empty()) return seen;
  const auto middle = footprints.begin() + static_cast<std::ptrdiff_t>(footprints.size() / 2);
  std::ranges::nth_element(footprints, middle);
  typical.footprint = *middle;
  return seen;
}

// What the photons of one light brought. Of those that are stored: what comes straight from a light counts only close to it.
struct Yield {
  std::vector<double> close;       // per target: useful light that arrived by mirrors, glass or exits
  std::vector<double> aims;        // per cell of AimTable: useful light that started there
  std::vector<std::pair<int, double>> starts;  // the same photon by photon, while they are few
  double seen = 0, all = 0;        // luminous flux where the camera looks, and anywhere

  void operator+=(Yield& o) {
    const auto add = [](std::vector<double>& to, const std::vector<double>& from) {
      to.resize(std::max(to.size(), from.size()));
      for (std::size_t i = 0; i < from.size(); ++i) to[i] += from[i];
    };
    add(close, o.close);
    std::ranges::stable_sort(o.starts, {}, &std::pair<int, double>::first);
    if (!o.starts.empty()) aims.resize(AimTable::cells);
    for (std::size_t i = 0; i < o.starts.size();) {
      const int cell = o.starts[i].first;
      double sum = 0;
      for (; i < o.starts.size() && o.starts[i].first == cell; ++i) sum += o.starts[i].second;
      aims[static_cast<std::size_t>(cell)] += sum;
    }
    seen += o.seen, all += o.all;
  }
};

class Pilot {
 public:
  Pilot(const Scene& scene, const TransportSettings& settings, const Effects& effects, ThreadPool& pool, const std::atomic<bool>& cancel)
      : scene_(scene), settings_(settings), effects_(effects), pool_(pool), cancel_(cancel), far_(find_far_entries(scene)) {
    for (int t = 0; t < pool.size(); ++t) tracers_.emplace_back(scene, settings, effects, pool.size());
  }

  Guide run() {
    Guide guide;
    Distances typical;
    const VisibleCells seen = look_around(scene_, settings_, cancel_, typical);
    const auto extent = static_cast<float>(scene_.extent());
    const DiskBounds bounds(scene_.camera(), scene_.frame(), settings_);
    const auto footprint = static_cast<float>(typical.footprint);
    guide.caustic_radius = bounds.common(footprint);
    guide.least_radius = guide.most_radius = guide.radius = most_radius_of_extent * extent;
    if (!effects_.photons()) return guide;
    add_specular_targets(scene_, most_targets / 2, guide.targets);
    find_entries(guide);
    if (far_.target) far_target_ = guide.targets.size(), guide.targets.push_back(*far_.target);
    const int seen_target = seen.empty() ? -1 : static_cast<int>(guide.targets.size());
    if (seen_target >= 0) guide.targets.push_back(seen.sphere());

    std::vector<float> power;
    for (const Light& light : scene_.lights()) power.push_back(light.power);
    guide.lights = Distribution(power);
    std::vector<float> even(guide.targets.size() + 2, 0.5f / static_cast<float>(std::max<std::size_t>(guide.targets.size(), 1)));
    even.front() = 0.5f, even.back() = 0;
    guide.strategies.assign(power.size(), Distribution(even));
    guide.aims.resize(power.size());
    if (guide.lights.empty()) return guide;
    guide.trust = try_lights(scene_, settings_, effects_, seen.hits(), pool_, cancel_);
    for (LightTracer& tracer : tracers_) tracer.trust = &guide.trust;
    share_out(guide, seen, seen_target, power);
    if (!cancel_) size_gathers(guide, seen, typical.length);
    if (cancel_ || !(footprint > 0)) return guide;
    const std::vector<V3d> places = visible_places(seen);
    const double part = static_cast<double>(settings_.pilot_paths) / settings_.photons;  // of a pass's photons are the pilot's
    const float near = bounds.widest(footprint, false), far = bounds.widest(footprint, true);
    guide.sharp_disks = size_disks({photons_, places, close_arrivals & ~soft_arrivals, photons_on_disk * part, guide.caustic_radius, near, near}, pool_, cancel_);
    guide.soft_disks = size_disks({photons_, places, soft_arrivals, photons_on_soft_disk * part, guide.caustic_radius, near, far}, pool_, cancel_);
    return guide;
  }

 private:
  // Entries become targets only if light that an entry takes was really met: else the guide, and so the image, is that of no edit. Each is
  // tried by itself, whatever others there are: an edit that takes nothing must not cost another one its target.
  void find_entries(Guide& guide) {
    const Edits& edits = scene_.edits();
    if (!effects_.light_edits || scene_.lights().empty()) return;
    std::vector<int> left;
    for (int e = 0; e < edits.size(); ++e)
      if (contains(edits.takers(Side::Light), e) && (!edits[e].exits.empty() || edits[e].is_partial)) left.push_back(e);
    const Guide aim = aim_anywhere();
    std::vector<char> moves(most_targets);
    for (std::size_t begin = 0; begin < left.size() && guide.targets.size() + 1 < most_targets && !cancel_; begin += most_targets) {
      const auto some = std::span(left).subspan(begin, std::min(most_targets, left.size() - begin));
      pool_.parallel_for(some.size(), [&](std::size_t i, int thread) { moves[i] = moves_light(aim, some[i], tracers_[static_cast<std::size_t>(thread)]); });
      for (std::size_t i = 0; i < some.size() && guide.targets.size() + 1 < most_targets; ++i)
        if (moves[i]) guide.targets.push_back(sphere_around(edits[some[i]].entry));
    }
  }

  // Towards one target, half of it from lights by power, half from all alike: an edit may name a dim one.
  [[nodiscard]] Guide aim_anywhere() const {
    double power = 0;
    for (const Light& light : scene_.lights()) power += light.power;
    std::vector<float> share;
    for (const Light& light : scene_.lights())
      share.push_back(static_cast<float>((power > 0 ? light.power / power : 0) + 1 / static_cast<double>(scene_.lights().size())));
    const float towards[] = {0, 1, 0};
    Guide aim;
    aim.targets.resize(1);
    aim.lights = Distribution(share);
    aim.strategies.assign(share.size(), Distribution(towards));
    aim.aims.resize(share.size());
    return aim;
  }

  [[nodiscard]] bool moves_light(Guide aim, int edit, LightTracer& tracer) const {
    aim.targets[0] = sphere_around(scene_.edits()[edit].entry);
    tracer.counts.start(scene_.edits().size());
    std::vector<Photon> photons;
    for (int path = 0; path < paths_per_entry && !cancel_; ++path) {
      const Sampler sampler(key_of(settings_.seed, PilotPurpose::Entries), static_cast<std::uint32_t>(path));
      photons.clear();
      if (const auto photon = emit_photon(scene_, aim, sampler)) tracer.trace(*photon, 1, sampler, static_cast<std::uint64_t>(path), photons);
      if (tracer.counts.of_edit(edit).moved > 0) return true;
    }
    return false;
  }

  // Traces the pilot's photons and turns what they brought into the shares of lights and targets.
  void share_out(Guide& guide, const VisibleCells& seen, int seen_target, const std::vector<float>& power) {
    const std::vector<Yield> yields = trace(guide, seen);
    std::vector<float> share;
    for (std::size_t l = 0; l < yields.size(); ++l) {
      const Yield& yield = yields[l];
      // A light that the pilot did not see at work may still matter: a tenth of the photons follow power alone.
      share.push_back(static_cast<float>(yield.seen + 0.1 * yield.all) + 0.1f * power[l] * static_cast<float>(std::min(1.0, total_ / std::max(guide.lights.total(), 1e-30))));
      std::vector<float> weights(guide.targets.size() + 2, 0.0f);
      double close = 0;
      for (const double c : yield.close) close += c;
      if (close > 0)
        for (std::size_t t = 0; t < guide.targets.size(); ++t) weights[t + 1] = static_cast<float>(close_share * yield.close[t] / close);
      if (!yield.aims.empty()) guide.aims[l] = AimTable(std::vector<float>(yield.aims.begin(), yield.aims.end()));
      if (!guide.aims[l].empty())
        weights.back() = seen_share;
      else if (seen_target >= 0 && yield.seen < 0.5 * yield.all)
        weights[static_cast<std::size_t>(seen_target) + 1] += seen_share;
      if (far_.is_for[l]) weights[far_target_ + 1] = std::max(weights[far_target_ + 1], far_share);
      weights[0] = std::max(own_share, 1 - std::accumulate(weights.begin() + 1, weights.end(), 0.0f));
      guide.strategies[l] = Distribution(weights);
    }
    const Distribution lights(share);
    if (!lights.empty()) guide.lights = lights;
  }

  // The radii at y, from the density of the pilot's photons where the camera looks.
  void size_gathers(Guide& guide, const VisibleCells& seen, double mean_length) {
    PhotonMap map;
    map.build(photons_, (1u << arrival_count) - 1, 2 * guide.radius, pool_, cancel_);
    const std::size_t step = std::max<std::size_t>(1, seen.hits().size() / 1024);
    double found = 0, asked = 0;
    for (std::size_t i = 0; i < seen.hits().size(); i += step, ++asked) map.query(V3f(seen.hits()[i].position), guide.radius, [&](const Photon&) { ++found; });
    const double expected = asked > 0 ? found / asked * settings_.photons / settings_.pilot_paths : 0;
    const auto radius_for = [&](double photons) { return expected > photons ? static_cast<float>(guide.radius * std::sqrt(photons / expected)) : guide.radius; };
    guide.least_radius = radius_for(fewest_photons), guide.most_radius = radius_for(most_photons);
    guide.radius = gather_radius(guide, mean_length, 1 / pi);
  }

  // Where the pilot's photons lie, as far as the camera sees it.
  std::vector<V3d> visible_places(const VisibleCells& seen) const {
    std::vector<V3d> places;
    for (const auto& chunk : photons_)
      for (const Photon& photon : chunk)
        if (seen.contains(photon.position)) places.emplace_back(photon.position);
    return places;
  }

  std::vector<Yield> trace(const Guide& guide, const VisibleCells& seen) {
    const int paths = settings_.pilot_paths;
    const std::size_t chunks = static_cast<std::size_t>((paths + paths_per_chunk - 1) / paths_per_chunk), lights = scene_.lights().size();
    photons_.assign(chunks, {});
    std::vector<std::vector<Yield>> chunk_yield(chunks, std::vector<Yield>(lights));
    pool_.parallel_for(chunks, [&](std::size_t c, int thread) {
      LightTracer& tracer = tracers_[static_cast<std::size_t>(thread)];
      std::vector<Photon> photons;
      const auto begin = static_cast<std::uint32_t>(c) * paths_per_chunk, end = std::min(begin + paths_per_chunk, static_cast<std::uint32_t>(paths));
      for (std::uint32_t path = begin; path < end && !cancel_; ++path) {
        const Sampler sampler(key_of(settings_.seed, PilotPurpose::Photons), path);
        const auto photon = emit_photon(scene_, guide, sampler);
        if (!photon) continue;
        photons.clear();
        tracer.trace(*photon, 1.0f / static_cast<float>(paths), sampler, path, photons);
        account(guide, seen, *photon, photons, chunk_yield[c][static_cast<std::size_t>(photon->light)]);
        photons_[c].insert(photons_[c].end(), photons.begin(), photons.end());
      }
    });
    std::vector<Yield> yields(lights);
    for (auto& yield : yields) yield.close.resize(guide.targets.size());
    for (auto& of_chunk : chunk_yield)
      for (std::size_t l = 0; l < lights; ++l) yields[l] += of_chunk[l];
    for (const Yield& yield : yields) total_ += yield.all;
    return yields;
  }

  [[nodiscard]] static bool is_close(const Photon& photon) noexcept { return close_arrivals & bit_of(photon.arrival); }

  void account(const Guide& guide, const VisibleCells& seen, const EmittedPhoton& start, const std::vector<Photon>& photons, Yield& yield) const {
    double close = 0, seen_flux = 0;
    for (const Photon& photon : photons) {
      const double flux = luminance(photon.flux());
      yield.all += flux;
      if (!seen.contains(photon.position)) continue;
      seen_flux += flux;
      if (is_close(photon)) close += flux;
    }
    yield.seen += seen_flux;
    const Light& light = scene_.lights()[static_cast<std::size_t>(start.light)];
    const bool infinite = is_infinite(light);
    if (!std::holds_alternative<World>(light.kind)) {  // the world shines along every axis: places tell nothing
      const V2f uv = infinite ? SunPlane(whole_scene(scene_), sun_axis(scene_, start.light)).uv(start.origin, start.direction) : uv_of_direction(start.direction);
      yield.starts.emplace_back(AimTable::cell(uv), seen_flux);
    }
    if (close == 0) return;
    yield.close.resize(guide.targets.size());
    for (std::size_t t = 0; t < guide.targets.size(); ++t)
      if (aims_at(guide.targets[t], start.origin, start.direction, infinite)) yield.close[t] += close;
  }

  const Scene& scene_;
  const TransportSettings& settings_;
  const Effects& effects_;
  ThreadPool& pool_;
  const std::atomic<bool>& cancel_;
  const FarEntries far_;
  std::size_t far_target_ = 0;  // if there are some
  std::vector<LightTracer> tracers_;
  std::vector<std::vector<Photon>> photons_;  // of the pilot, by chunk
  double total_ = 0;
};

}  // namespace

Guide make_guide(const Scene& scene, const TransportSettings& settings, const Effects& effects, ThreadPool& pool, const std::atomic<bool>& cancel) {
  return Pilot(scene, settings, effects, pool, cancel).run();
}

}  // namespace sluice
