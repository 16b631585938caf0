// SPDX-License-Identifier: GPL-3.0-or-later
// View paths, backward from the eye: what one pixel sample sees, by the four estimators of design §5. Edits
// hold on every segment: shadow and gather segments ask the light edits by the C rule (join.h), view segments
// take both continuations at an exit (straight on, and backward through it to its entry), view edits capture
// the view path itself. Gather segments are shared by near pixels (bundle.h). The light side of the same
// rules is light_path.h.
#pragma once
#include <array>
#include <vector>

#include "scene/gates_in_view.h"
#include "transport/bundle.h"
#include "transport/density.h"
#include "transport/film.h"
#include "transport/view/path_selection.h"
#include "transport/light_path.h"
#include "transport/pass.h"

namespace sluice {

struct ViewPath {
  V3d origin;
  V3f direction;
  V3f clearance{0};
  double t_max = std::numeric_limits<double>::infinity();
  Color weight{1};                     // radiance factor from the eye, since the last hue gate
  int hue = -1;                        // the hue gates met, list in ViewTracer
  ConstraintId joins = no_constraint;  // C
  StateId state = 0;                   // of the view edits' automata
  Color throughput{1};                 // of materials alone, for roulette
  int depth = 0;                       // D, S, G events so far
  int gates = 0;
  int excluded_group = -1;  // plane group that the segment starts on
  // just came backward out of this light edit's entry: the entry's plane comes first
  int own_entry = -1;
  int at_edit = -1, at_exit = 0;  // just left this exit of a view edit: entries in its plane come first
  int last_edit = -1;             // whose gate it met last
  // with which the last followed lobe made the direction, for MIS; 0: by no chance (delta, camera, gate)
  float lobe_pdf = 0;
  V3d lobe_origin{0};      // where that was
  V3f lobe_normal{0};      // what choose_light was asked with there
  bool is_camera = true;   // no event yet: sees what the camera sees
  std::uint64_t word = 0;  // of its events, hashed
};

// A vertex v that takes part in the bundle. A sample has several if materials mirror and scatter, or glass
// shows it two ways; their turn is the sample's.
struct Seer {
  std::size_t sample = 0;  // of the bundle
  ViewPath path;           // from the eye to v
  Vertex v;
  // hash of what the path met from the eye to v: with equal words events, depth and kinds of lobes are equal
  std::uint64_t word = 0;
};
inline constexpr std::size_t most_seers = 2 * bundle_size;  // beyond them a vertex gathers for itself

// What traces view samples on one of `threads` threads.
class alignas(64) ViewTracer {  // threads write to theirs: no cache line is shared
 public:
  ViewTracer(const Scene& scene, const TransportSettings& settings, const Effects& effects, int threads)
      : scene_(scene),
        settings_(settings),
        effects_(effects),
        gates_in_view_(scene.gates_in_view()),
        disk_bounds_(scene.camera(), scene.frame(), settings),
        selection_(scene.edits(), effects, {state_memory_of_one(settings, threads)}),
        lamps_(most_lamp_hits(scene)) {}

  void start_pass(const PassContext& context, const PhotonSet& photons);
  // At most bundle_size samples of pixels near each other.
  void trace(std::span<const ViewSample> bundle);
  // of the last bundle
  [[nodiscard]] const PixelSample& sample(std::size_t index) const noexcept { return members_[index].sample; }
  // Of its direct light's mean, as far as two samples of lights at each v tell, if they were asked to.
  [[nodiscard]] const V3d& light_variance(std::size_t index) const noexcept {
    return members_[index].light_variance;
  }
  [[nodiscard]] std::span<const Color> layers(std::size_t index) const noexcept {
    return members_[index].layers;
  }
  Counts counts;

 private:
  struct HueStep {
    Color factor;  // from the eye to this gate
    float angle;
    int towards_eye;
  };
  // a segment whose far end may be an emitter: what MIS and C need to know of its near end
  struct LightSegment {
    V3d origin;
    V3f direction, normal;
    // of the direction, times the number of such segments; 0: next-event estimation could not have made it
    float pdf;
    float light_samples = 1;  // that it took there
    bool camera = false;
  };

  // Elsewhere: the path now starts at another place
  enum class Went : std::uint8_t { Straight, Elsewhere, Nowhere };
  struct PhotonRun {  // photons that follow each other in one state, as neighbours often do
    bool asks;        // what becomes of them depends on it
    ImageSet asked;   // the images that they may be added to
    bool sums;        // the picture's share is summed up first
    std::uint32_t q = ~0u;
    JoinResult to{picture & asked};
    // they belong to the sum and nowhere else, and no edit has a share in them
    bool is_plain = !asks && sums;

    [[nodiscard]] bool is_new(const Photon& photon) const noexcept { return asks && photon.q != q; }
  };
  // the path (view_path.cpp)
  void trace_sample();
  void follow(ViewPath& path);
  void collect_light(const ViewPath& path, const Vertex& v);
  [[nodiscard]] bool next_vertex(ViewPath& path, Vertex& vertex);
  [[nodiscard]] bool can_leave(ViewPath& path);
  void record_first(const Vertex* vertex) noexcept;
  [[nodiscard]] bool extend(ViewPath& path, const Vertex& vertex);
  void take_lobe(ViewPath& path, const Vertex& vertex, const BsdfSample& sample);
  void add(Part part, const ViewPath& path, Color radiance, JoinResult to) noexcept;
  void add_up(Color& sum, const Color& radiance) noexcept;
  // Light that edits took on its way is in their statistics: calls book(edit) for each of them.
  template <class Book>
  void credit(StateId q, const Color& radiance, Book&& book) const {
    if (q == StateTable::dead || selection_.states().gates(q) == 0 || !is_finite(radiance)) return;
    for (const std::uint32_t edit : selection_.states().used(q)) book(edit);
  }
  void credit_radiance(StateId q, const Color& radiance) noexcept {
    credit(q, radiance, [&](std::uint32_t edit) {
      counts.of_edit(static_cast<int>(edit)).shown += luminance(radiance) * bundle_[at_].share;
    });
  }
  void credit_arm(StateId q, const ViewPath& path, const Color& radiance, const Arm& arm);

  // gates on view segments (view_gates.cpp)
  // Which gates does a view segment ask? Nearly always none, told at once: rays from the camera know from the
  // picture where gates lie.
  struct Asks {
    bool exits;         // of light edits, where light may have come out
    bool entries;       // of light edits, that may take light from the segment's far end or from a lamp on it
    bool view_entries;  // that may take the path
    [[nodiscard]] bool any() const noexcept { return exits || entries || view_entries; }
  };
  [[nodiscard]] Asks asks_of(const ViewPath& path, const Vertex* far,
                             std::span<const LampHit> lamps) const noexcept {
    const auto in_view = [&](Side side) {
      return !path.is_camera || gates_in_view_.any(side, bundle_[at_].x, bundle_[at_].y);
    };
    return {effects_.light_edits && scene_.edits().has_exits(Side::Light) && in_view(Side::Light),
            effects_.light_edits && may_be_taken_from(far, lamps),
            effects_.view_edits && !selection_.states().takes_none(path.state) && in_view(Side::View)};
  }
  [[nodiscard]] Went cross_gates(ViewPath& path, const Asks& asks, double t_end, const Vertex* far,
                                 std::span<LampHit> lamps);
  [[nodiscard]] bool meets_light_gate(const ViewPath& path, const Asks& asks, const Segment& segment,
                                      const Vertex* far, std::span<const LampHit> lamps);
  [[nodiscard]] bool meets_exit(const ViewPath& path, const Segment& segment) const noexcept;
  [[nodiscard]] Went cross_plane(ViewPath& path, std::span<const Crossing> plane);
  void meet_view_edit(const ViewPath& path, const Crossing& crossing);
  void push_view_copy(const ViewPath& path, const Crossing& crossing, int exit, float weight);
  [[nodiscard]] bool go_backward(ViewPath& path, std::span<const Crossing> plane, const Crossing& exit,
                                 float weight);
  // Walks for emission alone would count a pixel's paths twice.
  [[nodiscard]] EditCounts& of_view_edit(int edit) noexcept {
    return bundle_[at_].seeks == Seeks::Emission ? uncounted_ : counts.of_edit(edit);
  }
  [[nodiscard]] bool may_take(const ViewPath& path, const Crossing& crossing) const noexcept;
  [[nodiscard]] ConstraintId pass_entries(const ViewPath& path, std::span<const Crossing> plane, int except);
  void apply_gate(ViewPath& path, const Passage& passage, float weight);

  // direct light and emission (view_direct.cpp)
  struct AskedLight {
    int light;
    DirectSample point;
    float pdf;  // of light and point (1/sr, or of what a delta light has)
  };
  [[nodiscard]] std::optional<AskedLight> ask_light(const V3d& place, const V3f& side, LightTrust trust,
                                                    float u, const V2f& uv) const noexcept;
  void direct_light(const ViewPath& path, const Vertex& v, float segments);
  void measure_lights(const ViewPath& path, const Vertex& v, float segments);
  void light_sample(const ViewPath& path, const Vertex& v, const Sampler& numbers, float segments);
  void straight_light(const ViewPath& path, const Vertex& y, const Sampler& numbers, const Arms& arms);
  void keep_straight_light(const AskedLight& asked);
  struct Unblocked {
    Color left;
    StateId q;
  };
  [[nodiscard]] std::optional<Unblocked> unblocked(const Vertex& vertex, int light,
                                                   const DirectSample& sample);
  void count_taken(StateId q, const Segment& to_light);
  [[nodiscard]] bool is_taken_from_view(const ViewPath& path, const Vertex& vertex,
                                        const DirectSample& light);
  void far_emission(const ViewPath& path, const LightSegment& segment, const Arms& arms);
  void surface_emission(const ViewPath& path, const LightSegment& segment, const Vertex& vertex,
                        const Arms& arms);
  void add_emission(const ViewPath& path, const LightSegment& segment, int light, Color radiance,
                    const Hit* hit, const Arms& arms);

  // photons and gather segments at v (view_light.cpp)
  void close_density(const ViewPath& path, const Vertex& v);
  void gather_alone(const ViewPath& path, const Vertex& v);
  bool gather(const ViewPath& path, const Vertex& v, const Sampler& numbers, float segments, bool shares);
  struct Reached {
    double length;   // of the segment
    bool may_share;  // no alpha on the way or there, of which a shadow ray cannot tell
  };
  [[nodiscard]] std::optional<Reached> reach(const ViewPath& path, const LightSegment& segment, Ray ray,
                                             Arms& arms, Vertex& y);
  void deliver(const ViewPath& path, const Color& radiance, const Arm& arm, JoinResult to);
  [[nodiscard]] Arms arms_of(const ViewPath& path, const Vertex& v, const BsdfSample& sample);
  [[nodiscard]] bool may_be_taken_from(const Vertex* far, std::span<const LampHit> lamps) const noexcept {
    return !far || !lamps.empty() || scene_.may_be_taken_from(far->hit) || far->pass_chance > 0;
  }
  [[nodiscard]] EditSet takers_from(const Vertex* far, EventMask lobes, std::span<const LampHit> lamps);
  void narrow(const ViewPath& path, const LightSegment& segment, double t_start, double t_end,
              const Vertex* far, Arms& arms);
  void gather_at(const ViewPath& path, const Vertex& y, const Arms& arms, double length, float radius);

  // gather segments of a bundle (view_bundle.cpp)
  struct Connection {  // a way from some v to y
    const Seer* to;
    V3f wi{0};
    double distance = 0;
    float geometry = 0;    // cos at y / distance²
    float pdf = 0;         // with which `to` would send its segment here (1/sr)
    bool is_open = false;  // nothing lies on it, no entry takes its light
  };
  [[nodiscard]] bool join_bundle(const ViewPath& path) noexcept;
  void keep_far_end(const Arms& arms, const BsdfSample& sample, bool may_share);
  void put(Outgoing& light, const Color& radiance, StateId q, ImageSet images);
  void credit_outgoing(Outgoing& light, const Color& radiance, StateId q);
  void note_state(StateId q);
  void find_takers(const Seer& finder);
  void gather_together();
  void share(const Seer& finder);
  [[nodiscard]] bool connect(const Seer& to, Connection& way) const noexcept;
  void find_clear(std::span<Connection> ways) noexcept;
  [[nodiscard]] bool is_taken(const Connection& way, const Seer& finder);
  [[nodiscard]] bool ask_entries(const Connection& way, const Seer& finder);
  [[nodiscard]] bool sees_same_photons(const Seer& finder) const noexcept;
  [[nodiscard]] const Bsdf& lobes_towards(const V3f& wo) noexcept;
  void throw_straight_light(const Arm& arm, const Bsdf& bsdf, const V3f& wo, const Seer& to,
                            const Color& factor);
  void receive(const Seer& seer, const Outgoing& light, const Color& factor) noexcept;

  [[nodiscard]] float light_samples() const noexcept {
    return static_cast<float>(bundle_[at_].light_samples);
  }
  [[nodiscard]] LightSegment segment_of(const ViewPath& path) const noexcept {
    return {path.lobe_origin, path.direction,  path.lobe_normal,
            path.lobe_pdf,    light_samples(), path.is_camera};
  }
  [[nodiscard]] static Arms arm_of(const ViewPath& path) noexcept {
    Arms arms;
    arms.add({path.joins, Color(1), all_images});
    return arms;
  }

  [[nodiscard]] EventClass light_class(int light) const noexcept {
    return scene_.edits().event_class(Event::L, scene_.light_entity(light));
  }
  [[nodiscard]] StateId light_state(int light) noexcept {
    return selection_.states().next(StateTable::light_start, light_class(light));
  }
  [[nodiscard]] JoinResult counted(const JoinResult& joined) noexcept;
  [[nodiscard]] JoinResult join(StateId q, ConstraintId joins) noexcept {
    return counted(selection_.join(q, joins));
  }
  [[nodiscard]] JoinResult join_behind(ConstraintId joins, StateId q, const Vertex& vertex, Event e);
  // A run of photons in state q begins.
  void start_run(PhotonRun& run, std::uint32_t q, ConstraintId joins) noexcept {
    run.q = q;
    run.is_plain = run.sums && !selection_.asks_state(joins) &&
                   selection_.states().gates(selection_.state_of_photon(run.q)) == 0;
    if (!run.is_plain) join_run(run, joins);
  }
  void join_run(PhotonRun& run, ConstraintId joins) noexcept;  // asks C what becomes of them
  // Of those that met no gate.
  [[nodiscard]] SumAnswer answer_of(const PhotonRun& run) const noexcept {
    return {run.is_plain || ((run.to.images & picture) && selection_.states().gates(run.to.q) == 0),
            !run.is_plain};
  }
  [[nodiscard]] ConstraintId event_at(ConstraintId joins, const Vertex& vertex, Event e) {
    return selection_.constraints().event(joins, scene_.event_class(e, vertex.hit));
  }
  // Is it one to all expressions whether light leaves by D or by G?
  [[nodiscard]] bool same_event(const Vertex& vertex) const noexcept {
    return scene_.event_class(Event::D, vertex.hit) == scene_.event_class(Event::G, vertex.hit);
  }
  struct LobeGroup {  // lobes that C and the layers cannot tell apart
    EventMask lobes;
    ConstraintId joins;  // C behind them
    ImageSet images;
  };
  [[nodiscard]] Few<LobeGroup> groups_of(ConstraintId joins, const Vertex& vertex, ImageSet images);
  [[nodiscard]] BundleMember& self() noexcept { return members_[at_]; }
  [[nodiscard]] float random() noexcept {
    return to_unit(static_cast<std::uint32_t>(mix(key_, ++draws_) >> 32));
  }
  // Dimension pairs of the vertex at this depth.
  [[nodiscard]] static std::uint32_t pair_of(const ViewPath& path, std::uint32_t which) noexcept {
    return 2 + 8 * static_cast<std::uint32_t>(path.depth) + which;
  }
  [[nodiscard]] V2f pair(const ViewPath& path, std::uint32_t which) const noexcept {
    return sampler_.pair(pair_of(path, which));
  }

  const Scene& scene_;
  const TransportSettings& settings_;
  const Effects& effects_;
  const PhotonSet* photons_ = nullptr;
  const Guide* guide_ = nullptr;
  float radius_scale_ = 1;

  const GatesInView& gates_in_view_;
  const DiskBounds disk_bounds_;
  PathSelection selection_;

  std::span<const ViewSample> bundle_;
  std::array<BundleMember, bundle_size> members_;
  std::size_t at_ = 0;  // the member being traced
  // the last is never shared: room for a vertex when all others are taken
  std::array<Seer, most_seers + 1> seers_;
  std::size_t seer_count_ = 0;
  FarEnd far_end_;  // of the gather segment that the bundle shares now
  Sampler sampler_;
  std::uint64_t key_ = 0, draws_ = 0;
  bool recorded_ = false;
  EditCounts uncounted_;
  std::vector<HueStep> hues_;
  std::vector<Crossing> crossings_;
  std::vector<LampHit> lamps_;         // of one segment; room for all there are
  std::vector<std::uint64_t> takers_;  // scratch of takers_from()
  std::array<ViewPath, split_budget> branches_;
  int branch_count_ = 0;
  SplitBudget budget_;
  Vertex far_;         // scratch: too large to copy about
  Outgoing outgoing_;  // scratch of throw_straight_light()
};

}  // namespace sluice
