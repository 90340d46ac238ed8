// SPDX-License-Identifier: BSD-3-Clause
#include "core/conformance/sampler.hpp"

#include <cmath>
#include <sstream>

#include "core/base/text.hpp"
#include "core/conformance/buffer.hpp"
#include "core/io/graph_loader.hpp"

namespace graft::conformance {

namespace {

constexpr int kTrials = 300;

bool allFinite(const std::vector<double>& numbers) {
  for (const double x : numbers) {
    if (!std::isfinite(x)) return false;
  }
  return true;
}

/// Kinds of numbers to try, from common to special.
double trialNumber(int trial, Random& random) {
  switch (trial % 5) {
    case 0:
      return random.normal();
    case 1:
      return std::abs(random.normal());
    case 2:
      return random.uniform(0, 1);
    case 3:
      return std::floor(random.uniform(1, 6));
    default:
      return 5 * random.normal();
  }
}

}  // namespace

double Random::uniform(double low, double high) {
  return low + (high - low) * (double(engine_() >> 11) * 0x1p-53);
}

double Random::normal() {
  double sum = 0;
  for (int i = 0; i < 12; ++i) sum += uniform(0, 1);
  return sum - 6;
}

std::vector<double> randomEstimate(const graft_vertex_type& type, Random& random, int index) {
  constexpr double kScales[] = {1, 0.3, 3};
  const double scale = kScales[index % 3];
  const auto size = static_cast<std::size_t>(type.ambient_dim);
  const std::vector<double> x = guardedNumbers(size, type.identity);
  std::vector<double> delta(static_cast<std::size_t>(type.tangent_dim));
  for (double& d : delta) d = scale * random.normal();
  return guardedNumbers(size, [&](double* moved) { type.plus(1, x.data(), delta.data(), moved); });
}

std::vector<double> randomMeasurement(const graft_edge_type& type, int dim, Random& random,
                                      std::string& why) {
  std::vector<double> numbers(static_cast<std::size_t>(dim));
  for (int trial = 0; trial < kTrials; ++trial) {
    graft_message message = {};
    int status = GRAFT_FAILED;
    numbers = guardedNumbers(numbers.size(), [&](double* trial_numbers) {
      for (int i = 0; i < dim; ++i) trial_numbers[i] = trialNumber(trial, random);
      status = type.normalize(dim, trial_numbers, &message);
    });
    if (status == GRAFT_OK && allFinite(numbers)) return numbers;
    why = message.text;
  }
  return {};
}

std::vector<double> randomInformation(int dim, Random& random) {
  const auto n = static_cast<std::size_t>(dim);
  std::vector<double> root(n * n);
  for (double& x : root) x = random.normal() / std::sqrt(double(n));
  std::vector<double> upper;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::size_t c = r; c < n; ++c) {
      double sum = r == c ? 1 : 0;
      for (std::size_t k = 0; k < n; ++k) sum += root[k * n + r] * root[k * n + c];
      upper.push_back(sum);
    }
  }
  return upper;
}

std::vector<std::string> wordsOf(const char* text) {
  std::istringstream stream(text != nullptr ? text : "");
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::string exampleDirectory(const Context& context) {
  return context.options.example.empty() ? "." : directoryOf(context.options.example);
}

ResourceSample sampleResource(const Context& context, const graft_resource_type& type) {
  if (context.example != nullptr) {
    for (const Resource& one : context.example->resources()) {
      if (std::string(one.type->tag) == type.tag) return {one.tokens, one.data};
    }
  }
  const std::size_t fields = wordsOf(type.fields).size();
  Random random(context.options.seed);
  std::string why;
  for (int trial = 0; trial < kTrials; ++trial) {
    // At first the numbers of a pose: zeros, and one last.
    std::vector<std::string> tokens;
    for (std::size_t i = 0; i < fields; ++i) {
      const double last = i + 1 == fields ? 1 : 0;
      tokens.push_back(formatDouble(trial == 0 ? last : trialNumber(trial, random)));
    }
    std::vector<const char*> pointers;
    pointers.reserve(tokens.size());
    for (const std::string& token : tokens) pointers.push_back(token.c_str());
    graft_message message = {};
    const void* loaded =
        type.load(exampleDirectory(context).c_str(), static_cast<std::int32_t>(tokens.size()),
                  pointers.data(), &message);
    if (loaded != nullptr) {
      return {tokens, std::shared_ptr<const void>(
                          loaded, [&type](const void* resource) { type.destroy(resource); })};
    }
    why = message.text;
  }
  throw Skip(std::string("no ") + type.tag +
             " could be made from numbers; give a graph that has one with --graph (" + why + ")");
}

}  // namespace graft::conformance
