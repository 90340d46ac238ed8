// SPDX-License-Identifier: BSD-3-Clause
// How true a reachability map is, against KDL's inverse kinematics with 200 restarts.
// Unreachable poses take KDL a third of a second each, so it is asked last: a pose
// that lies farther from the shoulder than the arm is long needs no search, and one
// that another solver has reached is reachable.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "tests/types_lfd/reach/kdl_oracle.hpp"
#include "types_lfd/reach/reach_verify.hpp"

namespace {

using namespace graft;       // NOLINT: a program
using namespace graft::lfd;  // NOLINT

/// Proves that a pose is out of reach, by lengths alone: neither the last joint's
/// origin, as seen from the gripper, nor the first turning joint's, but for the
/// slide below it, depends on the joints.
class TooFar {
 public:
  explicit TooFar(const Chain& chain) {
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(chain.dof());
    const Eigen::Matrix3Xd at = chain.origins(zero);
    first_ = chain.prismatic(0) && chain.dof() > 1 ? 1 : 0;
    usable_ = !chain.prismatic(first_);
    Eigen::VectorXd low = zero;
    Eigen::VectorXd high = zero;
    if (first_ == 1) {
      low[0] = chain.lower()[0];
      high[0] = chain.upper()[0];
    }
    low_ = chain.origins(low).col(first_);
    high_ = chain.origins(high).col(first_);
    for (int j = first_ + 1; j < chain.dof(); ++j) {
      length_ += (at.col(j) - at.col(j - 1)).norm();
      if (chain.prismatic(j)) usable_ = false;
    }
    const Pose tip = chain.forward(zero);
    wrist_ = tip.inverse() * Eigen::Vector3d(at.col(chain.dof() - 1));
  }
  bool operator()(const Pose& base_T_gripper) const {
    const Eigen::Vector3d wrist = base_T_gripper * wrist_;
    const Eigen::Vector3d along = high_ - low_;
    const double square = along.squaredNorm();
    const double share =
        square > 0 ? std::clamp((wrist - low_).dot(along) / square, 0.0, 1.0) : 0.0;
    return usable_ && (wrist - low_ - share * along).norm() > length_ + 1e-3;
  }

 private:
  int first_ = 0;
  bool usable_ = true;
  double length_ = 0;
  Eigen::Vector3d low_;
  Eigen::Vector3d high_;
  Eigen::Vector3d wrist_;
};

int run(int count, char** arguments) {
  double poses_given = 0;
  double seed_given = 0;
  const auto whole = [](const char* text, double least, double& value) {
    return parseDouble(text, value) == NumberStatus::kOk && value >= least && value <= 1e9 &&
           value == std::floor(value);
  };
  if (count != 5 || !whole(arguments[3], 1, poses_given) || !whole(arguments[4], 0, seed_given)) {
    std::fprintf(stderr, "Usage: %s URDF TIP_LINK POSES SEED  (base link: base_footprint)\n",
                 arguments[0]);
    return 2;
  }
  const std::string path = arguments[1];
  const std::string tip = arguments[2];
  const int poses = static_cast<int>(poses_given);
  const auto seed = static_cast<std::uint64_t>(seed_given);
  Diagnostics diagnostics;
  const Chain chain(readUrdf(path, diagnostics), "base_footprint", tip);
  for (const std::string& line : diagnostics.lines()) std::fprintf(stderr, "%s\n", line.c_str());
  const ReachMap map = ReachMap::build(chain, ReachOptions());
  const TooFar too_far(chain);
  const ReachOracle own = ikOracle(chain, 30);
  const lfd::testing::KdlOracle kdl(path, "base_footprint", tip, 200);
  int by_length = 0;
  int by_kdl = 0;
  int found_by_kdl_alone = 0;
  const ReachOracle oracle = [&](const Pose& pose) {
    if (too_far(pose)) {
      ++by_length;
      return false;
    }
    if (own(pose)) return true;
    const bool reached = kdl(pose);
    ++(reached ? found_by_kdl_alone : by_kdl);
    return reached;
  };
  const ReachTrial trial = sampleReachTrial(chain, oracle, poses, seed);
  for (const Pose& pose : trial.reachable) {
    if (too_far(pose)) {
      std::fprintf(stderr, "the arm is longer than its lengths\n");
      return 1;
    }
  }
  const ReachRates rates = measureRates(map, trial);
  std::printf(
      "true positive rate %.4f, true negative rate %.4f, %d poses each, seed %llu; "
      "unreachable by length %d, by KDL %d; reached by KDL alone %d\n",
      rates.true_positive, rates.true_negative, poses, static_cast<unsigned long long>(seed),
      by_length, by_kdl, found_by_kdl_alone);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run(count, arguments);
  } catch (const graft::Error& error) {
    std::fprintf(stderr, "%s\n", error.formatted().c_str());
    return static_cast<int>(error.code());
  }
}
