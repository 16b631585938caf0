// SPDX-License-Identifier: GPL-3.0-or-later
// One render, from description to film: compile, guide, passes, on threads of its own. The host polls;
// nothing here calls back. Every public function may be called from any thread at any time. Several sessions
// share nothing.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/threads.h"
#include "render/progress.h"
#include "render/settings.h"
#include "render/statistics.h"
#include "scene/scene.h"
#include "transport/counts.h"
#include "transport/effects.h"
#include "transport/film.h"
#include "transport/guide.h"
#include "transport/guide/arrivals.h"
#include "transport/photons/photon_set.h"
#include "transport/pass.h"

namespace sluice {

class Session {
 public:
  Session() = default;
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Returns at once. A session renders once; a second start throws std::logic_error.
  void start(SceneDescription description, RenderSettings settings);
  // Starts a render of the scene that `base` has compiled, in another shot: another view or other edits. The
  // picture is the one that start() would make, but meshes, materials and lights are not compiled anew. False
  // if nothing was started: `base` has no scene yet, or edits lie so far away that all must be compiled anew.
  [[nodiscard]] bool start_from(const Session& base, ShotDescription shot, RenderSettings settings);
  bool wait(double seconds);  // True if the render is over, in whatever way.
  void cancel() noexcept;     // Returns at once; the render is over within half a second.

  [[nodiscard]] Progress progress() const;
  [[nodiscard]] Warnings warnings() const;
  [[nodiscard]] RenderStatistics statistics() const;

  struct Picture {
    int width, height, channels;
    std::vector<float> pixels;  // row 0 at the bottom
  };
  // Render passes by name, all as they are at one moment, with what unfinished passes have brought. Empty if
  // there is nothing yet, or if one of the names is unknown.
  [[nodiscard]] std::vector<Picture> pictures(const std::vector<std::string>& names) const;
  [[nodiscard]] std::uint64_t film_hash() const;
  // What settings.keep_at asks for, as far as the render is.
  struct Kept {
    Accuracy accuracy;
    Picture picture;  // Combined
  };
  [[nodiscard]] std::vector<Kept> kept() const;
  // What each pixel takes in a pass: view samples, those of emission alone, lights asked at each v, gather
  // segments (mean). Empty before the first pass has traced its photons.
  [[nodiscard]] std::optional<Picture> sample_counts() const;

 private:
  using MakeScene = std::function<std::unique_ptr<const Scene>(Warnings&)>;  // compiles or recompiles one

  void launch(RenderSettings settings, MakeScene make_scene);
  void run(const MakeScene& make_scene);
  void compile_scene(const MakeScene& make_scene);
  void render_scene(const Scene& scene);
  void start_rendering(const Scene& scene, const Effects& effects);
  void close_film_block();
  void finish_guide(Guide& guide, const PassContext& first, const PhotonSet& photons, ThreadPool& pool,
                    double photon_seconds);
  void explain_edits(const Scene& scene, const Effects& effects);
  void measure_shares(const Scene& scene);
  void record_pass(const PassRecord& pass);
  void fail(const std::string& message, const std::string& item = {}, int column = 0) noexcept;
  void finish(State state, StopReason reason = StopReason::None);
  [[nodiscard]] StopReason should_stop(double last_pass_seconds);
  void record_accuracy();
  void record_work(Accuracy& of) const;
  void keep_picture();
  [[nodiscard]] double elapsed() const;

  RenderSettings settings_;
  std::atomic<bool> cancel_{false};
  mutable std::mutex
      lock_;  // guards what others may ask for; what the render thread alone writes it reads without
  std::condition_variable over_;
  Progress progress_;
  std::shared_ptr<const Scene> scene_;  // stays when the render is over, for start_from()
  Warnings warnings_;
  RenderStatistics statistics_;
  std::chrono::steady_clock::time_point begin_{};
  mutable std::mutex film_lock_;
  std::unique_ptr<Film> film_;
  std::unique_ptr<Probes> probes_;
  std::vector<Kept> kept_;
  std::optional<SampleMap> sample_map_;
  BackgroundTask task_;  // the last member, so that it ends before what it works on
};

}  // namespace sluice
