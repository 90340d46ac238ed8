// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/reach/reach_verify.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "types_lfd/robot/arm_ik.hpp"

namespace graft::lfd {

namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

Eigen::Vector3d direction(std::mt19937_64& random) {
  const double z = uniform(random, -1, 1);
  const double around = uniform(random, -3.14159265358979323846, 3.14159265358979323846);
  const double r = std::sqrt(1 - z * z);
  return Eigen::Vector3d(r * std::cos(around), r * std::sin(around), z);
}

double share(const ReachMap& map, const std::vector<Pose>& poses, bool held) {
  const auto count = std::count_if(poses.begin(), poses.end(), [&](const Pose& pose) {
    return map.contains(pose, Pose2()) == held;
  });
  return poses.empty() ? 1 : static_cast<double>(count) / static_cast<double>(poses.size());
}

/// A joint vector within the limits in which the robot does not hit itself.
Eigen::VectorXd sampleAllowed(const Chain& chain, std::mt19937_64& random) {
  Eigen::VectorXd q = sampleJoints(chain, random);
  while (chain.hitsItself(q)) q = sampleJoints(chain, random);
  return q;
}

}  // namespace

ReachOracle ikOracle(const Chain& chain, int restarts) {
  IkOptions options;
  options.restarts = restarts;
  const Eigen::VectorXd start = 0.5 * (chain.lower() + chain.upper());
  return [&chain, options, start](const Pose& pose) {
    return solveIk(chain, pose, start, options).has_value();
  };
}

ReachTrial sampleReachTrial(const Chain& chain, const ReachOracle& oracle, int count,
                            std::uint64_t seed, double away) {
  std::mt19937_64 random(seed);
  ReachTrial trial;
  const auto wanted = static_cast<std::size_t>(count);
  while (trial.reachable.size() < wanted) {
    trial.reachable.push_back(chain.forward(sampleAllowed(chain, random)));
  }
  while (trial.unreachable.size() < wanted) {
    Pose pose = chain.forward(sampleAllowed(chain, random));
    const Eigen::Vector3d towards = direction(random);
    pose.translation += uniform(random, 0, away) * towards;
    if (!oracle(pose)) trial.unreachable.push_back(pose);
  }
  return trial;
}

ReachRates measureRates(const ReachMap& map, const ReachTrial& trial) {
  return {share(map, trial.reachable, true), share(map, trial.unreachable, false)};
}

}  // namespace graft::lfd
