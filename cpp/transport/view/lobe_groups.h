// SPDX-License-Identifier: GPL-3.0-or-later
// Lobes of a vertex, apart only as far as C or a layer can tell them apart: what is one to both is evaluated
// once. The picture's share of light goes by the same groups whether or not there are layers beside it, so
// that layers change no bit of it.
#pragma once
#include <array>

#include "transport/vertex.h"
#include "transport/view/path_selection.h"
#include "transport/view/view_path.h"

namespace sluice {

// At most one thing for D, one for G, and one for the picture beside its layers.
template <class T>
class Few {
 public:
  static constexpr std::size_t max = 3;
  void add(const T& item) noexcept { items_[count_++] = item; }
  [[nodiscard]] T* begin() noexcept { return items_.data(); }
  [[nodiscard]] T* end() noexcept { return items_.data() + count_; }
  [[nodiscard]] const T* begin() const noexcept { return items_.data(); }
  [[nodiscard]] const T* end() const noexcept { return items_.data() + count_; }

 private:
  std::array<T, max> items_;
  std::size_t count_ = 0;
};

// C of light that arrives at a vertex and will leave it by an event. `behind`: C of light that has left it,
// nearer to the eye.
[[nodiscard]] inline ConstraintId constraint_at(PathSelection& selection, const Scene& scene,
                                                ConstraintId behind, const Vertex& vertex, Event event) {
  return selection.constraints().event(behind, scene.event_class(event, vertex.hit));
}

// Lobes through which photons at a vertex are gathered.
struct LobeGroup {
  EventMask lobes;
  ConstraintId constraint;  // of the photons' light
  ImageSet images;          // that the group is for
};
// The gathering lobes of a vertex, for these images. `behind`: C of light that leaves it.
[[nodiscard]] Few<LobeGroup> lobe_groups(PathSelection& selection, const Scene& scene, ConstraintId behind,
                                         const Vertex& vertex, ImageSet images);

// Lobes of v through which light of a gather segment goes on to the eye.
struct LobeThroughput {
  ConstraintId constraint;      // of light that comes by the segment
  Color weight;                 // of that light: f cos / density
  ImageSet images;              // that it is for
  EventMask lobes = gathering;  // among v's
};
using LobeThroughputs = Few<LobeThroughput>;
// Of all light that arrives at the far end of the path itself.
[[nodiscard]] inline LobeThroughputs whole_path(const ViewPath& path) {
  LobeThroughputs whole;
  whole.add({path.constraint, Color(1), all_images});
  return whole;
}
// Of a segment that starts at v in a direction sampled from its gathering lobes.
[[nodiscard]] LobeThroughputs lobe_throughputs(PathSelection& selection, const Scene& scene,
                                               const ViewPath& path, const Vertex& v,
                                               const BsdfSample& direction);

}  // namespace sluice
