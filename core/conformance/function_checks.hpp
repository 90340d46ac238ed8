// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/conformance/buffer.hpp"
#include "core/conformance/checks.hpp"

namespace graft::conformance {

/// An array of a callback: `dim` numbers per item.
struct Array {
  std::string name;
  int dim = 0;
};

/// A callback under test seen as a function of numbers, with inputs to try it
/// on. Arrays over items are contiguous.
struct Function {
  std::vector<Array> inputs;
  std::vector<Array> outputs;
  /// Calls it for `count` items; throws Defect if it refuses them.
  std::function<void(std::int64_t count, const std::vector<const double*>& in,
                     const std::vector<double*>& out)>
      call;
  std::int64_t count = 0;
  std::vector<std::vector<double>> samples;  ///< per input array, `count` items
};

/// Outputs of a call, per output array.
using Outputs = std::vector<std::vector<double>>;

/// Calls the function for items [first, first + count) of its samples.
Outputs evaluate(const Function& function, std::int64_t first, std::int64_t count,
                 Placement placement = Placement::kAligned);

/// Adds the checks that hold for every callback (see checkPlugin()); `make` runs
/// inside a check.
void addFunctionChecks(const std::string& name, const std::function<Function()>& make,
                       Checks& checks);

/// Throws Defect unless all outputs are finite; `where` ends the sentence.
void requireFinite(const Function& function, const Outputs& outputs, const std::string& where);

}  // namespace graft::conformance
