// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/error.hpp"

#include <cstdio>

namespace graft {

namespace {

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      char buffer[8];
      std::snprintf(buffer, sizeof buffer, "\\x%02x", byte);
      out += buffer;
    } else {
      out += c;
    }
  }
  return out;
}

const char* nameOf(Diagnostics::Severity severity) {
  if (severity == Diagnostics::Severity::kError) return "error";
  return severity == Diagnostics::Severity::kWarning ? "warning" : "note";
}

}  // namespace

std::string formatMessage(const SourceLocation& where, std::string_view severity,
                          std::string_view text) {
  std::string out;
  if (!where.path.empty()) {
    out += escaped(where.path);
    if (where.line > 0) {
      out += ':' + std::to_string(where.line);
      if (where.column > 0) out += ':' + std::to_string(where.column);
    }
    out += ": ";
  }
  out += severity;
  out += ": ";
  out += escaped(text);
  return out;
}

std::string quoted(std::string_view token) {
  constexpr std::size_t kLimit = 64;
  std::string out = "'" + escaped(token.substr(0, kLimit));
  if (token.size() > kLimit) out += "...";
  return out + "'";
}

std::string Error::formatted() const {
  return dynamic_cast<const InputErrors*>(this) != nullptr ? std::string(what())
                                                           : formatMessage(where_, "error", what());
}

void Diagnostics::add(std::size_t& count, Message message) {
  if (++count > kShown) return;
  lines_.push_back(formatMessage(message.where, nameOf(message.severity), message.text));
  messages_.push_back(std::move(message));
}

void Diagnostics::error(SourceLocation where, const std::string& text) {
  add(error_count_, {Severity::kError, std::move(where), text});
}

void Diagnostics::warning(SourceLocation where, const std::string& text) {
  add(warning_count_, {Severity::kWarning, std::move(where), text});
}

void Diagnostics::note(SourceLocation where, const std::string& text) {
  add(note_count_, {Severity::kNote, std::move(where), text});
}

std::string Diagnostics::text() const {
  std::string out;
  for (const std::string& line : lines_) out += line + '\n';
  const auto cut = [&out](std::size_t count, const char* what) {
    if (count > kShown) {
      out += "... and " + std::to_string(count - kShown) + " more " + what + '\n';
    }
  };
  cut(error_count_, "errors");
  cut(warning_count_, "warnings");
  cut(note_count_, "notes");
  if (!out.empty()) out.pop_back();
  return out;
}

void Diagnostics::throwIfErrors(ExitCode code) const {
  if (error_count_ > 0) throw InputErrors(code, text());
}

void Diagnostics::append(const Diagnostics& other) {
  error_count_ += other.error_count_;
  warning_count_ += other.warning_count_;
  note_count_ += other.note_count_;
  lines_.insert(lines_.end(), other.lines_.begin(), other.lines_.end());
  messages_.insert(messages_.end(), other.messages_.begin(), other.messages_.end());
}

}  // namespace graft
