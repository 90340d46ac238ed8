// SPDX-License-Identifier: BSD-3-Clause
#include "tests/apps/report/written_report.hpp"

#include <tinyxml2.h>

#include <filesystem>
#include <functional>
#include <regex>

#include "apps/report/report.hpp"
#include "tests/support/test_data.hpp"

namespace graft::report::testing {

namespace {

void visit(const tinyxml2::XMLElement& element,
           const std::function<void(const tinyxml2::XMLElement&)>& see) {
  see(element);
  for (const auto* child = element.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    visit(*child, see);
  }
}

void collectText(const tinyxml2::XMLNode& node, std::string& out) {
  if (const auto* text = node.ToText()) {
    if (!out.empty()) out += ' ';
    out += text->Value();
  }
  for (const auto* child = node.FirstChild(); child != nullptr; child = child->NextSibling()) {
    collectText(*child, out);
  }
}

std::string attributeDefect(const tinyxml2::XMLElement& element) {
  // A search of its own: std::regex recurses once per character, and a path is long.
  constexpr const char* kPathCharacters = "MLQZh0123456789. -";
  static const std::regex number("-?[0-9.]+%?");
  for (const auto* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
    const std::string name = a->Name();
    const std::string value = a->Value();
    if (name == "d" && value.find_first_not_of(kPathCharacters) != std::string::npos) {
      return "path " + value.substr(0, 99);
    }
    for (const char* numeric : {"x", "y", "cx", "cy", "r", "rx", "width", "height"}) {
      if (name == numeric && !std::regex_match(value, number)) return name + "=" + value;
    }
    for (const char* foreign : {"href", "xlink:href", "src", "onload", "onclick"}) {
      if (name == foreign) return "attribute " + name;
    }
  }
  return "";
}

}  // namespace

std::map<std::string, std::string> writtenReport(const lfd::LearnResult& result,
                                                 const std::vector<std::string>& messages) {
  namespace fs = std::filesystem;
  const std::string folder = graft::testing::makeTemporaryDirectory() + "/out";
  StagedDirectory out(folder);
  writeReport(result, out, messages);
  out.commit();
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder).string()] =
        graft::testing::readTestFile(entry.path().string());
  }
  return files;
}

std::string defectOf(const std::string& content) {
  tinyxml2::XMLDocument document;
  if (document.Parse(content.c_str(), content.size()) != tinyxml2::XML_SUCCESS) {
    return document.ErrorStr();
  }
  const std::string space = "http://www.w3.org/2000/svg";
  std::string rest = content;
  for (std::size_t at; (at = rest.find(space)) != std::string::npos;) rest.erase(at, space.size());
  for (const char* foreign : {"http:", "https:", "url(", "@import", "<script", "//cdn"}) {
    if (rest.find(foreign) != std::string::npos) return std::string("contains ") + foreign;
  }
  std::string defect;
  visit(*document.RootElement(), [&](const tinyxml2::XMLElement& element) {
    if (defect.empty()) defect = attributeDefect(element);
  });
  return defect;
}

std::string plainText(const std::string& content) {
  tinyxml2::XMLDocument document;
  document.Parse(content.c_str(), content.size());
  std::string out;
  collectText(document, out);
  return out;
}

std::vector<std::vector<std::string>> tableRowsOf(const std::string& html) {
  tinyxml2::XMLDocument document;
  document.Parse(html.c_str(), html.size());
  std::vector<std::vector<std::string>> rows;
  visit(*document.RootElement(), [&](const tinyxml2::XMLElement& element) {
    if (std::string(element.Name()) != "tr") return;
    rows.emplace_back();
    for (const auto* cell = element.FirstChildElement(); cell != nullptr;
         cell = cell->NextSiblingElement()) {
      rows.back().push_back(cell->GetText() != nullptr ? cell->GetText() : "");
    }
  });
  return rows;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

}  // namespace graft::report::testing
