// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/slam3d/se3_offset.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>

namespace graft {

std::unique_ptr<const Se3Offset> ResourceTag<Se3Offset>::load(
    const std::string&, const std::vector<std::string>& tokens) {
  if (tokens.size() != 7) {
    throw std::invalid_argument("expected 7 numbers (x y z qx qy qz qw), got " +
                                std::to_string(tokens.size()));
  }
  double numbers[7];
  for (std::size_t i = 0; i < 7; ++i) {
    const char* begin = tokens[i].c_str();
    const char* end = begin + tokens[i].size();
    const auto [stop, error] = std::from_chars(begin, end, numbers[i]);
    if (error != std::errc() || stop != end || !std::isfinite(numbers[i])) {
      throw std::invalid_argument("'" + tokens[i] + "' is not a finite number");
    }
  }
  const double length =
      std::hypot(std::hypot(numbers[3], numbers[4]), std::hypot(numbers[5], numbers[6]));
  if (!(length > 0.5 && length < 2.0)) {
    throw std::invalid_argument("the length of the quaternion is not near 1");
  }
  Pose::normalize(numbers);
  auto offset = std::make_unique<Se3Offset>();
  offset->body_T_sensor = Pose::fromArray(numbers);
  return offset;
}

}  // namespace graft
