// SPDX-License-Identifier: GPL-3.0-or-later
// How photons leave their lights: a mixture of each light's own distribution, of aiming at targets, and of a
// histogram of what proved useful. Multiple importance sampling in its one-sample form (Veach 1997, §9.2.4):
// flux is divided by the density of the whole mixture, so shares change noise and never the mean.
#pragma once
#include <cstdint>
#include <numeric>
#include <vector>

#include "base/sampling.h"
#include "transport/emission_histogram.h"

namespace sluice {

// Shares of one light's photons, which need not sum to 1.
struct EmissionShares {
  float own = 0;               // as the light shines
  std::vector<float> targets;  // towards each of the guide's targets
  float histogram = 0;         // where its useful photons start

  [[nodiscard]] float aimed() const noexcept {
    return std::accumulate(targets.begin(), targets.end(), 0.0f) + histogram;
  }
};

// The mixture of one light. It alone knows how the ways to send out a photon are numbered.
class EmissionMixture {
 public:
  enum class Way : std::uint8_t { Own, Target, Histogram };
  struct Choice {
    static constexpr std::size_t no_target = ~std::size_t{0};
    Way way;
    std::size_t target;  // of Way::Target, else none
    float u;             // the random number, stretched to [0, 1) again
  };

  EmissionMixture(const EmissionShares& shares, EmissionHistogram histogram)
      : ways_(in_a_row(shares)), histogram_(std::move(histogram)) {}

  [[nodiscard]] const EmissionHistogram& histogram() const noexcept { return histogram_; }

  [[nodiscard]] Choice sample(float u) const noexcept {
    const Distribution::Choice way = ways_.sample(u);
    if (way.index == own) return {Way::Own, Choice::no_target, way.u};
    if (way.index == last()) return {Way::Histogram, Choice::no_target, way.u};
    return {Way::Target, way.index - first_target, way.u};
  }

  // The density of a start, however it was found: the sum of by_own(share), by_histogram(share) and
  // by_target(t, share) over all ways of share > 0. Each returns its density there times the share.
  template <class ByOwn, class ByHistogram, class ByTarget>
  [[nodiscard]] float pdf(ByOwn&& by_own, ByHistogram&& by_histogram, ByTarget&& by_target) const noexcept {
    float density = 0;
    if (const float share = ways_.pmf(own); share > 0) density += by_own(share);
    if (const float share = ways_.pmf(last()); share > 0) density += by_histogram(share);
    for (std::size_t way = first_target; way < last(); ++way)
      if (const float share = ways_.pmf(way); share > 0) density += by_target(way - first_target, share);
    return density;
  }

  // Calls act(share) for the light's own distribution, each target and the histogram.
  template <class Act>
  void for_each_share(Act&& act) const {
    for (std::size_t way = 0; way < ways_.size(); ++way) act(ways_.pmf(way));
  }

 private:
  static constexpr std::size_t own = 0, first_target = 1;
  [[nodiscard]] std::size_t last() const noexcept { return ways_.size() - 1; }  // the histogram
  [[nodiscard]] static Distribution in_a_row(const EmissionShares& shares) {
    std::vector<float> row = {shares.own};
    row.insert(row.end(), shares.targets.begin(), shares.targets.end());
    row.push_back(shares.histogram);
    return Distribution(row);
  }

  Distribution ways_;  // own, targets, histogram
  EmissionHistogram histogram_;
};

// Where the photons of a pass start (emission.h).
struct EmissionGuide {
  Distribution lights;  // share of the photons of each light
  std::vector<Target> targets;
  std::vector<EmissionMixture> mixtures;  // of each light
  Target aimed{V3d(0), 0};                // the sphere that the histograms of suns cover
};

}  // namespace sluice
