// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/statistics.h"

#include <algorithm>

#include "edit/edits.h"

namespace sluice {

void RenderStatistics::start(const Scene& scene, const Effects& effects, int thread_count) {
  reasons = effects.reasons;
  triangles = scene.triangle_count();
  threads = thread_count;
  const Edits& edits = scene.edits();
  for (int e = 0; e < edits.size(); ++e) {
    const Quad& entry = edits[e].entry;
    edit_names.push_back(edits[e].name);
    edit_floats.push_back(
        {edits.delta() + entry.offset, std::min(entry.edge_u.length(), entry.edge_v.length())});
  }
  counts.edits.resize(edit_names.size());
}

void RenderStatistics::record(const PassRecord& pass) {
  counts += pass.counts;
  seconds_of(Phase::Photons) += pass.photon_seconds;
  seconds_of(Phase::View) += pass.view_seconds;
  worst_ledger_residual = std::max(worst_ledger_residual, pass.counts.ledger.relative_residual());
  if (pass.photons > 0)
    bytes_per_photon = static_cast<double>(pass.map_bytes) / static_cast<double>(pass.photons);
}

PictureShares shares_of(const Scene& scene, const Film& film, const Counts& counts, int passes) {
  PictureShares shares;
  const double whole = film.mean_luminance("Combined");
  const auto share = [whole](double part) { return whole > 0 ? part / whole : 0; };
  for (const LayerDescription& layer : scene.edits().layers())
    shares.layers.push_back({layer.name, layer.expression, share(film.mean_luminance(layer.name))});
  const double samples = static_cast<double>(passes) * film.width() * film.height();
  for (const EditCounts& edit : counts.edits)
    shares.edits.push_back(samples > 0 ? share(edit.shown / samples) : 0);
  return shares;
}

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

}  // namespace sluice
