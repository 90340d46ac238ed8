// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/statistics.hpp"

#include <algorithm>
#include <cstddef>

namespace graft::lfd {

double medianOf(std::vector<double> values) {
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  if (values.size() % 2 == 1) return *half;
  return 0.5 * (*half + *std::max_element(values.begin(), half));
}

double repeatedMedianLine(const std::vector<double>& times, const std::vector<double>& values,
                          double at) {
  const std::size_t n = times.size();
  std::vector<double> slopes;
  std::vector<double> inner;
  for (std::size_t j = 0; j < n; ++j) {
    inner.clear();
    for (std::size_t k = 0; k < n; ++k) {
      if (k != j) inner.push_back((values[k] - values[j]) / (times[k] - times[j]));
    }
    slopes.push_back(medianOf(inner));
  }
  const double slope = medianOf(slopes);
  inner.clear();
  for (std::size_t k = 0; k < n; ++k) inner.push_back(values[k] - slope * (times[k] - at));
  return medianOf(inner);
}

}  // namespace graft::lfd
