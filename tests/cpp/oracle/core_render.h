// SPDX-License-Identifier: GPL-3.0-or-later
// The core's answer in the oracles' terms: whole renders with several seeds, as region means.
#pragma once
#include "oracle/rules.h"
#include "transport/guide/pilot.h"
#include "transport/photons/photon_pass.h"
#include "transport/photons/photon_set.h"
#include "transport/view/view_pass.h"

namespace sluice::oracle {

struct CoreRender {
  int seeds = 16, passes = 4;
  std::uint64_t first_seed = 1;
  // as a session does; one guide for all seeds saves the pilot's time and is as unbiased
  bool guide_per_seed = false;
  double gather_radius = 0.03;  // at y, first pass (m)
};

// The pictures' names: the parts, or the layers in their places.
inline std::vector<std::string> names_of(const Scene& scene) {
  std::vector<std::string> names;
  for (const LayerDescription& layer : scene.edits().layers()) names.push_back(layer.name);
  return names.empty() ? std::vector<std::string>{"Direct", "Caustics", "Edited", "Indirect", "Emission"}
                       : names;
}

inline Regions regions_of(const Film& film, int side, const FrameDescription& frame,
                          const std::vector<std::string>& names) {
  Regions out(side);
  for (std::size_t p = 0; p < names.size(); ++p) {
    const std::vector<float> image = film.image(names[p]);
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        const float* c = &image[3 * static_cast<std::size_t>(y * frame.width + x)];
        out.at(x + 0.5, y + 0.5, frame, static_cast<Part>(p)) +=
            V3d(c[0], c[1], c[2]) * (static_cast<double>(side) * side / (frame.width * frame.height));
      }
  }
  return out;
}

// All kinds of samples next to each other, in one bundle: few and many of them, of lights, of gather
// segments, of emission alone.
inline SampleMap mixed_samples(const FrameDescription& frame) {
  constexpr int side = 2;
  constexpr SampleCount kinds[] = {{},
                                   {.gather_segments = 1},
                                   {},
                                   {.light_samples = 2, .gather_segments = 2},
                                   {},
                                   {},
                                   {.gather_segments = 4, .emission_samples = 2},
                                   {.samples = 2}};
  const int width = (frame.width + side - 1) / side, height = (frame.height + side - 1) / side;
  std::vector<SampleCount> counts;
  for (int block = 0; block < width * height; ++block)
    counts.push_back(kinds[(block + block / width) % std::size(kinds)]);
  return {side, static_cast<std::size_t>(width), counts};
}

inline std::vector<Regions> render_core(const Scene& scene, TransportSettings settings, const CoreRender& how,
                                        int side, ThreadPool& pool, Counts& counts) {
  const Effects effects = find_effects(scene, settings);
  const std::atomic<bool> cancel{false};
  const auto guide_of = [&] {
    Guide guide = make_guide(scene, settings, effects, pool, cancel);
    // small, and the same everywhere
    guide.min_radius = guide.max_radius = guide.radius = static_cast<float>(how.gather_radius);
    guide.samples = mixed_samples(scene.frame());
    return guide;
  };
  Guide guide = guide_of();
  std::vector<Regions> out;
  for (int seed = 0; seed < how.seeds; ++seed) {
    settings.seed = how.first_seed + static_cast<std::uint64_t>(seed);
    if (how.guide_per_seed) guide = guide_of();
    PhotonPass photon_pass(scene, settings, effects, pool.size());
    ViewPass view_pass(scene, settings, effects, pool.size());
    const std::vector<std::string> names = names_of(scene);
    FilmContents contents;
    if (!scene.edits().layers().empty()) contents.layers = names;
    Film film(scene.frame().width, scene.frame().height, contents);
    std::mutex lock;
    PhotonSet photons;
    for (int pass = 0; pass < how.passes; ++pass) {
      const PassContext context{scene, settings, effects, guide, pass};
      Counts of_pass;
      (void)(!effects.traces_photons() || photon_pass.run(context, pool, cancel, photons, of_pass));
      (void)view_pass.run(context, photons, pool, cancel, film, lock, of_pass);
      counts += of_pass;
    }
    out.push_back(regions_of(film, side, scene.frame(), names));
  }
  return out;
}

}  // namespace sluice::oracle
