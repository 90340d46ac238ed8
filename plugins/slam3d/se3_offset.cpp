// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/slam3d/se3_offset.hpp"

namespace graft {

std::unique_ptr<const Se3Offset> ResourceTag<Se3Offset>::load(
    const std::string&, const std::vector<std::string>& tokens) {
  std::vector<double> numbers = resourceNumbers(tokens, kFields);
  auto offset = std::make_unique<Se3Offset>();
  offset->body_T_sensor = resourcePose(numbers.data());
  return offset;
}

}  // namespace graft
