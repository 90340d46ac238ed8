// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/resource.hpp"

namespace graft {

/// A pinhole camera on a vehicle: its pose body_T_camera (z ahead), focal lengths
/// and principal point in pixels; with two lenses their distance, m.
struct Camera {
  Pose body_T_camera;
  Mat<double, 3> k = Mat<double, 3>::Identity();
};
struct StereoCamera : Camera {
  double baseline = 0;
};

namespace slam3d {

inline void readCamera(std::vector<double>& numbers, Camera& camera) {
  camera.body_T_camera = resourcePose(numbers.data());
  camera.k << numbers[7], 0, numbers[9], 0, numbers[8], numbers[10], 0, 0, 1;
  if (numbers[7] == 0 || numbers[8] == 0) throw std::invalid_argument("a focal length is zero");
}

}  // namespace slam3d

template <>
struct ResourceTag<Camera> {
  static constexpr const char* kTag = "PARAMS_CAMERACALIB";
  static constexpr const char* kDoc = "camera in its vehicle: body_T_camera, m, and pixels";
  static constexpr const char* kFields = "x y z qx qy qz qw fx fy cx cy";
  static std::unique_ptr<const Camera> load(const std::string&,
                                            const std::vector<std::string>& tokens) {
    std::vector<double> numbers = resourceNumbers(tokens, kFields);
    auto camera = std::make_unique<Camera>();
    slam3d::readCamera(numbers, *camera);
    return camera;
  }
};

template <>
struct ResourceTag<StereoCamera> {
  static constexpr const char* kTag = "PARAMS_STEREOCAMERACALIB";
  static constexpr const char* kDoc = "stereo camera in its vehicle; no edge of g2o uses it";
  static constexpr const char* kFields = "x y z qx qy qz qw fx fy cx cy baseline";
  static std::unique_ptr<const StereoCamera> load(const std::string&,
                                                  const std::vector<std::string>& tokens) {
    std::vector<double> numbers = resourceNumbers(tokens, kFields);
    auto camera = std::make_unique<StereoCamera>();
    slam3d::readCamera(numbers, *camera);
    camera->baseline = numbers[11];
    return camera;
  }
};

}  // namespace graft
