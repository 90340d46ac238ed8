// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "types_lfd/learn/learn.hpp"

namespace graft::report::testing {

/// Files that writeReport() made, by name relative to the folder.
std::map<std::string, std::string> writtenReport(const lfd::LearnResult& result,
                                                 const std::vector<std::string>& messages = {});

/// What every file must fulfil: well-formed XML, no number that is not finite,
/// nothing loaded from elsewhere, no script. Empty, or what is wrong.
std::string defectOf(const std::string& content);

/// All text of an XML file with one blank between pieces.
std::string plainText(const std::string& content);

/// Cells of all tables of the page, row by row.
std::vector<std::vector<std::string>> tableRowsOf(const std::string& html);

/// Times that `part` occurs in `text`.
std::size_t occurrences(const std::string& text, const std::string& part);

}  // namespace graft::report::testing
