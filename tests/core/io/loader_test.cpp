// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstring>

#include "core/io/graph_loader.hpp"
#include "core/plugin/engine.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

// A loader as a plugin would register it, here inside the test program.

namespace graft {
namespace {

int recognizes(const char*, const char* head, std::int64_t size) {
  return size >= 4 && std::memcmp(head, "PAIR", 4) == 0 ? 1 : 0;
}

int load(const char* path, const graft_graph_sink* sink) {
  const double origin[] = {0, 0, 0};
  const double far[] = {5, 0, 0};
  const std::int64_t ids[] = {10, 20};
  const double measurement[] = {1, 0, 0};
  const double information[] = {1, 0, 0, 1, 0, 1};
  const std::string text = testing::readTestFile(path);
  const auto has = [&text](const char* word) { return text.find(word) != std::string::npos; };
  if (has("early")) sink->set_kernel(sink->host, "PairKernel", 2, 2);
  const char* tag = has("lost") ? "EDGE_OF_NOBODY" : "EDGE_SE2";
  sink->add_edge(sink->host, tag, 2, ids, 0, nullptr, 3, measurement, 6, information, 3);
  if (has("robust")) {
    sink->set_kernel(sink->host, has("unheard") ? "PairKernels" : "PairKernel",
                     has("narrow") ? 0 : 2.5, 4);
    sink->set_level(sink->host, has("below") ? -1 : 3, 5);
  }
  if (has("twice")) {
    sink->set_kernel(sink->host, "PairKernel", 2, 6);
    sink->set_level(sink->host, 1, 7);
  }
  if (has("robust")) {
    sink->add_edge(sink->host, "EDGE_SE2", 2, ids, 0, nullptr, 3, measurement, 6, information, 8);
  }
  sink->add_vertex(sink->host, "VERTEX_SE2", 10, origin, 3, 1);
  sink->add_vertex(sink->host, "VERTEX_SE2", 20, far, 3, 2);
  sink->fix_vertex(sink->host, 10, 4);
  if (has("bad")) {
    sink->report(sink->host, 2, nullptr, 7, 3, "this is bad");
    return GRAFT_FAILED;
  }
  if (has("mute")) return GRAFT_FAILED;
  if (has("wrong")) {
    sink->add_vertex(sink->host, "VERTEX_SE2", 30, far, 2, 9);
  }
  sink->report(sink->host, 0, "other.csv", 1, 0, "just saying");
  return GRAFT_OK;
}

const graft_loader_type kPairLoader = {
    sizeof(graft_loader_type), "pair", "two poses", ".pair", &recognizes, &load};

const graft_kernel_type kPairKernel = {sizeof(graft_kernel_type), "PairKernel", "s as it is",
                                       [](std::int64_t, const double*, double, double*) {}};

int registerLoader(const graft_registrar* registrar, graft_message*) {
  registrar->add_kernel_type(registrar->host, &kPairKernel);
  registrar->add_loader_type(registrar->host, &kPairLoader);
  return GRAFT_OK;
}

class LoaderTest : public ::testing::Test {
 protected:
  LoaderTest() {
    engine.registry().registerPlugin("pair", "here", "1", "BSD-3-Clause", &registerLoader);
  }
  LoadedGraph loadText(const std::string& text) {
    return testing::loadText(text, engine.registry(), diagnostics, options, "graph.pair");
  }
  std::string failure(const std::string& text) {
    try {
      loadText(text);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::kInput);
      return e.formatted();
    }
    return "no error";
  }

  Engine engine;
  LoadOptions options;
  Diagnostics diagnostics;
};

TEST_F(LoaderTest, FillsAGraphInAnyOrder) {
  const LoadedGraph loaded = loadText("PAIR");
  EXPECT_EQ(loaded.format, "pair");
  EXPECT_EQ(loaded.counts.vertices, 2u);
  EXPECT_EQ(loaded.counts.edges, 1u);
  EXPECT_TRUE(loaded.graph.isFixed(loaded.graph.find(10)));
  EXPECT_NE(diagnostics.text().find("other.csv:1: note: just saying"), std::string::npos);
}

TEST_F(LoaderTest, ItsErrorsHaveLines) {
  EXPECT_NE(failure("PAIR bad").find("graph.pair:7:3: error: this is bad"), std::string::npos);
}

TEST_F(LoaderTest, AFailureWithoutAReasonIsStillAnError) {
  EXPECT_NE(failure("PAIR mute").find("the loader pair failed without saying why"),
            std::string::npos);
}

TEST_F(LoaderTest, WrongCountsAreItsErrors) {
  EXPECT_NE(failure("PAIR wrong").find("graph.pair:9: error: VERTEX_SE2: expected 3 numbers"),
            std::string::npos);
}

TEST_F(LoaderTest, EdgesHaveKernelsAndLevels) {
  const LoadedGraph loaded = loadText("PAIR robust");
  ASSERT_EQ(loaded.graph.edgeBlocks().size(), 1u);
  const EdgeBlock& edges = loaded.graph.edgeBlocks().front();
  EXPECT_EQ(edges.levels, (std::vector<std::int32_t>{3, 0}));
  ASSERT_EQ(edges.kernels, (std::vector<std::int32_t>{0, -1}));
  EXPECT_STREQ(loaded.graph.kernels()[0].type->name, "PairKernel");
  EXPECT_EQ(loaded.graph.kernels()[0].width, 2.5);
}

TEST_F(LoaderTest, WhatIsWrongWithKernelsAndLevelsIsSaid) {
  const std::pair<const char*, const char*> cases[] = {
      {"PAIR robust unheard",
       "graph.pair:4: error: unknown robust kernel 'PairKernels' (did you mean PairKernel?)"},
      {"PAIR robust narrow",
       "graph.pair:4: error: the width of a robust kernel must be positive, got 0"},
      {"PAIR robust below", "graph.pair:5: error: expected a level from 0 to 2147483647, got '-1'"},
      {"PAIR robust twice", "graph.pair:6: error: the edge of line 3 has a robust kernel already"},
      {"PAIR robust twice", "graph.pair:7: error: the edge of line 3 has a level already"},
      {"PAIR early", "graph.pair:2: error: a robust kernel without an edge before it"}};
  for (const auto& [text, said] : cases) {
    diagnostics.clear();
    const std::string all = failure(text);
    EXPECT_NE(all.find(said), std::string::npos) << text << '\n' << all << diagnostics.text();
  }
}

TEST_F(LoaderTest, KernelsOfEdgesThatWereNotReadAreSkipped) {
  options.lenient = true;
  const LoadedGraph loaded = loadText("PAIR robust lost");
  EXPECT_EQ(loaded.graph.edgeBlocks().front().levels, (std::vector<std::int32_t>{0}));
  EXPECT_EQ(loaded.graph.edgeBlocks().front().kernels, (std::vector<std::int32_t>{-1}));
  for (const char* said : {"graph.pair:4: warning: a robust kernel of an edge that was not read",
                           "graph.pair:5: warning: a level of an edge that was not read"}) {
    EXPECT_NE(diagnostics.text().find(said), std::string::npos) << diagnostics.text();
  }
}

TEST_F(LoaderTest, OtherTextGoesToTheBuiltInReader) {
  EXPECT_EQ(loadText("VERTEX_SE2 0 1 2 3\n").format, "g2o");
}

}  // namespace
}  // namespace graft
