// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <thread>

#include "core/base/text.hpp"
#include "core/conformance/buffer.hpp"
#include "core/conformance/checks.hpp"
#include "core/conformance/sampler.hpp"

namespace graft::conformance {

namespace {

/// A random symmetric positive definite block matrix, sparse, with blocks of
/// different sizes.
struct Problem {
  Problem(std::uint64_t seed, int blocks) {
    Random random(seed);
    for (int j = 0; j < blocks; ++j) dims.push_back(1 + int(random.uniform(0, 6.99)));
    std::vector<int> first(1, 0);
    for (const int d : dims) first.push_back(first.back() + d);
    const int n = first.back();
    dense = Eigen::MatrixXd::Zero(n, n);
    std::int64_t offset = 0;
    columns.push_back(0);
    for (int j = 0; j < blocks; ++j) {
      for (int i = j; i < blocks; ++i) {
        // A chain, and some blocks far from the diagonal.
        if (i > j + 1 && random.uniform(0, 1) > 0.15) continue;
        rows.push_back(i);
        offsets.push_back(offset);
        offset += std::int64_t(dims[std::size_t(i)]) * dims[std::size_t(j)];
        auto block = dense.block(first[std::size_t(i)], first[std::size_t(j)], dims[std::size_t(i)],
                                 dims[std::size_t(j)]);
        for (Eigen::Index k = 0; k < block.size(); ++k) {
          block(k % block.rows(), k / block.rows()) = random.normal();
        }
      }
      columns.push_back(std::int64_t(rows.size()));
    }
    Eigen::MatrixXd lower = dense.triangularView<Eigen::StrictlyLower>();
    dense = lower + lower.transpose();
    // Dominance of the diagonal makes it positive definite.
    for (int r = 0; r < n; ++r) dense(r, r) = dense.row(r).cwiseAbs().sum() + 1;
    for (int j = 0; j < blocks; ++j) {
      for (std::int64_t b = columns[std::size_t(j)]; b < columns[std::size_t(j) + 1]; ++b) {
        const int i = rows[std::size_t(b)];
        const Eigen::MatrixXd block = dense.block(first[std::size_t(i)], first[std::size_t(j)],
                                                  dims[std::size_t(i)], dims[std::size_t(j)]);
        values.insert(values.end(), block.data(), block.data() + block.size());
      }
    }
    right = Eigen::VectorXd(n);
    damping = Eigen::VectorXd(n);
    for (int r = 0; r < n; ++r) {
      right[r] = random.normal();
      damping[r] = random.uniform(0, 5);
    }
    pattern.struct_size = sizeof pattern;
    pattern.block_count = blocks;
    pattern.dims = dims.data();
    pattern.columns = columns.data();
    pattern.rows = rows.data();
    pattern.offsets = offsets.data();
  }
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  /// Of (A + diag(damping)) x = b, or without damping.
  Eigen::VectorXd solution(bool damped) const {
    Eigen::MatrixXd a = dense;
    if (damped) a.diagonal() += damping;
    return a.llt().solve(right);
  }

  std::vector<std::int32_t> dims;
  std::vector<std::int64_t> columns;
  std::vector<std::int32_t> rows;
  std::vector<std::int64_t> offsets;
  std::vector<double> values;
  Eigen::MatrixXd dense;
  Eigen::VectorXd right;
  Eigen::VectorXd damping;
  graft_block_pattern pattern = {};
};

/// A solver object; its refusals become defects.
class Solver {
 public:
  explicit Solver(const graft_solver_type& type) : type_(type), self_(type.create(1)) {
    if (self_ == nullptr) throw Defect("create() gives null");
  }
  ~Solver() { type_.destroy(self_); }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  void analyze(const Problem& problem) {
    graft_message message = {};
    require(type_.analyze(self_, &problem.pattern, &message), "analyze()", message);
    if (type_.struct_size < sizeof type_ || type_.factor_bytes == nullptr) return;
    const double bytes = type_.factor_bytes(self_);
    if (!(bytes >= 0) || !std::isfinite(bytes)) {
      throw Defect("factor_bytes() gives " + formatDouble(bytes));
    }
  }
  int factorize(const std::vector<double>& values, const double* damping, std::int32_t& failed) {
    graft_message message = {};
    return type_.factorize(self_, values.data(), damping, &failed, &message);
  }
  void factorize(const Problem& problem, bool damped) {
    std::int32_t failed = -1;
    const Buffer values(problem.values, Placement::kOdd);
    graft_message message = {};
    require(type_.factorize(self_, values.data(), damped ? problem.damping.data() : nullptr,
                            &failed, &message),
            "factorize()", message);
    if (!sameBits(values.data(), problem.values.data(), values.size())) {
      throw Defect("factorize() changes the values");
    }
  }
  Eigen::VectorXd solve(const Problem& problem) {
    Buffer x(std::size_t(problem.right.size()), Placement::kOdd);
    graft_message message = {};
    require(type_.solve(self_, problem.right.data(), x.data(), &message), "solve()", message);
    if (x.changedBefore() + x.changedBehind() > 0) throw Defect("solve() writes beside x");
    if (x.firstUnwritten() < x.size()) throw Defect("solve() leaves numbers of x unwritten");
    return Eigen::Map<const Eigen::VectorXd>(x.data(), Eigen::Index(x.size()));
  }

 private:
  static void require(int status, const char* what, const graft_message& message) {
    if (status == GRAFT_OK) return;
    throw Defect(std::string(what) + " fails on a positive definite matrix: " + message.text);
  }
  const graft_solver_type& type_;
  void* self_;
};

void requireSolution(const Eigen::VectorXd& x, const Eigen::VectorXd& expected,
                     const std::string& text) {
  // Room for iterative solvers; a direct one is at 1e-15.
  const double error = (x - expected).norm() / expected.norm();
  if (error <= 1e-6) return;
  throw Defect(text + ": relative error " + std::to_string(error) + " against a dense Cholesky");
}

void checkSolve(const graft_solver_type& type, std::uint64_t seed) {
  Solver solver(type);
  for (const int blocks : {1, 2, 7, 30}) {
    const Problem problem(seed + std::uint64_t(blocks), blocks);
    const std::string text = "solution of " + std::to_string(blocks) + " blocks";
    solver.analyze(problem);
    solver.factorize(problem, false);
    requireSolution(solver.solve(problem), problem.solution(false), text);
    solver.factorize(problem, true);
    requireSolution(solver.solve(problem), problem.solution(true), text + " with damping");
    solver.factorize(problem, false);
    requireSolution(solver.solve(problem), problem.solution(false),
                    text + " after a factor with damping");
  }
}

void checkState(const graft_solver_type& type, std::uint64_t seed) {
  const Problem problem(seed, 12);
  const Problem other(seed + 1, 5);
  const auto solveWith = [&](Solver& solver) {
    solver.analyze(problem);
    solver.factorize(problem, true);
    return solver.solve(problem);
  };
  Solver first(type);
  const Eigen::VectorXd x = solveWith(first);
  first.analyze(other);
  first.factorize(other, false);
  first.solve(other);
  Solver second(type);
  for (const Eigen::VectorXd& again : {solveWith(first), solveWith(second)}) {
    if (sameBits(x.data(), again.data(), std::size_t(x.size()))) continue;
    throw Defect("the same system gives another solution the second time");
  }
}

void checkIndefinite(const graft_solver_type& type, std::uint64_t seed) {
  const Problem problem(seed, 8);
  Solver solver(type);
  solver.analyze(problem);
  std::vector<double> values = problem.values;
  const std::int64_t diagonal = problem.offsets[std::size_t(problem.columns[4])];
  values[std::size_t(diagonal)] = -1;
  std::int32_t failed = -7;
  const int status = solver.factorize(values, nullptr, failed);
  if (status == GRAFT_OK)
    throw Defect("factorize() accepts a matrix that is not positive definite");
  if (status == GRAFT_NOT_POSITIVE_DEFINITE && (failed < -1 || failed >= 8) && failed != -7) {
    throw Defect("factorize() names a block that does not exist: " + std::to_string(failed));
  }
  solver.factorize(problem, false);
  requireSolution(solver.solve(problem), problem.solution(false), "solution after a failed factor");
}

void checkNotFinite(const graft_solver_type& type, std::uint64_t seed) {
  const Problem problem(seed, 4);
  Solver solver(type);
  solver.analyze(problem);
  std::vector<double> values = problem.values;
  values[0] = std::numeric_limits<double>::quiet_NaN();
  std::int32_t failed = -1;
  if (solver.factorize(values, nullptr, failed) == GRAFT_OK) {
    throw Defect("factorize() accepts a matrix that is not finite");
  }
}

void checkThreads(const graft_solver_type& type, std::uint64_t seed) {
  std::string found[2];
  const auto work = [&](int id) {
    try {
      for (int round = 0; round < 20; ++round) {
        const Problem problem(seed + std::uint64_t(id), 10 + id);
        Solver solver(type);
        solver.analyze(problem);
        solver.factorize(problem, false);
        requireSolution(solver.solve(problem), problem.solution(false),
                        "solution while another solver runs on a second thread");
      }
    } catch (const std::exception& e) {
      found[id] = e.what();
    }
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  for (const std::string& text : found) {
    if (!text.empty()) throw Defect(text);
  }
}

}  // namespace

void addSolverChecks(const Context& context, const graft_solver_type& type, Checks& checks) {
  const std::uint64_t seed = context.options.seed;
  const auto add = [&](const char* name, void (*body)(const graft_solver_type&, std::uint64_t)) {
    checks.push_back({name, [&type, seed, body] { body(type, seed); }});
  };
  add("solve", checkSolve);
  add("solve.state", checkState);
  add("factorize.indefinite", checkIndefinite);
  add("factorize.not_finite", checkNotFinite);
  add("threads", checkThreads);
}

}  // namespace graft::conformance
