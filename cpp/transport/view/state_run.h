// SPDX-License-Identifier: GPL-3.0-or-later
// Photons that follow each other in one state, as neighbours often do: what becomes of them is asked once.
#pragma once
#include "transport/photons/flat_sum.h"
#include "transport/view/path_selection.h"

namespace sluice {

class StateRun {
 public:
  // `images`: that the photons may be added to. `sums`: the picture's share of photons that met no gate is
  // summed up before it is delivered.
  StateRun(PathSelection& selection, ConstraintId constraint, ImageSet images, bool sums) noexcept
      : selection_(selection),
        constraint_(constraint),
        images_(images),
        sums_(sums),
        asks_(selection.asks_photons(constraint)),
        joined_{picture & images},
        is_plain_(!asks_ && sums) {}

  [[nodiscard]] bool is_new(const Photon& photon) const noexcept { return asks_ && photon.q != q_; }
  void start(std::uint32_t q) noexcept {
    q_ = q;
    is_plain_ = sums_ && !selection_.asks_state(constraint_) &&
                selection_.states().gates(selection_.state_of_photon(q)) == 0;
    if (is_plain_) return;
    joined_ = selection_.join_photon(q, constraint_);
    joined_.images &= images_;
    is_plain_ = sums_ && joined_.images == picture && joined_.outcome == JoinOutcome::Joined &&
                selection_.states().gates(joined_.q) == 0;
  }

  // They belong to the sum and nowhere else, and no edit has a share in them.
  [[nodiscard]] bool is_plain() const noexcept { return is_plain_; }
  [[nodiscard]] const JoinResult& joined() const noexcept { return joined_; }
  // What becomes of those that met no gate.
  [[nodiscard]] SumAnswer answer() const noexcept {
    return {is_plain_ || ((joined_.images & picture) && selection_.states().gates(joined_.q) == 0),
            !is_plain_};
  }

 private:
  PathSelection& selection_;
  const ConstraintId constraint_;
  const ImageSet images_;
  const bool sums_, asks_;
  std::uint32_t q_ = ~0u;  // no photon's
  JoinResult joined_;
  bool is_plain_;
};

}  // namespace sluice
