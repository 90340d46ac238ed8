// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/linear_solver.hpp"

#include "core/base/error.hpp"
#include "core/base/memory.hpp"
#include "core/linear/block_cholesky.hpp"
#include "core/types/plugin_call.hpp"

namespace graft {

namespace {

class BuiltIn : public LinearSolver {
 public:
  explicit BuiltIn(ThreadPool& pool) : cholesky_(&pool) {}
  void analyze(const graft_block_pattern& pattern,
               const std::vector<std::int32_t>& order) override {
    cholesky_.analyze(pattern, order);
  }
  LinearOutcome factorize(const double* values, const double* damping) override {
    LinearOutcome outcome;
    outcome.failed_block = cholesky_.factorize(values, damping);
    outcome.ok = outcome.failed_block < 0;
    return outcome;
  }
  LinearOutcome solve(const double* b, double* x) override {
    cholesky_.solve(b, x);
    return {};
  }
  std::string ordering() const override { return cholesky_.symbolic().ordering.name; }
  double flops() const override { return cholesky_.symbolic().ordering.flops; }
  double bytes() const override { return cholesky_.symbolic().bytes(); }
  const std::vector<std::int32_t>* order() const override {
    return &cholesky_.symbolic().ordering.order;
  }

 private:
  BlockCholesky cholesky_;
};

/// A solver of a plugin.
class Plugged : public LinearSolver {
 public:
  Plugged(const graft_solver_type& type, int threads)
      : type_(type),
        self_(callPlugin(Callback::kSolver, type.name, [&] { return type.create(threads); })) {
    if (self_ == nullptr) {
      throw Error(ExitCode::kPlugin,
                  std::string("linear solver ") + type.name + " could not be made");
    }
  }
  ~Plugged() override {
    const PluginCall call(Callback::kSolver, type_.name);
    type_.destroy(self_);
  }
  Plugged(const Plugged&) = delete;
  Plugged& operator=(const Plugged&) = delete;

  void analyze(const graft_block_pattern& pattern, const std::vector<std::int32_t>&) override {
    block_count_ = pattern.block_count;
    graft_message message = {};
    const int status = callPlugin(Callback::kSolver, type_.name, message,
                                  [&] { return type_.analyze(self_, &pattern, &message); });
    if (status != GRAFT_OK) {
      throw Error(status == GRAFT_OUT_OF_MEMORY ? ExitCode::kResources : ExitCode::kPlugin,
                  describe("cannot analyze the pattern", message));
    }
    bytes_ = predictedBytes();
    requireMemory(bytes_, kFactorOfEquations, kWithoutFactor);
  }
  LinearOutcome factorize(const double* values, const double* damping) override {
    graft_message message = {};
    LinearOutcome outcome;
    const int status = callPlugin(Callback::kSolver, type_.name, message, [&] {
      return type_.factorize(self_, values, damping, &outcome.failed_block, &message);
    });
    outcome.ok = status == GRAFT_OK;
    if (status == GRAFT_OUT_OF_MEMORY) {
      throw Error(ExitCode::kResources, describe("is out of memory", message));
    }
    if (status == GRAFT_FAILED) outcome.message = describe("failed", message);
    const bool named = outcome.failed_block >= 0 && outcome.failed_block < block_count_;
    if (status != GRAFT_NOT_POSITIVE_DEFINITE || !named) outcome.failed_block = -1;
    if (status == GRAFT_NOT_POSITIVE_DEFINITE && !named) {
      outcome.message = describe("finds no positive definite matrix", message);
    }
    return outcome;
  }
  LinearOutcome solve(const double* b, double* x) override {
    graft_message message = {};
    LinearOutcome outcome;
    outcome.ok = callPlugin(Callback::kSolver, type_.name, message,
                            [&] { return type_.solve(self_, b, x, &message); }) == GRAFT_OK;
    if (!outcome.ok) outcome.message = describe("failed", message);
    return outcome;
  }
  double bytes() const override { return bytes_; }

 private:
  double predictedBytes() const {
    // Tables of minor version 2 end before.
    if (type_.struct_size < sizeof type_ || type_.factor_bytes == nullptr) return 0;
    return callPlugin(Callback::kSolver, type_.name, [&] { return type_.factor_bytes(self_); });
  }
  std::string describe(const char* what, const graft_message& message) const {
    std::string text = std::string("linear solver ") + type_.name + " " + what;
    if (message.text[0] != '\0') text += std::string(": ") + message.text;
    return withPlugin(text, type_.name);
  }
  const graft_solver_type& type_;
  void* self_;
  std::int32_t block_count_ = 0;
  double bytes_ = 0;
};

}  // namespace

std::unique_ptr<LinearSolver> LinearSolver::create(const std::string& name, Registry& registry,
                                                   ThreadPool& pool) {
  if (name == "block") return std::make_unique<BuiltIn>(pool);
  const graft_solver_type* type = registry.solver(name);
  if (type == nullptr) {
    throw Error(ExitCode::kUsage, "unknown linear solver " + quoted(name) + "; block is built in" +
                                      registry.advice({Kind::kSolver, name}));
  }
  return std::make_unique<Plugged>(*type, pool.threads());
}

}  // namespace graft
