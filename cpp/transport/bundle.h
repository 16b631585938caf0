// SPDX-License-Identifier: GPL-3.0-or-later
// View samples of near pixels are traced together, as a bundle: what one finds at the far end of its gather
// segment lights the others too, as far as they see it (Bekaert, Sbert, Halton 2002, "Accelerating path
// tracing by re-using paths"). So where that is enough only every second sample sends a segment, and each
// gets the light of several. What is shared, and with which weight: view_bundle.cpp.
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "base/random.h"
#include "edit/path_state.h"
#include "transport/film.h"
#include "transport/vertex.h"
#include "transport/view/join_constraints.h"

namespace sluice {

inline constexpr std::size_t bundle_size = 16;

// Gather segments of a sample, from each v: where its bundle shares them they are points of one sequence,
// dealt out to all its samples.
struct GatherSegments {
  float mean = 1;           // of their number, over the passes
  std::uint32_t count = 0;  // in this bundle
  Sampler first;            // of the bundle's points
  std::uint32_t place = 0;  // of its own first point

  [[nodiscard]] Sampler numbers(std::uint32_t segment) const noexcept { return first.after(place + segment); }
  // Of a v that shares nothing: where the others find no light for it, it must not wait for its turn.
  [[nodiscard]] std::uint32_t alone() const noexcept {
    return static_cast<std::uint32_t>(std::max(mean, 1.0f));
  }
};

// What a view sample looks for. Where lamps are seen, their edges are most of the noise and cheap to sample:
// a walk that looks for nothing else asks no light, no photon and sends no gather segment.
enum class Seeks : std::uint8_t { All, Emission, AllButEmission };

// What to trace: one sample of pixel (x, y) of the full frame.
struct ViewSample {
  int x, y;
  Sampler sampler;
  std::uint64_t key;  // of choices outside of the samplers' dimensions
  float share;        // in its pixel's mean; 0: traced for the others alone
  GatherSegments segments = {};
  std::uint32_t light_samples = 1;  // by next-event estimation at each v
  Seeks seeks = Seeks::All;
  bool measures_lights = false;  // there are two of them, to see how far they lie apart
};

// At most one thing for D, one for G, and one for the picture beside its layers.
template <class T>
class Few {
 public:
  static constexpr std::size_t most = 3;
  void add(const T& item) noexcept { items_[count_++] = item; }
  [[nodiscard]] T* begin() noexcept { return items_.data(); }
  [[nodiscard]] T* end() noexcept { return items_.data() + count_; }
  [[nodiscard]] const T* begin() const noexcept { return items_.data(); }
  [[nodiscard]] const T* end() const noexcept { return items_.data() + count_; }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }

 private:
  std::array<T, most> items_;
  std::size_t count_ = 0;
};

// One kind of lobe of v through which gathered light reaches the eye.
struct Arm {
  ConstraintId joins;
  Color weight;     // of light that comes by the segment: f / density, cosine included
  ImageSet images;  // that it is for
  EventMask lobes = gathering;
  bool is_kept = false;   // its light is kept for the bundle, in FarEnd; else it goes on to the eye at once
  std::size_t index = 0;  // among the arms
};
using Arms = Few<Arm>;

// Radiance that leaves y towards the bundle.
struct Outgoing {
  Color picture{0};
  std::vector<Color> layers;
  // the picture's, by edits that took it on its way: for their statistics
  std::vector<std::pair<std::uint32_t, Color>> taken;
};

// Straight light that next-event estimation found at a y that looks different from different sides: the lobes
// throw it when it is known where to.
struct StraightLight {
  struct Share {
    std::size_t arm;
    Event event;  // by which it leaves y
    StateId q;    // at the eye, for statistics
    ImageSet images;
  };
  V3f wi;
  Color arriving;  // radiance / density; black: none
  std::array<Share, 2 * Arms::most> shares;
  std::size_t count = 0;
};

// The far end of a gather segment that is shared.
struct FarEnd {
  bool is_own = false;  // not shared: alpha on the way or at y, of which a shadow ray cannot tell
  Vertex y;
  float pdf;  // with which v made the direction (1/sr)
  // angle (rad) over which what y sends out changes little; infinite: it is the same to all sides
  float width;
  Arms arms;  // of v
  StraightLight straight;
  // by arm: of photons, and straight light where y looks the same from all sides
  std::array<Outgoing, Arms::most> light;
  std::vector<StateId> arrived;       // of all light, at y, where edits ask
  bool may_be_taken = false;          // by a light edit, on its way to v
  bool knows_takers = false;          // what follows
  std::vector<StateId> states;        // of the light, behind y
  std::vector<std::uint64_t> takers;  // light edits that would take some of it; empty: none on any way
  std::vector<std::uint32_t>
      near_entries;           // of theirs, those that may lie on a way to the bundle, by numbers
  bool has_all_near = false;  // they were few enough to be listed

  [[nodiscard]] Outgoing& light_of(const Arm& arm) noexcept { return light[arm.index]; }
};

// What becomes of a sample.
struct BundleMember {
  PixelSample sample;
  std::vector<Color> layers;
  V3d light_variance;
};

}  // namespace sluice
