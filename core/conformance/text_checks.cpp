// SPDX-License-Identifier: BSD-3-Clause
#include "core/conformance/text_checks.hpp"

#include "core/base/text.hpp"
#include "core/io/g2o_reader.hpp"
#include "core/io/g2o_writer.hpp"

namespace graft::conformance {

namespace {

void appendNumbers(std::string& text, const double* numbers, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    text += ' ';
    appendDouble(text, numbers[i]);
  }
}

LoadedGraph read(const Context& context, const std::string& text) {
  LoadOptions options;
  Diagnostics diagnostics;
  // Resources refer to files beside the example.
  const std::string path = exampleDirectory(context) + "/conformance.g2o";
  GraphBuilder builder(path, context.registry, options, diagnostics);
  readG2o(text, builder);
  LoadedGraph loaded = builder.finish();
  if (diagnostics.errorCount() > 0) throw Defect("cannot be read back: " + diagnostics.lines()[0]);
  return loaded;
}

/// Reads `text`, and requires that writing and reading it again changes nothing.
LoadedGraph requireRoundTrip(const Context& context, const std::string& text) {
  LoadedGraph first = read(context, text);
  const std::string written = formatG2o(first.graph, first.values);
  const LoadedGraph second = read(context, written);
  if (formatG2o(second.graph, second.values) != written) {
    throw Defect("written, read and written again is another text");
  }
  return first;
}

}  // namespace

void requireVertexText(const Context& context, const graft_vertex_type& type) {
  Random random(context.options.seed);
  std::string text;
  std::vector<std::vector<double>> estimates;
  for (int i = 0; i < context.options.samples; ++i) {
    estimates.push_back(randomEstimate(type, random, i));
    text += std::string(type.tag) + ' ' + std::to_string(i);
    appendNumbers(text, estimates.back().data(), estimates.back().size());
    text += '\n';
  }
  const LoadedGraph loaded = requireRoundTrip(context, text);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const double* read = loaded.values.at(loaded.graph.find(std::int64_t(i)));
    if (!sameBits(read, estimates[i].data(), estimates[i].size())) {
      throw Defect("an estimate that is written and read loses bits");
    }
  }
}

void requireEdgeText(const Context& context, const EdgeSamples& samples) {
  const graft_edge_type& type = *samples.type;
  Random random(context.options.seed);
  std::string text;
  std::int64_t id = 0;
  std::string resource_ids;
  for (std::size_t r = 0; r < samples.resources.size(); ++r) {
    text += std::string(type.resource_types[r]) + ' ' + std::to_string(r);
    for (const std::string& token : samples.resources[r].tokens) text += ' ' + token;
    text += '\n';
    resource_ids += ' ' + std::to_string(r);
  }
  for (std::int64_t e = 0; e < samples.count; ++e) {
    std::string line = type.tag;
    for (std::size_t k = 0; k < samples.slots.size(); ++k, ++id) {
      const auto dim = static_cast<std::size_t>(samples.slots[k]->ambient_dim);
      text += std::string(samples.slots[k]->tag) + ' ' + std::to_string(id);
      appendNumbers(text, samples.vertices[k].data() + std::size_t(e) * dim, dim);
      text += '\n';
      line += ' ' + std::to_string(id);
    }
    if (type.arity == GRAFT_DYNAMIC) line += " ||";
    line += resource_ids;
    const auto dim = static_cast<std::size_t>(samples.measurement_dim);
    appendNumbers(line, samples.measurements.data() + std::size_t(e) * dim, dim);
    const std::vector<double> information = randomInformation(samples.error_dim, random);
    appendNumbers(line, information.data(), information.size());
    text += line + '\n';
  }
  const LoadedGraph loaded = requireRoundTrip(context, text);
  for (const EdgeBlock& block : loaded.graph.edgeBlocks()) {
    if (!sameBits(block.measurements.data(), samples.measurements.data(),
                  samples.measurements.size())) {
      throw Defect("a measurement that is written and read loses bits");
    }
  }
}

}  // namespace graft::conformance
