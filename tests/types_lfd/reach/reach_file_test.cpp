// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <random>

#include "tests/support/test_data.hpp"
#include "tests/types_lfd/reach/small_map.hpp"
#include "types_lfd/reach/reach_cache.hpp"

namespace graft::lfd {
namespace {

using graft::testing::makeTemporaryDirectory;
using graft::testing::readTestFile;
using graft::testing::writeTestFile;
using testing::smallMap;
using testing::smallOptions;
using testing::smallRobotChain;

// Places in the file, as reach_file.cpp states them.
constexpr std::size_t kVersionAt = 12;
constexpr std::size_t kSizeAt = 16;
constexpr std::size_t kChecksumAt = 24;
constexpr std::size_t kReachableAt = 56;
constexpr std::size_t kCoverageAt = 64;
constexpr std::size_t kResolutionAt = 80;
constexpr std::size_t kTurnAt = 88;
constexpr std::size_t kNxAt = 104;
constexpr std::size_t kRollsAt = 116;
constexpr std::size_t kNamesAt = 128;

std::string savedMap() {
  static const std::string content = [] {
    const std::string path = makeTemporaryDirectory() + "/map.irm";
    smallMap().save(path);
    return readTestFile(path);
  }();
  return content;
}

/// The file's checksum, written here from the description of the format.
void seal(std::string& content) {
  const std::uint64_t size = content.size();
  std::memcpy(content.data() + kSizeAt, &size, 8);
  std::uint64_t h = 0xcbf29ce484222325ULL;
  std::size_t i = 32;
  for (; i + 8 <= content.size(); i += 8) {
    std::uint64_t word;
    std::memcpy(&word, content.data() + i, 8);
    h = (h ^ word) * 0x100000001b3ULL;
    h ^= h >> 29;
  }
  for (; i < content.size(); ++i) {
    h = (h ^ static_cast<unsigned char>(content[i])) * 0x100000001b3ULL;
  }
  h ^= content.size() - 32;
  std::memcpy(content.data() + kChecksumAt, &h, 8);
}

template <class T>
std::string withValue(std::size_t at, T value) {
  std::string content = savedMap();
  std::memcpy(content.data() + at, &value, sizeof value);
  return content;
}

template <class T>
std::string sealedWith(std::size_t at, T value) {
  std::string content = withValue(at, value);
  seal(content);
  return content;
}

std::string loadMessage(const std::string& content) {
  static const std::string folder = makeTemporaryDirectory();
  const std::string path = writeTestFile(folder, "bad.irm", content);
  try {
    ReachMap::load(path);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_EQ(error.where().path, path);
    return error.what();
  }
  return "";
}

TEST(ReachFile, RoundTrips) {
  const std::string path = makeTemporaryDirectory() + "/map.irm";
  smallMap().save(path);
  const ReachMap map = ReachMap::load(path);
  EXPECT_EQ(map.cells(), smallMap().cells());
  EXPECT_EQ(map.distances(), smallMap().distances());
  EXPECT_EQ(map.grid().rolls, smallMap().grid().rolls);
  EXPECT_EQ(map.grid().fine, smallMap().grid().fine);
  EXPECT_EQ(map.robotName(), "small");
  EXPECT_EQ(map.baseLink(), "base");
  EXPECT_EQ(map.tipLink(), "tool");
  EXPECT_EQ(map.seed(), smallMap().seed());
  EXPECT_EQ(map.samples(), smallMap().samples());
  EXPECT_EQ(map.coverage(), smallMap().coverage());
  EXPECT_EQ(map.reachableCells(), smallMap().reachableCells());
  EXPECT_EQ(map.grid().nx, smallMap().grid().nx);
  EXPECT_EQ(map.grid().z0, smallMap().grid().z0);
  EXPECT_EQ(map.marginT(), smallMap().marginT());
  map.save(path + "2");
  EXPECT_EQ(readTestFile(path), readTestFile(path + "2"));
}

TEST(ReachFile, NamesTheDefect) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::string sealed_same = savedMap();
  seal(sealed_same);
  ASSERT_EQ(sealed_same, savedMap());
  const struct {
    std::string content;
    const char* message;
  } cases[] = {
      {"", "not a graft reachability map"},
      {"hello, this is some other file, long enough", "not a graft reachability map"},
      {"GRAFTIRM", "truncated: the header has 32 bytes, the file has 8"},
      {withValue(kVersionAt, std::uint32_t{7}), "version 7, this build reads 2"},
      {withValue(8, std::uint32_t{0x04030201}), "big-endian"},
      {savedMap() + "x", "bytes were added"},
      {withValue(kChecksumAt, std::uint64_t{1}), "checksum"},
      {sealedWith(kResolutionAt, 0.0), "the resolution is 0,"},
      {sealedWith(kResolutionAt, -0.05), "the resolution is -0.05"},
      {sealedWith(kResolutionAt, nan), "the resolution is"},
      {sealedWith(kCoverageAt, 2.0), "the coverage is 2"},
      {sealedWith(kTurnAt, 7), "not a multiple of 4"},
      {sealedWith(kTurnAt, 0), "angular cells is 0"},
      {sealedWith(kTurnAt, 16), "do not fit the grid"},
      {sealedWith(kTurnAt, 76), "angular cells is 76"},
      {sealedWith(kRollsAt, 3), "nodes in roll is neither"},
      {sealedWith(kRollsAt, 0), "nodes in roll is 0"},
      {sealedWith(kRollsAt + 4, 3), "nodes per cell is 3"},
      {sealedWith(kRollsAt + 8, 1), "reserved"},
      {sealedWith(kNxAt, 0), "nodes in x is 0"},
      {sealedWith(kNxAt, -1), "nodes in x is -1"},
      {sealedWith(kNxAt, 20), "do not fit the grid"},
      {sealedWith(kNxAt, std::numeric_limits<std::int32_t>::max()), "nodes in x is 2147483647"},
      {sealedWith(kReachableAt, std::uint64_t{5}), "counts 5 reachable nodes"},
      {sealedWith(kNamesAt, std::uint32_t{0xffffffff}), "longer than 4096"},
      {sealedWith(kNamesAt, std::uint32_t{4000}), ""},
  };
  for (const auto& c : cases) {
    const std::string message = loadMessage(c.content);
    EXPECT_NE(message, "");
    EXPECT_NE(message.find(c.message), std::string::npos) << message;
  }
}

TEST(ReachFile, GridTooLargeForItsBytesIsRefused) {
  std::string content = savedMap();
  const int sizes[3] = {1024, 1024, 1 << 20};
  std::memcpy(content.data() + kNxAt, sizes, sizeof sizes);
  seal(content);
  EXPECT_NE(loadMessage(content).find("does not fit"), std::string::npos);
}

TEST(ReachFile, EveryTruncationSaysBothSizes) {
  const std::string content = savedMap();
  std::mt19937_64 random(1);
  std::vector<std::size_t> sizes;
  for (std::size_t n = 8; n < 160; ++n) sizes.push_back(n);
  for (int n = 0; n < 40; ++n) sizes.push_back(random() % content.size());
  for (const std::size_t n : sizes) {
    const std::string message = loadMessage(content.substr(0, n));
    EXPECT_NE(message.find("truncated"), std::string::npos) << n << message;
    EXPECT_NE(message.find("the file has " + std::to_string(n)), std::string::npos) << message;
  }
}

TEST(ReachFile, EveryFlippedBitIsNoticed) {
  std::string content = savedMap();
  std::mt19937_64 random(2);
  std::vector<std::size_t> bits;
  for (std::size_t bit = 0; bit < 8 * 150; bit += 3) bits.push_back(bit);
  for (int n = 0; n < 60; ++n) bits.push_back(random() % (8 * content.size()));
  for (const std::size_t bit : bits) {
    content[bit / 8] = static_cast<char>(content[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_NE(loadMessage(content), "") << bit;
    content[bit / 8] = static_cast<char>(content[bit / 8] ^ (1 << (bit % 8)));
  }
}

TEST(ReachFile, KnowsItsRobot) {
  const Pose longer(Eigen::Vector3d(0.1, 0, 0), Eigen::Quaterniond::Identity());
  EXPECT_NO_THROW(smallMap().requireChain(smallRobotChain(), "m"));
  try {
    smallMap().requireChain(smallRobotChain(longer), "m");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_NE(error.formatted().find("m: error: the map was built for robot 'small', chain 'base'"),
              std::string::npos);
  }
}

class ReachCache : public ::testing::Test {
 protected:
  ReachCache() { ::setenv("GRAFT_CACHE_DIR", folder_.c_str(), 1); }
  ~ReachCache() override { ::unsetenv("GRAFT_CACHE_DIR"); }

  ReachMap get() {
    diagnostics_.clear();
    built_ = false;
    return cachedReachMap(
        smallRobotChain(), smallOptions(), [this](double) { built_ = true; }, &path_, diagnostics_);
  }

  std::string folder_ = makeTemporaryDirectory() + "/a/b";
  std::string path_;
  Diagnostics diagnostics_;
  bool built_ = false;
};

TEST_F(ReachCache, BuildsOnce) {
  EXPECT_EQ(get().cells(), smallMap().cells());
  EXPECT_TRUE(built_);
  EXPECT_EQ(diagnostics_.text(), "");
  EXPECT_EQ(path_, folder_ + "/" + reachCacheName(smallRobotChain(), smallOptions()));
  EXPECT_EQ(get().cells(), smallMap().cells());
  EXPECT_FALSE(built_);
  EXPECT_EQ(diagnostics_.text(), "");
}

TEST_F(ReachCache, RepairsADamagedFile) {
  get();
  std::filesystem::resize_file(path_, 1000);
  EXPECT_EQ(get().cells(), smallMap().cells());
  EXPECT_TRUE(built_);
  EXPECT_NE(diagnostics_.text().find("built anew: reachability map: truncated"), std::string::npos);
  get();
  EXPECT_FALSE(built_);
}

TEST_F(ReachCache, WorksWithoutAFolder) {
  // A file stands where the folder should be: no user can write below it.
  writeTestFile(makeTemporaryDirectory(), "x", "");
  const std::string file = writeTestFile(makeTemporaryDirectory(), "file", "x");
  ::setenv("GRAFT_CACHE_DIR", (file + "/below").c_str(), 1);
  EXPECT_EQ(get().cells(), smallMap().cells());
  EXPECT_EQ(path_, "");
  EXPECT_EQ(diagnostics_.warningCount(), 1U);
  EXPECT_NE(diagnostics_.text().find("cannot be cached"), std::string::npos);
}

TEST_F(ReachCache, FolderFollowsTheEnvironment) {
  EXPECT_EQ(reachCacheFolder(), folder_);
  ::setenv("GRAFT_CACHE_DIR", "relative", 1);
  ::setenv("XDG_CACHE_HOME", "/xdg", 1);
  EXPECT_EQ(reachCacheFolder(), "/xdg/graft");
  ::unsetenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  const std::string kept = home != nullptr ? home : "";
  ::setenv("HOME", "/home/someone", 1);
  EXPECT_EQ(reachCacheFolder(), "/home/someone/.cache/graft");
  ::unsetenv("HOME");
  EXPECT_EQ(reachCacheFolder(), "");
  if (home != nullptr) ::setenv("HOME", kept.c_str(), 1);
}

TEST_F(ReachCache, NameDependsOnChainAndOptions) {
  const std::string name = reachCacheName(smallRobotChain(), smallOptions());
  ReachOptions options = smallOptions();
  options.threads = 7;
  EXPECT_EQ(reachCacheName(smallRobotChain(), options), name);
  options.seed = 2;
  EXPECT_NE(reachCacheName(smallRobotChain(), options), name);
  const Pose longer(Eigen::Vector3d(0.1, 0, 0), Eigen::Quaterniond::Identity());
  EXPECT_NE(reachCacheName(smallRobotChain(longer), smallOptions()), name);
}

}  // namespace
}  // namespace graft::lfd
