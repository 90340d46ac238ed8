// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "types_lfd/model/motion_model.hpp"

namespace graft::lfd::testing {

/// Demonstrations of a made-up task with a known grasp: reaching on a curve,
/// pulling along an arc, letting go. Noise is in the shape, not at the grasp.
class SyntheticTask {
 public:
  explicit SyntheticTask(std::uint64_t seed = 5) : random_(seed) {}

  /// The grasp all demonstrations share.
  static Pose objectTGripper() {
    return Pose(Vec<double, 3>(-0.12, 0.03, 0.05), expSO3<double>(Vec<double, 3>(0.3, -0.2, 0.4)));
  }

  /// `kind` 0 reach, 1 manipulate, 2 retreat. Every demonstration has its own
  /// object pose (turned about the vertical), duration and number of samples.
  std::vector<SegmentDemonstration> demonstrations(int kind, int count = 5) {
    std::vector<SegmentDemonstration> result;
    for (int i = 0; i < count; ++i) {
      std::normal_distribution<double> normal;
      SegmentDemonstration d;
      d.world_T_object =
          Pose(Vec<double, 3>(2 + normal(random_), normal(random_), 1.0),
               expSO3<double>(Vec<double, 3>(0, 0, 1.5 * i)) * expSO3<double>(tilt_));
      const double duration = 3 + 0.5 * (i % 3);
      const int samples = 40 + 7 * i;
      const double bend = 0.03 * normal(random_);
      for (int n = 0; n < samples; ++n) {
        const double s = static_cast<double>(n) / (samples - 1);
        d.samples.push_back(sampleAt(kind, s, bend, d.world_T_object));
        d.samples.back().time = 100 * i + s * duration;
      }
      result.push_back(d);
    }
    return result;
  }

  MotionModel model(const FitOptions& options = FitOptions()) {
    MotionModel result;
    result.task = "synthetic";
    const char* names[] = {"reach", "manipulate", "retreat"};
    for (int kind = 0; kind < 3; ++kind) {
      result.segments.push_back(fitSegment(names[kind], demonstrations(kind), options));
    }
    return result;
  }

  static Pose objectAt(double x, double y, double yaw) {
    return Pose(Vec<double, 3>(x, y, 1.0),
                expSO3<double>(Vec<double, 3>(0, 0, yaw)) * expSO3<double>(tilt_));
  }

 private:
  static MotionSample sampleAt(int kind, double s, double bend, const Pose& world_T_object) {
    const double ease = s * s * (3 - 2 * s);
    // Way back from the grasp in reaching, 1 to 0; on from it in retreat.
    const double away = kind == 0 ? 1 - ease : kind == 2 ? ease : 0.0;
    const double pull = kind == 0 ? 0.0 : kind == 1 ? ease : 1.0;
    const double wiggle = bend * std::sin(3.14159265358979323846 * s);
    const Pose hinge(Vec<double, 3>(0, 0.7, 0), Eigen::Quaterniond::Identity());
    const Pose swing(Vec<double, 3>::Zero(), expSO3<double>(Vec<double, 3>(0, 0, -1.2 * pull)));
    const Pose approach(Vec<double, 3>(-0.4 * away, 0.2 * away * away + wiggle, 0.1 * away),
                        expSO3<double>(Vec<double, 3>(0.5 * away, -0.3 * away, wiggle)));
    const Pose moved_T_gripper = objectTGripper() * approach;
    MotionSample sample;
    sample.gripper = world_T_object * (hinge * swing * hinge.inverse() * moved_T_gripper);
    const Pose2 base(-0.8 - 0.5 * away - 0.4 * pull, 0.1 * away + wiggle, 0.2 * away - 0.5 * pull);
    sample.base = headingFrame(world_T_object, 0) * base;
    sample.base.renormalize();
    return sample;
  }

  inline static const Vec<double, 3> tilt_{0.1, -0.2, 0.0};
  std::mt19937_64 random_;
};

}  // namespace graft::lfd::testing
