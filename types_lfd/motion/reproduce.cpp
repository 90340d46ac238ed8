// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/motion/reproduce.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace graft::lfd {

namespace {

constexpr double kMostSamples = 1e7;
constexpr double kNodesPerSample = 4;
constexpr double kFewestNodes = 200;

/// Difference of two joint poses that can be scaled: positions along world axes,
/// rotation in the gripper's frame, yaw by the shorter way.
struct Offset {
  Vec<double, 3> gripper_translation = Vec<double, 3>::Zero();
  Vec<double, 3> gripper_rotation = Vec<double, 3>::Zero();
  Vec<double, 3> base = Vec<double, 3>::Zero();

  Offset() = default;
  Offset(const JointPose& from, const JointPose& to)
      : gripper_translation(to.gripper.translation - from.gripper.translation),
        gripper_rotation(
            logSO3(Eigen::Quaterniond(from.gripper.rotation.conjugate() * to.gripper.rotation))),
        base(to.base.x - from.base.x, to.base.y - from.base.y,
             wrapAngle(to.base.theta - from.base.theta)) {}
};

JointPose shifted(const JointPose& pose, const Offset& a, double share_a, const Offset& b,
                  double share_b) {
  const Vec<double, 3> turn = share_a * a.gripper_rotation + share_b * b.gripper_rotation;
  const Vec<double, 3> drive = share_a * a.base + share_b * b.base;
  JointPose result;
  result.gripper.translation =
      pose.gripper.translation + share_a * a.gripper_translation + share_b * b.gripper_translation;
  result.gripper.rotation = (pose.gripper.rotation * expSO3<double>(turn)).normalized();
  result.base = Pose2(pose.base.x + drive[0], pose.base.y + drive[1], pose.base.theta + drive[2]);
  return result;
}

/// A segment placed in the world.
class PlacedSegment {
 public:
  PlacedSegment(const SegmentModel& model, const Pose& world_T_object)
      : model_(model), world_T_object_(world_T_object) {}

  const SegmentModel& model() const { return model_; }
  JointPose start() const { return decode(model_.start); }
  JointPose end() const { return decode(model_.end); }
  JointPose at(double phase) const { return decode(model_.mixture.atTime(phase).mean); }
  Mat<double, kStateDimension> covarianceAt(double phase) const {
    const TimeRegression r = model_.mixture.atTime(phase);
    return model_.chart.decodeCovariance(r.mean, r.covariance, world_T_object_);
  }

 private:
  JointPose decode(const MotionState& state) const {
    return {model_.chart.decodeGripper(state, world_T_object_),
            model_.chart.decodeBase(state, world_T_object_)};
  }

  const SegmentModel& model_;
  const Pose& world_T_object_;
};

/// The regression from phase 0 to 1, carried to the given ends.
std::vector<JointPose> segmentPath(const PlacedSegment& segment, const JointPose& from,
                                   const JointPose& to, const ReproduceOptions& options) {
  const double wanted =
      std::max(kFewestNodes, kNodesPerSample * options.rate * segment.model().duration);
  if (!(wanted < kNodesPerSample * kMostSamples)) {
    throw Error(ExitCode::kResources,
                "segment '" + segment.model().name + "' would have too many samples");
  }
  const auto steps = static_cast<int>(wanted);
  const Offset at_start(segment.at(0), from);
  const Offset at_end(segment.at(1), to);
  std::vector<JointPose> path;
  path.reserve(static_cast<std::size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    const double phase = static_cast<double>(i) / steps;
    JointPose pose =
        shifted(segment.at(phase), at_start, 1 - minimumJerk(phase / options.blend_share), at_end,
                minimumJerk(phase));
    const double previous = path.empty() ? from.base.theta : path.back().base.theta;
    pose.base.theta = previous + wrapAngle(pose.base.theta - previous);
    path.push_back(pose);
  }
  return path;
}

/// Appends the samples of one segment. The first node is a sample of its own
/// only at the start of the motion; elsewhere it is the last one of before.
void sampleSegment(const PlacedSegment& segment, const std::vector<JointPose>& path,
                   const ReproduceOptions& options, MotionPoint point,
                   std::vector<MotionPoint>& motion) {
  const auto steps = static_cast<double>(path.size() - 1);
  const auto times =
      scaleTime(path, segment.model().duration / steps, options.rate, options.limits);
  const double total = times.back() * options.rate;
  if (!(total + static_cast<double>(motion.size()) < kMostSamples)) {
    throw Error(ExitCode::kResources, "the motion would have more than ten million samples");
  }
  const auto count = std::llround(total);
  // Stamps are multiples of the period, not sums of it.
  const auto first = motion.empty() ? 0LL : static_cast<long long>(motion.size()) - 1;
  std::size_t right = 1;
  for (long long i = motion.empty() ? 0 : 1; i <= count; ++i) {
    const double time = std::min(static_cast<double>(i) / options.rate, times.back());
    while (right + 1 < times.size() && times[right] < time) ++right;
    const double share =
        i == count
            ? 1.0
            : std::clamp((time - times[right - 1]) / (times[right] - times[right - 1]), 0.0, 1.0);
    if (i == count) right = times.size() - 1;
    const JointPose pose = interpolate(path[right - 1], path[right], share);
    point.time = static_cast<double>(first + i) / options.rate;
    point.gripper = pose.gripper;
    point.base = pose.base;
    point.covariance = segment.covarianceAt((static_cast<double>(right) - 1 + share) / steps);
    motion.push_back(point);
  }
}

/// The state in which one segment hands over to the next: half way between what
/// both learned of it.
JointPose handOver(const PlacedSegment& before, const PlacedSegment& after) {
  return interpolate(before.end(),
                     shifted(before.end(), Offset(before.end(), after.start()), 1, Offset(), 0),
                     0.5);
}

void appendAction(const PlacedModel& placed, int action, const ReproduceOptions& options,
                  std::vector<MotionPoint>& motion) {
  std::vector<PlacedSegment> segments;
  for (const SegmentModel& s : placed.model.segments) {
    segments.emplace_back(s, placed.world_T_object);
  }
  if (segments.empty()) {
    throw Error(ExitCode::kNoResult, "the model of '" + placed.model.task + "' has no segments");
  }
  JointPose from = segments.front().start();
  if (!motion.empty()) {
    from = {motion.back().gripper, motion.back().base};
  } else {
    if (options.start_gripper) from.gripper = *options.start_gripper;
    if (options.start_base) from.base = *options.start_base;
  }
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const bool last = i + 1 == segments.size();
    JointPose to = last ? segments[i].end() : handOver(segments[i], segments[i + 1]);
    if (i == 0 && action == 0 && options.object_T_gripper) {
      to.gripper = placed.world_T_object * *options.object_T_gripper;
    }
    const auto path = segmentPath(segments[i], from, to, options);
    MotionPoint point;
    point.segment = static_cast<int>(i);
    point.action = action;
    sampleSegment(segments[i], path, options, point, motion);
    from = path.back();
  }
}

}  // namespace

double minimumJerk(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (6 * s - 15));
}

std::vector<MotionPoint> reproduceChain(const std::vector<PlacedModel>& chain,
                                        const ReproduceOptions& options) {
  validateLimits(options.limits);
  if (!(options.rate > 0) || !std::isfinite(options.rate)) {
    throw Error(ExitCode::kUsage, "the rate of a motion must be positive");
  }
  if (!(options.blend_share > 0 && options.blend_share <= 1)) {
    throw Error(ExitCode::kUsage, "the blended share of reaching must be in (0, 1]");
  }
  if (chain.empty()) throw Error(ExitCode::kNoResult, "no model to reproduce");
  std::vector<MotionPoint> motion;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    appendAction(chain[i], static_cast<int>(i), options, motion);
  }
  return motion;
}

std::vector<MotionPoint> reproduceMotion(const MotionModel& model, const Pose& world_T_object,
                                         const ReproduceOptions& options) {
  return reproduceChain({{model, world_T_object}}, options);
}

}  // namespace graft::lfd
