// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>

#include "types_lfd/learn/learn.hpp"

namespace graft::lfd {

/// metrics.json and grasp.json as the project's file formats define them.
/// `messages` are what was said on the way, for a report that is written later.
nlohmann::ordered_json metricsJson(const LearnResult& result,
                                   const std::vector<std::string>& messages = {});
nlohmann::ordered_json graspJson(const LearnResult& result);
nlohmann::ordered_json table1Json(const Table1& table);

}  // namespace graft::lfd
