// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstring>

#include "core/io/graph_loader.hpp"
#include "core/plugin/engine.hpp"
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
  sink->add_edge(sink->host, "EDGE_SE2", 2, ids, 0, nullptr, 3, measurement, 6, information, 3);
  sink->add_vertex(sink->host, "VERTEX_SE2", 10, origin, 3, 1);
  sink->add_vertex(sink->host, "VERTEX_SE2", 20, far, 3, 2);
  sink->fix_vertex(sink->host, 10, 4);
  const std::string text = testing::readTestFile(path);
  if (text.find("bad") != std::string::npos) {
    sink->report(sink->host, 2, nullptr, 7, 3, "this is bad");
    return GRAFT_FAILED;
  }
  if (text.find("mute") != std::string::npos) return GRAFT_FAILED;
  if (text.find("wrong") != std::string::npos) {
    sink->add_vertex(sink->host, "VERTEX_SE2", 30, far, 2, 9);
  }
  sink->report(sink->host, 0, "other.csv", 1, 0, "just saying");
  return GRAFT_OK;
}

const graft_loader_type kPairLoader = {
    sizeof(graft_loader_type), "pair", "two poses", ".pair", &recognizes, &load};

int registerLoader(const graft_registrar* registrar, graft_message*) {
  registrar->add_loader_type(registrar->host, &kPairLoader);
  return GRAFT_OK;
}

class LoaderTest : public ::testing::Test {
 protected:
  LoaderTest() {
    engine.registry().registerPlugin("pair", "here", "1", "BSD-3-Clause", &registerLoader);
  }
  LoadedGraph loadText(const std::string& text) {
    const std::string path =
        testing::writeTestFile(testing::makeTemporaryDirectory(), "graph.pair", text);
    return loadGraph(path, engine.registry(), {}, diagnostics);
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

TEST_F(LoaderTest, OtherTextGoesToTheBuiltInReader) {
  EXPECT_EQ(loadText("VERTEX_SE2 0 1 2 3\n").format, "g2o");
}

}  // namespace
}  // namespace graft
