// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/types/edge.hpp"

namespace graft {

/// Base of an edge type over one vertex of kind H and any number n >= 1 of kind V,
/// with a part of `Part` errors and `Part` measured numbers for each of the n, e.g.
/// one robot that sees many points at once. Derived has
///   template <class T>
///   Vec<T, Part> error(const H<T>& head, const V<T>& one, const double* measured) const;
///   void jacobians(const H<double>&, const V<double>&, JacobianBlock<Part, ..> by_head,
///                  JacobianBlock<Part, ..> by_one) const;      // of one part
///   bool place(const H<double>& head, const double* measured, V<double>& one) const;
/// the last for initial guesses. The measurement begins with n itself, as g2o
/// writes it: TAG head id ... || n measured... information.
template <class Derived, int Part, template <class> class H, template <class> class V>
class OneToManyEdge {
 public:
  static constexpr int kHead = H<double>::kTangentDim;
  static constexpr int kOne = V<double>::kTangentDim;

  static const graft_edge_type& descriptor() {
    static const char* const slots[] = {VertexTag<H>::kTag, VertexTag<V>::kTag};
    static const graft_edge_type type = {sizeof(graft_edge_type),
                                         detail::FlagsOf<Derived>::kFlags,
                                         Derived::tag,
                                         Derived::doc,
                                         detail::FieldsOf<Derived>::kFields,
                                         GRAFT_DYNAMIC,
                                         GRAFT_DYNAMIC,
                                         GRAFT_DYNAMIC,
                                         0,
                                         0,
                                         slots,
                                         nullptr,
                                         &shape,
                                         &normalize,
                                         &evaluate,
                                         nullptr,
                                         &propagate,
                                         2,
                                         nullptr};
    return type;
  }

 private:
  static int shape(std::int32_t arity, std::int32_t* error_dim, std::int32_t* measurement_dim,
                   graft_message* message) {
    if (arity < 2) {
      detail::setMessage(message, "needs at least two vertices");
      return GRAFT_FAILED;
    }
    *error_dim = Part * (arity - 1);
    *measurement_dim = 1 + Part * (arity - 1);
    return GRAFT_OK;
  }

  static int normalize(std::int32_t dim, double* measurement, graft_message* message) {
    const int count = (dim - 1) / Part;
    if (measurement[0] == count) return GRAFT_OK;
    return detail::guarded(message, [&] {
      detail::setMessage(message, ("the number after || must be " + std::to_string(count) +
                                   ", the vertices after the first")
                                      .c_str());
      return GRAFT_FAILED;
    });
  }

  static int evaluate(const graft_edge_batch* batch, double* errors, double* jacobians,
                      graft_message* message) {
    return detail::guarded(message, [&] {
      const int count = batch->arity - 1;
      const std::int64_t rows = batch->error_dim;
      const std::int64_t stride = rows * (kHead + std::int64_t{count} * kOne);
      const Derived edge;
      for (std::int64_t e = 0; e < batch->count; ++e) {
        const double* const* vertices = batch->vertices + e * batch->arity;
        const H<double> head = H<double>::fromArray(vertices[0]);
        double* matrix = jacobians == nullptr ? nullptr : jacobians + e * stride;
        if (matrix != nullptr) std::fill(matrix, matrix + stride, 0.0);
        for (int i = 0; i < count; ++i) {
          const V<double> one = V<double>::fromArray(vertices[1 + i]);
          const double* measured = batch->measurements[e] + 1 + Part * i;
          Eigen::Map<Vec<double, Part>>(errors + e * rows + Part * i) =
              edge.template error<double>(head, one, measured);
          if (matrix == nullptr) continue;
          Mat<double, Part, kHead> by_head;
          Mat<double, Part, kOne> by_one;
          edge.jacobians(head, one, JacobianBlock<Part, kHead>(by_head.data()),
                         JacobianBlock<Part, kOne>(by_one.data()));
          for (int r = 0; r < Part; ++r) {
            for (int c = 0; c < kHead; ++c) matrix[c * rows + Part * i + r] = by_head(r, c);
            for (int c = 0; c < kOne; ++c) {
              matrix[(kHead + i * kOne + c) * rows + Part * i + r] = by_one(r, c);
            }
          }
        }
      }
      return GRAFT_OK;
    });
  }

  static int propagate(const graft_edge_batch* batch, std::int32_t to, double* estimate) {
    if (to == 0) return GRAFT_FAILED;
    return detail::guarded(nullptr, [&] {
      V<double> one = V<double>::fromArray(batch->vertices[to]);
      if (!Derived().place(H<double>::fromArray(batch->vertices[0]),
                           batch->measurements[0] + 1 + Part * (to - 1), one)) {
        return GRAFT_FAILED;
      }
      one.toArray(estimate);
      return GRAFT_OK;
    });
  }
};

}  // namespace graft
