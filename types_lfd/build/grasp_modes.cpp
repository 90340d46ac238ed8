// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/build/grasp_modes.hpp"

#include <algorithm>
#include <tuple>

namespace graft::lfd {

namespace {

/// Distance and angle between two demonstrations' holds.
Vec<double, 2> gapOf(const GraspSpread& spread, std::size_t a, std::size_t b) {
  const Vec<double, 6> e = poseError(spread.object_T_hand[a].inverse() * spread.object_T_hand[b]);
  return {e.head<3>().norm(), e.tail<3>().norm()};
}

/// The larger of both gaps in units of its limit: at most 1 for the same hold.
double dissimilarity(const GraspSpread& spread, std::size_t a, std::size_t b) {
  const Vec<double, 2> gap = gapOf(spread, a, b);
  return std::max(gap[0] / kSameGraspDistance, gap[1] / kSameGraspAngle);
}

double linkage(const GraspSpread& spread, const GraspMode& a, const GraspMode& b) {
  double largest = 0;
  for (const std::size_t i : a.demonstrations) {
    for (const std::size_t j : b.demonstrations) {
      largest = std::max(largest, dissimilarity(spread, i, j));
    }
  }
  return largest;
}

}  // namespace

bool sameGrasp(const GraspSpread& spread, std::size_t a, std::size_t b) {
  return dissimilarity(spread, a, b) <= 1;
}

std::vector<GraspMode> findGraspModes(const GraspSpread& spread) {
  std::vector<GraspMode> modes;
  for (std::size_t d = 0; d < spread.object_T_hand.size(); ++d) modes.push_back({{d}, 0, 0});
  while (modes.size() > 1) {
    double best = 2;
    std::size_t keep = 0;
    std::size_t merge = 0;
    for (std::size_t b = 0; b < modes.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const double link = linkage(spread, modes[a], modes[b]);
        if (link < best) std::tie(best, keep, merge) = std::make_tuple(link, a, b);
      }
    }
    if (best > 1) break;
    auto& target = modes[keep].demonstrations;
    const auto& source = modes[merge].demonstrations;
    target.insert(target.end(), source.begin(), source.end());
    modes.erase(modes.begin() + static_cast<std::ptrdiff_t>(merge));
  }
  for (GraspMode& mode : modes) {
    std::sort(mode.demonstrations.begin(), mode.demonstrations.end());
    for (const std::size_t i : mode.demonstrations) {
      for (const std::size_t j : mode.demonstrations) {
        const Vec<double, 2> gap = gapOf(spread, i, j);
        mode.distance = std::max(mode.distance, gap[0]);
        mode.angle = std::max(mode.angle, gap[1]);
      }
    }
  }
  std::sort(modes.begin(), modes.end(), [](const GraspMode& a, const GraspMode& b) {
    return a.demonstrations.size() != b.demonstrations.size()
               ? a.demonstrations.size() > b.demonstrations.size()
               : a.distance < b.distance;
  });
  return modes;
}

}  // namespace graft::lfd
