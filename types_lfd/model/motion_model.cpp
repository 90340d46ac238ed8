// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/motion_model.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace graft::lfd {

namespace {

/// Beyond this the chart's distances differ from angles by a fifth.
constexpr double kWideRotation = 1.57;

void validate(const std::string& name, std::size_t number, const SegmentDemonstration& d) {
  const std::string where =
      "segment '" + name + "', demonstration " + std::to_string(number + 1) + ": ";
  const auto finite = [](const Pose& p) {
    return p.translation.allFinite() && p.rotation.coeffs().allFinite();
  };
  if (!finite(d.world_T_object)) throw Error(ExitCode::kInput, where + "the object is not finite");
  for (std::size_t i = 0; i < d.samples.size(); ++i) {
    const MotionSample& s = d.samples[i];
    if (!std::isfinite(s.time) || !finite(s.gripper) || !std::isfinite(s.base.x) ||
        !std::isfinite(s.base.y) || !std::isfinite(s.base.theta)) {
      throw Error(ExitCode::kInput, where + "sample " + std::to_string(i + 1) + " is not finite");
    }
    if (i > 0 && s.time <= d.samples[i - 1].time) {
      throw Error(ExitCode::kInput,
                  where + "the time of sample " + std::to_string(i + 1) + " does not rise");
    }
  }
}

SegmentChart chooseChart(const std::vector<const SegmentDemonstration*>& demonstrations) {
  SegmentChart chart;
  std::vector<Pose> objects;
  std::vector<Eigen::Quaterniond> rotations;
  for (const auto* d : demonstrations) {
    objects.push_back(d->world_T_object);
    for (const MotionSample& s : d->samples) {
      rotations.push_back(d->world_T_object.rotation.conjugate() * s.gripper.rotation);
    }
  }
  chart.heading_axis = mostLevelAxis(objects);
  chart.orientation_mean = meanRotation(rotations);
  return chart;
}

/// States of one demonstration without jumps of a turn; the first one is taken
/// on the turn nearest to `reference`.
std::vector<MotionState> encodeContinuously(const SegmentDemonstration& d,
                                            const SegmentChart& chart,
                                            const MotionState* reference) {
  std::vector<MotionState> states;
  states.reserve(d.samples.size());
  for (const MotionSample& s : d.samples) {
    const MotionState* near = states.empty() ? reference : &states.back();
    states.push_back(near != nullptr ? chart.encode(s.gripper, s.base, d.world_T_object, *near)
                                     : chart.encode(s.gripper, s.base, d.world_T_object));
  }
  return states;
}

/// `count` columns [t; state] at equal steps of t = 0..1, linear between samples.
Eigen::MatrixXd resample(const SegmentDemonstration& d, const std::vector<MotionState>& states,
                         int count) {
  const double first = d.samples.front().time;
  const double span = d.samples.back().time - first;
  Eigen::MatrixXd columns(1 + kStateDimension, count);
  std::size_t right = 1;
  for (int i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / (count - 1);
    const double time = first + t * span;
    while (right + 1 < states.size() && d.samples[right].time < time) ++right;
    const double before = d.samples[right - 1].time;
    const double share = std::clamp((time - before) / (d.samples[right].time - before), 0.0, 1.0);
    columns(0, i) = t;
    columns.col(i).tail<kStateDimension>() =
        states[right - 1] + share * (states[right] - states[right - 1]);
  }
  return columns;
}

int resampledCount(const std::vector<const SegmentDemonstration*>& demonstrations,
                   const FitOptions& options) {
  std::vector<int> sizes;
  sizes.reserve(demonstrations.size());
  for (const auto* d : demonstrations) sizes.push_back(static_cast<int>(d->samples.size()));
  std::sort(sizes.begin(), sizes.end());
  return std::clamp(sizes[sizes.size() / 2], options.minimum_resampled, options.maximum_resampled);
}

}  // namespace

SegmentModel fitSegment(const std::string& name,
                        const std::vector<SegmentDemonstration>& demonstrations,
                        const FitOptions& options, FitReport* report) {
  if (options.minimum_resampled < 2 || options.maximum_resampled < options.minimum_resampled) {
    throw Error(ExitCode::kUsage, "resampling of demonstrations needs 2 <= minimum <= maximum");
  }
  FitReport local;
  FitReport& notes = report != nullptr ? *report : local;
  notes = FitReport();
  std::vector<const SegmentDemonstration*> used;
  for (std::size_t i = 0; i < demonstrations.size(); ++i) {
    validate(name, i, demonstrations[i]);
    if (demonstrations[i].samples.size() >= 2) {
      used.push_back(&demonstrations[i]);
    } else {
      notes.notes.push_back("demonstration " + std::to_string(i + 1) +
                            " left out: fewer than two samples");
    }
  }
  if (used.empty()) {
    throw Error(ExitCode::kNoResult,
                "segment '" + name + "': no demonstration with at least two samples");
  }

  SegmentModel model;
  model.name = name;
  model.demonstrations = static_cast<int>(used.size());
  model.chart = chooseChart(used);
  model.start.setZero();
  model.end.setZero();
  const int count = resampledCount(used, options);
  Eigen::MatrixXd samples(1 + kStateDimension, count * static_cast<Eigen::Index>(used.size()));
  MotionState reference;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const auto states = encodeContinuously(*used[i], model.chart, i == 0 ? nullptr : &reference);
    if (i == 0) reference = states.front();
    samples.middleCols(static_cast<Eigen::Index>(i) * count, count) =
        resample(*used[i], states, count);
    model.start += states.front();
    model.end += states.back();
    model.duration += used[i]->samples.back().time - used[i]->samples.front().time;
  }
  const auto number = static_cast<double>(used.size());
  model.start /= number;
  model.end /= number;
  model.duration /= number;
  model.samples = static_cast<int>(samples.cols());

  const double widest = samples.middleRows<3>(4).colwise().norm().maxCoeff();
  if (widest > kWideRotation) {
    notes.notes.push_back("gripper orientations spread up to " +
                          std::to_string(std::lround(widest * 180 / 3.14159265358979323846)) +
                          " degrees from their mean; covariances of rotation are distorted there");
  }
  EmResult fit = selectMixture(samples, options.mixture, SampleGroups{count});
  model.mixture = std::move(fit.mixture);
  model.selection = std::move(fit.curve);
  notes.log_likelihood = std::move(fit.history);
  notes.notes.insert(notes.notes.end(), fit.notes.begin(), fit.notes.end());
  return model;
}

}  // namespace graft::lfd
