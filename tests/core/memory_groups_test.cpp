// SPDX-License-Identifier: BSD-3-Clause
// What control groups leave, read from made-up trees of files.
#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "core/base/memory.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

struct GroupCase {
  const char* name;
  std::map<std::string, std::string> files;
  double left;
};

class MemoryGroups : public ::testing::TestWithParam<GroupCase> {};

TEST_P(MemoryGroups, LeaveTheLeast) {
  const std::string root = testing::makeTemporaryDirectory();
  for (const auto& [name, content] : GetParam().files) testing::writeTestFile(root, name, content);
  EXPECT_EQ(availableInGroups(root), GetParam().left);
}

const std::string kOne = "sys/fs/cgroup/memory/";
const std::string kTwo = "sys/fs/cgroup/";
// Page cache that can be dropped is not in the way.
const std::string kStat = "anon 100\nfile 700\ninactive_anon 5\ninactive_file 300\nslab 9\n";
const std::string kOldStat = "cache 700\ninactive_file 1\ntotal_inactive_file 300\n";

INSTANTIATE_TEST_SUITE_P(
    , MemoryGroups,
    ::testing::Values(
        GroupCase{"nothing_is_there", {}, kUnlimited},
        GroupCase{"no_group_of_memory", {{"proc/self/cgroup", "4:cpu,cpuacct:/a\n"}}, kUnlimited},
        GroupCase{"garbage", {{"proc/self/cgroup", "\n:\nx:y\n0:\n"}}, kUnlimited},
        GroupCase{"two_limit",
                  {{"proc/self/cgroup", "0::/a\n"},
                   {kTwo + "a/memory.max", "5000\n"},
                   {kTwo + "a/memory.current", "2000\n"}},
                  3000},
        GroupCase{"two_cache_is_free",
                  {{"proc/self/cgroup", "0::/a\n"},
                   {kTwo + "a/memory.max", "5000\n"},
                   {kTwo + "a/memory.current", "2000\n"},
                   {kTwo + "a/memory.stat", kStat}},
                  3300},
        GroupCase{"two_max",
                  {{"proc/self/cgroup", "0::/a\n"},
                   {kTwo + "a/memory.max", "max\n"},
                   {kTwo + "a/memory.current", "2000\n"}},
                  kUnlimited},
        GroupCase{"two_without_usage",
                  {{"proc/self/cgroup", "0::/a\n"}, {kTwo + "a/memory.max", "5000\n"}},
                  5000},
        GroupCase{"two_parent_is_lower",
                  {{"proc/self/cgroup", "0::/a/b/c\n"},
                   {kTwo + "a/b/c/memory.max", "9000\n"},
                   {kTwo + "a/b/c/memory.current", "10\n"},
                   {kTwo + "a/b/memory.max", "max\n"},
                   {kTwo + "a/b/memory.current", "500\n"},
                   {kTwo + "a/memory.max", "4000\n"},
                   {kTwo + "a/memory.current", "3500\n"}},
                  500},
        GroupCase{"two_in_a_container",  // the group's own path is not visible
                  {{"proc/self/cgroup", "0::/docker/1234\n"},
                   {kTwo + "memory.max", "700\n"},
                   {kTwo + "memory.current", "200\n"}},
                  500},
        GroupCase{"two_at_the_limit",
                  {{"proc/self/cgroup", "0::/a\n"},
                   {kTwo + "a/memory.max", "5000\n"},
                   {kTwo + "a/memory.current", "5000\n"}},
                  0},
        GroupCase{"two_above_the_limit",  // it was lowered
                  {{"proc/self/cgroup", "0::/a\n"},
                   {kTwo + "a/memory.max", "5000\n"},
                   {kTwo + "a/memory.current", "6000\n"},
                   {kTwo + "a/memory.stat", kStat}},
                  0},
        GroupCase{"two_more_cache_than_usage",
                  {{"proc/self/cgroup", "0::/a\n"},
                   {kTwo + "a/memory.max", "5000\n"},
                   {kTwo + "a/memory.current", "200\n"},
                   {kTwo + "a/memory.stat", kStat}},
                  5000},
        GroupCase{"one_limit",
                  {{"proc/self/cgroup", "7:cpu:/x\n4:memory:/a\n0::/\n"},
                   {kOne + "a/memory.limit_in_bytes", "5000\n"},
                   {kOne + "a/memory.usage_in_bytes", "2000\n"},
                   {kOne + "a/memory.stat", kOldStat}},
                  3300},
        GroupCase{"one_parent_is_lower",
                  {{"proc/self/cgroup", "4:hugetlb,memory:/a/b\n"},
                   {kOne + "a/b/memory.limit_in_bytes", "9223372036854771712\n"},
                   {kOne + "a/b/memory.usage_in_bytes", "100\n"},
                   {kOne + "memory.limit_in_bytes", "1000\n"},
                   {kOne + "memory.usage_in_bytes", "900\n"}},
                  100},
        GroupCase{"both",
                  {{"proc/self/cgroup", "4:memory:/a\n0::/b\n"},
                   {kOne + "a/memory.limit_in_bytes", "5000\n"},
                   {kOne + "a/memory.usage_in_bytes", "1000\n"},
                   {kTwo + "b/memory.max", "3000\n"},
                   {kTwo + "b/memory.current", "1\n"}},
                  2999}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(MemoryOfTheSystem, IsNoMoreThanItsGroupsLeave) {
  EXPECT_LE(availableMemory(), availableInGroups() + 1e8);
}

}  // namespace
}  // namespace graft
