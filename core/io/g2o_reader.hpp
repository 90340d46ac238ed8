// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "core/io/graph_builder.hpp"

namespace graft {

/// Reads g2o text held in memory into a builder. A line is a tag and
///   vertex:   id, the type's numbers
///   edge:     vertex ids ("||" ends them where the arity is dynamic), resource
///             ids, measurement, upper triangle of the information matrix
///   resource: id, tokens
///   FIX:      ids
///   ROBUST_KERNEL:  name and width of the kernel of the edge on the line before
///   G2O_EDGE_LEVEL: its level; one not given is 0
/// Blank lines and what follows a '#' are comments; LF or CRLF; a byte order
/// mark is skipped. Every line is used, or reported.
void readG2o(std::string_view text, GraphBuilder& builder);

/// Tags of lines that say something of the edge before them.
constexpr std::string_view kKernelTag = "ROBUST_KERNEL";
constexpr std::string_view kLevelTag = "G2O_EDGE_LEVEL";

/// Longest line that is read as a record.
constexpr std::size_t kLineLimit = std::size_t{1} << 26;

}  // namespace graft
