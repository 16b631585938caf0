// SPDX-License-Identifier: GPL-3.0-or-later
// What a pass counts beside its image: the energy ledger (design §4), traffic through the edits, work done,
// everything dropped or capped. One set per piece of work, added up in the order of the pieces, so the sums
// do not depend on threads.
#pragma once
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/colour.h"

namespace sluice {

// Luminous flux (W, luminance-weighted) on the photon side. It closes: emitted + added + sampling = absorbed
// + escaped + removed + capped + clamped. `sampling` is signed: what roulette and the choice of lobes or
// exits gave or took against their expectation. `added` and `removed` are what edits do, all exits together;
// `capped` also what is dropped as too grazing or no number.
struct Ledger {
  double emitted = 0, added = 0, sampling = 0, absorbed = 0, escaped = 0, removed = 0, capped = 0,
         clamped = 0;

  void operator+=(const Ledger& o) noexcept {
    emitted += o.emitted, added += o.added, sampling += o.sampling, absorbed += o.absorbed;
    escaped += o.escaped, removed += o.removed, capped += o.capped, clamped += o.clamped;
  }
  [[nodiscard]] double residual() const noexcept {
    return emitted + added + sampling - absorbed - escaped - removed - capped - clamped;
  }
  // Of what was emitted; infinite where some term is no number.
  [[nodiscard]] double relative_residual() const noexcept {
    const double part = std::abs(residual()) / emitted;
    return emitted == 0 ? 0 : std::isfinite(part) ? part : std::numeric_limits<double>::infinity();
  }
};

struct EditCounts {
  std::uint64_t matched = 0;  // taken by the entry
  std::uint64_t moved = 0;    // copies sent on by exits
  std::uint64_t capped = 0;   // absorbed at max_gates
  double energy_in = 0, energy_out = 0;
  double shown = 0;  // luminance that light it took brings to all samples of the picture
  // did it keep light from the picture that came as far as a view, shadow or gather segment?
  bool kept = false;
  // of a thread, on paths beyond its gates; no part of any picture, and another each time
  double seconds = 0;

  // Not all light is photons': of emission that the eye sees, next-event estimation and the last bounce only
  // the eye's segments tell.
  [[nodiscard]] bool has_acted() const noexcept { return matched > 0 || shown > 0 || kept; }
  void operator+=(const EditCounts& o) noexcept {
    matched += o.matched, moved += o.moved, capped += o.capped, kept |= o.kept;
    energy_in += o.energy_in, energy_out += o.energy_out, shown += o.shown, seconds += o.seconds;
  }
};

struct Counts {
  Ledger ledger;
  std::vector<EditCounts> edits;  // up to the last that had something to count
  std::uint64_t rays = 0, shadow_rays = 0, photon_paths = 0, photons_stored = 0, view_paths = 0, gathers = 0,
                photons_gathered = 0;
  std::uint64_t edit_queries = 0;  // segments that asked the edits
  // dropped or capped, never silently
  std::uint64_t non_finite = 0, adjoint_clamped = 0, depth_capped = 0, gates_capped = 0, split_capped = 0,
                grazing_dropped = 0;
  std::uint64_t alpha_capped = 0;   // behind more transparent surfaces than are followed
  std::uint64_t states_capped = 0;  // no memory for what they must remember of their way (edit/state_table.h)

  // From zero. Room for all edits, so that of_edit() cannot fail; none is written to before it has something
  // to count.
  void start(int edit_count) {
    *this = {};
    edits.reserve(static_cast<std::size_t>(edit_count));
  }
  [[nodiscard]] EditCounts& of_edit(int edit) noexcept {
    const auto e = static_cast<std::size_t>(edit);
    if (e >= edits.size()) edits.resize(e + 1);
    return edits[e];
  }
  void operator+=(const Counts& o) {
    ledger += o.ledger;
    if (edits.size() < o.edits.size()) edits.resize(o.edits.size());
    for (std::size_t i = 0; i < o.edits.size(); ++i) edits[i] += o.edits[i];
    rays += o.rays, shadow_rays += o.shadow_rays, photon_paths += o.photon_paths,
        photons_stored += o.photons_stored;
    view_paths += o.view_paths, gathers += o.gathers, photons_gathered += o.photons_gathered,
        edit_queries += o.edit_queries;
    non_finite += o.non_finite, adjoint_clamped += o.adjoint_clamped, depth_capped += o.depth_capped,
        gates_capped += o.gates_capped;
    split_capped += o.split_capped, grazing_dropped += o.grazing_dropped, alpha_capped += o.alpha_capped,
        states_capped += o.states_capped;
  }
};

// Adds the time that it lives to the edit through whose gate a branch came; of branches that came through
// none (< 0) it takes none.
class BranchClock {
 public:
  BranchClock(Counts& counts, int edit) noexcept : counts_(counts), edit_(edit) {
    if (edit_ >= 0) begin_ = Clock::now();
  }
  ~BranchClock() {
    if (edit_ >= 0)
      counts_.of_edit(edit_).seconds += std::chrono::duration<double>(Clock::now() - begin_).count();
  }
  BranchClock(const BranchClock&) = delete;
  BranchClock& operator=(const BranchClock&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  Counts& counts_;
  int edit_;
  Clock::time_point begin_{};
};

}  // namespace sluice
