// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace graft {

/// A vertex inside a graph: which of the graph's vertex types, and its place in
/// that type's array.
struct VertexRef {
  std::int32_t type = -1;
  std::int32_t index = -1;
  bool operator==(const VertexRef& o) const { return type == o.type && index == o.index; }
};

/// The estimates of all vertices of a graph: one contiguous array of doubles
/// per vertex type. Plain data: a snapshot or a rollback is a copy.
class Values {
 public:
  double* at(VertexRef v) {
    return arrays_[static_cast<std::size_t>(v.type)].numbers.data() +
           std::size_t(v.index) * dim(v.type);
  }
  const double* at(VertexRef v) const { return const_cast<Values*>(this)->at(v); }

  /// Makes room for vertices of a type with `ambient_dim` numbers each.
  void addType(int ambient_dim) { arrays_.push_back({std::size_t(ambient_dim), {}}); }
  /// Appends one vertex of a type.
  void append(int type, const double* numbers) {
    auto& array = arrays_[static_cast<std::size_t>(type)];
    array.numbers.insert(array.numbers.end(), numbers, numbers + array.dim);
  }
  /// Drops the vertices of a type that are not marked; the others move up.
  void keep(int type, const std::vector<char>& marked) {
    auto& array = arrays_[static_cast<std::size_t>(type)];
    std::size_t next = 0;
    for (std::size_t i = 0; i < marked.size(); ++i) {
      if (marked[i] == 0) continue;
      for (std::size_t k = 0; k < array.dim; ++k) {
        array.numbers[next++] = array.numbers[i * array.dim + k];
      }
    }
    array.numbers.resize(next);
  }
  std::size_t dim(int type) const { return arrays_[static_cast<std::size_t>(type)].dim; }
  std::size_t typeCount() const { return arrays_.size(); }
  /// All numbers of a type, vertex after vertex.
  const std::vector<double>& array(int type) const {
    return arrays_[static_cast<std::size_t>(type)].numbers;
  }
  bool operator==(const Values& o) const { return arrays_ == o.arrays_; }

 private:
  struct Array {
    std::size_t dim;
    std::vector<double> numbers;
    bool operator==(const Array& o) const { return dim == o.dim && numbers == o.numbers; }
  };
  std::vector<Array> arrays_;
};

}  // namespace graft
