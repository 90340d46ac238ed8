// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <vector>

#include "core/geometry/point.hpp"
#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"
#include "core/types/abi.h"

namespace graft {

/// How a vertex type takes part in relaxations (see graft_vertex_relaxation).
/// Specialise it for your value template:
///   static constexpr int kRows[2], kColumns[2];
///   static void relax(int stage, const double* x, double* y);
///   static int restore(int stage, const double* y, double* x);
/// Poses have the transposed rotation matrix (in the plane: cosine and sine) in
/// stage 0 and the translation in stage 1, points their coordinates in stage 1.
template <template <class> class V>
struct Relaxation {
  static constexpr int kRows[2] = {0, 0};
  static constexpr int kColumns[2] = {0, 0};
};

template <>
struct Relaxation<SE3> {
  static constexpr int kRows[2] = {3, 3};
  static constexpr int kColumns[2] = {3, 1};
  static void relax(int stage, const double* x, double* y) {
    const Pose pose = Pose::fromArray(x);
    if (stage == 1) {
      Eigen::Map<Eigen::Vector3d> out(y);
      out = pose.translation;
      return;
    }
    Eigen::Map<Eigen::Matrix3d> out(y);
    out = pose.rotation.toRotationMatrix().transpose();
  }
  static int restore(int stage, const double* y, double* x) {
    Pose pose = Pose::fromArray(x);
    if (stage == 1) {
      pose.translation = Eigen::Map<const Eigen::Vector3d>(y);
      pose.toArray(x);
      return GRAFT_OK;
    }
    // The rotation that is nearest in the Frobenius norm: orthogonal Procrustes.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
        Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix3d>(y).transpose()),
        Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (!(svd.singularValues()[1] > 1e-9)) return GRAFT_FAILED;
    Eigen::Vector3d signs(1, 1, 1);
    if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) signs[2] = -1;
    pose.rotation = Eigen::Quaterniond(
        Eigen::Matrix3d(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose()));
    pose.renormalize();
    pose.toArray(x);
    return GRAFT_OK;
  }
};

template <>
struct Relaxation<SE2> {
  static constexpr int kRows[2] = {2, 2};
  static constexpr int kColumns[2] = {1, 1};
  static void relax(int stage, const double* x, double* y) {
    y[0] = stage == 0 ? std::cos(x[2]) : x[0];
    y[1] = stage == 0 ? std::sin(x[2]) : x[1];
  }
  static int restore(int stage, const double* y, double* x) {
    if (stage == 1) {
      x[0] = y[0];
      x[1] = y[1];
      return GRAFT_OK;
    }
    if (!(std::hypot(y[0], y[1]) > 1e-9)) return GRAFT_FAILED;
    x[2] = std::atan2(y[1], y[0]);
    return GRAFT_OK;
  }
};

namespace detail {
template <int N>
struct PointRelaxation {
  static constexpr int kRows[2] = {0, N};
  static constexpr int kColumns[2] = {0, 1};
  static void relax(int, const double* x, double* y) {
    for (int i = 0; i < N; ++i) y[i] = x[i];
  }
  static int restore(int, const double* y, double* x) {
    for (int i = 0; i < N; ++i) x[i] = y[i];
    return GRAFT_OK;
  }
};
}  // namespace detail

template <>
struct Relaxation<Point2> : detail::PointRelaxation<2> {};
template <>
struct Relaxation<Point3> : detail::PointRelaxation<3> {};

template <template <class> class V>
constexpr int relaxedRows(int stage) {
  return Relaxation<V>::kRows[stage];
}
/// Columns of the unknowns of an edge's vertices: those of the first that takes part.
template <template <class> class... V>
int relaxedColumns(int stage) {
  int columns = 0;
  ((columns = columns == 0 ? Relaxation<V>::kColumns[stage] : columns), ...);
  return columns;
}

/// Where an edge writes its equations sum_k A_k Y_k = B; all zero at first.
class RelaxedEquations {
 public:
  /// `slot_rows`: rows of every slot's Y, 0 for those without a part.
  RelaxedEquations(int rows, const std::vector<int>& slot_rows, int columns, double* matrices,
                   double* right)
      : rows_(rows), columns_(columns), matrices_(matrices), right_(right) {
    begins_.push_back(0);
    for (const int count : slot_rows) begins_.push_back(begins_.back() + count);
    Eigen::Map<Eigen::MatrixXd>(matrices, rows, begins_.back()).setZero();
    Eigen::Map<Eigen::MatrixXd>(right, rows, columns).setZero();
  }
  /// A_k, rows x rows of Y_k.
  Eigen::Map<Eigen::MatrixXd> matrix(int slot) {
    const auto k = static_cast<std::size_t>(slot);
    return {matrices_ + begins_[k] * rows_, rows_, begins_[k + 1] - begins_[k]};
  }
  /// B, rows x columns.
  Eigen::Map<Eigen::MatrixXd> right() { return {right_, rows_, columns_}; }

 private:
  int rows_;
  int columns_;
  std::vector<int> begins_;
  double* matrices_;
  double* right_;
};

/// S with S' S = Omega, for a small positive semidefinite Omega.
template <int N, class Block>
Mat<double, N> rootOf(const Block& omega) {
  const Mat<double, N> matrix = omega;
  const Eigen::LLT<Mat<double, N>> cholesky(matrix);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<Mat<double, N>> eigen(matrix);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

namespace detail {
template <template <class> class V>
const graft_vertex_relaxation* vertexRelaxation() {
  using R = Relaxation<V>;
  if constexpr (R::kRows[0] + R::kRows[1] > 0) {
    static const graft_vertex_relaxation table = {sizeof(graft_vertex_relaxation),
                                                  {R::kRows[0], R::kRows[1]},
                                                  {R::kColumns[0], R::kColumns[1]},
                                                  &R::relax,
                                                  &R::restore};
    return &table;
  } else {
    return nullptr;
  }
}
}  // namespace detail

}  // namespace graft
