// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/conformance/derivative.hpp"
#include "core/conformance/edge_samples.hpp"
#include "core/conformance/text_checks.hpp"

namespace graft::conformance {

namespace {

using Numbers = std::vector<double>;

/// Vertices of edge e, per slot.
std::vector<Numbers> verticesOf(const EdgeSamples& samples, std::int64_t e) {
  std::vector<Numbers> vertices;
  for (std::size_t k = 0; k < samples.slots.size(); ++k) {
    const int dim = samples.slots[k]->ambient_dim;
    const double* begin = samples.vertices[k].data() + e * dim;
    vertices.emplace_back(begin, begin + dim);
  }
  return vertices;
}

/// The error of edge e with other vertices.
Numbers errorAt(const EdgeSamples& samples, std::int64_t e, const std::vector<Numbers>& vertices) {
  std::vector<const double*> pointers;
  pointers.reserve(vertices.size());
  for (const Numbers& x : vertices) pointers.push_back(x.data());
  const Batch batch(samples, 1, pointers, samples.measurements.data() + e * samples.measurement_dim,
                    samples.associations.data() + e * samples.type->association_dim);
  graft_message message = {};
  int status = GRAFT_FAILED;
  Numbers error = guardedNumbers(std::size_t(samples.error_dim), [&](double* out) {
    status = samples.type->evaluate(batch.get(), out, nullptr, &message);
  });
  if (status == GRAFT_OK) return error;
  throw Defect(std::string("evaluate() fails at valid values: ") + message.text);
}

void checkJacobian(const EdgeSamples& samples) {
  const Outputs exact = evaluate(evaluateFunction(samples, true), 0, samples.count);
  const std::size_t stride = std::size_t(samples.error_dim) * std::size_t(samples.tangent_dim);
  std::size_t compared = 0;
  for (std::int64_t e = 0; e < samples.count; ++e) {
    const double* column = exact[1].data() + std::size_t(e) * stride;
    for (std::size_t k = 0; k < samples.slots.size(); ++k) {
      const graft_vertex_type& slot = *samples.slots[k];
      for (int c = 0; c < slot.tangent_dim; ++c, column += samples.error_dim) {
        const NumericDerivative numeric = differentiate([&](double step) {
          std::vector<Numbers> moved = verticesOf(samples, e);
          Numbers delta(std::size_t(slot.tangent_dim), 0.0);
          delta[std::size_t(c)] = step;
          moved[k] = guardedNumbers(moved[k].size(), [&](double* out) {
            slot.plus(1, moved[k].data(), delta.data(), out);
          });
          return errorAt(samples, e, moved);
        });
        if (!numeric.reliable()) continue;
        ++compared;
        for (int r = 0; r < samples.error_dim; ++r) {
          if (!numeric.contradicts(column[r], std::size_t(r))) continue;
          throw Defect("the derivative of error " + std::to_string(r + 1) + " by number " +
                       std::to_string(c + 1) + " of slot " + std::to_string(k + 1) + " (" +
                       slot.tag + ") is " + std::to_string(column[r]) + ", numerically " +
                       std::to_string(numeric.value[std::size_t(r)]));
        }
      }
    }
  }
  if (compared == 0) throw Skip("the error is not smooth at any of the inputs");
}

void checkSameErrors(const EdgeSamples& samples) {
  const Numbers alone = evaluate(evaluateFunction(samples, false), 0, samples.count)[0];
  const Numbers both = evaluate(evaluateFunction(samples, true), 0, samples.count)[0];
  for (std::size_t i = 0; i < alone.size(); ++i) {
    const double scale = std::max(1.0, std::abs(alone[i]));
    if (std::abs(alone[i] - both[i]) <= 1e-9 * scale) continue;
    throw Defect("errors with and without Jacobians differ: " + std::to_string(both[i]) + " and " +
                 std::to_string(alone[i]));
  }
}

void checkIdentity(const EdgeSamples& samples) {
  const EdgeSamples at_identity = atIdentity(samples);
  const Function function = evaluateFunction(at_identity, true);
  requireFinite(function, evaluate(function, 0, function.count),
                "with all vertices at their identity");
}

void checkMeasurement(const EdgeSamples& samples) {
  if (samples.measurement_dim == 0) throw Skip("it has no measurement");
  const auto dim = static_cast<std::size_t>(samples.measurement_dim);
  for (std::int64_t e = 0; e < samples.count; ++e) {
    const double* begin = samples.measurements.data() + std::size_t(e) * dim;
    Buffer buffer(Numbers(begin, begin + dim), Placement::kOdd);
    graft_message message = {};
    if (samples.type->normalize(samples.measurement_dim, buffer.data(), &message) != GRAFT_OK) {
      throw Defect(std::string("normalize() refuses what it made: ") + message.text);
    }
    if (buffer.changedBefore() + buffer.changedBehind() > 0) {
      throw Defect("normalize() writes beside the numbers");
    }
    if (!sameBits(buffer.data(), begin, dim)) {
      throw Defect("normalize() changes numbers that are valid already");
    }
  }
}

/// Which errors of edge e depend on slot `slot`, by the Jacobian there. An edge to
/// many points can make only those vanish that are about the one point.
std::vector<bool> errorsThatDepend(const EdgeSamples& samples, std::int64_t e,
                                   const std::vector<Numbers>& vertices, std::size_t slot) {
  std::vector<const double*> pointers;
  pointers.reserve(vertices.size());
  for (const Numbers& x : vertices) pointers.push_back(x.data());
  const Batch batch(samples, 1, pointers, samples.measurements.data() + e * samples.measurement_dim,
                    samples.associations.data() + e * samples.type->association_dim);
  const auto rows = static_cast<std::size_t>(samples.error_dim);
  Buffer error(rows, Placement::kAligned);
  Buffer jacobian(rows * std::size_t(samples.tangent_dim), Placement::kAligned);
  graft_message message = {};
  if (samples.type->evaluate(batch.get(), error.data(), jacobian.data(), &message) != GRAFT_OK) {
    throw Defect(std::string("evaluate() fails where propagate() leads: ") + message.text);
  }
  std::size_t column = 0;
  for (std::size_t k = 0; k < slot; ++k) column += std::size_t(samples.slots[k]->tangent_dim);
  std::vector<bool> depends(rows, false);
  for (int c = 0; c < samples.slots[slot]->tangent_dim; ++c, ++column) {
    for (std::size_t r = 0; r < rows; ++r) {
      if (jacobian.data()[column * rows + r] != 0) depends[r] = true;
    }
  }
  return depends;
}

void checkPropagate(const EdgeSamples& samples) {
  if (samples.type->propagate == nullptr) throw Skip("it has no propagate()");
  std::size_t told = 0;
  for (std::int64_t e = 0; e < samples.count; ++e) {
    const std::vector<Numbers> vertices = verticesOf(samples, e);
    for (std::size_t to = 0; to < vertices.size(); ++to) {
      std::vector<const double*> pointers;
      pointers.reserve(vertices.size());
      for (const Numbers& x : vertices) pointers.push_back(x.data());
      const Batch batch(samples, 1, pointers,
                        samples.measurements.data() + e * samples.measurement_dim,
                        samples.associations.data() + e * samples.type->association_dim);
      Buffer estimate(vertices[to].size(), Placement::kAligned);
      if (samples.type->propagate(batch.get(), std::int32_t(to), estimate.data()) != GRAFT_OK) {
        continue;
      }
      ++told;
      if (estimate.changedBefore() + estimate.changedBehind() > 0) {
        throw Defect("propagate() writes beside the estimate");
      }
      if (estimate.firstUnwritten() < estimate.size()) {
        throw Defect("propagate() leaves numbers of the estimate unwritten");
      }
      std::vector<Numbers> moved = vertices;
      moved[to] = estimate.numbers();
      graft_message message = {};
      if (samples.slots[to]->normalize(moved[to].data(), &message) != GRAFT_OK) {
        throw Defect(std::string("propagate() gives no valid estimate: ") + message.text);
      }
      double scale = 1;
      for (const Numbers& x : moved) {
        for (const double number : x) scale = std::max(scale, std::abs(number));
      }
      const Numbers error = errorAt(samples, e, moved);
      const std::vector<bool> depends = errorsThatDepend(samples, e, moved, to);
      for (std::size_t r = 0; r < error.size(); ++r) {
        if (!depends[r] || std::abs(error[r]) <= 1e-9 * scale) continue;
        throw Defect("propagate() to slot " + std::to_string(to + 1) + " leaves an error of " +
                     std::to_string(error[r]));
      }
    }
  }
  if (told == 0) throw Skip("propagate() never tells");
}

void checkAssociate(const EdgeSamples& samples) {
  if (samples.type->associate == nullptr) throw Skip("it has no associate()");
  std::vector<const double*> vertices;
  for (const Numbers& x : samples.vertices) vertices.push_back(x.data());
  const Batch batch(samples, samples.count, vertices, samples.measurements.data(),
                    samples.associations.data());
  Buffer again(samples.associations, Placement::kAligned);
  std::vector<std::uint8_t> changed(std::size_t(samples.count), 7);
  graft_message message = {};
  if (samples.type->associate(batch.get(), 0, again.data(), changed.data(), &message) != GRAFT_OK) {
    throw Defect(std::string("associate() fails at valid values: ") + message.text);
  }
  for (const std::uint8_t one : changed) {
    if (one == 7) throw Defect("associate() leaves `changed` unwritten");
    if (one != 0) throw Defect("associate() at the same estimates says that something changed");
  }
  if (!sameBits(again.data(), samples.associations.data(), again.size())) {
    throw Defect("associate() at the same estimates changes the association");
  }
}

/// The k-th choice of the first edge of a batch; empty if there are no more.
Numbers choiceOf(const EdgeSamples& samples, const Batch& batch, int k) {
  Buffer chosen(std::size_t(samples.type->association_dim), Placement::kAligned);
  std::uint8_t there = 7;
  graft_message message = {};
  if (samples.type->associate(batch.get(), GRAFT_ALTERNATIVE + k, chosen.data(), &there,
                              &message) != GRAFT_OK) {
    throw Defect("associate() fails at choice " + std::to_string(k) + ": " + message.text);
  }
  if (there > 1) throw Defect("associate() leaves `changed` unwritten at a choice");
  if (there == 1 && chosen.firstUnwritten() < chosen.size()) {
    throw Defect("associate() leaves choice " + std::to_string(k) + " unwritten");
  }
  return there == 1 ? chosen.numbers() : Numbers();
}

void checkAlternatives(const EdgeSamples& samples) {
  constexpr int kMost = 100000;
  const int dim = samples.type->association_dim;
  for (std::int64_t e = 0; e < std::min<std::int64_t>(samples.count, 4); ++e) {
    // The same edge at its own estimates and at another's.
    std::vector<const double*> own;
    std::vector<const double*> other;
    for (std::size_t k = 0; k < samples.slots.size(); ++k) {
      const int ambient = samples.slots[k]->ambient_dim;
      own.push_back(samples.vertices[k].data() + e * ambient);
      other.push_back(samples.vertices[k].data() + (e + 1) % samples.count * ambient);
    }
    const double* measurement = samples.measurements.data() + e * samples.measurement_dim;
    const double* chosen = samples.associations.data() + e * dim;
    const Batch batch(samples, 1, own, measurement, chosen);
    const Batch elsewhere(samples, 1, other, measurement, chosen);
    bool listed = false;
    for (int k = 0;; ++k) {
      if (k == kMost) throw Defect("associate() lists 100,000 choices and goes on");
      const Numbers choice = choiceOf(samples, batch, k);
      const Numbers again = choiceOf(samples, elsewhere, k);
      if (choice.size() != again.size() || !sameBits(choice.data(), again.data(), choice.size())) {
        throw Defect("choice " + std::to_string(k) + " depends on the estimates");
      }
      if (choice.empty()) break;
      listed = listed || std::equal(choice.begin(), choice.end(), chosen);
    }
    if (!listed) throw Defect("associate() chooses what is not among the choices that it lists");
  }
}

void checkShape(const EdgeSamples& samples) {
  if (samples.type->shape == nullptr) throw Skip("it has a fixed number of vertices");
  for (const std::int32_t arity : {0, -1}) {
    graft_message message = {};
    std::int32_t errors = -1;
    std::int32_t measurements = -1;
    if (samples.type->shape(arity, &errors, &measurements, &message) == GRAFT_OK && errors <= 0) {
      throw Defect("shape() accepts " + std::to_string(arity) + " vertices");
    }
  }
}

}  // namespace

void addEdgeChecks(const Context& context, const graft_edge_type& type, Checks& checks) {
  const bool dynamic = type.arity == GRAFT_DYNAMIC;
  for (const bool larger : {false, true}) {
    if (larger && !dynamic) continue;
    const std::string suffix = larger ? "+" : "";
    const auto sample = [context, &type, larger] { return sampleEdges(context, type, larger); };
    const auto add = [&](const char* name, void (*body)(const EdgeSamples&)) {
      checks.push_back({name + suffix, [sample, body] { body(sample()); }});
    };
    addFunctionChecks(
        "evaluate" + suffix, [sample] { return evaluateFunction(sample(), true); }, checks);
    addFunctionChecks(
        "errors" + suffix, [sample] { return evaluateFunction(sample(), false); }, checks);
    if (type.associate != nullptr) {
      addFunctionChecks(
          "associate" + suffix, [sample] { return associateFunction(sample()); }, checks);
      add("associate.again", checkAssociate);
      if ((type.flags & GRAFT_EDGE_HAS_ALTERNATIVES) != 0) {
        add("associate.alternatives", checkAlternatives);
      }
    }
    add("identity", checkIdentity);
    add("jacobian", checkJacobian);
    add("errors.same", checkSameErrors);
    if (type.measurement_dim != 0) add("normalize.keeps", checkMeasurement);
    if (type.propagate != nullptr) add("propagate", checkPropagate);
    if (dynamic) add("shape", checkShape);
    checks.push_back({"text" + suffix, [context, sample] {
                        const EdgeSamples samples = sample();
                        requireEdgeText(context, samples);
                      }});
  }
}

}  // namespace graft::conformance
