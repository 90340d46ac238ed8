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
/// Share of a segment within which it comes to rest at its ends.
constexpr double kRestShare = 0.15;
/// Step in phase for the slope of the regression at its ends.
constexpr double kSlopeStep = 1e-5;

/// [gripper translation along world axes; gripper rotation in its frame; base x,
/// y, yaw]: a difference of two joint poses that can be scaled and added.
using Offset = Vec<double, kStateDimension>;

/// From `a` to `b`; rotations by the shorter way.
Offset offsetBetween(const JointPose& a, const JointPose& b) {
  Offset d;
  d.head<3>() = b.gripper.translation - a.gripper.translation;
  d.segment<3>(3) = logSO3(Eigen::Quaterniond(a.gripper.rotation.conjugate() * b.gripper.rotation));
  d.tail<3>() << b.base.x - a.base.x, b.base.y - a.base.y, wrapAngle(b.base.theta - a.base.theta);
  return d;
}

JointPose shifted(const JointPose& pose, const Offset& d) {
  const Vec<double, 3> turn = d.segment<3>(3);
  JointPose result;
  result.gripper.translation = pose.gripper.translation + d.head<3>();
  result.gripper.rotation = (pose.gripper.rotation * expSO3<double>(turn)).normalized();
  result.base = Pose2(pose.base.x + d[6], pose.base.y + d[7], pose.base.theta + d[8]);
  return result;
}

/// Quintic with value 0 and slope 1 at s = 0 and neither value, slope nor
/// curvature elsewhere at the ends of [0, 1]; 0 outside.
double slopeBlend(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * (1 - s * s * (6 - s * (8 - 3 * s)));
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

/// What is added to the regression near one end of a segment: an offset that
/// carries it to the pose it should have there, and a change of velocity that
/// lets it stand still there.
struct EndCorrection {
  Offset offset;
  Offset slope;  ///< per unit of phase, away from the end

  /// `outside` is the pose wanted where the regression has `pose`, and `inner` the
  /// regression a little inside, at distance `step` in phase.
  EndCorrection(const JointPose& outside, const JointPose& pose, const JointPose& inner,
                double step)
      : offset(offsetBetween(pose, outside)), slope(-offsetBetween(pose, inner) / step) {
    // Velocity of the shifted rotation R exp(d): exp(-d) w + J(d) d' = 0.
    const Vec<double, 3> d = offset.segment<3>(3);
    const Vec<double, 3> w = slope.segment<3>(3);
    const Vec<double, 3> back = -d;
    slope.segment<3>(3) = inverseRightJacobianSO3(d) * (expSO3<double>(back) * w);
  }

  /// The correction at distance `s` in phase from the end.
  Offset at(double s, double offset_share) const {
    return (1 - minimumJerk(s / offset_share)) * offset +
           kRestShare * slopeBlend(s / kRestShare) * slope;
  }
};

/// The regression from phase 0 to 1, carried to the given ends, at rest there.
std::vector<JointPose> segmentPath(const PlacedSegment& segment, const JointPose& from,
                                   const JointPose& to, const ReproduceOptions& options) {
  const double wanted =
      std::max(kFewestNodes, kNodesPerSample * options.rate * segment.model().duration);
  if (!(wanted < kNodesPerSample * kMostSamples)) {
    throw Error(ExitCode::kResources,
                "segment '" + segment.model().name + "' would have too many samples");
  }
  const auto steps = static_cast<int>(wanted);
  const EndCorrection start(from, segment.at(0), segment.at(kSlopeStep), kSlopeStep);
  const EndCorrection end(to, segment.at(1), segment.at(1 - kSlopeStep), kSlopeStep);
  std::vector<JointPose> path;
  path.reserve(static_cast<std::size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    const double phase = static_cast<double>(i) / steps;
    JointPose pose =
        shifted(segment.at(phase), start.at(phase, options.blend_share) + end.at(1 - phase, 1));
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
  const JointPose end = before.end();
  return shifted(end, 0.5 * offsetBetween(end, after.start()));
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
