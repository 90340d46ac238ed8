// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "apps/report/pictures.hpp"

namespace graft::report {

/// An HTML page in the making: well-formed XML, too, so that it can be checked.
/// All texts are plain and escaped here.
class Page {
 public:
  explicit Page(std::string title) : title_(std::move(title)) {}

  void heading(const std::string& text);
  void paragraph(const std::string& text, const char* classes = nullptr);
  /// Values with their names, side by side.
  void facts(const std::vector<std::pair<std::string, std::string>>& facts);
  void list(const std::vector<std::string>& items, const char* classes = nullptr);
  /// The first column is text, others are right-aligned; `first_class` may name
  /// a class per row.
  void table(const std::vector<std::string>& head,
             const std::vector<std::vector<std::string>>& rows);
  void figure(const Picture& picture);
  /// Pictures side by side with one caption for all.
  void figures(const std::vector<Picture>& pictures, const std::string& caption);

  std::string text() const;

 private:
  std::string title_;
  std::string body_;
};

/// Sections of the report, each adding to the page what the result has.
void addOverview(Page& page, const lfd::LearnResult& result);
void addMessages(Page& page, const lfd::LearnResult& result,
                 const std::vector<std::string>& messages);
void addTable(Page& page, const lfd::LearnResult& result);
void addGrasp(Page& page, const lfd::LearnResult& result);
void addModes(Page& page, const lfd::LearnResult& result);
void addDisagreement(Page& page, const lfd::LearnResult& result);
void addSolve(Page& page, const lfd::LearnResult& result);
void addModel(Page& page, const lfd::LearnResult& result);
void addWeights(Page& page, const lfd::LearnResult& result);
void addSeconds(Page& page, const lfd::LearnResult& result);

}  // namespace graft::report
