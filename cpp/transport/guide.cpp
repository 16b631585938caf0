// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide.h"

#include <algorithm>
#include <bit>

#include "base/random.h"

namespace sluice {

std::uint64_t Guide::hash() const noexcept {
  std::uint64_t h = 0;
  const auto add = [&h](auto x) { h = mix(h, std::bit_cast<std::uint32_t>(static_cast<float>(x))); };
  const auto add_all = [&add](const Distribution& d) {
    for (std::size_t i = 0; i < d.size(); ++i) add(d.pmf(i));
  };
  const auto add_target = [&add](const Target& t) {
    add(t.centre.x), add(t.centre.y), add(t.centre.z), add(t.radius);
  };
  add_all(emission.lights);
  std::ranges::for_each(emission.targets, add_target);
  add_target(emission.aimed);
  for (const EmissionMixture& mixture : emission.mixtures) mixture.for_each_share(add);
  for (const EmissionMixture& mixture : emission.mixtures) add_all(mixture.histogram().distribution());
  add(min_radius), add(max_radius), add(radius), add(caustic_radius);
  return mix(mix(mix(h, trust.hash()), mix(sharp_disks.hash(), soft_disks.hash())), samples.hash());
}

}  // namespace sluice
