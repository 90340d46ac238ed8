// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "types_lfd/eval/metrics.hpp"

namespace graft::report {

enum class Unit { kCentimetre, kDegree, kPercent };

/// "cm", "degrees" and "%".
const char* unitName(Unit unit);

/// A row of the paper's Table I in the paper's units; empty = undefined.
struct TableRow {
  std::string label;
  std::string key;      ///< as in metrics.json
  std::string meaning;  ///< one sentence
  Unit unit = Unit::kCentimetre;
  std::optional<double> before;
  std::optional<double> after;
  std::optional<double> paper_before;
  std::optional<double> paper_after;
};

/// Rows in the paper's order, then ours. The paper's figures (Welschehold,
/// Dornhege, Burgard, "Learning Mobile Manipulation Actions from Human
/// Demonstrations", 2017, Table I) are there for its four tasks: room_door,
/// swivel_door, drawer, sliding_door.
std::vector<TableRow> tableRows(const std::string& task, const lfd::Table1& before,
                                const lfd::Table1& after);

/// Whether the paper has figures for a task of this name.
bool isTaskOfPaper(const std::string& task);

/// "0.55 cm", "8.02°", "99.74 %" (small ones with more decimals), or a dash.
std::string formatValue(const std::optional<double>& value, Unit unit);
/// The same for figures that are given with few decimals: "8.1°".
std::string formatGiven(const std::optional<double>& value, Unit unit);

}  // namespace graft::report
