// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/photons/photon_map.h"

namespace sluice {
namespace {

std::uint32_t buckets_for(std::size_t photons) {
  return std::bit_ceil(static_cast<std::uint32_t>(std::clamp<std::size_t>(photons, 64, 1u << 24)));
}

}  // namespace

void PhotonMap::build(Chunks chunks, unsigned arrivals, float cell, ThreadPool& pool,
                      const std::atomic<bool>& cancel) {
  photons_.clear(), has_reaches_ = false;
  const float inverse_cell = 1 / cell;
  if (!for_each_taken(
          chunks, arrivals,
          [&](const Photon& photon, std::size_t i) { keys_[i] = hash(photon.position, inverse_cell); }, pool,
          cancel))
    return;
  grids_[0] = {.inverse_cell = inverse_cell, .mask = buckets_for(keys_.size()) - 1};
  start_.assign(grids_[0].mask + 2, 0);
  for (std::uint32_t& key : keys_) key &= grids_[0].mask;
  sort(chunks, arrivals, cancel);
}

// How many are taken of the chunks before each; at the end, of all.
std::vector<std::size_t> PhotonMap::offsets_of(Chunks chunks, unsigned arrivals, ThreadPool& pool,
                                               const std::atomic<bool>& cancel) {
  std::vector<std::size_t> offsets(chunks.size() + 1, 0);
  pool.parallel_for(chunks.size(), [&](std::size_t c, int) {
    if (!cancel)
      offsets[c + 1] = static_cast<std::size_t>(std::ranges::count_if(
          chunks[c], [arrivals](const Photon& photon) { return takes(arrivals, photon); }));
  });
  for (std::size_t c = 0; c < chunks.size(); ++c) offsets[c + 1] += offsets[c];
  return offsets;
}

// One after the other in the table; keys become those of the table.
void PhotonMap::lay_out_grids() {
  std::array<std::size_t, levels> held = {};
  for (const float reach : reach_) ++held[static_cast<std::size_t>(level_of(reach))];
  std::uint32_t end = 0;
  occupied_ = 0;
  for (int level = 0; level < levels; ++level) {
    const auto l = static_cast<std::size_t>(level);
    if (held[l] == 0) continue;
    occupied_ |= std::uint64_t{1} << level;
    grids_[l] = {.inverse_cell = inverse_cell(level), .first = end, .mask = buckets_for(held[l]) - 1};
    end += grids_[l].mask + 1;
  }
  start_.assign(end + 1, 0);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const Grid& grid = grids_[static_cast<std::size_t>(level_of(reach_[i]))];
    keys_[i] = grid.first + (keys_[i] & grid.mask);
  }
}

// By counting, stable: within a bucket photons keep the order of their paths.
void PhotonMap::sort(Chunks chunks, unsigned arrivals, const std::atomic<bool>& cancel) {
  for (const std::uint32_t key : keys_) ++start_[key + 1];
  for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
  resize(keys_.size());
  std::size_t i = 0;
  for (const auto& chunk : chunks) {
    if (cancel) return photons_.clear();
    for (const Photon& photon : chunk) {
      if (!takes(arrivals, photon)) continue;
      const std::uint32_t to = start_[keys_[i]]++;
      put(to, photon);
      if (has_reaches_) {
        per_reach2_[to] = 1 / square(reach_[i]);
        grids_[static_cast<std::size_t>(level_of(reach_[i]))].add(photon.position);
      }
      ++i;
    }
  }
  for (std::size_t b = start_.size() - 1; b > 0; --b) start_[b] = start_[b - 1];  // undo the running ends
  start_[0] = 0;
}

void PhotonMap::resize(std::size_t count) {
  photons_.resize(count);
  per_reach2_.resize(has_reaches_ ? count + lane_count : 0);
  for (auto* column : {&x_, &y_, &z_, &flux_[0], &flux_[1], &flux_[2]}) column->resize(count + lane_count);
  for (auto* column : {&normal_, &tag_}) column->resize(count + lane_count);
}

void PhotonMap::put(std::uint32_t to, const Photon& photon) noexcept {
  photons_[to] = photon;
  x_[to] = photon.position.x, y_[to] = photon.position.y, z_[to] = photon.position.z;
  const Color flux = photon.flux();
  for (int c = 0; c < 3; ++c) flux_[c][to] = flux[c];
  normal_[to] = photon.normal, tag_[to] = tag_of(photon);
}

std::size_t PhotonMap::bytes() const noexcept {
  std::size_t columns = start_.capacity() + keys_.capacity() + normal_.capacity() + tag_.capacity();
  for (const auto* column : {&x_, &y_, &z_, &per_reach2_, &flux_[0], &flux_[1], &flux_[2], &reach_})
    columns += column->capacity();
  return photons_.capacity() * sizeof(Photon) + columns * sizeof(float);
}

// Runs of photons that may lie there, on their way into the cache. Most rows of cells are empty where photons
// are few.
int PhotonMap::ranges(const Grid& grid, const V3f& p, const V3f& extent,
                      std::span<Range> out) const noexcept {
  const auto cell = [&grid](float x) { return cell_of(x, grid.inverse_cell); };
  const std::int32_t x0 = cell(p.x - extent.x), x1 = cell(p.x + extent.x);
  const std::int32_t y0 = cell(p.y - extent.y), y1 = cell(p.y + extent.y);
  const std::int32_t z0 = cell(p.z - extent.z), z1 = cell(p.z + extent.z);
  const std::uint32_t buckets = grid.mask + 1,
                      width = std::min(static_cast<std::uint32_t>(x1 - x0 + 1), buckets);
  std::size_t n = 0;
  const auto add = [&](std::uint32_t first, std::uint32_t last) {
    const Range row{start_[grid.first + first], start_[grid.first + last]};
    if (row.begin == row.end) return;
    __builtin_prefetch(&x_[row.begin]), __builtin_prefetch(&y_[row.begin]),
        __builtin_prefetch(&z_[row.begin]);
    std::size_t at = n++;  // by where they begin; there are few
    for (; at > 0 && out[at - 1].begin > row.begin; --at) out[at] = out[at - 1];
    out[at] = row;
  };
  // a radius far beyond the cells: everything, once
  if (std::int64_t{y1 - y0 + 1} * (z1 - z0 + 1) > max_ranges / 2) {
    add(0, buckets);
    return static_cast<int>(n);
  }
  for (std::int32_t z = z0; z <= z1; ++z)
    for (std::int32_t y = y0; y <= y1; ++y) {
      const std::uint32_t b = hash(x0, y, z) & grid.mask, e = b + width;
      add(b, std::min(e, buckets));
      if (e > buckets) add(0, e - buckets);
    }
  if (n < 2) return static_cast<int>(n);
  // Rows that hash onto each other are merged, else their photons would count twice.
  std::size_t merged = 0;
  for (std::size_t i = 1; i < n; ++i) {
    if (out[i].begin < out[merged].end)
      out[merged].end = std::max(out[merged].end, out[i].end);
    else
      out[++merged] = out[i];
  }
  return static_cast<int>(merged) + 1;
}

}  // namespace sluice
