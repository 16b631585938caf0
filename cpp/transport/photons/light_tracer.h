// SPDX-License-Identifier: GPL-3.0-or-later
// Light paths, forward from a light: segments through gates (paper §4), vertices, and the branches that
// several exits make. One emitted photon is one tree of light paths; each branch carries its own state q. The
// view side of the same rules is view/view_tracer.h. An observer is told all that happens to the paths; those
// of a render have none, and its calls cost them nothing.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "base/random.h"
#include "edit/edits.h"
#include "transport/branching.h"
#include "transport/counts.h"
#include "transport/effects.h"
#include "transport/photons/emission.h"
#include "transport/guide.h"
#include "transport/photons/photon.h"
#include "transport/photons/photon_states.h"
#include "transport/vertex.h"

namespace sluice {

// One branch. `Word` is what it carries for its observer: nothing, where there is none.
template <class Word>
struct LightPath {
  V3d origin;
  V3f direction;
  V3f clearance{0};
  Color flux;           // W
  Color throughput{1};  // of materials alone, for roulette
  StateId q = 0;
  Event last = Event::L;     // last event: the class of the next arrival
  bool was_diffuse = false;  // a D before
  int depth = 0;             // D, S, G events so far
  int excluded_group = -1;   // plane group that the segment starts on
  double t_min = 0;          // gates beyond it count; -infinity on the first segment of light from infinity
  [[no_unique_address]] Word word{};
  int last_edit = -1;  // whose exit the branch came from
  // just left this exit: entries in its plane come first (design §2, quads in one plane)
  int at_edit = -1, at_exit = 0;
};

// The observer of renders, which sees nothing. ArrivalRecorder, which does, says what they are told.
struct Unobserved {
  struct Word {};
  static constexpr bool sees = false;

  [[nodiscard]] Word started(int) const noexcept { return {}; }
  [[nodiscard]] Word scattered(const Word&, Event, const Hit&) const noexcept { return {}; }
  [[nodiscard]] Word moved(const Word&, int) const noexcept { return {}; }
  void crossed(const LightPath<Word>&, const Segment&, const std::optional<Crossing>&) const noexcept {}
  void left_exit(const LightPath<Word>&, const std::optional<Crossing>&) const noexcept {}
};

// What traces light paths on one of `threads` threads: scratch memory, states, counts. Photons go to a list
// of the caller's.
template <class Observer = Unobserved>
class alignas(64) LightTracer {  // threads write to theirs: no cache line is shared
 public:
  // Photons get their q from `shared_states`; null: nobody asks for it.
  LightTracer(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads,
              PhotonStates* shared_states = nullptr, const Observer& the_observer = {})
      : observer(the_observer),
        scene_(scene),
        settings_(settings),
        effects_(effects),
        shared_states_(shared_states),
        states_(scene.edits(), {state_memory_of_one(settings, threads)}) {
    counts.start(scene.edits().size());
  }

  // Follows one emitted photon to its ends and appends what it leaves behind. `scale` = 1 / paths per pass.
  void trace(const EmittedPhoton& photon, float scale, const Sampler& sampler, std::uint64_t key,
             std::vector<Photon>& out);

  [[no_unique_address]] Observer observer;
  Counts counts;
  const LightTrusts* trust = nullptr;  // of the guide, which must live on

 private:
  using Path = LightPath<typename Observer::Word>;

  // Does someone ask what happens to the paths?
  [[nodiscard]] bool is_watched() const noexcept { return Observer::sees || effects_.tracks_states; }
  [[nodiscard]] bool next_vertex(Path& path, Vertex& vertex) noexcept;
  // Must the entries on its next segment be asked?
  [[nodiscard]] bool asks(const Path& path) const noexcept {
    return Observer::sees || !states_.takes_none(path.q);
  }
  // Apart from the rest, so that paths that nobody watches stay short.
  [[nodiscard, gnu::noinline]] bool drop_if_dead(const Path& path) noexcept;
  [[nodiscard, gnu::noinline]] bool leave_exit(Path& path) noexcept;
  [[nodiscard, gnu::noinline]] bool meet_entries(const Path& path, double t_end) noexcept;
  void meet_light_edit(const Path& path, const Crossing& crossing) noexcept;
  struct Copy {
    std::optional<Passage> passage;  // empty: too grazing at the exit
    Color flux{0};
    double energy = 0;
  };
  [[nodiscard]] Copy copy_of(const Path& path, const Crossing& crossing, int exit,
                             float weight) const noexcept;
  double push_light_copy(const Path& path, const Crossing& crossing, int exit, float weight) noexcept;
  [[nodiscard]] bool is_read(const Path& path, Arrival arrival, const Vertex& vertex) const noexcept;
  void store(const Path& path, const Vertex& vertex, std::vector<Photon>& out);
  [[nodiscard]] bool take_lobe(Path& path, const Vertex& vertex, int lobe, const BsdfSample& sample,
                               const Color& weight) noexcept;
  [[nodiscard]] bool scatter(Path& path, const Vertex& vertex, const Sampler& sampler) noexcept;
  [[nodiscard]] float random() noexcept {
    return to_unit(static_cast<std::uint32_t>(mix(key_, ++draws_) >> 32));
  }

  const Scene& scene_;
  const TransportSettings& settings_;
  const Effects& effects_;
  PhotonStates* shared_states_;
  StateTable states_;  // which notes the numbers that states have there
  std::array<Path, split_budget + max_lobes> branches_;
  int branch_count_ = 0;
  SplitBudget budget_;      // of exits
  bool has_split_ = false;  // at glass
  int light_ = 0;           // where the paths being traced started
  Hit emitter_{};
  // of choices that must not move the dimensions of scattering: alpha, exits
  std::uint64_t key_ = 0, draws_ = 0;
};

}  // namespace sluice
