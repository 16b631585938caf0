// SPDX-License-Identifier: GPL-3.0-or-later
// What a pass counts beside its image: the energy ledger (design §4), traffic through the edits, work done,
// everything dropped or capped. One set per piece of work, added up in the order of the pieces, so the sums
// do not depend on threads. Each kind of count stands once as a member and once as a row of a table, from
// which sums, reports and Python's statistics follow; a member without its row does not compile.
#pragma once
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iterator>
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

  void operator+=(const Ledger& o) noexcept;
  [[nodiscard]] double residual() const noexcept;
  // Of what was emitted; infinite where some term is no number.
  [[nodiscard]] double relative_residual() const noexcept {
    const double part = std::abs(residual()) / emitted;
    return emitted == 0 ? 0 : std::isfinite(part) ? part : std::numeric_limits<double>::infinity();
  }
};

struct LedgerTerm {
  const char* name;
  double Ledger::*value;
  double sign;  // in the residual
};
inline constexpr LedgerTerm ledger_terms[] = {
    {"emitted", &Ledger::emitted, 1},   {"added", &Ledger::added, 1},
    {"sampling", &Ledger::sampling, 1}, {"absorbed", &Ledger::absorbed, -1},
    {"escaped", &Ledger::escaped, -1},  {"removed", &Ledger::removed, -1},
    {"capped", &Ledger::capped, -1},    {"clamped", &Ledger::clamped, -1},
};
static_assert(sizeof(Ledger) == std::size(ledger_terms) * sizeof(double), "each term has a row");

inline void Ledger::operator+=(const Ledger& o) noexcept {
  for (const LedgerTerm& term : ledger_terms) this->*term.value += o.*term.value;
}
inline double Ledger::residual() const noexcept {
  double sum = 0;
  for (const LedgerTerm& term : ledger_terms) sum += term.sign * (this->*term.value);
  return sum;
}

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
    // All members by name: one that is missing here does not compile.
    const auto& [o_matched, o_moved, o_capped, o_energy_in, o_energy_out, o_shown, o_kept, o_seconds] = o;
    matched += o_matched, moved += o_moved, capped += o_capped, kept |= o_kept;
    energy_in += o_energy_in, energy_out += o_energy_out, shown += o_shown, seconds += o_seconds;
  }
};

// Whole numbers: work done; then what was dropped or capped, never silently.
struct Counters {
  std::uint64_t rays = 0, shadow_rays = 0, photon_paths = 0, photons_stored = 0, view_paths = 0, gathers = 0,
                photons_gathered = 0;
  std::uint64_t edit_queries = 0;  // segments that asked the edits
  std::uint64_t non_finite = 0, adjoint_clamped = 0, depth_capped = 0, gates_capped = 0, split_capped = 0,
                grazing_dropped = 0;
  std::uint64_t alpha_capped = 0;   // behind more transparent surfaces than are followed
  std::uint64_t states_capped = 0;  // no memory for what they must remember of their way (state_table.h)

  void operator+=(const Counters& o) noexcept;
};

struct WorkCounter {
  const char* name;
  std::uint64_t Counters::*value;
};
inline constexpr WorkCounter work_counters[] = {
    {"rays", &Counters::rays},
    {"shadow_rays", &Counters::shadow_rays},
    {"photon_paths", &Counters::photon_paths},
    {"photons_stored", &Counters::photons_stored},
    {"view_paths", &Counters::view_paths},
    {"gathers", &Counters::gathers},
    {"photons_gathered", &Counters::photons_gathered},
    {"edit_queries", &Counters::edit_queries},
};

// In the order of the report, which says "fate: number how, number how; fate: number how".
struct DropCounter {
  const char* name;
  std::uint64_t Counters::*value;
  const char *fate, *how;
};
inline constexpr DropCounter drop_counters[] = {
    {"non_finite", &Counters::non_finite, "dropped", " not finite"},
    {"adjoint_clamped", &Counters::adjoint_clamped, "clamped", " at shading normals"},
    {"depth_capped", &Counters::depth_capped, "capped", " by depth"},
    {"gates_capped", &Counters::gates_capped, "capped", " by gates"},
    {"alpha_capped", &Counters::alpha_capped, "capped", " by alpha layers"},
    {"states_capped", &Counters::states_capped, "capped", " by states"},
    {"split_capped", &Counters::split_capped, "capped", " splits"},
    {"grazing_dropped", &Counters::grazing_dropped, "grazing exits", ""},
};
static_assert(sizeof(Counters) ==
                  (std::size(work_counters) + std::size(drop_counters)) * sizeof(std::uint64_t),
              "each counter has a row");

inline void Counters::operator+=(const Counters& o) noexcept {
  for (const WorkCounter& counter : work_counters) this->*counter.value += o.*counter.value;
  for (const DropCounter& counter : drop_counters) this->*counter.value += o.*counter.value;
}

struct Counts : Counters {
  Ledger ledger;
  std::vector<EditCounts> edits;  // up to the last that had something to count

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
    Counters::operator+=(o);
    ledger += o.ledger;
    if (edits.size() < o.edits.size()) edits.resize(o.edits.size());
    for (std::size_t i = 0; i < o.edits.size(); ++i) edits[i] += o.edits[i];
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
