// SPDX-License-Identifier: GPL-3.0-or-later
// What the samples of a bundle have collected, and what was counted on the way. Knows nothing of how light
// was found.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "transport/counts.h"
#include "transport/film.h"
#include "transport/view/hue_gates.h"
#include "transport/view/outgoing_radiance.h"
#include "transport/view/path_selection.h"
#include "transport/view/sample.h"
#include "transport/view/view_path.h"

namespace sluice {

class SampleSums {
 public:
  SampleSums(const Scene& scene, const TransportSettings& settings, const PathSelection& selection)
      : scene_(scene), settings_(settings), selection_(selection) {}

  Counts counts;
  // Of the sample that is followed; gone when shared gather points are evaluated, which is why only paths
  // without gates share.
  HueGates hue_gates;

  [[nodiscard]] const PixelSample& sample(std::size_t index) const noexcept { return sums_[index].sample; }
  [[nodiscard]] std::span<const Color> layers(std::size_t index) const noexcept {
    return sums_[index].layers;
  }
  // What each edit took on its way, of a sample with ViewSample::is_probed.
  [[nodiscard]] std::span<const TakenLight> edits(std::size_t index) const noexcept {
    return sums_[index].edits;
  }
  // Of the mean direct light of a sample with ViewSample::measures_lights, from two light samples at each v.
  [[nodiscard]] V3d& light_variance(std::size_t index) noexcept { return sums_[index].light_variance; }
  [[nodiscard]] const V3d& light_variance(std::size_t index) const noexcept {
    return sums_[index].light_variance;
  }

  void start_bundle(std::span<const ViewSample> bundle) noexcept { bundle_ = bundle; }
  // A sample begins, of which nothing is known.
  void start(Sample& sample);
  // Depth, normal, albedo and alpha are those of the first thing that a sample meets (null: the world).
  void record_first(Sample& sample, const Vertex* vertex) noexcept;
  // A sample that has met nothing was taken by edits: black, but no hole in the film.
  void finish(const Sample& sample) noexcept;

  // Radiance that reaches the path's far end goes on to the eye, into the images that it belongs to.
  void add(Part part, const Sample& sample, const ViewPath& path, const BlurredLight& light,
           const JoinResult& joined) noexcept;
  // The same for what leaves a point that several paths see, to the sample with this index. `factor`: of its
  // path, all the way to the eye.
  void add(Part part, std::size_t sample, const OutgoingRadiance& light, const Color& factor) noexcept;
  // Radiance at the eye, added elsewhere, counts for the edits that took it.
  void credit(const Sample& sample, StateId q, const BlurredLight& light) noexcept {
    if (selection_.has_acted_edits(q)) credit_takers(sample, q, light);
  }
  // Both for radiance that leaves such a point.
  void add(OutgoingRadiance& to, const BlurredLight& light, const JoinResult& joined);
  void credit(OutgoingRadiance& to, const BlurredLight& light, StateId q) const;

  // Counts what a cap or an entry kept from the eye.
  const JoinResult& counted(const JoinResult& joined) noexcept {
    if (joined.outcome != JoinOutcome::Joined) count_lost(joined);
    return joined;
  }
  // Walks for emission alone would count a pixel's paths twice.
  [[nodiscard]] EditCounts& of_view_edit(const Sample& sample, int edit) noexcept {
    return sample.asked.seeks == Seeks::Emission ? uncounted_ : counts.of_edit(edit);
  }

 private:
  struct Sums {
    PixelSample sample;
    std::vector<Color> layers;
    std::vector<TakenLight> edits;
    V3d light_variance;
  };
  void add_up(Color& sum, const Color& radiance) noexcept;
  void credit(std::size_t sample, std::size_t edit, const BlurredLight& light) noexcept;
  void count_lost(const JoinResult& joined) noexcept;
  void credit_takers(const Sample& sample, StateId q, const BlurredLight& light) noexcept;

  const Scene& scene_;
  const TransportSettings& settings_;
  const PathSelection& selection_;
  std::span<const ViewSample> bundle_;
  std::array<Sums, bundle_size> sums_;
  EditCounts uncounted_;
};

}  // namespace sluice
