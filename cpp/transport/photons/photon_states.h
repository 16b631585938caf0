// SPDX-License-Identifier: GPL-3.0-or-later
// Each thread numbers states as it meets them; photons carry numbers that all threads agree on. Who met a
// state first decides its number, which therefore differs from run to run. Nothing but the content is ever
// read of it, so pictures do not.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <vector>

#include "edit/state_table.h"
#include "transport/photons/photon.h"

namespace sluice {

class PhotonStates {
 public:
  static constexpr std::uint32_t none = StateTable::no_note;

  // Locks; callers remember the answer. None: a photon has no room for more.
  [[nodiscard]] std::uint32_t number(std::span<const std::uint32_t> content) {
    const std::lock_guard lock(lock_);
    const auto [at, is_new] = numbers_.emplace(std::vector(content.begin(), content.end()),
                                               static_cast<std::uint32_t>(contents_.size()));
    if (is_new && contents_.size() == max_states) {
      numbers_.erase(at);
      return none;
    }
    if (is_new) contents_.push_back(&at->first);
    return at->second;
  }

  // By number; not while threads number.
  [[nodiscard]] std::uint32_t size() const noexcept { return static_cast<std::uint32_t>(contents_.size()); }
  [[nodiscard]] std::span<const std::uint32_t> content(std::uint32_t number) const noexcept {
    return *contents_[number];
  }

 private:
  static constexpr std::size_t max_states = std::size_t{1} << Photon::q_bits;
  std::mutex lock_;
  std::map<std::vector<std::uint32_t>, std::uint32_t> numbers_;
  std::vector<const std::vector<std::uint32_t>*> contents_;
};

}  // namespace sluice
