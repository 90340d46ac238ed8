// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types/plugin.hpp"

namespace graft {

/// A segment in the plane by its ends, x1 y1 x2 y2, metres.
template <class T = double>
struct Segment2 : Euclidean<T, 4> {
  static constexpr const char* kFields = "x1 y1 x2 y2";
  /// One metre long, for a segment of no length has no direction.
  Segment2() { this->coordinates[2] = T(1); }
  static Segment2 fromArray(const double* p) {
    Segment2 r;
    r.read(p);
    return r;
  }
  Segment2 plus(const Vec<T, 4>& d) const {
    Segment2 r = *this;
    r.coordinates += d;
    return r;
  }
  Vec<T, 4> minus(const Segment2& o) const { return this->coordinates - o.coordinates; }
  Vec<T, 2> first() const { return this->coordinates.template head<2>(); }
  Vec<T, 2> second() const { return this->coordinates.template tail<2>(); }
};

template <>
struct VertexTag<Segment2> {
  static constexpr const char* kTag = "VERTEX_SEGMENT2D";
  static constexpr const char* kDoc = "segment in the plane by its ends: metres";
};

namespace slam2d {

/// Direction of the normal [dy -dx] of a segment as a pose sees it, rad.
template <class T>
T normalDirection(const SE2<T>& pose, const Segment2<T>& segment) {
  using std::atan2;
  const Vec<T, 2> d = pose.inverse() * segment.second() - pose.inverse() * segment.first();
  return atan2(-d[0], d[1]);
}

}  // namespace slam2d

/// Both ends seen: error = ends in the pose's frame minus measured, metres.
struct EdgeSe2Segment2d : Edge<EdgeSe2Segment2d, 4, SE2, Segment2>, Measured<Numbers<4>> {
  static constexpr auto tag = "EDGE_SE2_SEGMENT2D";
  static constexpr auto doc = "measured ends of a segment, in the frame of the pose that sees it";
  static constexpr auto fields = "x1 y1 x2 y2";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 4> error(const SE2<T>& pose, const Segment2<T>& segment) const {
    Vec<T, 4> e;
    e.template head<2>() = pose.inverse() * segment.first();
    e.template tail<2>() = pose.inverse() * segment.second();
    return e - measurement.values.template cast<T>();
  }

  bool propagate(int to, Pose2& pose, Segment2<double>& segment) const {
    if (to != 1) return false;
    segment.coordinates.head<2>() = pose * Vec<double, 2>(measurement.values.head<2>());
    segment.coordinates.tail<2>() = pose * Vec<double, 2>(measurement.values.tail<2>());
    return true;
  }
};

/// Only the line of the segment seen: error = [direction of the normal, distance of
/// the line] minus measured.
struct EdgeSe2Segment2dLine : Edge<EdgeSe2Segment2dLine, 2, SE2, Segment2>, Measured<Numbers<2>> {
  static constexpr auto tag = "EDGE_SE2_SEGMENT2D_LINE";
  static constexpr auto doc = "measured line of a segment, in the frame of the pose that sees it";
  static constexpr auto fields = "theta rho";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 2> error(const SE2<T>& pose, const Segment2<T>& segment) const {
    using std::cos;
    using std::sin;
    const T theta = slam2d::normalDirection(pose, segment);
    const Vec<T, 2> a = pose.inverse() * segment.first();
    const Vec<T, 2> b = pose.inverse() * segment.second();
    // The mean of both ends' distances; in exact numbers they are the same.
    const T rho = 0.5 * (cos(theta) * (a[0] + b[0]) + sin(theta) * (a[1] + b[1]));
    return Vec<T, 2>(wrapAngle(T(theta - measurement.values[0])), rho - measurement.values[1]);
  }
};

/// Which end of a segment was seen (0 or 1), where, and the line's direction.
struct EndAndDirection : Numbers<4> {
  static constexpr const char* kFields = "end x y theta";
  static EndAndDirection fromArray(const double* p) {
    EndAndDirection m;
    for (int i = 0; i < 4; ++i) m.values[i] = p[i];
    return m;
  }
  static const char* normalize(double* p) {
    return p[0] == 0 || p[0] == 1 ? nullptr : "the number of the end must be 0 or 1";
  }
};

/// One end and the line's direction seen: error = [end, direction of the normal]
/// minus measured.
struct EdgeSe2Segment2dPointLine : Edge<EdgeSe2Segment2dPointLine, 3, SE2, Segment2>,
                                   Measured<EndAndDirection> {
  static constexpr auto tag = "EDGE_SE2_SEGMENT2D_POINTLINE";
  static constexpr auto doc = "one measured end of a segment and the direction of its normal";
  static constexpr std::uint32_t kFlags = GRAFT_EDGE_RELATIVE;

  template <class T>
  Vec<T, 3> error(const SE2<T>& pose, const Segment2<T>& segment) const {
    const Vec<T, 2> end =
        pose.inverse() * (measurement.values[0] == 0 ? segment.first() : segment.second());
    return Vec<T, 3>(end[0] - measurement.values[1], end[1] - measurement.values[2],
                     wrapAngle(T(slam2d::normalDirection(pose, segment) - measurement.values[3])));
  }
};

}  // namespace graft
