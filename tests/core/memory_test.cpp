// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/memory.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.hpp"
#include "core/linear/block_cholesky.hpp"
#include "tests/support/address_space.hpp"
#include "tests/support/block_matrix.hpp"
#include "tests/support/graphs.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

using testing::AddressSpaceLimit;

TEST(Memory, FormatsBytes) {
  const std::pair<double, const char*> cases[] = {
      {0, "0 B"},          {999, "999 B"},       {999.6, "1.00 kB"},  {1234, "1.23 kB"},
      {12345, "12.3 kB"},  {9.996e6, "10.0 MB"}, {214.4e6, "214 MB"}, {41.26e9, "41.3 GB"},
      {1.5e12, "1.50 TB"}, {3e18, "3000 PB"}};
  for (const auto& [bytes, text] : cases) EXPECT_EQ(formatBytes(bytes), text) << bytes;
}

TEST(Memory, IsFiniteAndFollowsTheLimitOfTheAddressSpace) {
  GRAFT_REQUIRE_LIMITS();
  EXPECT_GT(availableMemory(), 1e6);
  EXPECT_LT(availableMemory(), 1e15);
  const AddressSpaceLimit limit(3e7);
  EXPECT_NEAR(availableMemory(), 3e7, 1e6);
  EXPECT_TRUE(fitsIntoMemory(2e7));
  EXPECT_FALSE(fitsIntoMemory(4e7));
  requireMemory(2e7, "this");
  try {
    requireMemory(4e7, "this", "; that");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kNoResult);
    const std::string text = error.what();
    EXPECT_EQ(text.find("this needs 40.0 MB, "), 0u) << text;
    EXPECT_NE(text.find(" MB are free; that"), std::string::npos) << text;
  }
}

/// A pattern whose factor is much larger than itself.
std::string tryToFactor(double bytes, int threads, bool& with_tasks) {
  const testing::BlockMatrix a(std::vector<std::int32_t>(40 * 40, 1), testing::gridPairs(40), 4);
  // As if blocks were large; the values do not matter to the analysis.
  const std::vector<std::int32_t> dims(40 * 40, 12);
  graft_block_pattern pattern = a.pattern;
  pattern.dims = dims.data();
  ThreadPool pool(threads);
  BlockCholesky cholesky(&pool);
  const AddressSpaceLimit limit(bytes);
  try {
    cholesky.analyze(pattern);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kNoResult);
    return error.what();
  }
  with_tasks = !cholesky.symbolic().tasks.empty();
  return {};
}

TEST(Memory, PredictsTheFactor) {
  GRAFT_REQUIRE_LIMITS();
  bool with_tasks = false;
  EXPECT_EQ(tryToFactor(1e9, 3, with_tasks), "");
  EXPECT_TRUE(with_tasks);
  const std::string text = tryToFactor(2e7, 3, with_tasks);
  EXPECT_EQ(text.find("the factor of the normal equations needs "), 0u) << text;
  // The factor with what a sequential factorisation needs, but not what tasks need.
  const testing::BlockMatrix a(std::vector<std::int32_t>(40 * 40, 1), testing::gridPairs(40), 4);
  const std::vector<std::int32_t> dims(40 * 40, 12);
  graft_block_pattern pattern = a.pattern;
  pattern.dims = dims.data();
  const double sequential = analyzePattern(pattern, false).bytes();
  const double parallel = analyzePattern(pattern, true).bytes();
  ASSERT_GT(parallel, 1.3 * sequential);
  EXPECT_EQ(tryToFactor(0.5 * (sequential + parallel), 3, with_tasks), "");
  EXPECT_FALSE(with_tasks);
}

/// What analysing blocks of 65536 rows, on the diagonal only, says.
std::string refusalOf(std::int32_t blocks) {
  const std::int32_t dim = 65536;
  const std::vector<std::int32_t> dims(std::size_t(blocks), dim);
  std::vector<std::int64_t> columns = {0};
  std::vector<std::int64_t> offsets;
  std::vector<std::int32_t> rows;
  for (std::int32_t j = 0; j < blocks; ++j) {
    rows.push_back(j);
    offsets.push_back(std::int64_t(j) * dim * dim);
    columns.push_back(j + 1);
  }
  const graft_block_pattern pattern = {sizeof pattern, blocks,      dims.data(),
                                       columns.data(), rows.data(), offsets.data()};
  try {
    BlockCholesky().analyze(pattern);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kNoResult);
    return error.what();
  }
  return "accepted";
}

TEST(Memory, SizesBeyondAnyIndexAreRefusedBeforeMemoryIsTaken) {
  // 32767 * 65536 * 65537 / 2 numbers of 8 bytes.
  EXPECT_EQ(refusalOf(32767).find("the factor of the normal equations needs 563 TB, "), 0u)
      << refusalOf(32767);
  EXPECT_EQ(refusalOf(32769),
            "the normal equations have 2147549184 unknowns in 32769 blocks: too many for indices "
            "of 32 bits");
}

TEST(Memory, EndsOptimizeWithATextAndNotByAKiller) {
  GRAFT_REQUIRE_LIMITS();
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(folder, "cube.g2o", testing::cubeOfPoses(16));
  const std::string graft = testing::binaryDirectory() + "/bin/graft optimize " + in;
  for (const int kilobytes : {90000, 120000}) {
    const testing::CommandResult result =
        testing::runCommand("ulimit -v " + std::to_string(kilobytes) + "; " + graft +
                            " --threads 1 --initial-guess file -o " + folder + "/out.g2o");
    EXPECT_EQ(result.exit_code, 4) << result.err;
    EXPECT_NE(result.err.find("no usable result: the factor of the normal equations needs "),
              std::string::npos)
        << result.err;
    EXPECT_NE(result.out.find("failed (the factor"), std::string::npos) << result.out;
    EXPECT_FALSE(std::ifstream(folder + "/out.g2o").good());
  }
}

TEST(Memory, IsNamedBySummary) {
  const std::string folder = testing::makeTemporaryDirectory();
  const std::string in = testing::writeTestFile(folder, "cube.g2o", testing::cubeOfPoses(5));
  const testing::CommandResult result = testing::runCommand(
      testing::binaryDirectory() + "/bin/graft optimize " + in + " --json " + folder + "/out.json");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("ordering amd, "), std::string::npos) << result.out;
  const std::string json = testing::readTestFile(folder + "/out.json");
  const std::size_t at = json.find("\"factor_bytes\": ");
  ASSERT_NE(at, std::string::npos) << json;
  // Between the lower triangle of the pattern and a full matrix of 124 poses.
  const double bytes = std::stod(json.substr(at + 16));
  EXPECT_GT(bytes, 8.0 * 36 * (124 + 300));
  EXPECT_LT(bytes, 2 * 8.0 * 744 * 744);
}

}  // namespace
}  // namespace graft
