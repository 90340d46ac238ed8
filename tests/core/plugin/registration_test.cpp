// SPDX-License-Identifier: BSD-3-Clause
// What a registration may not offer: each is refused whole, with type and field.
#include <gtest/gtest.h>

#include "core/types/plugin.hpp"
#include "core/types/registry.hpp"

namespace graft {
namespace {

struct Offer {
  graft_vertex_type vertex = vertexType<SE2>();
  graft_edge_type edge = {};
  graft_kernel_type kernel = {};
  graft_resource_type resource = {};
  graft_solver_type solver = {};
  graft_loader_type loader = {};

  Offer() {
    static const char* const slots[] = {"VERTEX_SE2"};
    edge.struct_size = sizeof edge;
    edge.tag = "EDGE";
    edge.doc = "doc";
    edge.fields = "";
    edge.arity = edge.error_dim = edge.measurement_dim = 1;
    edge.slot_types = slots;
    edge.normalize = [](std::int32_t, double*, graft_message*) -> int { return GRAFT_OK; };
    edge.evaluate = [](const graft_edge_batch*, double*, double*, graft_message*) -> int {
      return GRAFT_OK;
    };
    kernel = {sizeof kernel, "KERNEL", "doc", [](std::int64_t, const double*, double, double*) {}};
    resource = {sizeof resource,
                "RESOURCE",
                "doc",
                "",
                [](const char*, std::int32_t, const char* const*, graft_message*) -> const void* {
                  return nullptr;
                },
                [](const void*) {}};
    solver = {sizeof solver,
              "SOLVER",
              "doc",
              "BSD-3-Clause",
              [](std::int32_t) -> void* { return nullptr; },
              [](void*) {},
              [](void*, const graft_block_pattern*, graft_message*) -> int { return GRAFT_OK; },
              [](void*, const double*, const double*, std::int32_t*, graft_message*) -> int {
                return GRAFT_OK;
              },
              [](void*, const double*, double*, graft_message*) -> int { return GRAFT_OK; },
              nullptr};
    loader = {sizeof loader,
              "LOADER",
              "doc",
              "",
              [](const char*, const char*, std::int64_t) -> int { return 0; },
              [](const char*, const graft_graph_sink*) -> int { return GRAFT_OK; }};
  }
};

const Offer* offered = nullptr;

int registerOffer(const graft_registrar* registrar, graft_message*) {
  registrar->add_vertex_type(registrar->host, &offered->vertex);
  registrar->add_edge_type(registrar->host, &offered->edge);
  registrar->add_kernel_type(registrar->host, &offered->kernel);
  registrar->add_resource_type(registrar->host, &offered->resource);
  registrar->add_solver_type(registrar->host, &offered->solver);
  registrar->add_loader_type(registrar->host, &offered->loader);
  return GRAFT_OK;
}

/// Empty, or why the registry refuses it.
std::string refusal(const Offer& offer, std::size_t expected = 6) {
  offered = &offer;
  Registry registry;
  try {
    registry.registerPlugin("offer", "/here/offer.so", "1", "BSD-3-Clause", &registerOffer);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kPlugin);
    EXPECT_EQ(e.where().path, "/here/offer.so");
    EXPECT_TRUE(registry.provided().empty()) << "something stayed";
    EXPECT_TRUE(registry.plugins().empty());
    return e.what();
  }
  EXPECT_EQ(registry.provided().size(), expected);
  return "";
}

TEST(Registration, AGoodOfferIsTaken) { EXPECT_EQ(refusal(Offer()), ""); }

struct Defective {
  void (*spoil)(Offer&);
  const char* message;
};

TEST(Registration, EveryDefectIsRefusedWithTypeAndField) {
  static const std::string long_tag(256, 'x');
  const Defective cases[] = {
      {[](Offer& o) { o.vertex.tag = nullptr; }, "a type without a name"},
      {[](Offer& o) { o.vertex.tag = ""; }, "a type without a name"},
      {[](Offer& o) { o.vertex.tag = "two words"; }, "has blanks or control bytes"},
      {[](Offer& o) { o.edge.tag = "line\nbreak"; }, "has blanks or control bytes"},
      {[](Offer& o) { o.edge.tag = "#comment"; }, "has blanks or control bytes"},
      {[](Offer& o) { o.kernel.name = long_tag.c_str(); }, "too long"},
      {[](Offer& o) { o.vertex.doc = ""; }, "VERTEX_SE2: doc is empty"},
      {[](Offer& o) { o.vertex.struct_size = 8; }, "VERTEX_SE2: struct_size is 8, expected "},
      {[](Offer& o) { o.solver.struct_size = 8; }, "SOLVER: struct_size is 8, expected "},
      {[](Offer& o) { o.vertex.ambient_dim = 0; }, "VERTEX_SE2: ambient_dim"},
      {[](Offer& o) { o.vertex.ambient_dim = -1; }, "VERTEX_SE2: ambient_dim"},
      {[](Offer& o) { o.vertex.tangent_dim = 1000000000; }, "VERTEX_SE2: tangent_dim"},
      {[](Offer& o) { o.vertex.plus = nullptr; }, "VERTEX_SE2: a callback is null"},
      {[](Offer& o) { o.edge.arity = 0; }, "EDGE: arity"},
      {[](Offer& o) { o.edge.arity = 1000000000; }, "EDGE: arity"},
      {[](Offer& o) { o.edge.error_dim = 0; }, "EDGE: error_dim"},
      {[](Offer& o) { o.edge.error_dim = 1000000000; }, "EDGE: error_dim"},
      {[](Offer& o) { o.edge.error_dim = GRAFT_DYNAMIC; }, "EDGE: only types of dynamic arity"},
      {[](Offer& o) { o.edge.measurement_dim = -2; }, "EDGE: measurement_dim"},
      {[](Offer& o) { o.edge.association_dim = 3; }, "EDGE: association_dim and associate()"},
      {[](Offer& o) { o.edge.arity = GRAFT_DYNAMIC; }, "EDGE: shape() goes with dynamic arity"},
      {[](Offer& o) { o.edge.slot_types = nullptr; }, "EDGE: slot_types is null"},
      {[](Offer& o) { o.edge.resource_count = 1; }, "EDGE: resource_types is null"},
      {[](Offer& o) { o.edge.resource_count = -1; }, "EDGE: resource_count"},
      {[](Offer& o) { o.edge.evaluate = nullptr; }, "EDGE: a callback is null"},
      {[](Offer& o) { o.kernel.evaluate = nullptr; }, "KERNEL: a callback is null"},
      {[](Offer& o) { o.resource.destroy = nullptr; }, "RESOURCE: a callback is null"},
      {[](Offer& o) { o.solver.create = nullptr; }, "SOLVER: a callback is null"},
      {[](Offer& o) { o.loader.load = nullptr; }, "LOADER: a callback is null"},
  };
  for (const Defective& one : cases) {
    Offer offer;
    one.spoil(offer);
    const std::string text = refusal(offer);
    EXPECT_EQ(text.rfind("invalid type: ", 0), 0u) << text;
    EXPECT_NE(text.find(one.message), std::string::npos) << text << " instead of " << one.message;
  }
}

TEST(Registration, ATypeTwiceInOnePluginIsRefused) {
  Offer offer;
  offer.kernel.name = "SAME";
  offered = &offer;
  Registry registry;
  const auto twice = [](const graft_registrar* registrar, graft_message*) -> int {
    registrar->add_kernel_type(registrar->host, &offered->kernel);
    registrar->add_kernel_type(registrar->host, &offered->kernel);
    return GRAFT_OK;
  };
  try {
    registry.registerPlugin("offer", "/here/offer.so", "1", "BSD-3-Clause", twice);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("SAME is provided already by the same plugin"),
              std::string::npos)
        << e.what();
  }
  EXPECT_TRUE(registry.provided().empty());
}

}  // namespace
}  // namespace graft
