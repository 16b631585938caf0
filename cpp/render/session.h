// SPDX-License-Identifier: GPL-3.0-or-later
// One render, from description to film: compile, guide, passes, on threads of its own. The host polls;
// nothing here calls back. Every public function may be called from any thread at any time. Several sessions
// share nothing.
#pragma once
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "base/error.h"
#include "base/threads.h"
#include "render/settings.h"
#include "scene/scene.h"
#include "transport/counts.h"
#include "transport/effects.h"
#include "transport/film.h"
#include "transport/guide.h"
#include "transport/guide/arrivals.h"
#include "transport/pass.h"

namespace sluice {

enum class State : std::uint8_t { Idle, Compiling, Rendering, Finished, Cancelled, Failed };
enum class StopReason : std::uint8_t { None, Passes, Time, Error, Cancelled };

struct Failure {
  std::string message, item;  // item: the edit or object at fault, may be empty
  int column = 0;             // in the edit's expression, from 1; 0: none
};

struct Progress {
  State state = State::Idle;
  StopReason stop_reason = StopReason::None;
  int pass = 0, passes = 0;    // finished, wanted
  std::uint64_t photons = 0;   // light paths emitted
  double seconds = 0;          // of rendering
  double seconds_left = -1;    // estimate to the nearest stop; < 0: unknown
  double relative_error = -1;  // of the picture; < 0: fewer than 4 passes
  // the first of the lights and effects that it does not know of: the pilot found nothing of them
  std::vector<std::string> unmet;
  std::size_t memory = 0;  // bytes of film and photon maps
  std::optional<Failure> failure;
};

struct LayerShare {
  std::string name, expression;
  double share = 0;  // of the picture's luminance
};

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

struct Statistics {
  Counts counts;
  std::array<double, phase_count> seconds{};
  std::vector<Effects::Reason> reasons;
  std::vector<std::string> edit_names;  // of counts.edits
  std::vector<Floating> edit_floats;    // of counts.edits
  std::vector<double> edit_shares;      // of the picture's luminance: light that the edit took on its way
  std::vector<LayerShare> layers;
  std::vector<UnmetShare> unmet;   // what relative_error does not know of
  std::vector<Arrivals> arrivals;  // at the edits' entries; empty unless the settings ask
  std::uint64_t guide_hash = 0;
  double worst_ledger_residual = 0;  // of a pass, relative to what it emitted
  double bytes_per_photon = 0;       // of the maps, all included
  std::size_t triangles = 0;
  int threads = 0;
  std::array<float, 2> radius{};  // of the first pass (m): in general, caustics
};

class Session {
 public:
  Session() = default;
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Returns at once. A session renders once; a second start throws std::logic_error.
  void start(SceneDescription description, RenderSettings settings);
  // The same things as `base` shows, with another view or other edits: the picture that start() would make,
  // without compiling them anew. False, and nothing was started: `base` has not compiled them, or edits lie
  // so far away that it must be done anew.
  [[nodiscard]] bool start_from(const Session& base, ShotDescription shot, RenderSettings settings);
  bool wait(double seconds);  // true: over, whatever way
  void cancel() noexcept;     // returns at once; over within half a second

  [[nodiscard]] Progress progress() const;
  [[nodiscard]] Warnings warnings() const;
  [[nodiscard]] Statistics statistics() const;

  struct Picture {
    int width, height, channels;
    std::vector<float> pixels;  // row 0 at the bottom
  };
  // Passes of the film by name, of one moment, unfinished passes included. Empty: there is nothing yet, or no
  // pass of such a name.
  [[nodiscard]] std::vector<Picture> pictures(const std::vector<std::string>& names) const;
  [[nodiscard]] std::uint64_t film_hash() const;

 private:
  using Compile = std::function<std::unique_ptr<const Scene>(Warnings&)>;

  void launch(RenderSettings settings, Compile compile);
  void run(const Compile& compile);
  void compile_scene(const Compile& compile);
  void render_scene(const Scene& scene);
  void start_rendering(const Scene& scene, const Effects& effects);
  void close_film_block();
  void finish_guide(Guide& guide, const PassContext& first, const PhotonSet& photons, ThreadPool& pool,
                    double photon_seconds);
  void explain_edits(const Scene& scene, const Effects& effects);
  void measure_shares(const Scene& scene);
  void record_pass(const Counts& counts, const PhotonSet& photons, double photon_seconds,
                   double view_seconds);
  void fail(const std::string& message, const std::string& item = {}, int column = 0) noexcept;
  void finish(State state, StopReason reason = StopReason::None);
  [[nodiscard]] StopReason should_stop(double last_pass_seconds);
  [[nodiscard]] double elapsed() const;

  RenderSettings settings_;
  std::atomic<bool> cancel_{false};
  mutable std::mutex lock_;  // of all below but the film
  std::condition_variable over_;
  Progress progress_;
  std::shared_ptr<const Scene> scene_;  // stays when the render is over: for start_from
  Warnings warnings_;
  Statistics statistics_;
  std::chrono::steady_clock::time_point begin_{};
  mutable std::mutex film_lock_;
  std::unique_ptr<Film> film_;
  BackgroundTask task_;  // last: it ends before what it works on
};

}  // namespace sluice
