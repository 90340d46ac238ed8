// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/types/edge.hpp"

namespace graft {

/// Base of an edge type whose arity is known only at run time: one edge over n
/// vertices of kind V, e.g. "these grasps agree". Derived has
///   static bool shape(int arity, int& error_dim, int& measurement_dim);
///   template <class T> void error(const std::vector<V<T>>& vertices,
///                                 const std::vector<double>& measurement,
///                                 Vec<T, Eigen::Dynamic>& e) const;
/// `e` comes with error_dim entries. Derivatives come from dual numbers, one
/// vertex at a time, unless Derived has
///   void jacobian(const std::vector<V<double>>&, const std::vector<double>&,
///                 int slot, Eigen::Ref<Eigen::MatrixXd> J) const;
/// In files: TAG id id ... || measurement information.
template <class Derived, template <class> class V>
class DynamicEdge {
 public:
  static constexpr int kTangentDim = V<double>::kTangentDim;

  static const graft_edge_type& descriptor() {
    static const char* const slots[] = {VertexTag<V>::kTag};
    static const graft_edge_type type = {sizeof(graft_edge_type),
                                         detail::FlagsOf<Derived>::kFlags,
                                         Derived::tag,
                                         Derived::doc,
                                         "",
                                         GRAFT_DYNAMIC,
                                         GRAFT_DYNAMIC,
                                         GRAFT_DYNAMIC,
                                         0,
                                         detail::ResourcesOf<Derived>::kCount,
                                         slots,
                                         detail::ResourcesOf<Derived>::tags(),
                                         &shape,
                                         &normalize,
                                         &evaluate,
                                         nullptr,
                                         nullptr,
                                         1,
                                         nullptr};
    return type;
  }

 private:
  template <class E, class = void>
  struct HasJacobian : std::false_type {};
  template <class E>
  struct HasJacobian<E, std::void_t<decltype(&E::jacobian)>> : std::true_type {};

  static int shape(std::int32_t arity, std::int32_t* error_dim, std::int32_t* measurement_dim,
                   graft_message* message) {
    return detail::guarded(message, [&] {
      int errors = 0;
      int measurements = 0;
      if (!Derived::shape(arity, errors, measurements)) {
        detail::setMessage(message, "this number of vertices is not possible");
        return GRAFT_FAILED;
      }
      *error_dim = errors;
      *measurement_dim = measurements;
      return GRAFT_OK;
    });
  }

  static int normalize(std::int32_t, double*, graft_message*) { return GRAFT_OK; }

  static int evaluate(const graft_edge_batch* batch, double* errors, double* jacobians,
                      graft_message* message) {
    return detail::guarded(message, [&] {
      const int arity = batch->arity;
      const int dim = batch->error_dim;
      const std::int64_t stride = std::int64_t{dim} * arity * kTangentDim;
      Vec<double, Eigen::Dynamic> e(dim);
      for (std::int64_t i = 0; i < batch->count; ++i) {
        const Derived edge = detail::makeEdge<Derived>(*batch, i);
        const double* const* pointers = batch->vertices + i * arity;
        const std::vector<double> measurement(batch->measurements[i],
                                              batch->measurements[i] + batch->measurement_dim);
        std::vector<V<double>> values;
        values.reserve(static_cast<std::size_t>(arity));
        for (int k = 0; k < arity; ++k) values.push_back(V<double>::fromArray(pointers[k]));
        edge.error(values, measurement, e);
        Eigen::Map<Vec<double, Eigen::Dynamic>>(errors + i * dim, dim) = e;
        if (jacobians == nullptr) continue;
        for (int k = 0; k < arity; ++k) {
          Eigen::Map<Eigen::MatrixXd> block(
              jacobians + i * stride + std::int64_t{k} * dim * kTangentDim, dim, kTangentDim);
          if constexpr (HasJacobian<Derived>::value) {
            edge.jacobian(values, measurement, k, block);
          } else {
            differentiate(edge, pointers, arity, measurement, k, block);
          }
        }
      }
      return GRAFT_OK;
    });
  }

  static void differentiate(const Derived& edge, const double* const* pointers, int arity,
                            const std::vector<double>& measurement, int slot,
                            Eigen::Map<Eigen::MatrixXd>& block) {
    using D = Dual<kTangentDim>;
    std::vector<V<D>> values;
    values.reserve(static_cast<std::size_t>(arity));
    for (int k = 0; k < arity; ++k) values.push_back(V<D>::fromArray(pointers[k]));
    Vec<D, kTangentDim> delta;
    for (int c = 0; c < kTangentDim; ++c) delta[c] = D::variable(0, c);
    values[static_cast<std::size_t>(slot)] = values[static_cast<std::size_t>(slot)].plus(delta);
    Vec<D, Eigen::Dynamic> e(block.rows());
    edge.error(values, measurement, e);
    for (Eigen::Index r = 0; r < block.rows(); ++r) {
      for (int c = 0; c < kTangentDim; ++c) block(r, c) = e[r].d[c];
    }
  }
};

}  // namespace graft
