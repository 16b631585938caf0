// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/photon_map.h"

#include <bit>

namespace sluice {

void PhotonMap::build(std::span<const std::vector<Photon>> chunks, unsigned arrivals, float cell, ThreadPool& pool, const std::atomic<bool>& cancel) {
  const auto taken = [arrivals](const Photon& photon) { return (arrivals >> static_cast<unsigned>(photon.arrival)) & 1u; };
  photons_.clear();
  std::vector<std::size_t> offset(chunks.size() + 1, 0);
  pool.parallel_for(chunks.size(), [&](std::size_t c, int) {
    if (!cancel) offset[c + 1] = static_cast<std::size_t>(std::ranges::count_if(chunks[c], taken));
  });
  if (cancel) return;  // chunks may be missing from the count
  for (std::size_t c = 0; c < chunks.size(); ++c) offset[c + 1] += offset[c];

  const std::size_t count = offset.back();
  const std::uint32_t buckets = std::bit_ceil(static_cast<std::uint32_t>(std::clamp<std::size_t>(count, 64, 1u << 24)));
  mask_ = buckets - 1;
  inverse_cell_ = 1 / cell;
  keys_.resize(count);
  pool.parallel_for(chunks.size(), [&](std::size_t c, int) {
    if (cancel) return;
    std::size_t i = offset[c];
    for (const Photon& photon : chunks[c])
      if (taken(photon)) keys_[i++] = bucket(cell_of(photon.position.x), cell_of(photon.position.y), cell_of(photon.position.z));
  });
  if (cancel) return;  // some keys may be those of a pass before

  // Counting sort, stable: within a bucket photons keep the order of their paths.
  start_.assign(buckets + 1, 0);
  for (const std::uint32_t key : keys_) ++start_[key + 1];
  for (std::uint32_t b = 0; b < buckets; ++b) start_[b + 1] += start_[b];
  resize(count);
  std::size_t i = 0;
  for (const auto& chunk : chunks) {
    if (cancel) return photons_.clear();
    for (const Photon& photon : chunk)
      if (taken(photon)) put(start_[keys_[i++]]++, photon);
  }
  for (std::uint32_t b = buckets; b > 0; --b) start_[b] = start_[b - 1];  // undo the running ends
  start_[0] = 0;
}

void PhotonMap::resize(std::size_t count) {
  photons_.resize(count);
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
  for (const auto* column : {&x_, &y_, &z_, &flux_[0], &flux_[1], &flux_[2]}) columns += column->capacity();
  return photons_.capacity() * sizeof(Photon) + columns * sizeof(float);
}

int PhotonMap::ranges(const V3f& p, const V3f& extent, Rows& out) const noexcept {
  const std::int64_t x0 = cell_of(p.x - extent.x), x1 = cell_of(p.x + extent.x);
  const std::int64_t y0 = cell_of(p.y - extent.y), y1 = cell_of(p.y + extent.y);
  const std::int64_t z0 = cell_of(p.z - extent.z), z1 = cell_of(p.z + extent.z);
  const std::uint32_t width = static_cast<std::uint32_t>(std::min<std::int64_t>(x1 - x0 + 1, mask_ + 1));
  if ((y1 - y0 + 1) * (z1 - z0 + 1) > max_ranges / 2) {  // a radius far beyond the cells: everything, once
    out[0] = {0, mask_ + 1};
    return 1;
  }
  int n = 0;
  for (std::int64_t z = z0; z <= z1; ++z)
    for (std::int64_t y = y0; y <= y1; ++y) {
      const std::uint32_t b = bucket(x0, y, z), e = b + width;
      out[n++] = {b, std::min(e, mask_ + 1)};
      if (e > mask_ + 1) out[n++] = {0, e - mask_ - 1};
    }
  // Rows that hash onto each other are merged, else their photons would count twice.
  std::sort(out.begin(), out.begin() + n, [](const Range& a, const Range& b) { return a.begin < b.begin; });
  int merged = 0;
  for (int i = 1; i < n; ++i) {
    if (out[i].begin < out[merged].end)
      out[merged].end = std::max(out[merged].end, out[i].end);
    else
      out[++merged] = out[i];
  }
  return n == 0 ? 0 : merged + 1;
}

}  // namespace sluice
