// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/map/map_yaml.hpp"

#include <map>
#include <vector>

#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

constexpr const char* kKeys[] = {"image",           "resolution",  "origin", "negate",
                                 "occupied_thresh", "free_thresh", "mode"};

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// A comment begins at a '#' at the start or after a blank, outside quotes.
std::string_view withoutComment(std::string_view line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if ((c == '"' || c == '\'') && i > 0 && (line[i - 1] == ' ' || line[i - 1] == ':')) {
      quote = c;
    } else if (c == '#' && (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t')) {
      return line.substr(0, i);
    }
  }
  return line;
}

struct Entry {
  std::int64_t line = 0;
  std::string value;
  std::vector<std::string> items;  ///< of a list
  bool list = false;
};

class Parser {
 public:
  Parser(const std::string& path, Diagnostics& diagnostics)
      : path_(path), diagnostics_(diagnostics) {}

  void readLines(std::string_view content) {
    LineReader lines(content);
    std::string_view raw;
    Entry* last = nullptr;
    while (lines.next(raw)) {
      last_line_ = lines.lineNumber();
      const std::string_view line = withoutComment(raw);
      const std::string_view text = trimmed(line);
      if (text.empty() || text == "---") continue;
      if (text.front() == '-' && (text.size() == 1 || text[1] == ' ')) {
        if (last == nullptr || (!last->list && !last->value.empty())) {
          error(last_line_, "a list item without a list");
        } else {
          last->list = true;
          last->items.emplace_back(trimmed(text.substr(1)));
        }
        continue;
      }
      last = readEntry(line, text);
    }
  }

  const Entry* find(const std::string& key) const {
    const auto found = entries_.find(key);
    return found == entries_.end() ? nullptr : &found->second;
  }
  const Entry* require(const std::string& key) {
    const Entry* entry = find(key);
    if (entry == nullptr) error(last_line_, "the key '" + key + "' is missing");
    return entry;
  }
  void error(std::int64_t line, const std::string& text) {
    diagnostics_.error({path_, line, 0}, text);
  }

  /// Number of an entry; false with a message where it is none.
  bool number(const std::string& key, double& value) {
    const Entry* entry = require(key);
    if (entry == nullptr) return false;
    return number(*entry, entry->list ? "[" : entry->value, key, value);
  }
  bool number(const Entry& entry, const std::string& token, const std::string& key, double& value) {
    const NumberStatus status = parseDouble(token, value);
    if (status == NumberStatus::kOk) return true;
    error(entry.line, key + ": " +
                          (status == NumberStatus::kEmpty ? std::string("the value is missing")
                                                          : describe(status, token)));
    return false;
  }

 private:
  Entry* readEntry(std::string_view line, std::string_view text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos ||
        (colon + 1 < text.size() && text[colon + 1] != ' ' && text[colon + 1] != '\t')) {
      error(last_line_, "expected 'key: value', got " + quoted(text));
      return nullptr;
    }
    const std::string key(trimmed(text.substr(0, colon)));
    bool known = false;
    for (const char* candidate : kKeys) known = known || key == candidate;
    if (!known || line.front() == ' ' || line.front() == '\t') {
      error(last_line_,
            known ? "the key '" + key + "' must not be indented" : "unknown key " + quoted(key));
      return nullptr;
    }
    if (entries_.count(key) != 0) {
      error(last_line_, "the key '" + key + "' is given twice");
      return nullptr;
    }
    Entry& entry = entries_[key];
    entry.line = last_line_;
    readValue(trimmed(text.substr(colon + 1)), entry);
    return &entry;
  }

  void readValue(std::string_view value, Entry& entry) {
    if (value.size() >= 2 && (value.front() == '"' || value.front() == '\'') &&
        value.back() == value.front()) {
      entry.value = value.substr(1, value.size() - 2);
      return;
    }
    if (value.empty() || value.front() != '[') {
      entry.value = value;
      return;
    }
    entry.list = true;
    if (value.back() != ']') {
      error(entry.line, "the list does not end with ']' on its line");
      return;
    }
    std::string_view inner = trimmed(value.substr(1, value.size() - 2));
    while (!inner.empty()) {
      const std::size_t comma = inner.find(',');
      entry.items.emplace_back(trimmed(inner.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      inner.remove_prefix(comma + 1);
      if (trimmed(inner).empty()) entry.items.emplace_back();
    }
  }

  const std::string& path_;
  Diagnostics& diagnostics_;
  std::map<std::string, Entry> entries_;
  std::int64_t last_line_ = 0;
};

void readOrigin(Parser& parser, MapYaml& yaml) {
  const Entry* entry = parser.require("origin");
  if (entry == nullptr) return;
  if (!entry->list || entry->items.size() != 3) {
    parser.error(entry->line, "origin: expected [x, y, yaw], got " +
                                  (entry->list ? std::to_string(entry->items.size()) + " numbers"
                                               : quoted(entry->value)));
    return;
  }
  double values[3];
  for (std::size_t i = 0; i < 3; ++i) {
    if (!parser.number(*entry, entry->items[i], "origin", values[i])) return;
  }
  yaml.origin = Pose2::fromArray(values);
}

void readThresholds(Parser& parser, MapYaml& yaml) {
  // Both are looked at, so that both are reported.
  const bool has_occupied = parser.number("occupied_thresh", yaml.occupied_thresh);
  const bool has_free = parser.number("free_thresh", yaml.free_thresh);
  if (!has_occupied || !has_free) return;
  const auto check = [&parser](const char* key, double value) {
    if (value >= 0 && value <= 1) return true;
    parser.error(parser.find(key)->line,
                 std::string(key) + " is " + formatDouble(value) + ", expected 0 to 1");
    return false;
  };
  if (!check("occupied_thresh", yaml.occupied_thresh)) return;
  if (!check("free_thresh", yaml.free_thresh)) return;
  if (yaml.free_thresh > yaml.occupied_thresh) {
    parser.error(parser.find("free_thresh")->line, "free_thresh " + formatDouble(yaml.free_thresh) +
                                                       " is above occupied_thresh " +
                                                       formatDouble(yaml.occupied_thresh));
  }
}

void readNegate(Parser& parser, MapYaml& yaml) {
  const Entry* entry = parser.require("negate");
  if (entry == nullptr) return;
  const std::string& value = entry->value;
  if (value == "0" || value == "false" || value == "False") {
    yaml.negate = false;
  } else if (value == "1" || value == "true" || value == "True") {
    yaml.negate = true;
  } else {
    parser.error(entry->line, "negate is " + quoted(value) + ", expected 0 or 1");
  }
}

}  // namespace

MapYaml parseMapYaml(std::string_view content, const std::string& path, Diagnostics& diagnostics) {
  MapYaml yaml;
  Parser parser(path, diagnostics);
  parser.readLines(content);
  if (const Entry* image = parser.require("image")) {
    yaml.image = image->value;
    yaml.image_line = image->line;
    if (image->value.empty()) parser.error(image->line, "image: the value is missing");
    // A map that reaches out of its folder cannot be moved or copied with it.
    if (("/" + image->value + "/").find("/../") != std::string::npos) {
      parser.error(image->line, "image: " + quoted(image->value) + " leaves the map's folder");
    }
  }
  if (parser.number("resolution", yaml.resolution) && !(yaml.resolution > 0)) {
    parser.error(parser.find("resolution")->line,
                 "resolution is " + formatDouble(yaml.resolution) + ", expected more than 0");
  }
  readOrigin(parser, yaml);
  readNegate(parser, yaml);
  readThresholds(parser, yaml);
  if (const Entry* mode = parser.find("mode"); mode != nullptr && mode->value != "trinary") {
    parser.error(mode->line, "mode " + quoted(mode->value) + " is not supported, only trinary");
  }
  return yaml;
}

}  // namespace graft::lfd
