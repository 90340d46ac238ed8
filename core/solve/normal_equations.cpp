// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/normal_equations.hpp"

#include <algorithm>
#include <iterator>

#include "core/base/memory.hpp"
#include "core/linear/block_product.hpp"

namespace graft {

namespace {

constexpr std::int32_t kColumnsPerPiece = 64;

/// What a Linearizer keeps.
double jacobianBytes(const Problem& problem) {
  double numbers = 0;
  for (const EdgeGroup& group : problem.groups()) {
    numbers += double(group.count) * group.error_dim * (group.tangent_dim + 1);
  }
  return numbers * sizeof(double);
}

}  // namespace

NormalEquations::NormalEquations(const Problem& problem) : problem_(&problem) {
  findTerms(problem);
  hessian_.resize(std::size_t(value_offsets_.back()));
  gradient_.resize(std::size_t(problem.dim()));
  diagonal_.resize(std::size_t(problem.dim()));
  pattern_.struct_size = sizeof pattern_;
  pattern_.block_count = std::int32_t(problem.dims().size());
  pattern_.dims = problem.dims().data();
  pattern_.columns = columns_.data();
  pattern_.rows = rows_.data();
  pattern_.offsets = value_offsets_.data();
}

void NormalEquations::findTerms(const Problem& problem) {
  struct Entry {
    std::int32_t row;
    Term term;
  };
  const std::size_t blocks = problem.dims().size();
  // Two passes over all products: count per column, then place.
  std::vector<std::int64_t> begin(blocks + 1, 0);
  const auto forEach = [&](auto&& visit) {
    for (std::size_t g = 0; g < problem.groups().size(); ++g) {
      const EdgeGroup& group = problem.groups()[g];
      for (std::int64_t e = 0; e < group.count; ++e) {
        const std::int32_t* slots = group.blocks.data() + e * group.arity;
        // An edge of weight 0 adds nothing, but a vertex keeps its diagonal block.
        const bool diagonal_only = group.weight(e) == 0;
        for (int a = 0; a < group.arity; ++a) {
          for (int b = 0; b < group.arity; ++b) {
            if (slots[b] < 0 || slots[a] < slots[b]) continue;
            if (diagonal_only && slots[a] != slots[b]) continue;
            visit(slots[a], slots[b],
                  Term{std::int32_t(g), std::int32_t(e), group.slot_offsets[std::size_t(a)],
                       group.slot_offsets[std::size_t(b)]});
          }
        }
      }
    }
  };
  forEach(
      [&](std::int32_t, std::int32_t column, const Term&) { ++begin[std::size_t(column) + 1]; });
  for (std::size_t j = 0; j < blocks; ++j) begin[j + 1] += begin[j];
  requireMemory(double(begin[blocks]) * (sizeof(Entry) + sizeof(Term) + sizeof(double)) +
                    jacobianBytes(problem),
                "the linear model of the edges");
  std::vector<Entry> entries;
  entries.resize(std::size_t(begin[blocks]));
  std::vector<std::int64_t> next(begin.begin(), begin.end() - 1);
  forEach([&](std::int32_t row, std::int32_t column, const Term& term) {
    entries[std::size_t(next[std::size_t(column)]++)] = {row, term};
  });
  columns_.push_back(0);
  value_offsets_.push_back(0);
  terms_.reserve(entries.size());
  for (std::size_t j = 0; j < blocks; ++j) {
    const auto first = entries.begin() + begin[j];
    const auto last = entries.begin() + begin[j + 1];
    std::stable_sort(first, last, [](const Entry& a, const Entry& b) { return a.row < b.row; });
    for (auto entry = first; entry != last; ++entry) {
      if (entry == first || entry->row != (entry - 1)->row) {
        rows_.push_back(entry->row);
        term_begin_.push_back(std::int64_t(terms_.size()));
        value_offsets_.push_back(value_offsets_.back() +
                                 std::int64_t{problem.dims()[std::size_t(entry->row)]} *
                                     problem.dims()[j]);
      }
      terms_.push_back(entry->term);
    }
    columns_.push_back(std::int64_t(rows_.size()));
  }
  term_begin_.push_back(std::int64_t(terms_.size()));
}

void NormalEquations::gather(const Linearizer& linearizer, ThreadPool& pool) {
  const std::int32_t count = pattern_.block_count;
  pool.run((count + kColumnsPerPiece - 1) / kColumnsPerPiece, [&](std::int64_t piece) {
    const auto begin = std::int32_t(piece) * kColumnsPerPiece;
    const std::int32_t end = std::min(begin + kColumnsPerPiece, count);
    for (std::int32_t j = begin; j < end; ++j) gatherColumn(j, linearizer);
  });
}

void NormalEquations::gather(const Linearizer& linearizer, const std::vector<EdgePlace>& edges) {
  std::vector<std::int32_t> columns;
  for (const auto& [index, edge] : edges) {
    const EdgeGroup& group = problem_->groups()[index];
    const auto first = group.blocks.begin() + std::int64_t(edge) * group.arity;
    std::copy_if(first, first + group.arity, std::back_inserter(columns),
                 [](std::int32_t block) { return block >= 0; });
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  for (const std::int32_t column : columns) gatherColumn(column, linearizer);
}

void NormalEquations::gatherColumn(std::int32_t column, const Linearizer& linearizer) {
  const auto j = std::size_t(column);
  const int columns = pattern_.dims[j];
  double* gradient = gradient_.data() + problem_->offsets()[j];
  std::fill(gradient, gradient + columns, 0.0);
  for (std::int64_t block = columns_[j]; block < columns_[j + 1]; ++block) {
    const auto index = std::size_t(block);
    const int rows = pattern_.dims[rows_[index]];
    double* out = hessian_.data() + value_offsets_[index];
    std::fill(out, out + rows * columns, 0.0);
    const bool diagonal = block == columns_[j];
    BlockProduct product = nullptr;
    std::int32_t product_group = -1;
    for (std::int64_t t = term_begin_[index]; t < term_begin_[index + 1]; ++t) {
      const Term& term = terms_[std::size_t(t)];
      const EdgeGroup& group = problem_->groups()[std::size_t(term.group)];
      const int errors = group.error_dim;
      const int stride = group.tangent_dim;
      if (term.group != product_group) {
        product = blockProduct(errors, rows, columns);
        product_group = term.group;
      }
      const std::int64_t row = std::int64_t{term.edge} * errors;
      const double* jacobian = linearizer.jacobians(std::size_t(term.group)).data() + row * stride;
      product(jacobian + term.a, jacobian + term.b, errors, rows, columns, stride, out);
      if (!diagonal || term.a != term.b) continue;
      const double* r = linearizer.residuals(std::size_t(term.group)).data() + row;
      for (int e = 0; e < errors; ++e) {
        for (int i = 0; i < columns; ++i) gradient[i] += jacobian[e * stride + term.a + i] * r[e];
      }
    }
    if (!diagonal) continue;
    double* entries = diagonal_.data() + problem_->offsets()[j];
    for (int i = 0; i < columns; ++i) entries[i] = out[i * columns + i];
  }
}

double NormalEquations::quadraticForm(const std::vector<double>& y) const {
  double sum = 0;
  for (std::int32_t j = 0; j < pattern_.block_count; ++j) {
    const double* yj = y.data() + problem_->offsets()[std::size_t(j)];
    for (std::int64_t b = columns_[std::size_t(j)]; b < columns_[std::size_t(j) + 1]; ++b) {
      const std::int32_t row = rows_[std::size_t(b)];
      const double* yi = y.data() + problem_->offsets()[std::size_t(row)];
      const double* block = hessian_.data() + value_offsets_[std::size_t(b)];
      double part = 0;
      for (int c = 0; c < pattern_.dims[j]; ++c) {
        for (int r = 0; r < pattern_.dims[row]; ++r) part += yi[r] * *block++ * yj[c];
      }
      sum += row == j ? part : 2 * part;
    }
  }
  return sum;
}

}  // namespace graft
