// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <exception>
#include <type_traits>
#include <utility>

#include "core/geometry/point.hpp"
#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"
#include "core/types/abi.h"
#include "core/types/relaxation.hpp"

namespace graft {

/// Name and description of a vertex type in files. Specialise it for your own
/// value template to make a vertex type of it:
///
///   template <> struct graft::VertexTag<MyValue> {
///     static constexpr const char* kTag = "VERTEX_MINE";
///     static constexpr const char* kDoc = "what it is, units, frame";
///   };
///
/// A value template V<T> has: kAmbientDim, kTangentDim, kFields (names of the
/// numbers), fromArray(const double*), toArray(double*), normalize(double*)
/// (null or why the numbers are no value), plus(Vec<T, kTangentDim>),
/// minus(V<T>) and renormalize(). SE3, SE2, Point2 and Point3 are examples.
/// Optional: a Relaxation<V> (core/types/relaxation.hpp).
template <template <class> class V>
struct VertexTag;

template <>
struct VertexTag<SE3> {
  static constexpr const char* kTag = "VERTEX_SE3:QUAT";
  static constexpr const char* kDoc = "pose in space: metres, unit quaternion";
};
template <>
struct VertexTag<SE2> {
  static constexpr const char* kTag = "VERTEX_SE2";
  static constexpr const char* kDoc = "pose in the plane: metres, radians";
};
template <>
struct VertexTag<Point2> {
  static constexpr const char* kTag = "VERTEX_XY";
  static constexpr const char* kDoc = "point in the plane: metres";
};
template <>
struct VertexTag<Point3> {
  static constexpr const char* kTag = "VERTEX_TRACKXYZ";
  static constexpr const char* kDoc = "point in space: metres";
};

namespace detail {

inline void setMessage(graft_message* message, const char* text) {
  if (message != nullptr) std::snprintf(message->text, sizeof message->text, "%s", text);
}

/// Runs the body of a callback; exceptions become GRAFT_FAILED and a text, for
/// none may cross the boundary.
template <class Body>
int guarded(graft_message* message, Body&& body) noexcept {
  try {
    return std::forward<Body>(body)();
  } catch (const std::exception& e) {
    setMessage(message, e.what());
  } catch (...) {
    setMessage(message, "unknown exception");
  }
  return GRAFT_FAILED;
}

/// normalize() of a value or measurement type as an ABI callback body.
template <class Value>
int normalizeNumbers(double* numbers, graft_message* message) {
  const char* why = Value::normalize(numbers);
  if (why == nullptr) return GRAFT_OK;
  setMessage(message, why);
  return GRAFT_FAILED;
}

}  // namespace detail

/// The descriptor of a vertex type, generated from its value template.
template <template <class> class V>
const graft_vertex_type& vertexType() {
  using Value = V<double>;
  constexpr int kAmbient = Value::kAmbientDim;
  constexpr int kTangent = Value::kTangentDim;
  static const graft_vertex_type type = {
      sizeof(graft_vertex_type),
      VertexTag<V>::kTag,
      VertexTag<V>::kDoc,
      Value::kFields,
      kAmbient,
      kTangent,
      [](double* x) { Value().toArray(x); },
      [](double* x, graft_message* message) { return detail::normalizeNumbers<Value>(x, message); },
      [](std::int64_t count, const double* x, const double* delta, double* out) {
        for (std::int64_t i = 0; i < count; ++i) {
          const Eigen::Map<const Vec<double, kTangent>> step(delta + i * kTangent);
          Value moved = Value::fromArray(x + i * kAmbient).plus(step);
          moved.renormalize();
          moved.toArray(out + i * kAmbient);
        }
      },
      [](std::int64_t count, const double* a, const double* b, double* delta) {
        for (std::int64_t i = 0; i < count; ++i) {
          Eigen::Map<Vec<double, kTangent>> step(delta + i * kTangent);
          step = Value::fromArray(a + i * kAmbient).minus(Value::fromArray(b + i * kAmbient));
        }
      },
      detail::vertexRelaxation<V>()};
  return type;
}

}  // namespace graft
