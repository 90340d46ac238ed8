// SPDX-License-Identifier: BSD-3-Clause
#include "core/conformance/function_checks.hpp"

#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

namespace graft::conformance {

namespace {

/// The buffers of one call.
struct Call {
  Call(const Function& function, std::int64_t first, std::int64_t count, Placement placement) {
    const auto items = static_cast<std::size_t>(count);
    for (std::size_t a = 0; a < function.inputs.size(); ++a) {
      const auto dim = static_cast<std::size_t>(function.inputs[a].dim);
      const auto begin = function.samples[a].begin() + first * function.inputs[a].dim;
      original.emplace_back(begin, begin + std::ptrdiff_t(items * dim));
      inputs.push_back(std::make_unique<Buffer>(original.back(), placement));
      in.push_back(inputs.back()->data());
    }
    for (const Array& array : function.outputs) {
      outputs.push_back(
          std::make_unique<Buffer>(items * static_cast<std::size_t>(array.dim), placement));
      out.push_back(outputs.back()->data());
    }
    function.call(count, in, out);
  }
  Outputs numbers() const {
    Outputs result;
    for (const auto& buffer : outputs) result.push_back(buffer->numbers());
    return result;
  }
  std::vector<std::vector<double>> original;
  std::vector<std::unique_ptr<Buffer>> inputs;
  std::vector<std::unique_ptr<Buffer>> outputs;
  std::vector<const double*> in;
  std::vector<double*> out;
};

std::string place(const Array& array, std::size_t index) {
  const auto dim = static_cast<std::size_t>(array.dim);
  return "number " + std::to_string(index % dim + 1) + " of " + std::to_string(dim) + " of the " +
         array.name + " of item " + std::to_string(index / dim + 1);
}

/// Throws Defect with `text` where `outputs` of items from `first` on differ
/// from those of the whole batch.
void requireSame(const Function& function, const Outputs& batch, const Outputs& outputs,
                 std::int64_t first, const std::string& text) {
  for (std::size_t a = 0; a < outputs.size(); ++a) {
    const std::size_t offset =
        static_cast<std::size_t>(first) * static_cast<std::size_t>(function.outputs[a].dim);
    for (std::size_t i = 0; i < outputs[a].size(); ++i) {
      if (sameBits(&batch[a][offset + i], &outputs[a][i], 1)) continue;
      throw Defect(text + ": " + place(function.outputs[a], offset + i));
    }
  }
}

void requireWritten(const Function& function) {
  for (const std::int64_t count : {std::int64_t{1}, function.count}) {
    const Call call(function, 0, count, Placement::kAligned);
    for (std::size_t a = 0; a < function.outputs.size(); ++a) {
      const std::size_t index = call.outputs[a]->firstUnwritten();
      if (index < call.outputs[a]->size()) {
        throw Defect("leaves " + place(function.outputs[a], index) + " unwritten");
      }
    }
  }
}

void requireInBounds(const Function& function) {
  for (const std::int64_t count : {std::int64_t{1}, function.count}) {
    const Call call(function, 0, count, Placement::kAligned);
    for (std::size_t a = 0; a < function.outputs.size(); ++a) {
      const auto report = [&](std::size_t numbers, const char* where) {
        if (numbers == 0) return;
        throw Defect("writes " + std::to_string(numbers) + " numbers " + where + " the " +
                     function.outputs[a].name + " of " + std::to_string(count) + " items");
      };
      report(call.outputs[a]->changedBehind(), "behind the end of");
      report(call.outputs[a]->changedBefore(), "before the begin of");
    }
  }
}

void requireInputsUntouched(const Function& function) {
  const Call call(function, 0, function.count, Placement::kAligned);
  for (std::size_t a = 0; a < function.inputs.size(); ++a) {
    const Buffer& buffer = *call.inputs[a];
    for (std::size_t i = 0; i < buffer.size(); ++i) {
      if (sameBits(buffer.data() + i, &call.original[a][i], 1)) continue;
      throw Defect("changes its input: " + place(function.inputs[a], i));
    }
    if (buffer.changedBefore() + buffer.changedBehind() > 0) {
      throw Defect("writes beside its input, the " + function.inputs[a].name);
    }
  }
}

void requireItemsAlone(const Function& function) {
  const Outputs batch = evaluate(function, 0, function.count);
  for (std::int64_t i = 0; i < function.count; ++i) {
    requireSame(function, batch, evaluate(function, i, 1), i,
                "a batch of " + std::to_string(function.count) + " and one item differ");
  }
  const std::int64_t half = function.count / 2;
  if (half == 0) return;
  requireSame(function, batch, evaluate(function, 0, half), 0, "two chunks of a batch differ");
  requireSame(function, batch, evaluate(function, half, function.count - half), half,
              "two chunks of a batch differ");
}

void requireNoState(const Function& function) {
  std::vector<Outputs> first;
  for (std::int64_t i = 0; i < function.count; ++i) first.push_back(evaluate(function, i, 1));
  for (std::int64_t i = function.count; i-- > 0;) {
    const Outputs again = evaluate(function, i, 1);
    for (std::size_t a = 0; a < again.size(); ++a) {
      const Outputs& before = first[static_cast<std::size_t>(i)];
      for (std::size_t k = 0; k < again[a].size(); ++k) {
        if (sameBits(&before[a][k], &again[a][k], 1)) continue;
        throw Defect("the same input gives another result the second time: " +
                     place(function.outputs[a], k));
      }
    }
  }
}

/// Two threads, each on its half of the items, as long as it takes to meet.
void requireThreadSafe(const Function& function) {
  using Clock = std::chrono::steady_clock;
  const Outputs batch = evaluate(function, 0, function.count);
  const std::int64_t half = std::max<std::int64_t>(1, function.count / 2);
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(100);
  std::string found[2];
  const auto work = [&](int id) {
    const std::int64_t first = id == 0 ? 0 : function.count - half;
    try {
      for (int round = 0; round < 8 || Clock::now() < end; ++round) {
        requireSame(function, batch, evaluate(function, first, half), first,
                    "results change while another thread calls it, too");
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

void requirePlacement(const Function& function, Placement placement, const std::string& text) {
  const Outputs batch = evaluate(function, 0, function.count);
  requireSame(function, batch, evaluate(function, 0, function.count, placement), 0, text);
  for (std::int64_t i = 0; i < function.count; ++i) {
    requireSame(function, batch, evaluate(function, i, 1, placement), i, text);
  }
}

}  // namespace

Outputs evaluate(const Function& function, std::int64_t first, std::int64_t count,
                 Placement placement) {
  return Call(function, first, count, placement).numbers();
}

void requireFinite(const Function& function, const Outputs& outputs, const std::string& where) {
  for (std::size_t a = 0; a < outputs.size(); ++a) {
    for (std::size_t i = 0; i < outputs[a].size(); ++i) {
      if (std::isfinite(outputs[a][i])) continue;
      throw Defect(place(function.outputs[a], i) + " is not finite " + where);
    }
  }
}

void addFunctionChecks(const std::string& name, const std::function<Function()>& make,
                       Checks& checks) {
  const auto add = [&](const char* check, const std::function<void(const Function&)>& body) {
    checks.push_back({name + "." + check, [make, body] {
                        const Function function = make();
                        if (function.count == 0) throw Skip("no valid input was found");
                        body(function);
                      }});
  };
  // Overrun first: what it finds may bring down what comes after.
  add("overrun", requireInBounds);
  add("written", requireWritten);
  add("finite", [](const Function& function) {
    requireFinite(function, evaluate(function, 0, function.count), "at valid values");
  });
  add("inputs", requireInputsUntouched);
  add("batch", requireItemsAlone);
  add("state", requireNoState);
  add("threads", requireThreadSafe);
  add("alignment", [](const Function& function) {
    requirePlacement(function, Placement::kOdd, "results depend on where the buffers lie");
  });
  add("bounds", [](const Function& function) {
    requirePlacement(function, Placement::kAtPageEnd, "results depend on where the buffers lie");
    requirePlacement(function, Placement::kAtPageBegin, "results depend on where the buffers lie");
  });
}

}  // namespace graft::conformance
