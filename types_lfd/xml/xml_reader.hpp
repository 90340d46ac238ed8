// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tinyxml2.h>

#include <string>
#include <vector>

#include "core/base/error.hpp"

namespace graft::lfd {

/// An XML file held in memory, with errors that name file and line. Document
/// type definitions are refused (they only serve attacks here).
class XmlFile {
 public:
  /// Throws Error(kInput) with path and line where the file is no XML.
  explicit XmlFile(const std::string& path);
  XmlFile(const std::string& path, const std::string& content);

  const std::string& path() const { return path_; }
  const tinyxml2::XMLElement& root() const { return *document_.RootElement(); }

  SourceLocation at(const tinyxml2::XMLNode& node) const { return {path_, node.GetLineNum(), 0}; }
  [[noreturn]] void fail(const tinyxml2::XMLNode& node, const std::string& text) const;

  /// Fails on the first attribute whose name is not listed.
  void allowAttributes(const tinyxml2::XMLElement& element,
                       const std::vector<std::string>& names) const;

  /// Value of an attribute; the required form fails where it is missing.
  std::string required(const tinyxml2::XMLElement& element, const char* name) const;
  std::string optional(const tinyxml2::XMLElement& element, const char* name,
                       const std::string& otherwise = "") const;
  bool has(const tinyxml2::XMLElement& element, const char* name) const;
  double number(const tinyxml2::XMLElement& element, const char* name) const;
  /// Blank-separated numbers; fails unless there are `count` (0 = any number).
  std::vector<double> numbers(const tinyxml2::XMLElement& element, const char* name,
                              std::size_t count = 0) const;

 private:
  void parse(const std::string& content);

  std::string path_;
  tinyxml2::XMLDocument document_;
};

}  // namespace graft::lfd
