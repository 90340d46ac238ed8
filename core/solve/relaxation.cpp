// SPDX-License-Identifier: BSD-3-Clause
#include "core/solve/relaxation.hpp"

#include <Eigen/Core>
#include <algorithm>

#include "core/base/disjoint_sets.hpp"
#include "core/base/error.hpp"
#include "core/linear/block_cholesky.hpp"
#include "core/solve/edge_batch.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

/// The equations of one edge in one stage, and which vertices they tie.
struct Equations {
  std::vector<VertexRef> vertices;  ///< slots that take part
  Eigen::MatrixXd matrix;           ///< rows x sum of the vertices' rows
  Eigen::MatrixXd right;            ///< rows x columns
};

class Stage {
 public:
  /// `settled`: per free vertex whether earlier stages determined it.
  Stage(int stage, const Problem& problem, const State& state, const std::vector<char>& settled)
      : stage_(stage), problem_(problem), state_(state), settled_(settled) {
    collect();
    choose();
  }

  /// Whether there are more equations than unknowns (or no unknowns).
  bool isOverdetermined() const {
    std::int64_t unknowns = 0;
    for (const std::int32_t block : unknowns_) {
      unknowns += rowsOf(problem_.freeVertices()[std::size_t(block)]);
    }
    std::int64_t rows = 0;
    for (const Equations& equations : equations_) rows += equations.matrix.rows();
    return unknowns == 0 || rows > unknowns;
  }
  /// Solves for vertices of `columns` columns each at a time; empty, or why not.
  std::string solve(ThreadPool& pool, Values& values, std::vector<char>& settled) {
    for (int columns = 1; columns <= 64; ++columns) {
      std::string failure = solveFor(columns, pool, values, settled);
      if (!failure.empty()) return failure;
    }
    return {};
  }
  /// Whether a free vertex has unknowns in this stage.
  bool has(VertexRef v) const { return rowsOf(v) > 0; }

 private:
  const graft_vertex_relaxation* relaxationOf(VertexRef v) const {
    return problem_.graph().type(v).relaxation;
  }
  int rowsOf(VertexRef v) const {
    return relaxationOf(v) == nullptr ? 0 : relaxationOf(v)->rows[stage_];
  }
  int columnsOf(VertexRef v) const { return relaxationOf(v)->columns[stage_]; }

  void collect() {
    for (std::size_t g = 0; g < problem_.groups().size(); ++g) {
      const EdgeGroup& group = problem_.groups()[g];
      const graft_edge_relaxation* relaxation = group.type->relaxation;
      if (relaxation == nullptr || relaxation->rows[stage_] == 0) continue;
      const EdgeBatch batch(group, g, state_, 0, group.count);
      for (std::int64_t e = 0; e < group.count; ++e) {
        if (group.weight(e) > 0) collectEdge(group, batch, e);
      }
    }
  }

  void collectEdge(const EdgeGroup& group, const EdgeBatch& batch, std::int64_t e) {
    Equations equations;
    int width = 0;
    int columns = 0;
    for (int k = 0; k < group.arity; ++k) {
      const VertexRef v = group.vertices[std::size_t(e * group.arity + k)];
      const std::int32_t block = problem_.blockOf(v);
      // The equations look at what earlier stages found.
      if (block >= 0 && settled_[std::size_t(block)] == 0) return;
      if (rowsOf(v) == 0) continue;
      if (columns != 0 && columnsOf(v) != columns) return;
      columns = columnsOf(v);
      width += rowsOf(v);
      equations.vertices.push_back(v);
    }
    if (columns == 0) return;
    const int rows = group.type->relaxation->rows[stage_];
    equations.matrix.resize(rows, width);
    equations.right.resize(rows, columns);
    const Eigen::Index dim = group.error_dim;
    const Eigen::Map<const Eigen::MatrixXd> root(group.roots.data() + e * dim * dim, dim, dim);
    const Eigen::MatrixXd information = root.transpose() * root;
    const double* pointer = information.data();
    graft_edge_batch one = batch.single(e);
    one.information = &pointer;
    const int status = callPlugin(Callback::kRelax, group.type->tag, [&] {
      return group.type->relaxation->equations(&one, stage_, equations.matrix.data(),
                                               equations.right.data());
    });
    if (status != GRAFT_OK) return;
    const bool usable = equations.matrix.allFinite() && equations.right.allFinite() &&
                        equations.matrix.squaredNorm() > 0;
    if (usable) equations_.push_back(std::move(equations));
  }

  /// The unknowns are the free vertices that equations tie to something known.
  void choose() {
    const std::size_t count = problem_.freeVertices().size();
    DisjointSets sets(count);
    std::vector<char> touched(count, 0);
    std::vector<char> anchored(count, 0);
    for (const Equations& equations : equations_) {
      std::int32_t first = -1;
      bool anchors = equations.vertices.size() == 1;
      for (const VertexRef v : equations.vertices) {
        const std::int32_t block = problem_.blockOf(v);
        if (block < 0) {
          anchors = true;
          continue;
        }
        touched[std::size_t(block)] = 1;
        if (first >= 0) sets.merge(std::size_t(first), std::size_t(block));
        first = block;
      }
      if (first >= 0 && anchors) anchored[std::size_t(first)] = 1;
    }
    std::vector<char> set_anchored(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
      if (anchored[i] != 0) set_anchored[sets.find(i)] = 1;
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (touched[i] == 0 || set_anchored[sets.find(i)] == 0) continue;
      unknowns_.push_back(std::int32_t(i));
    }
  }

  std::int32_t blockOf(VertexRef v) const { return problem_.blockOf(v); }

  /// The normal equations of the unknowns of one width.
  struct System {
    std::vector<VertexRef> vertices;
    std::vector<std::int32_t> number;  ///< of a free vertex among them, -1 = none
    std::vector<std::int32_t> dims;
    std::vector<std::int64_t> begins{0};
    std::vector<std::int64_t> columns{0};  ///< lower triangle by block columns
    std::vector<std::int32_t> rows;
    std::vector<std::int64_t> offsets;
    std::vector<double> matrix;
    Eigen::MatrixXd right;
  };

  std::string solveFor(int columns, ThreadPool& pool, Values& values, std::vector<char>& settled) {
    System system;
    numberUnknowns(columns, system);
    if (system.vertices.empty()) return {};
    findPattern(columns, system);
    system.right.setZero(system.begins.back(), columns);
    for (const Equations& equations : equations_) {
      if (equations.right.cols() == columns) add(equations, values, system);
    }
    const graft_block_pattern pattern = {
        sizeof(graft_block_pattern), std::int32_t(system.vertices.size()),
        system.dims.data(),          system.columns.data(),
        system.rows.data(),          system.offsets.data()};
    BlockCholesky cholesky(&pool);
    try {
      cholesky.analyze(pattern);
    } catch (const Error& error) {
      if (error.code() != ExitCode::kNoResult) throw;
      return error.what();
    }
    const std::int32_t failed = cholesky.factorize(system.matrix.data(), nullptr);
    if (failed >= 0) {
      return "stage " + std::to_string(stage_ + 1) + " does not determine " +
             problem_.describeVertex(system.vertices[std::size_t(failed)]);
    }
    Eigen::MatrixXd solution(system.begins.back(), columns);
    for (Eigen::Index c = 0; c < columns; ++c) {
      cholesky.solve(system.right.col(c).data(), solution.col(c).data());
    }
    for (std::size_t i = 0; i < system.vertices.size(); ++i) {
      const VertexRef v = system.vertices[i];
      const Eigen::MatrixXd y = solution.middleRows(system.begins[i], system.dims[i]);
      if (!y.allFinite()) continue;
      const int status = callPlugin(Callback::kRelax, problem_.graph().type(v).tag, [&] {
        return relaxationOf(v)->restore(stage_, y.data(), values.at(v));
      });
      if (status != GRAFT_OK) continue;
      settled[std::size_t(blockOf(v))] = 1;
    }
    return {};
  }

  static std::int32_t numberOf(std::int32_t block, const System& system) {
    return block < 0 ? -1 : system.number[std::size_t(block)];
  }

  void numberUnknowns(int columns, System& system) const {
    system.number.assign(problem_.freeVertices().size(), -1);
    for (const std::int32_t block : unknowns_) {
      const VertexRef v = problem_.freeVertices()[std::size_t(block)];
      if (columnsOf(v) != columns) continue;
      system.number[std::size_t(block)] = std::int32_t(system.vertices.size());
      system.vertices.push_back(v);
      system.dims.push_back(rowsOf(v));
      system.begins.push_back(system.begins.back() + rowsOf(v));
    }
  }

  void findPattern(int columns, System& system) const {
    std::vector<std::vector<std::int32_t>> below(system.vertices.size());
    for (std::size_t i = 0; i < below.size(); ++i) below[i].push_back(std::int32_t(i));
    for (const Equations& equations : equations_) {
      if (equations.right.cols() != columns) continue;
      for (const VertexRef a : equations.vertices) {
        const std::int32_t column = numberOf(blockOf(a), system);
        if (column < 0) continue;
        for (const VertexRef b : equations.vertices) {
          const std::int32_t row = numberOf(blockOf(b), system);
          if (row > column) below[std::size_t(column)].push_back(row);
        }
      }
    }
    std::int64_t size = 0;
    for (std::size_t c = 0; c < below.size(); ++c) {
      std::sort(below[c].begin(), below[c].end());
      below[c].erase(std::unique(below[c].begin(), below[c].end()), below[c].end());
      for (const std::int32_t r : below[c]) {
        system.rows.push_back(r);
        system.offsets.push_back(size);
        size += std::int64_t{system.dims[c]} * system.dims[std::size_t(r)];
      }
      system.columns.push_back(std::int64_t(system.rows.size()));
    }
    system.matrix.assign(std::size_t(size), 0.0);
  }

  /// Adds A'A and A'(B - what known vertices take).
  void add(const Equations& equations, const Values& values, System& system) const {
    Eigen::MatrixXd residual = equations.right;
    Eigen::Index at = 0;
    for (const VertexRef v : equations.vertices) {
      const int count = rowsOf(v);
      if (numberOf(blockOf(v), system) < 0) {
        Eigen::MatrixXd known(count, residual.cols());
        callPlugin(Callback::kRelax, problem_.graph().type(v).tag,
                   [&] { relaxationOf(v)->relax(stage_, values.at(v), known.data()); });
        residual -= equations.matrix.middleCols(at, count) * known;
      }
      at += count;
    }
    Eigen::Index at_a = 0;
    for (const VertexRef a : equations.vertices) {
      const auto matrix_a = equations.matrix.middleCols(at_a, rowsOf(a));
      at_a += rowsOf(a);
      const std::int32_t column = numberOf(blockOf(a), system);
      if (column < 0) continue;
      system.right.middleRows(system.begins[std::size_t(column)], rowsOf(a)) +=
          matrix_a.transpose() * residual;
      const auto begin = system.rows.begin() + system.columns[std::size_t(column)];
      const auto end = system.rows.begin() + system.columns[std::size_t(column) + 1];
      Eigen::Index at_b = 0;
      for (const VertexRef b : equations.vertices) {
        const auto matrix_b = equations.matrix.middleCols(at_b, rowsOf(b));
        at_b += rowsOf(b);
        const std::int32_t row = numberOf(blockOf(b), system);
        if (row < column) continue;
        const auto place = std::size_t(std::lower_bound(begin, end, row) - system.rows.begin());
        Eigen::Map<Eigen::MatrixXd>(system.matrix.data() + system.offsets[place], rowsOf(b),
                                    rowsOf(a)) += matrix_b.transpose() * matrix_a;
      }
    }
  }

  int stage_;
  const Problem& problem_;
  const State& state_;
  const std::vector<char>& settled_;
  std::vector<Equations> equations_;
  std::vector<std::int32_t> unknowns_;  ///< block numbers, rising
};

}  // namespace

RelaxResult relaxEstimates(const Problem& problem, const State& state, ThreadPool& pool,
                           bool only_overdetermined) {
  RelaxResult result;
  State current = state;
  const std::size_t count = problem.freeVertices().size();
  std::vector<char> settled(count, 1);
  std::vector<char> took_part(count, 0);
  for (int stage = 0; stage < GRAFT_RELAXATION_STAGES; ++stage) {
    Stage one(stage, problem, current, settled);
    if (only_overdetermined && !one.isOverdetermined()) {
      result.failure =
          "stage " + std::to_string(stage + 1) + " has no more equations than unknowns";
      return result;
    }
    std::vector<char> now(count, 0);
    result.failure = one.solve(pool, current.values, now);
    if (!result.failure.empty()) return result;
    for (std::size_t i = 0; i < count; ++i) {
      if (!one.has(problem.freeVertices()[i])) continue;
      took_part[i] = 1;
      settled[i] = settled[i] != 0 && now[i] != 0 ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const VertexRef v = problem.freeVertices()[i];
    if (took_part[i] != 0 && settled[i] != 0) {
      result.placed.push_back(v);
      continue;
    }
    // Half a guess is none.
    std::copy(state.values.at(v), state.values.at(v) + state.values.dim(v.type),
              current.values.at(v));
  }
  if (result.placed.empty()) {
    result.failure = "no vertex has edges with linear equations that lead to a known one";
  }
  result.values = std::move(current.values);
  return result;
}

}  // namespace graft
