// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/teach/grasp_samples.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/text.hpp"
#include "types_lfd/teach/random.hpp"

namespace graft::lfd {

namespace {

/// Multiples of a millionth: a file people can read, and the same numbers on
/// every machine.
double rounded(double value) { return std::round(value * 1e6) / 1e6; }

Grasp drawGrasp(const Scenario& scenario, double looseness, int row, Random& random) {
  const Eigen::Vector3d& bar = scenario.bar;
  const Eigen::Vector3d across = Eigen::Vector3d::UnitX().cross(bar);
  const double along = looseness * random.uniform(-0.04, 0.04);
  const double deep = -0.009 + looseness * random.uniform(-0.006, 0.006);
  const double beside = looseness * random.uniform(-0.006, 0.006);
  const double about_bar = looseness * random.uniform(-0.44, 0.44);
  const double tilt = looseness * random.uniform(-0.20, 0.20);
  const double roll = looseness * random.uniform(-0.06, 0.06);
  // The closing axis stands across the bar.
  const double straight = std::abs(bar.z()) > 0.5 ? 0 : 1.57079632679489661923;
  Grasp grasp;
  grasp.object_T_gripper.translation =
      deep * Eigen::Vector3d::UnitX() + along * bar + beside * across;
  const Eigen::Vector3d turn = about_bar * bar + tilt * across + roll * Eigen::Vector3d::UnitX();
  grasp.object_T_gripper.rotation =
      (expSO3<double>(turn) * expSO3<double>(Eigen::Vector3d(straight, 0, 0))).normalized();
  const double miss =
      std::hypot(std::hypot(along / 0.04, beside / 0.012), std::hypot(about_bar / 0.6, tilt / 0.3));
  const double quality = 1 - 0.75 * miss + 0.05 * random.normal();
  grasp.quality = rounded(std::clamp(quality, 0.0, 1.0));
  grasp.row = row;
  return grasp;
}

}  // namespace

std::vector<Grasp> sampleGrasps(const Scenario& scenario, std::uint64_t seed) {
  constexpr int kEnough = 10;
  Random random(seed, 4, 0);
  std::vector<Grasp> grasps;
  int good = 0;
  for (int row = 0; row < kGraspSamples; ++row) {
    // The last rows are drawn closely where too few good ones have come yet.
    const bool needed = kGraspSamples - row <= kEnough - good;
    Grasp grasp = drawGrasp(scenario, needed ? 0.3 : 1.0, row, random);
    while (needed && grasp.quality < kTaughtMinQuality) {
      grasp = drawGrasp(scenario, 0.3, row, random);
    }
    good += grasp.quality >= kTaughtMinQuality;
    grasps.push_back(grasp);
  }
  return grasps;
}

std::string formatGrasps(const std::vector<Grasp>& grasps) {
  std::string out = "x,y,z,qx,qy,qz,qw,quality\n";
  for (const Grasp& grasp : grasps) {
    double values[7];
    grasp.object_T_gripper.toArray(values);
    for (const double value : values) {
      appendDouble(out, rounded(value));
      out += ',';
    }
    appendDouble(out, grasp.quality);
    out += '\n';
  }
  return out;
}

}  // namespace graft::lfd
