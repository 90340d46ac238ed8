// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "core/base/text.hpp"
#include "core/io/g2o_writer.hpp"
#include "core/io/graph_loader.hpp"
#include "core/plugin/engine.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

using testing::makeTemporaryDirectory;
using testing::writeTestFile;

constexpr const char* kUnit3 = " 1 0 0 1 0 1";

LoadedGraph load(const std::string& text, Engine& engine, Diagnostics& diagnostics,
                 const LoadOptions& options = {}) {
  return testing::loadText(text, engine.registry(), diagnostics, options);
}

LoadedGraph load(const std::string& text, const LoadOptions& options = {}) {
  static Engine engine;
  Diagnostics diagnostics;
  return load(text, engine, diagnostics, options);
}

std::string rewritten(const std::string& text) {
  const LoadedGraph loaded = load(text);
  return formatG2o(loaded.graph, loaded.values);
}

TEST(G2o, ReadsInAnyOrder) {
  const LoadedGraph loaded =
      load("FIX 7\nEDGE_SE2 3 7 1 2 0.5" + std::string(kUnit3) +
           "\n# a comment\n \t \nVERTEX_SE2 7 1 2 3 # and one at the end\nVERTEX_SE2 3 0 0 0");
  EXPECT_EQ(loaded.counts.vertices, 2u);
  EXPECT_EQ(loaded.counts.edges, 1u);
  EXPECT_EQ(loaded.counts.fixed, 1u);
  EXPECT_FALSE(loaded.vertices_made);
  const VertexRef v = loaded.graph.find(7);
  EXPECT_TRUE(loaded.graph.isFixed(v));
  EXPECT_EQ(loaded.values.at(v)[2], 3);
}

TEST(G2o, LineEndsAndByteOrderMarkDoNotMatter) {
  const std::string text =
      "VERTEX_SE2 0 1 2 3\nVERTEX_SE2 1 1 2 3\nEDGE_SE2 0 1 1 2 0.5" + std::string(kUnit3) + "\n";
  const std::string expected = rewritten(text);
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(rewritten(crlf), expected);
  EXPECT_EQ(rewritten("\xef\xbb\xbf" + text), expected);
  EXPECT_EQ(rewritten(text.substr(0, text.size() - 1)), expected);
}

TEST(G2o, EveryNumberKeepsEveryBit) {
  std::mt19937_64 random(42);
  std::string text;
  std::vector<double> numbers;
  for (int i = 0; i < 30000; ++i) {
    double value = 0;
    do {
      const std::uint64_t bits = random();
      std::memcpy(&value, &bits, sizeof value);
    } while (!std::isfinite(value));
    numbers.push_back(value);
  }
  numbers[0] = std::numeric_limits<double>::denorm_min();
  numbers[1] = -0.0;
  numbers[2] = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    text += "VERTEX_XY " + std::to_string(i) + ' ' + formatDouble(numbers[i]) + ' ' +
            formatDouble(numbers[i + 1]) + '\n';
  }
  const LoadedGraph loaded = load(text);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double* read = loaded.values.at(loaded.graph.find(std::int64_t(i - i % 2)));
    ASSERT_EQ(std::memcmp(&read[i % 2], &numbers[i], sizeof(double)), 0) << i;
  }
  EXPECT_EQ(formatG2o(loaded.graph, loaded.values), text);
}

TEST(G2o, WrittenTextDependsOnTheGraphAlone) {
  std::vector<std::string> lines = {"PARAMS_SE3OFFSET 4 0 0 1 0 0 0 1",
                                    "VERTEX_SE3:QUAT 9223372036854775807 1 2 3 0 0 0 1",
                                    "VERTEX_SE3:QUAT 0 1 2 3 0.5 0.5 0.5 0.5",
                                    "FIX 0",
                                    "VERTEX_XY 5 1 2",
                                    "VERTEX_SE2 6 1 2 3",
                                    "EDGE_SE2_XY 6 5 1 2 1 0 1",
                                    "EDGE_SE2_XY 6 5 1 1 1 0 1",
                                    "EDGE_SE2_XY 6 5 1 1 1 0 0.5"};
  const std::string unit6 = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
  lines.push_back("EDGE_SE3_PRIOR 0 4 1 2 3 0 0 0 1" + unit6);
  lines.push_back("EDGE_SE3:QUAT 0 9223372036854775807 1 2 3 0 0 0 1" + unit6);
  std::mt19937_64 random(1);
  std::string first;
  for (int round = 0; round < 20; ++round) {
    std::shuffle(lines.begin(), lines.end(), random);
    std::string text;
    for (const std::string& line : lines) text += line + '\n';
    const std::string written = rewritten(text);
    if (first.empty()) first = written;
    EXPECT_EQ(written, first);
    EXPECT_EQ(rewritten(written), written);
  }
  EXPECT_EQ(first.substr(0, first.find('\n')), "PARAMS_SE3OFFSET 4 0 0 1 0 0 0 1");
}

TEST(G2o, ReadingAndWritingTheSharedFilesIsStable) {
  for (const char* name : {"sphere2500", "intel", "dlr", "CSAIL"}) {
    const std::string path = std::string("pose_graphs/") + name + ".g2o";
    GRAFT_REQUIRE_DATA(path);
    const std::string once = rewritten(testing::readTestFile(testing::dataPath(path)));
    EXPECT_EQ(rewritten(once), once) << name;
  }
}

TEST(G2o, VerticesAreMadeAlongTheEdgesWhereThereAreNone) {
  Engine engine;
  Diagnostics diagnostics;
  const LoadedGraph loaded =
      load("EDGE_SE2_XY 1 2 1 2 1 0 1\nEDGE_SE2 1 3 1 2 0.5" + std::string(kUnit3) + "\nFIX 3\n",
           engine, diagnostics);
  EXPECT_TRUE(loaded.vertices_made);
  EXPECT_EQ(loaded.counts.made_vertices, 3u);
  EXPECT_STREQ(loaded.graph.type(loaded.graph.find(2)).tag, "VERTEX_XY");
  EXPECT_TRUE(loaded.graph.isFixed(loaded.graph.find(3)));
  EXPECT_NE(diagnostics.text().find("3 vertices made along the edges"), std::string::npos);
}

TEST(G2o, LenientSkipsUnknownTagsOnlyAndCountsThem) {
  Engine engine;
  Diagnostics diagnostics;
  LoadOptions options;
  options.lenient = true;
  const LoadedGraph loaded = testing::loadText("VERTEX_SE2 0 1 2 3\nFOO 1 2\nBAR\nFOO 3\n",
                                               engine.registry(), diagnostics, options);
  EXPECT_EQ(loaded.counts.skipped_lines, 3u);
  EXPECT_NE(diagnostics.text().find("g.g2o:3: warning: unknown tag 'BAR'"), std::string::npos);
  EXPECT_NE(diagnostics.text().find("3 lines with unknown tags skipped"), std::string::npos);
  EXPECT_THROW(load("VERTEX_SE2 0 1 2\n", options), Error);
}

TEST(G2o, IndefiniteInformationIsProjectedOnRequest) {
  const std::string text = "VERTEX_XY 0 0 0\nVERTEX_SE2 1 0 0 0\nEDGE_SE2_XY 1 0 1 2 1 2 1\n";
  EXPECT_THROW(load(text), Error);
  LoadOptions options;
  options.project_information = true;
  const LoadedGraph loaded = load(text, options);
  EXPECT_EQ(loaded.counts.projected, 1u);
  // Eigenvalues 3 and -1 of [1 2; 2 1] become 3 and 0: 1.5 everywhere.
  for (const double entry : loaded.graph.edgeBlocks().front().information) {
    EXPECT_NEAR(entry, 1.5, 1e-14);
  }
}

/// A resource whose one token is the name of a file.
const graft_resource_type kFileResource = {
    sizeof(graft_resource_type),
    "TEST_FILE",
    "a file",
    "name",
    [](const char* directory, std::int32_t, const char* const* tokens,
       graft_message*) -> const void* {
      return new std::string(testing::readTestFile(std::string(directory) + '/' + tokens[0]));
    },
    [](const void* resource) { delete static_cast<const std::string*>(resource); }};

TEST(G2o, ResourceFilesAreFoundFromWhereTheTextLies) {
  Engine engine;
  engine.registry().registerPlugin("file", "here", "1", "BSD-3-Clause",
                                   [](const graft_registrar* registrar, graft_message*) {
                                     registrar->add_resource_type(registrar->host, &kFileResource);
                                     return int(GRAFT_OK);
                                   });
  const std::string root = makeTemporaryDirectory();
  writeTestFile(root, "a/data.txt", "content");
  const std::string path =
      writeTestFile(root, "a/g.g2o", "TEST_FILE 3 data.txt\nVERTEX_XY 0 1 2\n");
  Diagnostics diagnostics;
  const LoadedGraph loaded = loadGraph(path, engine.registry(), {}, diagnostics);
  EXPECT_EQ(*static_cast<const std::string*>(loaded.graph.resources().front().data.get()),
            "content");
  const auto written = [&](const std::string& folder) {
    return formatG2o(loaded.graph, loaded.values, {root + "/a", folder});
  };
  EXPECT_EQ(written(root + "/a"), "TEST_FILE 3 data.txt\nVERTEX_XY 0 1 2\n");
  EXPECT_EQ(written(root + "/b"), "TEST_FILE 3 ../a/data.txt\nVERTEX_XY 0 1 2\n");
}

TEST(G2o, QuaternionsAreNormalised) {
  Engine engine;
  Diagnostics diagnostics;
  const LoadedGraph loaded =
      load("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1.000001\nVERTEX_SE3:QUAT 1 0 0 0 0 0 0.6 0.85\n", engine,
           diagnostics);
  EXPECT_EQ(loaded.values.at(loaded.graph.find(0))[6], 1.0);
  EXPECT_EQ(diagnostics.warningCount(), 2u);  // the length, and vertices without edges
  EXPECT_NE(diagnostics.text().find("g.g2o:2: warning: the quaternion has length 1.04"),
            std::string::npos);
}

/// A file cut anywhere is either a valid shorter file or an error with a line.
TEST(G2o, TruncationAtEveryByteIsNeverACrash) {
  const std::string text =
      "PARAMS_SE3OFFSET 1 0 0 0 0 0 0 1\nVERTEX_SE2 0 0.25 1 0\n"
      "VERTEX_SE2 1 1 2 3\nFIX 1\nEDGE_SE2 0 1 1 2 0.5" +
      std::string(kUnit3) + "\nVERTEX_XY 4 1 2\nEDGE_SE2_XY 1 4 1 2 1 0 1\n";
  int loaded_count = 0;
  for (std::size_t size = 0; size <= text.size(); ++size) {
    try {
      load(text.substr(0, size));
      ++loaded_count;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ExitCode::kInput);
      EXPECT_NE(e.formatted().find("g.g2o:"), std::string::npos) << e.formatted();
    }
  }
  EXPECT_GT(loaded_count, 6);
  EXPECT_LT(loaded_count, int(text.size()) / 2);
}

TEST(G2o, ALongListOfDefectsIsCutAndCounted) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += "VERTEX_SE2 " + std::to_string(i) + " nan 0 0\n";
  try {
    load(text);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(e.formatted().find("g.g2o:20:15: error:"), std::string::npos);
    EXPECT_EQ(e.formatted().find("g.g2o:21:"), std::string::npos);
    EXPECT_NE(e.formatted().find("... and 30 more errors"), std::string::npos);
  }
}

TEST(G2o, KernelsAndLevelsBelongToTheEdgeBefore) {
  const std::string text =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 2 0 0\n"
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nROBUST_KERNEL Huber 1.5\nG2O_EDGE_LEVEL 2\n"
      "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\nROBUST_KERNEL Cauchy 0.1\n"
      "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\nG2O_EDGE_LEVEL 1\n"
      "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n";
  const LoadedGraph loaded = load(text);
  const EdgeBlock& block = loaded.graph.edgeBlocks().front();
  EXPECT_EQ(block.levels, (std::vector<std::int32_t>{2, 0, 1, 0}));
  ASSERT_EQ(loaded.graph.kernels().size(), 2u);
  EXPECT_STREQ(loaded.graph.kernels()[std::size_t(block.kernels[0])].type->name, "Huber");
  EXPECT_EQ(loaded.graph.kernels()[std::size_t(block.kernels[0])].width, 1.5);
  EXPECT_STREQ(loaded.graph.kernels()[std::size_t(block.kernels[1])].type->name, "Cauchy");
  EXPECT_EQ(block.kernels[2], -1);
  EXPECT_EQ(block.kernels[3], -1);
  // Kernels are shared where name and width are the same, not one of them.
  const std::string edge = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
  const std::string vertices = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";
  const LoadedGraph many =
      load(vertices + edge + "ROBUST_KERNEL Huber 1.5\n" + edge + "ROBUST_KERNEL Huber 2\n" + edge +
           "ROBUST_KERNEL Cauchy 1.5\n" + edge + "ROBUST_KERNEL Huber 1.5\n");
  EXPECT_EQ(many.graph.edgeBlocks().front().kernels, (std::vector<std::int32_t>{0, 1, 2, 0}));
  const std::string written = rewritten(text);
  EXPECT_EQ(rewritten(written), written);
  // The two edges that differ in their level alone are written by rising level.
  const std::string sorted =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 2 0 0\n"
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nROBUST_KERNEL Huber 1.5\nG2O_EDGE_LEVEL 2\n"
      "EDGE_SE2 0 2 2 0 0 1 0 0 1 0 1\nROBUST_KERNEL Cauchy 0.1\n"
      "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\nG2O_EDGE_LEVEL 1\n";
  EXPECT_EQ(written, sorted);
  // A level of 0 is what an edge without the line has, and blank lines and comments
  // between an edge and what belongs to it do not matter.
  EXPECT_EQ(rewritten("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n\n# here\nG2O_EDGE_LEVEL 0\n"),
            rewritten("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"));
}

TEST(G2o, LenientSkipsWhatBelongsToASkippedLine) {
  Engine engine;
  Diagnostics diagnostics;
  LoadOptions lenient;
  lenient.lenient = true;
  const LoadedGraph loaded = load("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nBAR 1 2\nG2O_EDGE_LEVEL 1\n",
                                  engine, diagnostics, lenient);
  EXPECT_EQ(loaded.graph.edgeBlocks().front().levels.front(), 0);
  EXPECT_NE(diagnostics.text().find("g.g2o:3: warning: G2O_EDGE_LEVEL of a line that was not read"),
            std::string::npos)
      << diagnostics.text();
}

}  // namespace
}  // namespace graft
