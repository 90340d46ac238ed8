// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/error.hpp"

#include <algorithm>
#include <cstdio>

namespace graft {

namespace {

/// Bytes of a character in UTF-8 that may be shown at the begin of a text; 0 if what
/// stands there is none: malformed, or a control character (C0, DEL, C1).
std::size_t shownCharacter(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return byte(0) >= 0x20 && byte(0) != 0x7f ? 1 : 0;
  const std::size_t size = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : 2;
  if (byte(0) < 0xc2 || byte(0) > 0xf4 || text.size() < size) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if (byte(i) < 0x80 || byte(i) > 0xbf) return 0;
  }
  return byte(0) == 0xc2 && byte(1) < 0xa0 ? 0 : size;
}

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t shown = shownCharacter(text);
    if (shown == 0) {
      char buffer[8];
      std::snprintf(buffer, sizeof buffer, "\\x%02x", static_cast<unsigned char>(text[0]));
      out += buffer;
    } else {
      out += text.substr(0, shown);
    }
    text.remove_prefix(std::max<std::size_t>(shown, 1));
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
