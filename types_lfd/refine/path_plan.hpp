// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "types_lfd/refine/placement.hpp"
#include "types_lfd/refine/refine.hpp"

namespace graft::lfd {

/// How base offsets to try are spread.
enum class Spread {
  kUsual,  ///< up to 0.45 m and 0.8 rad
  kWide,   ///< up to 1 m and half a turn
  kFine    ///< up to 0.2 m and 0.3 rad, closely
};

/// Base offsets to try: rings of growing distance around 0, with turns; sorted
/// by length, 0 first.
std::vector<BaseOffset> offsetLattice(Spread spread);

struct PathRequest {
  std::vector<std::size_t> keys;  ///< rising tuples to plan for, at least one
  const Placed* first = nullptr;  ///< prescribed at the first key
  const Placed* last = nullptr;   ///< prescribed at the last key
  /// Path (all tuples) around which to look; null = around the optimized bases.
  const std::vector<Placed>* around = nullptr;
};

struct PlannedPath {
  std::vector<Placed> at;  ///< for each key
  double cost = 0;
};

/// Cheapest way of base and arm through the keys: see refineBases. Where no
/// place has an arm solution, the nearest that stands is passed without.
PlannedPath planPath(const Placement& placement, const std::vector<BaseOffset>& lattice,
                     const std::vector<Eigen::VectorXd>& postures, const RefineOptions& options,
                     const PathRequest& request);

}  // namespace graft::lfd
