// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>

#include "core/conformance/derivative.hpp"
#include "core/conformance/function_checks.hpp"

namespace graft::conformance {

namespace {

constexpr double kWidths[] = {0.1, 1, 5};

struct Rho {
  double value;
  double first;
  double second;
};

Rho at(const graft_kernel_type& type, double squared_error, double width) {
  double rho[3] = {};
  type.evaluate(1, &squared_error, width, rho);
  return {rho[0], rho[1], rho[2]};
}

/// Squared errors from 0 over the tiny to the huge, for a width.
std::vector<double> squaredErrors(double width) {
  std::vector<double> list = {0};
  for (int power = -24; power <= 24; ++power) {
    list.push_back(width * width * std::pow(10.0, power * 0.5) * 1.0625);
  }
  return list;
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", x);
  return text;
}

Function kernelFunction(const graft_kernel_type& type, double width) {
  Function function;
  function.inputs = {{"squared errors", 1}};
  function.outputs = {{"kernel values", 3}};
  function.call = [&type, width](std::int64_t count, const auto& in, const auto& out) {
    type.evaluate(count, in[0], width, out[0]);
  };
  function.samples = {squaredErrors(width)};
  function.count = std::int64_t(function.samples[0].size());
  return function;
}

void checkZero(const graft_kernel_type& type) {
  for (const double width : kWidths) {
    const Rho rho = at(type, 0, width);
    if (std::abs(rho.value) > 1e-15) throw Defect("rho(0) is " + number(rho.value) + ", not 0");
    if (std::abs(rho.first - 1) > 1e-12) {
      throw Defect("rho'(0) is " + number(rho.first) + ", not 1");
    }
  }
}

void checkMonotone(const graft_kernel_type& type) {
  for (const double width : kWidths) {
    double last = 0;
    for (const double s : squaredErrors(width)) {
      const Rho rho = at(type, s, width);
      if (rho.value < last * (1 - 1e-12) || rho.first < 0) {
        throw Defect("rho falls at s = " + number(s) + " with width " + number(width));
      }
      last = rho.value;
    }
  }
}

/// rho' (or rho'') against the derivative of rho (or rho'), where it is smooth.
void checkDerivative(const graft_kernel_type& type, bool second) {
  std::size_t compared = 0;
  for (const double width : kWidths) {
    for (const double s : squaredErrors(width)) {
      // Far out and close to 0, differences of rho are rounding.
      if (s < 1e-3 * width * width || s > 1e3 * width * width) continue;
      const NumericDerivative numeric = differentiate([&](double step) {
        const Rho rho = at(type, s * (1 + step), width);
        return std::vector<double>{(second ? rho.first : rho.value) / s};
      });
      if (!numeric.reliable()) continue;
      ++compared;
      const Rho rho = at(type, s, width);
      const double exact = second ? rho.second : rho.first;
      if (!numeric.contradicts(exact, 0)) continue;
      throw Defect(std::string(second ? "rho''" : "rho'") + " at s = " + number(s) +
                   " with width " + number(width) + " is " + number(exact) + ", numerically " +
                   number(numeric.value[0]));
    }
  }
  if (compared == 0) throw Skip("it is not smooth anywhere");
}

}  // namespace

void addKernelChecks(const Context&, const graft_kernel_type& type, Checks& checks) {
  addFunctionChecks(
      "evaluate", [&type] { return kernelFunction(type, 1); }, checks);
  checks.push_back({"rho.zero", [&type] { checkZero(type); }});
  checks.push_back({"rho.monotone", [&type] { checkMonotone(type); }});
  checks.push_back({"rho.derivative", [&type] { checkDerivative(type, false); }});
  checks.push_back({"rho.second_derivative", [&type] { checkDerivative(type, true); }});
}

}  // namespace graft::conformance
