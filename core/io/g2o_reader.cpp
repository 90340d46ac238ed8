// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/g2o_reader.hpp"

#include <limits>

#include "core/base/text.hpp"

namespace graft {

namespace {

bool hasControlByte(std::string_view token, char& found) {
  for (const char c : token) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      found = c;
      return true;
    }
  }
  return false;
}

/// Reads the records of one text; kept apart so that its buffers are reused.
class Reader {
 public:
  Reader(std::string_view text, GraphBuilder& builder) : text_(text), builder_(builder) {}

  void run() {
    LineReader lines(text_);
    std::string_view line;
    while (!binary_ && lines.next(line)) {
      line_ = line;
      number_ = lines.lineNumber();
      record();
    }
  }

 private:
  void record() {
    LineTokens tokens(line_);
    const std::string_view name = tokens.next();
    if (name.empty()) return;
    if (line_.size() > kLineLimit) {
      return fail(0, "the line is longer than " + std::to_string(kLineLimit) + " bytes");
    }
    tag_ = name;
    if (name == kKernelTag) return kernel(tokens);
    if (name == kLevelTag) return level(tokens);
    before_ = Before::kNoEdge;
    if (name == "FIX") return fix(tokens);
    char control = 0;
    if (hasControlByte(name, control)) return controlByte(tokens, control);
    const TagType& type = builder_.tag(name);
    bool good = true;
    if (type.vertex != nullptr) {
      good = vertex(tokens, type);
    } else if (type.edge != nullptr) {
      before_ = edge(tokens, type) ? Before::kEdge : Before::kLostEdge;
    } else if (type.resource != nullptr) {
      good = resource(tokens, type);
    } else {
      before_ = Before::kLostEdge;
      builder_.unknownTag(name, number_);
    }
    if (!good) builder_.definitionLost();
  }

  void fail(std::int64_t column, const std::string& text) { builder_.error(number_, column, text); }

  void controlByte(const LineTokens& tokens, char control) {
    binary_ = true;
    builder_.definitionLost();
    fail(tokens.column(),
         "control byte " + quoted(std::string_view(&control, 1)) + ", this is not a text file");
  }

  /// Reports a token that is no number or id.
  bool badToken(const LineTokens& tokens, std::string_view token, const std::string& text) {
    char control = 0;
    if (hasControlByte(token, control)) {
      controlByte(tokens, control);
    } else {
      fail(tokens.column(), text);
    }
    return false;
  }

  std::string what() const { return " (" + std::string(tag_); }

  bool id(LineTokens& tokens, std::int64_t& value) { return idOf(tokens, tokens.next(), value); }

  bool idOf(const LineTokens& tokens, std::string_view token, std::int64_t& value) {
    switch (parseInteger(token, value)) {
      case NumberStatus::kOk:
        if (value >= 0) return true;
        return badToken(tokens, token, "id " + quoted(token) + " is negative");
      case NumberStatus::kEmpty:
        return badToken(tokens, token, "expected id, the line ends");
      case NumberStatus::kOutOfRange:
        return badToken(tokens, token,
                        "id " + quoted(token) + " is out of range (0 to " +
                            std::to_string(std::numeric_limits<std::int64_t>::max()) + ")");
      default:
        return badToken(tokens, token, "expected an integer id, got " + quoted(token));
    }
  }

  /// Reads exactly `count` numbers and the end of the line.
  bool numbers(LineTokens& tokens, std::size_t count, std::size_t fields_before) {
    numbers_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::string_view token = tokens.next();
      const NumberStatus status = parseDouble(token, numbers_[i]);
      if (status == NumberStatus::kOk) continue;
      if (status == NumberStatus::kEmpty) {
        fail(tokens.column(), std::string(tag_) + ": expected " +
                                  std::to_string(fields_before + count) + " fields, got " +
                                  std::to_string(fields_before + i));
        return false;
      }
      return badToken(tokens, token,
                      describe(status, token) + what() + " field " +
                          std::to_string(fields_before + i + 1) + ")");
    }
    return lineEnds(tokens, fields_before + count);
  }

  bool lineEnds(LineTokens& tokens, std::size_t expected) {
    const std::string_view extra = tokens.next();
    if (extra.empty()) return true;
    const std::int64_t column = tokens.column();
    std::size_t fields = expected + 1;
    while (!tokens.next().empty()) ++fields;
    fail(column, "unexpected token " + quoted(extra) + ": " + std::string(tag_) + " has " +
                     std::to_string(expected) + " fields, got " + std::to_string(fields));
    return false;
  }

  bool vertex(LineTokens& tokens, const TagType& type) {
    std::int64_t id_value = 0;
    if (!id(tokens, id_value)) return false;
    const int dim = type.vertex->ambient_dim;
    if (!numbers(tokens, std::size_t(dim), 1)) return false;
    builder_.addVertex(type, id_value, numbers_.data(), dim, number_);
    return true;
  }

  bool resource(LineTokens& tokens, const TagType& type) {
    std::int64_t id_value = 0;
    if (!id(tokens, id_value)) return false;
    std::vector<std::string> rest;
    for (std::string_view t = tokens.next(); !t.empty(); t = tokens.next()) {
      char control = 0;
      if (hasControlByte(t, control)) {
        controlByte(tokens, control);
        return false;
      }
      rest.emplace_back(t);
    }
    builder_.addResource(type, id_value, std::move(rest), number_);
    return true;
  }

  void fix(LineTokens& tokens) {
    tag_ = "FIX";
    std::int64_t value = 0;
    do {
      if (!id(tokens, value)) return;
      builder_.fix(value, number_);
    } while (!tokens.atEnd());
  }

  /// Whether a line that says something of the edge before it has one.
  bool hasEdge() {
    if (before_ == Before::kEdge) return true;
    if (before_ == Before::kLostEdge) {
      builder_.warning(number_, std::string(tag_) + " of a line that was not read, skipped");
    } else {
      fail(1, std::string(tag_) + " belongs behind the line of an edge");
    }
    return false;
  }

  void kernel(LineTokens& tokens) {
    if (!hasEdge()) return;
    const std::string_view name = tokens.next();
    if (name.empty()) return fail(tokens.column(), "expected the name of a kernel, the line ends");
    const std::int64_t column = tokens.column();
    if (!numbers(tokens, 1, 1)) return;
    builder_.setKernel(name, numbers_[0], number_, column);
  }

  void level(LineTokens& tokens) {
    if (!hasEdge()) return;
    const std::string_view token = tokens.next();
    std::int64_t value = 0;
    if (parseInteger(token, value) != NumberStatus::kOk || value < 0 ||
        value > std::numeric_limits<std::int32_t>::max()) {
      badToken(tokens, token,
               token.empty() ? "expected a level, the line ends"
                             : "expected a level from 0 to 2147483647, got " + quoted(token));
      return;
    }
    if (lineEnds(tokens, 1)) builder_.setLevel(std::int32_t(value), number_);
  }

  bool vertexIds(LineTokens& tokens, const graft_edge_type& edge_type) {
    ids_.clear();
    std::int64_t value = 0;
    if (edge_type.arity != GRAFT_DYNAMIC) {
      for (int k = 0; k < edge_type.arity; ++k) {
        if (!id(tokens, value)) return false;
        ids_.push_back(value);
      }
      return true;
    }
    for (;;) {
      const std::string_view token = tokens.next();
      if (token == "||") return true;
      if (token.empty()) {
        fail(tokens.column(), "expected '||' after the vertex ids" + what() + ")");
        return false;
      }
      if (!idOf(tokens, token, value)) return false;
      ids_.push_back(value);
    }
  }

  bool edge(LineTokens& tokens, const TagType& type) {
    const graft_edge_type& edge_type = *type.edge;
    if (!vertexIds(tokens, edge_type)) return false;
    const auto arity = int(ids_.size());
    for (int k = 0; k < edge_type.resource_count; ++k) {
      std::int64_t value = 0;
      if (!id(tokens, value)) return false;
      ids_.push_back(value);
    }
    std::int32_t error_dim = edge_type.error_dim;
    std::int32_t measurement_dim = edge_type.measurement_dim;
    if (edge_type.arity == GRAFT_DYNAMIC) {
      graft_message message = {};
      if (!edgeShape(edge_type, arity, error_dim, measurement_dim, message)) {
        fail(0,
             std::string(tag_) + " with " + std::to_string(arity) + " vertices: " + message.text);
        return false;
      }
    }
    const auto entries = std::size_t(triangleSize(error_dim));
    const auto measured = std::size_t(measurement_dim);
    if (!numbers(tokens, measured + entries, ids_.size())) return false;
    builder_.addEdge(type,
                     {ids_.data(), arity, ids_.data() + arity, edge_type.resource_count,
                      numbers_.data(), measurement_dim, numbers_.data() + measured, int(entries)},
                     number_);
    return true;
  }

  std::string_view text_;
  GraphBuilder& builder_;
  std::string_view line_;
  std::int64_t number_ = 0;
  std::string_view tag_;
  std::vector<std::int64_t> ids_;
  std::vector<double> numbers_;
  bool binary_ = false;
  /// What the last line was that was no ROBUST_KERNEL or G2O_EDGE_LEVEL.
  enum class Before { kNoEdge, kEdge, kLostEdge };
  Before before_ = Before::kNoEdge;
};

/// Empty, or why the text is not one that this reader can read.
std::string foreignEncoding(std::string_view text) {
  const auto starts = [&text](std::string_view head) {
    return text.substr(0, head.size()) == head;
  };
  using namespace std::string_view_literals;
  if (starts("\x1f\x8b"sv)) return "gzip input is not supported; unpack it, e.g. zcat FILE | graft";
  if (starts("\xff\xfe"sv) || starts("\xfe\xff"sv) || starts("\x00\x00\xfe\xff"sv)) {
    return "looks like UTF-16 or UTF-32, expected UTF-8";
  }
  if (text.find('\n') == std::string_view::npos && text.find('\r') != std::string_view::npos &&
      text.find('\r') + 1 < text.size()) {
    return "no newline; CR line ends are not supported";
  }
  return "";
}

std::int64_t columnOf(std::string_view text, std::int64_t line, int token) {
  LineReader lines(text);
  std::string_view content;
  while (lines.next(content)) {
    if (lines.lineNumber() < line) continue;
    LineTokens tokens(content);
    for (int k = 0; k < token; ++k) tokens.next();
    tokens.next();
    return tokens.column();
  }
  return 0;
}

}  // namespace

void readG2o(std::string_view text, GraphBuilder& builder) {
  const std::string foreign = foreignEncoding(text);
  if (!foreign.empty()) {
    builder.error(1, 0, foreign);
    return;
  }
  builder.setColumns([text](std::int64_t line, int token) { return columnOf(text, line, token); });
  Reader(text, builder).run();
}

}  // namespace graft
