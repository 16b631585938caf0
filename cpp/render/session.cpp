// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/session.h"

#include <algorithm>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>

#include "edit/edits.h"
#include "transport/photons/photon_pass.h"
#include "transport/guide/pilot.h"
#include "transport/guide/sample_pilot.h"
#include "transport/view/view_pass.h"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Names of the layers, which are the names of their passes.
std::vector<std::string> layer_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const LayerDescription& layer : scene.edits().layers()) {
    if (layer.name.empty()) throw SceneError("layer", "a layer has no name; give it one");
    if (Film::is_fixed(layer.name))
      throw SceneError("layer '" + layer.name + "'",
                       "a render pass has this name already; choose another one");
    if (std::ranges::find(names, layer.name) != names.end())
      throw SceneError("layer '" + layer.name + "'", "two layers have this name; rename one of them");
    names.push_back(layer.name);
  }
  return names;
}

FilmContents film_contents(const Scene& scene, const RenderSettings& settings) {
  const auto& passes = settings.render_passes;
  if (passes)
    for (const std::string& name : *passes)
      if (!Film::is_fixed(name)) throw SceneError("render pass '" + name + "'", "there is no such pass");
  return {.layers = layer_names(scene), .passes = passes, .is_opaque = !settings.transport.transparent_film};
}

void switch_off(std::vector<EditDescription>& edits) {
  for (EditDescription& edit : edits) edit.enabled = false;  // layers may name them all the same
}

}  // namespace

Session::~Session() { cancel(); }

void Session::start(SceneDescription description, RenderSettings settings) {
  if (!settings.use_edits) switch_off(description.edits);
  launch(std::move(settings), [this, description = std::move(description)](Warnings& warnings) mutable {
    return compile(std::move(description), warnings, [this] { return cancel_.load(); }, settings_.threads);
  });
}

bool Session::start_from(const Session& base, ShotDescription shot, RenderSettings settings) {
  std::shared_ptr<const Scene> compiled;
  {
    const std::lock_guard lock(base.lock_);
    compiled = base.scene_;
  }
  if (!settings.use_edits) switch_off(shot.edits);
  if (!compiled || !can_recompile(*compiled, shot)) return false;
  launch(std::move(settings),
         [this, compiled = std::move(compiled), shot = std::move(shot)](Warnings& warnings) {
           return recompile(*compiled, shot, warnings, [this] { return cancel_.load(); });
         });
  return true;
}

void Session::launch(RenderSettings settings, MakeScene make_scene) {
  {
    const std::lock_guard lock(lock_);
    if (progress_.state != State::Idle) throw std::logic_error("a session renders once: make a new one");
    settings_ = bounded(std::move(settings));
    if (settings_.use_animated_seed)
      settings_.transport.seed = mix(settings_.transport.seed, static_cast<std::uint64_t>(settings_.frame));
    progress_.state = State::Compiling;
    progress_.passes = settings_.passes;
    begin_ = Clock::now();
  }
  try {
    task_ = BackgroundTask([this, make_scene = std::move(make_scene)] { run(make_scene); });
  } catch (const std::system_error& error) {
    fail(std::string("no thread could be started: ") + error.what());
  }
}

void Session::cancel() noexcept { cancel_ = true; }

bool Session::wait(double seconds) {
  std::unique_lock lock(lock_);
  const auto over = [this] {
    return progress_.state != State::Compiling && progress_.state != State::Rendering;
  };
  return over_.wait_for(lock, std::chrono::duration<double>(seconds > 0 ? std::min(seconds, 1e6) : 0.0),
                        over);
}

// What was warned of stays when an error ends the compilation: it may say why.
void Session::compile_scene(const MakeScene& make_scene) {
  Warnings warnings;
  std::shared_ptr<const Scene> scene;
  std::exception_ptr error;
  try {
    scene = make_scene(warnings);
  } catch (...) { error = std::current_exception(); }
  {
    const std::lock_guard lock(lock_);
    scene_ = std::move(scene), warnings_ = std::move(warnings);
  }
  if (error) std::rethrow_exception(error);
}

// Worker threads turn everything into a status: an exception that left one would end the host (Blender).
void Session::run(const MakeScene& make_scene) {
  try {
    compile_scene(make_scene);
    if (!scene_) return finish(State::Cancelled, StopReason::Cancelled);
    render_scene(*scene_);
  } catch (const ExpressionError& error) {
    fail(error.what(), error.item, error.column);
  } catch (const SceneError& error) { fail(error.what(), error.item); } catch (const std::bad_alloc&) {
    fail("out of memory: render fewer pixels, smaller textures or fewer polygons");
  } catch (const std::exception& error) { fail(error.what()); } catch (...) {
    fail("an unknown error");
  }
}

void Session::fail(const std::string& message, const std::string& item, int column) noexcept {
  try {
    const std::lock_guard lock(lock_);
    progress_.failure = Failure{message, item, column};
  } catch (...) {  // no memory for words: failed all the same
  }
  finish(State::Failed);
}

void Session::render_scene(const Scene& scene) {
  ThreadPool pool(settings_.threads);
  const TransportSettings& transport = settings_.transport;
  const Effects effects = find_effects(scene, transport);
  start_rendering(scene, effects);
  Guide guide = make_guide(scene, transport, effects, pool, cancel_);
  PhotonPass photon_pass(scene, transport, effects, pool.size());
  ViewPass view_pass(scene, transport, effects, pool.size());
  PhotonSet photons;
  StopReason stop = StopReason::None;
  for (int pass = 0; stop == StopReason::None; ++pass) {
    const PassContext context{scene, transport, effects, guide, pass};
    Counts counts;
    const Clock::time_point photons_begin = Clock::now();
    const bool traced = !effects.traces_photons() || photon_pass.run(context, pool, cancel_, photons, counts);
    const double photon_seconds = seconds_since(photons_begin);
    if (traced && pass == 0) finish_guide(guide, context, photons, pool, photon_seconds);
    const Clock::time_point view_begin = Clock::now();
    if (!traced ||
        !view_pass.run(context, photons, pool, cancel_, *film_, film_lock_, counts, probes_.get())) {
      stop = StopReason::Cancelled;
      break;
    }
    const bool block_ends = (pass + 1) % passes_per_block == 0;
    if (block_ends) close_film_block();
    const double view_seconds = seconds_since(view_begin);
    record_pass({counts, photons.at_y.size(), photons.at_y.bytes() + photons.at_v.bytes(), photon_seconds,
                 view_seconds});
    stop = should_stop(photon_seconds + view_seconds);
  }
  close_film_block();
  measure_shares(scene);
  if (settings_.explain_edits && stop != StopReason::Cancelled) explain_edits(scene, effects);
  finish(stop == StopReason::Cancelled ? State::Cancelled : State::Finished, stop);
}

// Between the halves of the first pass: where view samples go is found out with its photons.
void Session::finish_guide(Guide& guide, const PassContext& first, const PhotonSet& photons, ThreadPool& pool,
                           double photon_seconds) {
  if (first.settings.use_adaptive_sampling) guide.samples = place_samples(first, photons, pool, cancel_);
  {
    const std::lock_guard lock(film_lock_);
    sample_map_ = guide.samples;
  }
  std::vector<UnmetShare> unmet = unmet_of(first.scene, guide);
  const std::lock_guard lock(lock_);
  for (std::size_t i = 0; i < std::min<std::size_t>(unmet.size(), 3); ++i)
    progress_.unmet.push_back(unmet[i].name);
  statistics_.unmet = std::move(unmet);
  statistics_.seconds_of(Phase::Guide) = seconds_since(begin_) - photon_seconds;
  statistics_.guide_hash = guide.hash();
  statistics_.radius = {guide.radius, guide.caustic_radius};
}

std::optional<Session::Picture> Session::sample_counts() const {
  const std::lock_guard lock(film_lock_);
  if (!sample_map_) return {};
  Picture counts{film_->width(), film_->height(), 4, {}};
  const FrameDescription& frame = scene_->frame();
  for (int y = frame.y0; y < frame.y1; ++y)
    for (int x = frame.x0; x < frame.x1; ++x) {
      const SampleCount at = sample_map_->at(x, y);
      counts.pixels.insert(counts.pixels.end(),
                           {static_cast<float>(at.samples), static_cast<float>(at.emission_samples),
                            static_cast<float>(at.light_samples), at.mean_segments()});
    }
  return counts;
}

void Session::explain_edits(const Scene& scene, const Effects& effects) {
  auto arrivals = find_arrivals(scene, settings_.transport, effects, settings_.threads, cancel_);
  const std::lock_guard lock(lock_);
  statistics_.arrivals = std::move(arrivals);
}

void Session::start_rendering(const Scene& scene, const Effects& effects) {
  const FrameDescription& frame = scene.frame();
  auto film = std::make_unique<Film>(frame.x1 - frame.x0, frame.y1 - frame.y0,
                                     film_contents(scene, settings_), frame.x0, frame.y0);
  auto probes = std::make_unique<Probes>(frame, scene.edits().told_apart());
  {
    const std::lock_guard lock(film_lock_);
    film_ = std::move(film), probes_ = std::move(probes);
  }
  const std::lock_guard lock(lock_);
  statistics_.seconds_of(Phase::Compile) = seconds_since(begin_);
  statistics_.start(scene, effects, settings_.threads);
  progress_.state = State::Rendering;
  begin_ = Clock::now();
}

void Session::close_film_block() {
  const std::lock_guard lock(film_lock_);
  film_->close_block();
}

void Session::measure_shares(const Scene& scene) {
  // what is read here is written by this thread alone
  PictureShares shares = shares_of(scene, *film_, statistics_.counts, progress_.pass);
  const std::lock_guard lock(lock_);
  statistics_.shares = std::move(shares);
}

void Session::record_pass(const PassRecord& pass) {
  const std::lock_guard lock(lock_);
  statistics_.record(pass);
  const std::uint64_t capped = pass.counts.states_capped;
  if (capped > 0 && capped == statistics_.counts.states_capped)  // the first that are
    warnings_.push_back({"edits",
                         "light goes through more combinations of edits than there is memory to tell apart; "
                         "paths beyond them are dropped (the log "
                         "says how many) and the picture depends on the number of threads: lower Max Edits "
                         "per Path, or let edits take less"});
  ++progress_.pass;
  progress_.photons += pass.counts.photon_paths;
  progress_.memory = film_->bytes() + probes_->bytes() + pass.map_bytes;
}

// After each pass.
StopReason Session::should_stop(double last_pass_seconds) {
  if (cancel_) return StopReason::Cancelled;
  // progress_.pass and the film are written by this thread alone
  Pace pace{.passes = progress_.pass, .last_pass_seconds = last_pass_seconds};
  if (measures_error_after(pace.passes)) {
    record_accuracy();
    pace.relative_error = progress_.accuracy.error();
  }
  if (std::ranges::find(settings_.keep_at, pace.passes) != settings_.keep_at.end()) keep_picture();
  pace.seconds = elapsed();
  return stop_after(pace, settings_);
}

// Film and probes are written by this thread's passes alone, of which none runs now.
void Session::record_accuracy() {
  Accuracy now = measure_accuracy(*film_, *probes_);
  record_work(now);
  std::optional<MainCause> cause = main_cause(now, statistics_.edit_names);
  const std::lock_guard lock(lock_);
  progress_.accuracy = now, progress_.main_cause = std::move(cause);
  statistics_.accuracy.push_back(std::move(now));
}

void Session::record_work(Accuracy& of) const {
  of.seconds = elapsed();
  of.rays = statistics_.counts.rays + statistics_.counts.shadow_rays;
  of.photons = statistics_.counts.photon_paths;
}

void Session::keep_picture() {
  Kept kept{
      .accuracy = progress_.accuracy,
      .picture = {film_->width(), film_->height(), film_->channels("Combined"), film_->image("Combined")}};
  if (kept.accuracy.pass != progress_.pass) kept.accuracy = {.pass = progress_.pass};
  record_work(kept.accuracy);
  const std::lock_guard lock(film_lock_);
  kept_.push_back(std::move(kept));
}

std::vector<Session::Kept> Session::kept() const {
  const std::lock_guard lock(film_lock_);
  return kept_;
}

void Session::finish(State state, StopReason reason) {
  {
    const std::lock_guard lock(lock_);
    progress_.seconds = elapsed();
    progress_.state = state;
    progress_.stop_reason = reason;
  }
  over_.notify_all();
}

double Session::elapsed() const { return seconds_since(begin_); }

Progress Session::progress() const {
  const std::lock_guard lock(lock_);
  Progress now = progress_;
  now.passes_to_target = passes_to(settings_.error_target, now.accuracy);
  if (now.state != State::Rendering) return now;
  now.seconds = elapsed();
  now.seconds_left = seconds_left(now, settings_);
  return now;
}

Warnings Session::warnings() const {
  const std::lock_guard lock(lock_);
  return warnings_;
}

RenderStatistics Session::statistics() const {
  const std::lock_guard lock(lock_);
  return statistics_;
}

std::vector<Session::Picture> Session::pictures(const std::vector<std::string>& names) const {
  const std::lock_guard lock(film_lock_);
  if (!film_ || !film_->has_samples()) return {};
  if (std::ranges::any_of(names, [this](const std::string& name) { return film_->channels(name) == 0; }))
    return {};
  std::vector<Picture> found;
  for (const std::string& name : names)
    found.push_back({film_->width(), film_->height(), film_->channels(name), film_->image(name)});
  return found;
}

std::uint64_t Session::film_hash() const {
  const std::lock_guard lock(film_lock_);
  return film_ ? film_->hash() : 0;
}

}  // namespace sluice
