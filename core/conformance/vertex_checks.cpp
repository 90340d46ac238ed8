// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/conformance/function_checks.hpp"
#include "core/conformance/sampler.hpp"
#include "core/conformance/text_checks.hpp"

namespace graft::conformance {

namespace {

using Numbers = std::vector<double>;

/// The callbacks of a vertex type on vectors.
class Vertex {
 public:
  explicit Vertex(const graft_vertex_type& type) : type_(type) {}

  Numbers identity() const {
    return guardedNumbers(std::size_t(type_.ambient_dim), type_.identity);
  }
  Numbers plus(const Numbers& x, const Numbers& delta) const {
    return guardedNumbers(x.size(),
                          [&](double* out) { type_.plus(1, x.data(), delta.data(), out); });
  }
  Numbers plusInPlace(const Numbers& x, const Numbers& delta) const {
    return guardedNumbers(x.size(), [&](double* moved) {
      std::copy(x.begin(), x.end(), moved);
      type_.plus(1, moved, delta.data(), moved);
    });
  }
  Numbers minus(const Numbers& a, const Numbers& b) const {
    return guardedNumbers(std::size_t(type_.tangent_dim),
                          [&](double* delta) { type_.minus(1, a.data(), b.data(), delta); });
  }
  Numbers zero() const { return Numbers(std::size_t(type_.tangent_dim)); }
  Numbers step(Random& random, double size) const {
    Numbers delta = zero();
    for (double& d : delta) d = random.uniform(-size, size);
    return delta;
  }

 private:
  const graft_vertex_type& type_;
};

/// Throws Defect unless a and b agree to rounding.
void requireNear(const Numbers& a, const Numbers& b, double tolerance, const std::string& text) {
  double scale = 1;
  for (const double x : b) scale = std::max(scale, std::abs(x));
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) <= tolerance * scale) continue;
    throw Defect(text + ": number " + std::to_string(i + 1) + " is " + std::to_string(a[i]) +
                 ", expected " + std::to_string(b[i]));
  }
}

Function plusFunction(const Context& context, const graft_vertex_type& type) {
  Function function;
  function.inputs = {{"estimates", type.ambient_dim}, {"steps", type.tangent_dim}};
  function.outputs = {{"moved estimates", type.ambient_dim}};
  function.call = [&type](std::int64_t count, const auto& in, const auto& out) {
    type.plus(count, in[0], in[1], out[0]);
  };
  function.count = context.options.samples;
  function.samples.resize(2);
  Random random(context.options.seed);
  for (int i = 0; i < context.options.samples; ++i) {
    const Numbers x = randomEstimate(type, random, i);
    function.samples[0].insert(function.samples[0].end(), x.begin(), x.end());
    for (int k = 0; k < type.tangent_dim; ++k) function.samples[1].push_back(random.normal());
  }
  return function;
}

Function minusFunction(const Context& context, const graft_vertex_type& type) {
  Function function;
  function.inputs = {{"estimates a", type.ambient_dim}, {"estimates b", type.ambient_dim}};
  function.outputs = {{"differences", type.tangent_dim}};
  function.call = [&type](std::int64_t count, const auto& in, const auto& out) {
    type.minus(count, in[0], in[1], out[0]);
  };
  function.count = context.options.samples;
  Random random(context.options.seed);
  function.samples.resize(2);
  for (int i = 0; i < context.options.samples; ++i) {
    for (auto& array : function.samples) {
      const Numbers x = randomEstimate(type, random, i);
      array.insert(array.end(), x.begin(), x.end());
    }
  }
  return function;
}

Function identityFunction(const graft_vertex_type& type) {
  Function function;
  function.outputs = {{"identity", type.ambient_dim}};
  function.call = [&type](std::int64_t count, const auto&, const auto& out) {
    for (std::int64_t i = 0; i < count; ++i) type.identity(out[0] + i * type.ambient_dim);
  };
  function.count = 2;
  return function;
}

void normalizeKeepsValidNumbers(const graft_vertex_type& type, const Numbers& x) {
  Buffer buffer(x, Placement::kOdd);
  graft_message message = {};
  if (type.normalize(buffer.data(), &message) != GRAFT_OK) {
    throw Defect(std::string("normalize() refuses a valid estimate: ") + message.text);
  }
  if (buffer.changedBefore() + buffer.changedBehind() > 0) {
    throw Defect("normalize() writes beside the numbers");
  }
  if (!sameBits(buffer.data(), x.data(), x.size())) {
    throw Defect("normalize() changes numbers that are valid already");
  }
}

}  // namespace

void addVertexChecks(const Context& context, const graft_vertex_type& type, Checks& checks) {
  const auto forSamples = [context, &type](auto body) {
    return [context, &type, body] {
      Random random(context.options.seed);
      const Vertex vertex(type);
      body(vertex, vertex.identity(), random);
      for (int i = 0; i < context.options.samples; ++i) {
        const Numbers x = randomEstimate(type, random, i);
        body(vertex, x, random);
      }
    };
  };
  addFunctionChecks(
      "identity", [&type] { return identityFunction(type); }, checks);
  addFunctionChecks(
      "plus", [context, &type] { return plusFunction(context, type); }, checks);
  addFunctionChecks(
      "minus", [context, &type] { return minusFunction(context, type); }, checks);
  checks.push_back({"plus.zero", forSamples([](const Vertex& v, const Numbers& x, Random&) {
                      requireNear(v.plus(x, v.zero()), x, 1e-12, "x plus 0 is not x");
                    })});
  checks.push_back({"minus.zero", forSamples([](const Vertex& v, const Numbers& x, Random&) {
                      requireNear(v.minus(x, x), v.zero(), 1e-12, "x minus x is not 0");
                    })});
  checks.push_back(
      {"minus.inverse", forSamples([](const Vertex& v, const Numbers& x, Random& random) {
         const Numbers y = v.plus(x, v.step(random, 1));
         requireNear(v.minus(v.plus(x, v.minus(y, x)), y), v.zero(), 1e-9,
                     "x plus (y minus x) is not y");
         // The identity may be where a chart is singular, and several steps lead to one y.
         if (sameBits(x.data(), v.identity().data(), x.size())) return;
         const Numbers delta = v.step(random, 0.01);
         requireNear(v.minus(v.plus(x, delta), x), delta, 1e-9, "(x plus d) minus x is not d");
       })});
  checks.push_back(
      {"plus.in_place", forSamples([](const Vertex& v, const Numbers& x, Random& random) {
         const Numbers delta = v.step(random, 1);
         const Numbers expected = v.plus(x, delta);
         const Numbers moved = v.plusInPlace(x, delta);
         if (!sameBits(moved.data(), expected.data(), moved.size())) {
           throw Defect("a step in place (out = x) gives another result");
         }
       })});
  checks.push_back({"normalize.keeps", [context, &type] {
                      normalizeKeepsValidNumbers(type, Vertex(type).identity());
                      Random random(context.options.seed);
                      for (int i = 0; i < context.options.samples; ++i) {
                        normalizeKeepsValidNumbers(type, randomEstimate(type, random, i));
                      }
                    }});
  checks.push_back({"text", [context, &type] { requireVertexText(context, type); }});
}

}  // namespace graft::conformance
