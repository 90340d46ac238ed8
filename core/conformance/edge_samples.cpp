// SPDX-License-Identifier: BSD-3-Clause
#include "core/conformance/edge_samples.hpp"

#include <algorithm>

namespace graft::conformance {

namespace {

constexpr int kLargestArity = 8;

void append(std::vector<double>& to, const double* numbers, int count) {
  to.insert(to.end(), numbers, numbers + count);
}

/// Arity and dimensions: declared, or the first (second) that shape() accepts.
void chooseShape(EdgeSamples& samples, bool larger) {
  const graft_edge_type& type = *samples.type;
  if (type.arity != GRAFT_DYNAMIC) {
    samples.arity = type.arity;
    samples.error_dim = type.error_dim;
    samples.measurement_dim = type.measurement_dim;
    return;
  }
  int wanted = larger ? 2 : 1;
  for (int arity = 1; arity <= kLargestArity; ++arity) {
    graft_message message = {};
    std::int32_t errors = -1;
    std::int32_t measurements = -1;
    if (type.shape(arity, &errors, &measurements, &message) != GRAFT_OK) continue;
    if (errors <= 0 || measurements < 0) {
      throw Defect("shape() accepts " + std::to_string(arity) + " vertices with " +
                   std::to_string(errors) + " errors and " + std::to_string(measurements) +
                   " measured numbers");
    }
    if (--wanted > 0) continue;
    samples.arity = arity;
    samples.error_dim = errors;
    samples.measurement_dim = measurements;
    return;
  }
  throw Skip(std::string("shape() accepts ") + (larger ? "one number" : "no number") +
             " of vertices up to " + std::to_string(kLargestArity));
}

void chooseSlots(const Context& context, EdgeSamples& samples) {
  for (int k = 0; k < samples.arity; ++k) {
    const char* tag = slotType(*samples.type, k);
    const graft_vertex_type* vertex = context.registry.vertex(tag);
    if (vertex == nullptr) {
      throw Defect(std::string("slot ") + std::to_string(k + 1) + " takes " + tag +
                   ", which no plugin provides that is known or required");
    }
    samples.slots.push_back(vertex);
    samples.tangent_dim += vertex->tangent_dim;
  }
  samples.vertices.resize(samples.slots.size());
}

bool fits(const EdgeSamples& samples, const EdgeBlock& block, std::size_t e) {
  return block.arity(e) == samples.arity && block.error_dims[e] == samples.error_dim &&
         block.measurementDim(e) == samples.measurement_dim;
}

/// Takes edges of the example that share the resources of the first.
void takeExamples(const Context& context, EdgeSamples& samples) {
  if (context.example == nullptr) return;
  const int resource_count = samples.type->resource_count;
  for (const EdgeBlock& block : context.example->edgeBlocks()) {
    if (block.type != samples.type) continue;
    const std::int32_t* chosen = nullptr;
    for (std::size_t e = 0; e < block.size(); ++e) {
      if (samples.count >= context.options.samples / 2) return;
      if (!fits(samples, block, e)) continue;
      const std::int32_t* resources = block.resources.data() + e * std::size_t(resource_count);
      if (chosen == nullptr) {
        chosen = resources;
        for (int r = 0; r < resource_count; ++r) {
          const Resource& one = context.example->resources()[std::size_t(chosen[r])];
          samples.resources.push_back({one.tokens, one.data});
        }
      }
      if (!std::equal(resources, resources + resource_count, chosen)) continue;
      for (std::size_t k = 0; k < samples.slots.size(); ++k) {
        const VertexRef v = block.vertices[std::size_t(block.vertex_begin[e]) + k];
        append(samples.vertices[k], context.example_values->at(v), samples.slots[k]->ambient_dim);
      }
      append(samples.measurements, block.measurements.data() + block.measurement_begin[e],
             samples.measurement_dim);
      ++samples.count;
    }
  }
}

void addRandom(const Context& context, EdgeSamples& samples) {
  Random random(context.options.seed);
  const std::int64_t examples = samples.count;
  for (int i = 0; samples.count < context.options.samples; ++i) {
    std::string why;
    std::vector<double> measurement =
        randomMeasurement(*samples.type, samples.measurement_dim, random, why);
    if (samples.measurement_dim > 0 && measurement.empty()) {
      if (examples == 0) {
        throw Skip(
            "no random numbers are a measurement; give a graph that has some with --graph "
            "(" +
            why + ")");
      }
      const double* example =
          samples.measurements.data() + std::ptrdiff_t(i % examples) * samples.measurement_dim;
      measurement.assign(example, example + samples.measurement_dim);
    }
    for (std::size_t k = 0; k < samples.slots.size(); ++k) {
      const std::vector<double> x = randomEstimate(*samples.slots[k], random, i);
      append(samples.vertices[k], x.data(), int(x.size()));
    }
    append(samples.measurements, measurement.data(), samples.measurement_dim);
    ++samples.count;
  }
}

}  // namespace

Batch::Batch(const EdgeSamples& samples, std::int64_t count,
             const std::vector<const double*>& vertices, const double* measurements,
             const double* associations) {
  const graft_edge_type& type = *samples.type;
  for (const ResourceSample& one : samples.resources) edge_resources_.push_back(one.data.get());
  const auto dim = static_cast<std::size_t>(samples.error_dim);
  identity_.assign(dim * dim, 0.0);
  for (std::size_t i = 0; i < dim; ++i) identity_[i * dim + i] = 1;
  for (std::int64_t e = 0; e < count; ++e) {
    for (std::size_t k = 0; k < samples.slots.size(); ++k) {
      vertices_.push_back(vertices[k] + e * samples.slots[k]->ambient_dim);
    }
    // As the engine does, a pointer for every edge, even to no numbers.
    measurements_.push_back(measurements != nullptr ? measurements + e * samples.measurement_dim
                                                    : identity_.data());
    if (associations != nullptr) associations_.push_back(associations + e * type.association_dim);
    information_.push_back(identity_.data());
    resources_.push_back(edge_resources_.data());
  }
  batch_.struct_size = sizeof batch_;
  batch_.arity = samples.arity;
  batch_.error_dim = samples.error_dim;
  batch_.measurement_dim = samples.measurement_dim;
  batch_.association_dim = type.association_dim;
  batch_.resource_count = type.resource_count;
  batch_.count = count;
  batch_.vertices = vertices_.data();
  batch_.measurements = measurements_.data();
  batch_.associations = associations_.data();
  batch_.information = information_.data();
  batch_.resources = resources_.data();
}

EdgeSamples sampleEdges(const Context& context, const graft_edge_type& type, bool larger) {
  EdgeSamples samples;
  samples.type = &type;
  chooseShape(samples, larger);
  chooseSlots(context, samples);
  takeExamples(context, samples);
  if (samples.resources.empty()) {
    for (int r = 0; r < type.resource_count; ++r) {
      const graft_resource_type* resource = context.registry.resource(type.resource_types[r]);
      if (resource == nullptr) {
        throw Defect(std::string("it uses ") + type.resource_types[r] +
                     ", which no plugin provides that is known or required");
      }
      samples.resources.push_back(sampleResource(context, *resource));
    }
  }
  addRandom(context, samples);
  if (type.associate != nullptr) {
    samples.associations = evaluate(associateFunction(samples), 0, samples.count)[0];
  }
  return samples;
}

EdgeSamples atIdentity(EdgeSamples samples) {
  for (std::size_t k = 0; k < samples.slots.size(); ++k) {
    const int dim = samples.slots[k]->ambient_dim;
    for (std::int64_t e = 0; e < samples.count; ++e) {
      samples.slots[k]->identity(samples.vertices[k].data() + e * dim);
    }
  }
  if (samples.type->associate != nullptr) {
    samples.associations = evaluate(associateFunction(samples), 0, samples.count)[0];
  }
  return samples;
}

namespace {

/// Inputs that every callback of an edge has.
Function edgeFunction(const EdgeSamples& samples) {
  Function function;
  function.count = samples.count;
  for (std::size_t k = 0; k < samples.slots.size(); ++k) {
    function.inputs.push_back(
        {"vertices of slot " + std::to_string(k + 1), samples.slots[k]->ambient_dim});
    function.samples.push_back(samples.vertices[k]);
  }
  if (samples.measurement_dim > 0) {
    function.inputs.push_back({"measurements", samples.measurement_dim});
    function.samples.push_back(samples.measurements);
  }
  return function;
}

}  // namespace

Function evaluateFunction(const EdgeSamples& samples, bool jacobians) {
  Function function = edgeFunction(samples);
  const bool associated = samples.type->association_dim > 0;
  if (associated) {
    function.inputs.push_back({"associations", samples.type->association_dim});
    function.samples.push_back(samples.associations);
  }
  function.outputs.push_back({"errors", samples.error_dim});
  if (jacobians) function.outputs.push_back({"Jacobian", samples.error_dim * samples.tangent_dim});
  function.call = [samples, associated, jacobians](std::int64_t count, const auto& in,
                                                   const auto& out) {
    const std::size_t slots = samples.slots.size();
    const bool measured = samples.measurement_dim > 0;
    const Batch batch(samples, count, in, measured ? in[slots] : nullptr,
                      associated ? in[slots + (measured ? 1 : 0)] : nullptr);
    graft_message message = {};
    if (samples.type->evaluate(batch.get(), out[0], jacobians ? out[1] : nullptr, &message) !=
        GRAFT_OK) {
      throw Defect(std::string("evaluate() fails at valid values: ") + message.text);
    }
  };
  return function;
}

Function associateFunction(const EdgeSamples& samples) {
  Function function = edgeFunction(samples);
  function.outputs.push_back({"associations", samples.type->association_dim});
  function.call = [samples](std::int64_t count, const auto& in, const auto& out) {
    const std::size_t slots = samples.slots.size();
    const Batch batch(samples, count, in, samples.measurement_dim > 0 ? in[slots] : nullptr,
                      out[0]);
    std::vector<std::uint8_t> changed(std::size_t(count), 0);
    graft_message message = {};
    if (samples.type->associate(batch.get(), 1, out[0], changed.data(), &message) != GRAFT_OK) {
      throw Defect(std::string("associate() fails at valid values: ") + message.text);
    }
    for (const std::uint8_t one : changed) {
      if (one != 1) throw Defect("the first associate() does not set `changed` to 1");
    }
  };
  return function;
}

}  // namespace graft::conformance
