// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/xml/xml_reader.hpp"

#include <algorithm>

#include "core/base/file.hpp"
#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

constexpr std::size_t kMaximumBytes = std::size_t{64} << 20;

}  // namespace

XmlFile::XmlFile(const std::string& path) : path_(path) { parse(readFile(path, kMaximumBytes)); }

XmlFile::XmlFile(const std::string& path, const std::string& content) : path_(path) {
  parse(content);
}

void XmlFile::parse(const std::string& content) {
  document_.Parse(content.data(), content.size());
  if (document_.Error()) {
    throw Error(ExitCode::kInput, {path_, document_.ErrorLineNum(), 0},
                std::string("not valid XML: ") + document_.ErrorName());
  }
  for (const auto* node = document_.FirstChild(); node != nullptr; node = node->NextSibling()) {
    if (node->ToUnknown() != nullptr) fail(*node, "document type definitions are not allowed");
  }
  if (document_.RootElement() == nullptr) {
    throw Error(ExitCode::kInput, {path_, 1, 0}, "no XML element found");
  }
  const auto* extra = document_.RootElement()->NextSiblingElement();
  if (extra != nullptr) fail(*extra, "a second root element");
}

void XmlFile::fail(const tinyxml2::XMLNode& node, const std::string& text) const {
  throw Error(ExitCode::kInput, at(node), text);
}

void XmlFile::allowAttributes(const tinyxml2::XMLElement& element,
                              const std::vector<std::string>& names) const {
  for (const auto* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
    if (std::find(names.begin(), names.end(), a->Name()) == names.end()) {
      fail(element,
           std::string("unknown attribute ") + quoted(a->Name()) + " of <" + element.Name() + ">");
    }
  }
}

std::string XmlFile::required(const tinyxml2::XMLElement& element, const char* name) const {
  const char* value = element.Attribute(name);
  if (value == nullptr) {
    fail(element, std::string("<") + element.Name() + "> needs the attribute '" + name + "'");
  }
  return value;
}

std::string XmlFile::optional(const tinyxml2::XMLElement& element, const char* name,
                              const std::string& otherwise) const {
  const char* value = element.Attribute(name);
  return value != nullptr ? value : otherwise;
}

bool XmlFile::has(const tinyxml2::XMLElement& element, const char* name) const {
  return element.Attribute(name) != nullptr;
}

double XmlFile::number(const tinyxml2::XMLElement& element, const char* name) const {
  return numbers(element, name, 1).front();
}

std::vector<double> XmlFile::numbers(const tinyxml2::XMLElement& element, const char* name,
                                     std::size_t count) const {
  const std::string text = required(element, name);
  const std::string where = std::string("attribute '") + name + "' of <" + element.Name() + ">: ";
  std::string flat = text;
  for (char& c : flat) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  std::vector<double> values;
  LineTokens tokens(flat);
  for (auto token = tokens.next(); !token.empty(); token = tokens.next()) {
    double value = 0;
    const NumberStatus status = parseDouble(token, value);
    if (status != NumberStatus::kOk) fail(element, where + describe(status, token));
    values.push_back(value);
  }
  if (count != 0 && values.size() != count) {
    fail(element, where + "expected " + std::to_string(count) + " numbers, got " +
                      std::to_string(values.size()));
  }
  return values;
}

}  // namespace graft::lfd
