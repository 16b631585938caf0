// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/session.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>

#include "edit/gates.h"
#include "transport/guide/pilot.h"
#include "transport/guide/sample_pilot.h"
#include "transport/photons/photon_pass.h"
#include "transport/view_pass.h"

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

// By the names that the artist knows them by.
std::vector<UnmetShare> unmet_of(const Scene& scene, const Guide& guide) {
  std::vector<UnmetShare> named;
  for (const auto& [light, effect, share] : guide.unmet) {
    const std::vector<std::string> none,
        &names =
            light < 0 ? none : scene.entities()[static_cast<std::size_t>(scene.light_entity(light))].names;
    named.push_back({names.empty() ? effect : names.front(), share});
  }
  return named;
}

void switch_off(std::vector<EditDescription>& edits) {
  for (EditDescription& edit : edits) edit.enabled = false;  // layers may name them all the same
}

}  // namespace

Session::~Session() { cancel(); }

void Session::start(SceneDescription description, RenderSettings settings) {
  if (!settings.use_edits) switch_off(description.edits);
  launch(std::move(settings), [this, things = std::move(description)](Warnings& warnings) mutable {
    return compile(std::move(things), warnings, [this] { return cancel_.load(); }, settings_.threads);
  });
}

bool Session::start_from(const Session& base, ShotDescription shot, RenderSettings settings) {
  std::shared_ptr<const Scene> things;
  {
    const std::lock_guard lock(base.lock_);
    things = base.scene_;
  }
  if (!settings.use_edits) switch_off(shot.edits);
  if (!things || !can_recompile(*things, shot)) return false;
  launch(std::move(settings), [this, things = std::move(things), shot = std::move(shot)](Warnings& warnings) {
    return recompile(*things, shot, warnings, [this] { return cancel_.load(); });
  });
  return true;
}

void Session::launch(RenderSettings settings, Compile compile) {
  {
    const std::lock_guard lock(lock_);
    if (progress_.state != State::Idle) throw std::logic_error("a session renders once: make a new one");
    settings_ = std::move(settings);
    if (settings_.threads <= 0) settings_.threads = hardware_threads();
    settings_.threads = std::min(settings_.threads, 4 * hardware_threads());
    settings_.passes = std::clamp(settings_.passes, 1, 1 << 28);
    // whatever a file says: these bounds keep every index and radius meaningful
    TransportSettings& t = settings_.transport;
    t.photons = std::clamp(t.photons, 1, 1 << 28);
    t.pilot_paths = std::clamp(t.pilot_paths, 1 << 10, 1 << 24);
    t.max_depth = std::clamp(t.max_depth, 1, 250);
    const auto bound = [](float& x, float least, float otherwise) {
      x = std::isfinite(x) ? std::clamp(x, least, 100.0f) : otherwise;
    };
    bound(t.caustic_radius_factor, 0.1f, TransportSettings().caustic_radius_factor);
    bound(t.caustic_radius_range, 1, TransportSettings().caustic_radius_range);
    bound(t.soft_range, 1, TransportSettings().soft_range);
    t.pilot_paths = std::min(t.pilot_paths, std::max(t.photons, TransportSettings::short_pilot));
    if (settings_.use_animated_seed)
      settings_.transport.seed = mix(settings_.transport.seed, static_cast<std::uint64_t>(settings_.frame));
    progress_.state = State::Compiling;
    progress_.passes = settings_.passes;
    begin_ = Clock::now();
  }
  try {
    task_ = BackgroundTask([this, compile = std::move(compile)] { run(compile); });
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
void Session::compile_scene(const Compile& compile) {
  Warnings warnings;
  std::shared_ptr<const Scene> scene;
  std::exception_ptr error;
  try {
    scene = compile(warnings);
  } catch (...) { error = std::current_exception(); }
  {
    const std::lock_guard lock(lock_);
    scene_ = std::move(scene), warnings_ = std::move(warnings);
  }
  if (error) std::rethrow_exception(error);
}

// Worker threads turn everything into a status: an exception that left one would end the host (Blender).
void Session::run(const Compile& compile) {
  try {
    compile_scene(compile);
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
    const bool traced = !effects.photons() || photon_pass.run(context, pool, cancel_, photons, counts);
    const double photon_seconds = seconds_since(photons_begin);
    if (traced && pass == 0) finish_guide(guide, context, photons, pool, photon_seconds);
    const Clock::time_point view_begin = Clock::now();
    if (!traced || !view_pass.run(context, photons, pool, cancel_, *film_, film_lock_, counts)) {
      stop = StopReason::Cancelled;
      break;
    }
    const bool block_ends = (pass + 1) % passes_per_block == 0;
    if (block_ends) close_film_block();
    const double view_seconds = seconds_since(view_begin);
    record_pass(counts, photons, photon_seconds, view_seconds);
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
  std::vector<UnmetShare> unmet = unmet_of(first.scene, guide);
  const std::lock_guard lock(lock_);
  for (std::size_t i = 0; i < std::min<std::size_t>(unmet.size(), 3); ++i)
    progress_.unmet.push_back(unmet[i].name);
  statistics_.unmet = std::move(unmet);
  statistics_.seconds[static_cast<std::size_t>(Phase::Guide)] = seconds_since(begin_) - photon_seconds;
  statistics_.guide_hash = guide.hash();
  statistics_.radius = {guide.radius, guide.caustic_radius};
}

void Session::explain_edits(const Scene& scene, const Effects& effects) {
  auto arrivals = find_arrivals(scene, settings_.transport, effects, settings_.threads, cancel_);
  const std::lock_guard lock(lock_);
  statistics_.arrivals = std::move(arrivals);
}

void Session::start_rendering(const Scene& scene, const Effects& effects) {
  const FrameDescription& frame = scene.frame();
  auto film = std::make_unique<Film>(frame.x1 - frame.x0, frame.y1 - frame.y0, layer_names(scene), frame.x0,
                                     frame.y0);
  {
    const std::lock_guard lock(film_lock_);
    film_ = std::move(film);
  }
  const std::lock_guard lock(lock_);
  statistics_.seconds[static_cast<std::size_t>(Phase::Compile)] = seconds_since(begin_);
  statistics_.reasons = effects.reasons;
  statistics_.triangles = scene.triangle_count();
  statistics_.threads = settings_.threads;
  for (int e = 0; e < scene.edits().size(); ++e) {
    const Quad& entry = scene.edits()[e].entry;
    statistics_.edit_names.push_back(scene.edits()[e].name);
    statistics_.edit_floats.push_back(
        {scene.edits().delta() + entry.offset, std::min(entry.edge_u.length(), entry.edge_v.length())});
  }
  statistics_.counts.edits.resize(statistics_.edit_names.size());
  progress_.state = State::Rendering;
  begin_ = Clock::now();
}

void Session::close_film_block() {
  const std::lock_guard lock(film_lock_);
  film_->close_block();
}

// What layers and edits make up of the picture.
void Session::measure_shares(const Scene& scene) {
  std::vector<LayerShare> layers;
  const double whole = film_->mean_luminance("Combined");
  const auto share = [whole](double part) { return whole > 0 ? part / whole : 0; };
  for (const LayerDescription& layer : scene.edits().layers())
    layers.push_back({layer.name, layer.expression, share(film_->mean_luminance(layer.name))});
  const std::lock_guard lock(lock_);
  statistics_.layers = std::move(layers);
  const double samples = static_cast<double>(progress_.pass) * film_->width() * film_->height();
  for (const EditCounts& edit : statistics_.counts.edits)
    statistics_.edit_shares.push_back(samples > 0 ? share(edit.shown / samples) : 0);
}

void Session::record_pass(const Counts& counts, const PhotonSet& photons, double photon_seconds,
                          double view_seconds) {
  const std::lock_guard lock(lock_);
  statistics_.counts += counts;
  // the first that are
  if (counts.states_capped > 0 && counts.states_capped == statistics_.counts.states_capped)
    warnings_.push_back({"edits",
                         "light goes through more combinations of edits than there is memory to tell apart; "
                         "paths beyond them are dropped (the log "
                         "says how many) and the picture depends on the number of threads: lower Max Edits "
                         "per Path, or let edits take less"});
  statistics_.seconds[static_cast<std::size_t>(Phase::Photons)] += photon_seconds;
  statistics_.seconds[static_cast<std::size_t>(Phase::View)] += view_seconds;
  statistics_.worst_ledger_residual =
      std::max(statistics_.worst_ledger_residual, counts.ledger.relative_residual());
  const std::size_t map_bytes = photons.all.bytes() + photons.close.bytes();
  if (photons.all.size() > 0)
    statistics_.bytes_per_photon = static_cast<double>(map_bytes) / static_cast<double>(photons.all.size());
  ++progress_.pass;
  progress_.photons += counts.photon_paths;
  progress_.memory = film_->bytes() + map_bytes;
}

// After each pass. The error is looked at when all streams have as many passes.
StopReason Session::should_stop(double last_pass_seconds) {
  const int pass = progress_.pass;  // written by this thread alone
  if (cancel_) return StopReason::Cancelled;
  if (pass % stream_count == 0) {
    const double error = film_->relative_error();  // only this thread writes to the film
    const std::lock_guard lock(lock_);
    progress_.relative_error = error;
    if (settings_.error_target > 0 && pass >= 2 * stream_count && error >= 0 &&
        error <= settings_.error_target)
      return StopReason::Error;
  }
  const double seconds = elapsed();
  if (settings_.time_limit > 0 && seconds + last_pass_seconds / 2 > settings_.time_limit)
    return StopReason::Time;
  return pass >= settings_.passes ? StopReason::Passes : StopReason::None;
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
  if (now.state != State::Rendering) return now;
  now.seconds = elapsed();
  if (now.pass == 0) return now;
  const double per_pass = now.seconds / now.pass;
  now.seconds_left = per_pass * (now.passes - now.pass);
  if (settings_.time_limit > 0)
    now.seconds_left = std::min(now.seconds_left, std::max(0.0, settings_.time_limit - now.seconds));
  // error ~ passes^(-1/2) while noise rules: passes needed = passes so far · (error / target)²
  if (settings_.error_target > 0 && now.relative_error > 0)
    now.seconds_left =
        std::min(now.seconds_left,
                 now.seconds * std::max(0.0, square(now.relative_error / settings_.error_target) - 1));
  return now;
}

Warnings Session::warnings() const {
  const std::lock_guard lock(lock_);
  return warnings_;
}

Statistics Session::statistics() const {
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
