// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/demo/recording_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/base/text.hpp"
#include "types_lfd/demo/match.hpp"
#include "types_lfd/demo/statistics.hpp"

namespace graft::lfd {

namespace {

// A tracker that gives a pose in more than this is no tracker of motion, s.
constexpr double kLongInterval = 2;
// No hand works higher than this over the floor, m.
constexpr double kHighestHand = 10;
// Nobody walks as far in one action, m.
constexpr double kWidestAction = 100;
// Below the floor by more than calibration leaves, m.
constexpr double kBelowFloor = 0.1;
// Way from the place of rest that counts as having left it, m and rad.
constexpr double kLeft = 0.05;
constexpr double kTurned = 0.35;
// Who moves first is clear if by this, s.
constexpr double kEarlier = 0.3;
// A hand that keeps within this has not reached for anything, m.
constexpr double kStill = 0.02;

std::string rounded(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

double quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// Where nine of ten positions lie along an axis, m.
struct Span {
  double low = 0;
  double middle = 0;
  double high = 0;
  double size() const { return high - low; }
  bool within(double a, double b) const { return a <= low && high <= b; }
};
Span spanAlong(const Trajectory& track, int axis) {
  std::vector<double> values;
  for (const Pose& pose : track.poses) values.push_back(pose.translation[axis]);
  return {quantile(values, 0.05), quantile(values, 0.5), quantile(values, 0.95)};
}

/// Times at which a pose is away from its first for the first time, and from its
/// last for the last time; three samples in a row have to agree.
struct Motion {
  bool moves = false;
  double first = 0;
  double last = 0;
};
bool away(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).norm() > kLeft ||
         rotationAngle(a.rotation.conjugate() * b.rotation) > kTurned;
}
Motion motionOf(const Trajectory& track) {
  Motion motion;
  const std::size_t n = track.size();
  for (std::size_t i = 2; i < n && !motion.moves; ++i) {
    motion.moves = away(track.poses[0], track.poses[i]) &&
                   away(track.poses[0], track.poses[i - 1]) &&
                   away(track.poses[0], track.poses[i - 2]);
    motion.first = track.times[i - 2];
  }
  for (std::size_t i = n; i-- > 2;) {
    motion.last = track.times[i];
    if (away(track.poses[n - 1], track.poses[i]) && away(track.poses[n - 1], track.poses[i - 1]) &&
        away(track.poses[n - 1], track.poses[i - 2])) {
      break;
    }
  }
  return motion;
}

/// Median distance of a track's place on the object, over the times in which the
/// object moves, from its own middle; m.
double spreadOnObject(const Trajectory& track, const Trajectory& object, const Motion& motion) {
  std::vector<double> times;
  const double first = std::max({motion.first, track.times.front(), object.times.front()});
  const double last = std::min({motion.last, track.times.back(), object.times.back()});
  for (const double time : object.times) {
    if (time >= first && time <= last) times.push_back(time);
  }
  if (times.size() < 5) return 0;
  const MatchedTrack a = resample(track, times);
  const MatchedTrack o = resample(object, times);
  std::array<std::vector<double>, 3> values;
  std::vector<Vec<double, 3>> points;
  for (std::size_t i = 0; i < times.size(); ++i) {
    points.push_back((o.poses[i].inverse() * a.poses[i]).translation);
    for (std::size_t k = 0; k < 3; ++k) values[k].push_back(points.back()[Eigen::Index(k)]);
  }
  const Vec<double, 3> middle(medianOf(values[0]), medianOf(values[1]), medianOf(values[2]));
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const Vec<double, 3>& point : points) distances.push_back((point - middle).norm());
  return medianOf(distances);
}

/// The findings about one demonstration.
class DemonstrationCheck {
 public:
  DemonstrationCheck(const Demonstration& demo, const SourceLocation& where,
                     Diagnostics& diagnostics)
      : demo_(demo), where_(where), diagnostics_(diagnostics) {
    tracks_ = {{"hand", &demo.hand}, {"object", &demo.object}};
    if (demo.torso.size() > 0) tracks_.push_back({"torso", &demo.torso});
  }

  /// True if units are right, so that the rest makes sense.
  bool units() const {
    bool right = true;
    for (const Track& track : tracks_) right = stamps(track) && lengths(track) && right;
    return right;
  }

  void scene() const {
    overlap();
    if (!upright()) floor();
    still();
    names();
  }

  /// The object begins to move before the hand and ends after it.
  bool objectLeads() const {
    const Motion hand = motionOf(demo_.hand);
    const Motion object = motionOf(demo_.object);
    return hand.moves && object.moves && object.first < hand.first - kEarlier &&
           object.last > hand.last + kEarlier;
  }

 private:
  struct Track {
    const char* name;
    const Trajectory* poses;
  };

  void error(const std::string& text) const {
    diagnostics_.error(where_, demo_.name + ": " + text);
  }
  void warning(const std::string& text) const {
    diagnostics_.warning(where_, demo_.name + ": " + text);
  }

  bool stamps(const Track& track) const {
    const double interval = summarize(*track.poses).median_interval;
    const std::vector<double>& times = track.poses->times;
    if (interval == 1 && times.size() >= 10 &&
        std::all_of(times.begin(), times.end(), [](double t) { return t == std::floor(t); })) {
      warning(std::string("the stamps of the ") + track.name +
              " rise by 1 each: they look like numbers of frames; give seconds");
    }
    if (interval <= kLongInterval) return true;
    std::string guess = "give seconds";
    const std::pair<double, const char*> units[] = {
        {1e3, "milliseconds"}, {1e6, "microseconds"}, {1e9, "nanoseconds"}};
    for (const auto& [factor, name] : units) {
      if (interval / factor < 5e-4 || interval / factor > 0.5) continue;
      guess = std::string("they look like ") + name + "; divide them by " + rounded(factor);
    }
    error(std::string("the stamps of the ") + track.name + " are " + rounded(interval) +
          " s apart (median): " + guess);
    return false;
  }

  bool lengths(const Track& track) const {
    const double height = std::abs(spanAlong(*track.poses, 2).middle);
    double width = 0;
    for (int axis = 0; axis < 3; ++axis) {
      width = std::max(width, spanAlong(*track.poses, axis).size());
    }
    if (height <= kHighestHand && width <= kWidestAction) return true;
    std::string guess = "give metres in a frame with the floor at z = 0";
    if (height > 150 || width > kWidestAction) {
      guess = "they look like millimetres; divide them by 1000";
    } else if (height > 20) {
      guess = "they look like centimetres; divide them by 100";
    }
    error(std::string("the positions of the ") + track.name + " are " + rounded(height) +
          " m over the floor and spread over " + rounded(width) + " m: " + guess);
    return false;
  }

  void overlap() const {
    const TimeSpan common = commonSpan(demo_);
    double shortest = 1e300;
    for (const Track& track : tracks_) {
      const TimeSpan span = spanOf(*track.poses);
      shortest = std::min(shortest, span.last - span.first);
    }
    const double covered = common.last - common.first;
    if (covered >= 0.5 * shortest) return;
    warning("the tracks cover only " + rounded(covered) + " s together of the " +
            rounded(shortest) + " s of the shortest: " + describeSpans(demo_) +
            "; are the clocks the same?");
  }

  /// True if something was said about the vertical axis.
  bool upright() const {
    if (demo_.torso.size() > 0) {
      Vec<double, 3> up = Vec<double, 3>::Zero();
      for (const Pose& pose : demo_.torso.poses) up += pose.rotation * Vec<double, 3>(0, 0, 1);
      up /= static_cast<double>(demo_.torso.size());
      const Span y = spanAlong(demo_.torso, 1);
      const Span z = spanAlong(demo_.torso, 2);
      const bool stands_along_y = std::abs(up[1]) > 0.8;
      const bool high_along_y = y.within(0.4, 1.8) && y.size() < 0.5 && !z.within(0.4, 1.8);
      const std::string fix = "; y seems to be up: turn the tracks so that z is";
      if (stands_along_y && high_along_y) {
        error("the torso stands along y, at " + rounded(y.middle) + " m of y and " +
              rounded(z.middle) + " m of z" + fix);
        return true;
      }
      if (high_along_y) {
        warning("the torso keeps at " + rounded(y.middle) + " m of y, but at " + rounded(z.low) +
                " to " + rounded(z.high) + " m of z" + fix);
        return true;
      }
      return false;
    }
    const Span z = spanAlong(demo_.hand, 2);
    if (z.low >= -kBelowFloor) return false;
    if (!spanAlong(demo_.hand, 1).within(0.1, 2.3) || !spanAlong(demo_.object, 1).within(0, 2.3)) {
      return false;
    }
    error("the hand is at " + rounded(z.low) + " m of z, below the floor, and at " +
          rounded(spanAlong(demo_.hand, 1).middle) +
          " m of y; y seems to be up: turn the tracks so that z is");
    return true;
  }

  void floor() const {
    for (const Track& track : tracks_) {
      const Span z = spanAlong(*track.poses, 2);
      if (z.low >= -kBelowFloor) continue;
      const std::string text = std::string("the ") + track.name + " is at " + rounded(z.low) +
                               " m, below the floor: z has to point up, with the floor at z = 0";
      if (track.poses == &demo_.hand) {
        error(text);
      } else {
        warning(text);
      }
    }
  }

  void still() const {
    double width = 0;
    for (int axis = 0; axis < 3; ++axis) {
      width = std::max(width, spanAlong(demo_.hand, axis).size());
    }
    if (width < kStill) {
      error("the hand never moves (it keeps within " + rounded(100 * width) +
            " cm); was its tracker frozen?");
    }
  }

  void names() const {
    if (demo_.hand.poses.size() == demo_.object.poses.size()) {
      bool same = true;
      for (std::size_t i = 0; i < demo_.hand.size() && same; ++i) {
        same = demo_.hand.poses[i].translation == demo_.object.poses[i].translation;
      }
      if (same) error("hand and object are the same track");
    }
    const Motion object = motionOf(demo_.object);
    if (demo_.torso.size() < 2 || !object.moves) return;
    const double hand = spreadOnObject(demo_.hand, demo_.object, object);
    const double torso = spreadOnObject(demo_.torso, demo_.object, object);
    if (hand > 0.05 && torso < 0.5 * hand) {
      error("while the object moves, the torso keeps to it (within " + rounded(100 * torso) +
            " cm) rather than the hand (" + rounded(100 * hand) +
            " cm): hand and torso seem to be swapped");
    }
  }

  const Demonstration& demo_;
  const SourceLocation& where_;
  Diagnostics& diagnostics_;
  std::vector<Track> tracks_;
};

void checkAccuracies(const Task& task, Diagnostics& diagnostics) {
  for (const auto& [entity, accuracy] : task.trackers) {
    const SourceLocation where{task.path, 0, 0};
    // Beyond a radian, or half a metre, nothing can be learned from a pose.
    if (accuracy.sigma_r > 1) {
      diagnostics.warning(where, "<tracker> for '" + entity + "': sigma_r is " +
                                     rounded(accuracy.sigma_r) +
                                     " rad; is it in degrees? Divide it by 57.3");
    }
    if (accuracy.sigma_t > 0.5) {
      diagnostics.warning(where, "<tracker> for '" + entity + "': sigma_t is " +
                                     rounded(accuracy.sigma_t) +
                                     " m; is it in millimetres? Divide it by 1000");
    }
  }
}

}  // namespace

void checkRecordings(const Task& task, const std::vector<Demonstration>& demonstrations,
                     Diagnostics& diagnostics) {
  checkAccuracies(task, diagnostics);
  std::vector<std::size_t> reversed;
  for (std::size_t d = 0; d < demonstrations.size(); ++d) {
    const DemonstrationCheck check(demonstrations[d], task.demonstrations[d].where, diagnostics);
    if (!check.units()) continue;
    check.scene();
    if (check.objectLeads()) reversed.push_back(d);
  }
  for (const std::size_t d : reversed) {
    const std::string text =
        demonstrations[d].name +
        ": the object moves before the hand does and after it; hand and object seem to be swapped";
    if (2 * reversed.size() > demonstrations.size()) {
      diagnostics.error(task.demonstrations[d].where, text);
    } else {
      diagnostics.warning(task.demonstrations[d].where, text);
    }
  }
}

}  // namespace graft::lfd
