// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/sample_sums.h"

#include <limits>

#include "transport/sample_map.h"

namespace sluice {
namespace {

constexpr float far_away = 1e10f;  // Blender's depth of nothing

}  // namespace

void SampleSums::start(Sample& sample) {
  Sums& sums = sums_[sample.index];
  sums.sample = {}, sums.light_variance = V3d(0);
  sums.layers.assign(scene_.edits().layers().size(), Color(0));
  if (sample.asked.is_probed) sums.edits.assign(static_cast<std::size_t>(scene_.edits().told_apart()), {});
  sample.is_recorded = sample.asked.seeks == Seeks::Emission;  // other samples tell
  hue_gates.clear();
}

void SampleSums::record_first(Sample& sample, const Vertex* vertex) noexcept {
  if (sample.is_recorded) return;
  sample.is_recorded = true;
  PixelSample& sums = sums_[sample.index].sample;
  sums.alpha = vertex || !settings_.transparent_film ? 1 : 0;
  sums.depth = vertex ? static_cast<float>(scene_.camera().depth(vertex->hit.position)) : far_away;
  if (!vertex) return;
  sums.normal = vertex->point.ns;
  sums.albedo = albedo(vertex->bsdf, vertex->point.wo, any_lobe);
}

void SampleSums::finish(const Sample& sample) noexcept {
  if (!sample.is_recorded) sums_[sample.index].sample.alpha = 1, sums_[sample.index].sample.depth = far_away;
}

// The sum of numbers that are finite need not be. It is capped so that the sum of all parts of all samples of
// a pixel is.
void SampleSums::add_up(Color& sum, const Color& radiance) noexcept {
  constexpr float max_sum = std::numeric_limits<float>::max() / (8 * SampleMap::max_samples);
  static_assert(part_count <= 8);
  sum += radiance;
  if (max_component(sum) < max_sum) return;
  ++counts.non_finite;
  for (int c = 0; c < 3; ++c) sum[c] = std::min(sum[c], max_sum);
}

void SampleSums::add(Part part, const Sample& sample, const ViewPath& path, const BlurredLight& light,
                     const JoinResult& joined) noexcept {
  const Color radiance = hue_gates.to_eye(light.radiance * path.weight, path.hue);
  if (!is_finite(radiance)) {
    ++counts.non_finite;
    return;
  }
  Sums& sums = sums_[sample.index];
  if (joined.images & picture) {
    add_up(sums.sample.parts[static_cast<std::size_t>(part)], radiance);
    const BlurredLight at_eye = light.changed_to(radiance);
    sums.sample.bias[static_cast<std::size_t>(part)] += at_eye.bias;
    credit(sample, joined.q, at_eye);
  }
  for (ImageSet layers = joined.images >> 1; layers; layers &= layers - 1)
    add_up(sums.layers[static_cast<std::size_t>(std::countr_zero(layers))], radiance);
}

void SampleSums::add(Part part, std::size_t sample, const OutgoingRadiance& light,
                     const Color& factor) noexcept {
  const Color radiance = light.picture * factor;
  if (!is_finite(radiance)) return void(++counts.non_finite);
  Sums& sums = sums_[sample];
  add_up(sums.sample.parts[static_cast<std::size_t>(part)], radiance);
  sums.sample.bias[static_cast<std::size_t>(part)] +=
      BlurredLight(light.picture, light.bias).bias_of(radiance);
  for (std::size_t l = 0; l < sums.layers.size(); ++l) add_up(sums.layers[l], light.layers[l] * factor);
  for (const auto& [edit, share] : light.taken)
    credit(sample, edit, share.changed_to(share.radiance * factor));
}

void SampleSums::credit_takers(const Sample& sample, StateId q, const BlurredLight& light) noexcept {
  if (!is_finite(light.radiance)) return;
  for (const std::uint32_t edit : selection_.acted_edits(q)) credit(sample.index, edit, light);
}

void SampleSums::credit(std::size_t sample, std::size_t edit, const BlurredLight& light) noexcept {
  const float share = bundle_[sample].share, shown = luminance(light.radiance) * share;
  counts.of_edit(static_cast<int>(edit)).shown += shown;
  if (bundle_[sample].is_probed) sums_[sample].edits[edit] += {shown, light.bias * share};
}

void SampleSums::add(OutgoingRadiance& to, const BlurredLight& light, const JoinResult& joined) {
  if (!is_finite(light.radiance)) return void(++counts.non_finite);
  to.add(light, joined.images);
  if (joined.images & picture) credit(to, light, joined.q);
}

void SampleSums::credit(OutgoingRadiance& to, const BlurredLight& light, StateId q) const {
  if (!selection_.has_acted_edits(q) || !is_finite(light.radiance)) return;
  for (const std::uint32_t edit : selection_.acted_edits(q)) to.credit(edit, light);
}

void SampleSums::count_lost(const JoinResult& joined) noexcept {
  if (joined.outcome == JoinOutcome::GatesCapped) ++counts.gates_capped;
  if (joined.outcome == JoinOutcome::StatesCapped) ++counts.states_capped;
  if (joined.refused_by >= 0) counts.of_edit(joined.refused_by).kept = true;
}

}  // namespace sluice
