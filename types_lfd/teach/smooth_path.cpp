// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/smooth_path.hpp"

#include <algorithm>

namespace graft::lfd {

double minimumJerkFraction(double s) {
  const double x = std::clamp(s, 0.0, 1.0);
  return x * x * x * (10 + x * (6 * x - 15));
}

Eigen::Vector3d bezier(const Eigen::Vector3d& p0, const Eigen::Vector3d& p1,
                       const Eigen::Vector3d& p2, const Eigen::Vector3d& p3, double s) {
  const double r = 1 - s;
  return r * r * r * p0 + 3 * r * r * s * p1 + 3 * r * s * s * p2 + s * s * s * p3;
}

void PlanarPath::add(double time, const Eigen::Vector3d& value) {
  times_.push_back(time);
  values_.push_back(value);
}

Eigen::Vector3d PlanarPath::slope(std::size_t i) const {
  if (i == 0 || i + 1 == times_.size()) return Eigen::Vector3d::Zero();
  return (values_[i + 1] - values_[i - 1]) / (times_[i + 1] - times_[i - 1]);
}

Eigen::Vector3d PlanarPath::at(double time) const {
  if (time <= times_.front()) return values_.front();
  if (time >= times_.back()) return values_.back();
  const auto after = std::upper_bound(times_.begin(), times_.end(), time);
  const auto i = static_cast<std::size_t>(after - times_.begin()) - 1;
  const double length = times_[i + 1] - times_[i];
  const double s = (time - times_[i]) / length;
  const double r = 1 - s;
  return r * r * (1 + 2 * s) * values_[i] + s * s * (3 - 2 * s) * values_[i + 1] +
         length * s * r * (r * slope(i) - s * slope(i + 1));
}

}  // namespace graft::lfd
