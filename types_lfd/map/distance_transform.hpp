// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace graft::lfd {

/// Stands for "no marked cell anywhere".
constexpr std::int32_t kNoDistance = std::numeric_limits<std::int32_t>::max();

/// Exact squared Euclidean distance, in cells, from the centre of every cell to
/// the centre of the nearest marked cell; width * height entries, row by row.
/// Time is linear in the number of cells. Sides up to 32767.
/// Source: Felzenszwalb and Huttenlocher, "Distance transforms of sampled
/// functions", Theory of Computing 8, 2012.
std::vector<std::int32_t> squaredDistances(const std::vector<bool>& marked, int width, int height);

}  // namespace graft::lfd
