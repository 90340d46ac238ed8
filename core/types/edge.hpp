// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <tuple>

#include "core/types/resource.hpp"
#include "core/types/vertex.hpp"

namespace graft {

/// Part of an edge that has a measurement of type M (kAmbientDim, kFields,
/// fromArray, normalize): `struct MyEdge : Edge<...>, Measured<Pose>`.
template <class M>
struct Measured {
  using Measurement = M;
  M measurement;
};

/// N plain numbers as a measurement.
template <int N>
struct Numbers {
  static constexpr int kAmbientDim = N;
  static constexpr const char* kFields = "";
  Vec<double, N> values;
  static Numbers fromArray(const double* p) {
    Numbers m;
    for (int i = 0; i < N; ++i) m.values[i] = p[i];
    return m;
  }
  static const char* normalize(double*) { return nullptr; }
};

/// Part of an edge that looks something up: N numbers that associate() writes
/// and error() reads, constant between two associations.
template <int N>
struct Associated {
  static constexpr int kAssociationDim = N;
  const double* association = nullptr;
};

/// Part of an edge that uses shared resources of the types R...
template <class... R>
struct Using {
  using Resources = std::tuple<const R*...>;
  std::tuple<const R*...> resources;
  template <int I = 0>
  const auto& resource() const {
    return *std::get<I>(resources);
  }
};

/// Where an analytic Jacobian is written: error dim x tangent dim, column-major.
template <int Rows, int Columns>
using JacobianBlock = Eigen::Map<Eigen::Matrix<double, Rows, Columns>>;
using InformationBlock = Eigen::Map<const Eigen::MatrixXd>;

namespace detail {

template <class E, class = void>
struct MeasurementOf {
  static constexpr int kDim = 0;
  static constexpr const char* kFields = "";
  static int normalize(double*, graft_message*) { return GRAFT_OK; }
  static void set(E&, const double*) {}
};
template <class E>
struct MeasurementOf<E, std::void_t<typename E::Measurement>> {
  using M = typename E::Measurement;
  static constexpr int kDim = M::kAmbientDim;
  static constexpr const char* kFields = M::kFields;
  static int normalize(double* numbers, graft_message* message) {
    return normalizeNumbers<M>(numbers, message);
  }
  static void set(E& edge, const double* numbers) { edge.measurement = M::fromArray(numbers); }
};

template <class E, class = void>
struct AssociationOf {
  static constexpr int kDim = 0;
  static void set(E&, const double*) {}
};
template <class E>
struct AssociationOf<E, std::void_t<decltype(E::kAssociationDim)>> {
  static constexpr int kDim = E::kAssociationDim;
  static void set(E& edge, const double* numbers) { edge.association = numbers; }
};

template <class E, class = void>
struct ResourcesOf {
  static constexpr int kCount = 0;
  static const char* const* tags() { return nullptr; }
  static void set(E&, const void* const*) {}
};
template <class E>
struct ResourcesOf<E, std::void_t<typename E::Resources>> {
  static constexpr int kCount = static_cast<int>(std::tuple_size_v<typename E::Resources>);
  template <class Tuple>
  struct Tags;
  template <class... R>
  struct Tags<std::tuple<const R*...>> {
    static const char* const* get() {
      static const char* const tags[] = {ResourceTag<R>::kTag...};
      return tags;
    }
    template <std::size_t... I>
    static void assign(E& edge, const void* const* pointers, std::index_sequence<I...>) {
      ((std::get<I>(edge.resources) = static_cast<const R*>(pointers[I])), ...);
    }
  };
  static const char* const* tags() { return Tags<typename E::Resources>::get(); }
  static void set(E& edge, const void* const* pointers) {
    Tags<typename E::Resources>::assign(edge, pointers, std::make_index_sequence<kCount>());
  }
};

/// The edge object of item e of a batch.
template <class E>
E makeEdge(const graft_edge_batch& batch, std::int64_t e) {
  E edge;
  if constexpr (MeasurementOf<E>::kDim > 0) MeasurementOf<E>::set(edge, batch.measurements[e]);
  if constexpr (AssociationOf<E>::kDim > 0) AssociationOf<E>::set(edge, batch.associations[e]);
  if constexpr (ResourcesOf<E>::kCount > 0) ResourcesOf<E>::set(edge, batch.resources[e]);
  return edge;
}

template <class E, class = void>
struct HasJacobians : std::false_type {};
template <class E>
struct HasJacobians<E, std::void_t<decltype(&E::jacobians)>> : std::true_type {};
template <class E, class = void>
struct HasPropagate : std::false_type {};
template <class E>
struct HasPropagate<E, std::void_t<decltype(&E::propagate)>> : std::true_type {};
template <class E, class = void>
struct HasRelax : std::false_type {};
template <class E>
struct HasRelax<E, std::void_t<decltype(&E::relax)>> : std::true_type {};
template <class E, class = void>
struct FieldsOf {
  static constexpr const char* kFields = MeasurementOf<E>::kFields;
};
template <class E>
struct FieldsOf<E, std::void_t<decltype(E::fields)>> {
  static constexpr const char* kFields = E::fields;
};
template <class E, class = void>
struct HasAlternative : std::false_type {};
template <class E>
struct HasAlternative<
    E, std::void_t<decltype(std::declval<const E&>().alternative(0, std::declval<double*>()))>>
    : std::true_type {};
template <class E>
constexpr std::uint32_t kOwnFlags = HasAlternative<E>::value ? GRAFT_EDGE_HAS_ALTERNATIVES : 0;
template <class E, class = void>
struct FlagsOf {
  static constexpr std::uint32_t kFlags = kOwnFlags<E>;
};
template <class E>
struct FlagsOf<E, std::void_t<decltype(E::kFlags)>> {
  static constexpr std::uint32_t kFlags = E::kFlags | kOwnFlags<E>;
};

}  // namespace detail

/// Base of an edge type of fixed arity, `Dim` errors over vertices V...:
///
///   struct HandGripperEdge : graft::Edge<HandGripperEdge, 6, SE3, SE3, SE3> {
///     static constexpr auto tag = "LFD_HAND_GRIPPER";
///     static constexpr auto doc = "...";
///     template <class T>
///     Vec<T, 6> error(const SE3<T>& g, const SE3<T>& h, const SE3<T>& rel) const;
///   };
///
/// Derived may add, found at compile time:
///  - Measured<M>, Associated<N>, Using<R...> as further bases;
///  - void jacobians(const V<double>&..., JacobianBlock<Dim, tangent of V>...)
///    const: analytic derivatives by the tangents, each block to be filled
///    whole; without it they come from forward dual numbers;
///  - bool associate(bool first, const V<double>&..., const InformationBlock&,
///    double* association) const: see graft_edge_type; true if it changed;
///  - bool alternative(int k, double* association) const: writes the k-th of all that
///    associate() may choose; false if there are no more. The solver then asks, once it
///    has converged, whether another choice would have cost less;
///  - bool propagate(int to, V<double>&...) const: sets the vertex in slot `to`
///    so that the error vanishes; false if it cannot;
///  - static constexpr int kRelaxedRows[GRAFT_RELAXATION_STAGES] and
///    bool relax(int stage, const InformationBlock&, const V<double>&...,
///    RelaxedEquations&) const: linear equations for initial guesses, see
///    graft_edge_relaxation; false if this edge has none;
///  - static constexpr auto fields: names of the measurement's numbers, where its
///    type has none;
///  - static constexpr std::uint32_t kFlags.
template <class Derived, int Dim, template <class> class... V>
class Edge {
 public:
  static constexpr int kArity = sizeof...(V);
  static constexpr int kErrorDim = Dim;
  static constexpr int kTotalTangentDim = (V<double>::kTangentDim + ...);

  static const graft_edge_type& descriptor() {
    static const char* const slots[] = {VertexTag<V>::kTag...};
    static const graft_edge_type type = {sizeof(graft_edge_type),
                                         detail::FlagsOf<Derived>::kFlags,
                                         Derived::tag,
                                         Derived::doc,
                                         detail::FieldsOf<Derived>::kFields,
                                         kArity,
                                         Dim,
                                         detail::MeasurementOf<Derived>::kDim,
                                         detail::AssociationOf<Derived>::kDim,
                                         detail::ResourcesOf<Derived>::kCount,
                                         slots,
                                         detail::ResourcesOf<Derived>::tags(),
                                         nullptr,
                                         &normalize,
                                         &evaluate,
                                         associateCallback(),
                                         propagateCallback(),
                                         0,
                                         relaxation()};
    return type;
  }

 private:
  using Indices = std::index_sequence_for<V<double>...>;
  static constexpr std::array<int, kArity> kTangents = {V<double>::kTangentDim...};

  static constexpr int tangentOffset(std::size_t slot) {
    int offset = 0;
    for (std::size_t k = 0; k < slot; ++k) offset += kTangents[k];
    return offset;
  }

  static int normalize(std::int32_t, double* measurement, graft_message* message) {
    return detail::MeasurementOf<Derived>::normalize(measurement, message);
  }

  static int evaluate(const graft_edge_batch* batch, double* errors, double* jacobians,
                      graft_message* message) {
    return detail::guarded(message, [&] {
      for (std::int64_t e = 0; e < batch->count; ++e) {
        const Derived edge = detail::makeEdge<Derived>(*batch, e);
        const double* const* vertices = batch->vertices + e * kArity;
        double* error = errors + e * Dim;
        if (jacobians == nullptr) {
          evaluateError(edge, vertices, error, Indices());
        } else {
          evaluateBoth(edge, vertices, error, jacobians + e * Dim * kTotalTangentDim, Indices());
        }
      }
      return GRAFT_OK;
    });
  }

  template <std::size_t... K>
  static void evaluateError(const Derived& edge, const double* const* vertices, double* error,
                            std::index_sequence<K...>) {
    Eigen::Map<Vec<double, Dim>> result(error);
    result = edge.template error<double>(V<double>::fromArray(vertices[K])...);
  }

  template <std::size_t... K>
  static void evaluateBoth(const Derived& edge, const double* const* vertices, double* error,
                           double* jacobian, std::index_sequence<K...> indices) {
    if constexpr (detail::HasJacobians<Derived>::value) {
      evaluateError(edge, vertices, error, indices);
      edge.jacobians(
          V<double>::fromArray(vertices[K])...,
          JacobianBlock<Dim, V<double>::kTangentDim>(jacobian + Dim * tangentOffset(K))...);
    } else {
      using D = Dual<kTotalTangentDim>;
      const Vec<D, Dim> result = edge.template error<D>(seeded<V, D, K>(vertices[K])...);
      for (int r = 0; r < Dim; ++r) {
        error[r] = result[r].v;
        for (int c = 0; c < kTotalTangentDim; ++c) jacobian[c * Dim + r] = result[r].d[c];
      }
    }
  }

  /// The vertex of slot K with its tangent as independent variables.
  template <template <class> class W, class D, std::size_t K>
  static W<D> seeded(const double* x) {
    Vec<D, W<D>::kTangentDim> delta;
    for (int i = 0; i < W<D>::kTangentDim; ++i) {
      delta[i] = D::variable(0, tangentOffset(K) + i);
    }
    return W<D>::fromArray(x).plus(delta);
  }

  static auto associateCallback() -> decltype(graft_edge_type::associate) {
    if constexpr (detail::AssociationOf<Derived>::kDim > 0) {
      return [](const graft_edge_batch* batch, std::int32_t first, double* associations,
                std::uint8_t* changed, graft_message* message) {
        return detail::guarded(message, [&] {
          for (std::int64_t e = 0; e < batch->count; ++e) {
            const Derived edge = detail::makeEdge<Derived>(*batch, e);
            if constexpr (detail::HasAlternative<Derived>::value) {
              if (first >= GRAFT_ALTERNATIVE) {
                double* chosen = associations + e * Derived::kAssociationDim;
                changed[e] = edge.alternative(first - GRAFT_ALTERNATIVE, chosen) ? 1 : 0;
                continue;
              }
            }
            changed[e] = associateOne(edge, first != 0, batch->vertices + e * kArity,
                                      InformationBlock(batch->information[e], Dim, Dim),
                                      associations + e * Derived::kAssociationDim, Indices())
                             ? 1
                             : 0;
          }
          return GRAFT_OK;
        });
      };
    } else {
      return nullptr;
    }
  }

  template <std::size_t... K>
  static bool associateOne(const Derived& edge, bool first, const double* const* vertices,
                           const InformationBlock& information, double* association,
                           std::index_sequence<K...>) {
    return edge.associate(first, V<double>::fromArray(vertices[K])..., information, association);
  }

  static auto propagateCallback() -> decltype(graft_edge_type::propagate) {
    if constexpr (detail::HasPropagate<Derived>::value) {
      return [](const graft_edge_batch* batch, std::int32_t to, double* estimate) {
        return detail::guarded(nullptr,
                               [&] { return propagateOne(*batch, to, estimate, Indices()); });
      };
    } else {
      return nullptr;
    }
  }

  static const graft_edge_relaxation* relaxation() {
    if constexpr (detail::HasRelax<Derived>::value) {
      static const graft_edge_relaxation table = {
          sizeof(graft_edge_relaxation),
          {Derived::kRelaxedRows[0], Derived::kRelaxedRows[1]},
          [](const graft_edge_batch* batch, std::int32_t stage, double* matrices, double* right) {
            return detail::guarded(
                nullptr, [&] { return relaxOne(*batch, stage, matrices, right, Indices()); });
          }};
      return &table;
    } else {
      return nullptr;
    }
  }

  template <std::size_t... K>
  static int relaxOne(const graft_edge_batch& batch, int stage, double* matrices, double* right,
                      std::index_sequence<K...>) {
    const Derived edge = detail::makeEdge<Derived>(batch, 0);
    RelaxedEquations equations(Derived::kRelaxedRows[stage], {relaxedRows<V>(stage)...},
                               relaxedColumns<V...>(stage), matrices, right);
    return edge.relax(stage, InformationBlock(batch.information[0], Dim, Dim),
                      V<double>::fromArray(batch.vertices[K])..., equations)
               ? GRAFT_OK
               : GRAFT_FAILED;
  }

  template <std::size_t... K>
  static int propagateOne(const graft_edge_batch& batch, int to, double* estimate,
                          std::index_sequence<K...>) {
    const Derived edge = detail::makeEdge<Derived>(batch, 0);
    std::tuple<V<double>...> values(V<double>::fromArray(batch.vertices[K])...);
    if (!edge.propagate(to, std::get<K>(values)...)) return GRAFT_FAILED;
    ((static_cast<int>(K) == to ? std::get<K>(values).toArray(estimate) : void()), ...);
    return GRAFT_OK;
  }
};

}  // namespace graft
