// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft_lfd/session.hpp"

#include <algorithm>
#include <cstdio>

#include "apps/report/table_rows.hpp"
#include "core/base/text.hpp"

namespace graft::lfd {

void printTable1(const std::string& task_name, const Table1* before, const Table1& after) {
  const bool paper = report::isTaskOfPaper(task_name);
  std::printf("%-42s", "");
  if (before != nullptr) std::printf(" %11s", "before");
  std::printf(" %11s", "after");
  if (paper) std::printf("   %14s %11s", "paper: before", "after");
  std::printf("\n");
  // The degree sign takes two bytes, which a field width does not know.
  const auto cell = [](const std::string& text, int width) {
    int columns = 0;
    for (const char c : text) columns += (static_cast<unsigned char>(c) & 0xc0) != 0x80 ? 1 : 0;
    std::printf(" %*s%s", std::max(0, width - columns), "", text.c_str());
  };
  for (const report::TableRow& row :
       report::tableRows(task_name, before != nullptr ? *before : after, after)) {
    std::printf("%-42s", row.label.c_str());
    if (before != nullptr) cell(report::formatValue(row.before, row.unit), 11);
    cell(report::formatValue(row.after, row.unit), 11);
    if (paper) {
      cell(report::formatGiven(row.paper_before, row.unit), 16);
      cell(report::formatGiven(row.paper_after, row.unit), 11);
    }
    std::printf("\n");
  }
}

std::vector<int> parseList(const std::string& text, const std::string& option) {
  std::vector<int> list;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::int64_t value = 0;
    if (parseInteger(text.substr(begin, end - begin), value) != NumberStatus::kOk || value < 0 ||
        value > 1000000) {
      throw Error(ExitCode::kUsage,
                  option + ": expected numbers separated by commas, got " + quoted(text));
    }
    list.push_back(int(value));
    begin = end + 1;
  }
  return list;
}

Pose parsePose(const std::string& text, const std::string& option) {
  double v[7];
  LineTokens tokens(text);
  for (double& value : v) {
    if (parseDouble(tokens.next(), value) != NumberStatus::kOk) {
      throw Error(ExitCode::kUsage, option + ": expected \"x y z qx qy qz qw\"");
    }
  }
  if (!tokens.atEnd() || !normalizeQuaternion(v + 3)) {
    throw Error(ExitCode::kUsage, option + ": expected \"x y z qx qy qz qw\"");
  }
  return Pose::fromArray(v);
}

}  // namespace graft::lfd
