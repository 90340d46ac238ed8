// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/svg.hpp"

#include <charconv>
#include <cmath>

namespace graft::report {

namespace {

constexpr const char* kReplacement = "\xEF\xBF\xBD";

/// Bytes of the well-formed UTF-8 character at `i`; 0 if there is none.
std::size_t characterLength(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = byte(i);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || i + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xC0) != 0x80) return 0;
  }
  // Overlong forms, surrogates, and what is beyond Unicode.
  const unsigned char second = byte(i + 1);
  if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F)) return 0;
  if ((first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F)) return 0;
  return length;
}

std::string toChars(double value, int decimals) {
  char buffer[400];
  const auto end =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  return std::string(buffer, end.ptr);
}

bool finite(Point p) { return std::isfinite(p.x) && std::isfinite(p.y); }

/// A colour on light and on dark ground.
struct Role {
  const char* name;
  const char* light;
  const char* dark;
};

constexpr Role kRoles[] = {
    {"ink", "#1f2328", "#e4e7ea"},          {"muted", "#6a737d", "#98a2ac"},
    {"grid", "#e4e7ea", "#2f353c"},         {"paper", "#ffffff", "#15181c"},
    {"wall", "#111111", "#d0d4d9"},         {"unknown", "#eceef0", "#22262c"},
    {"hand", "#e07b00", "#ffa03c"},         {"torso", "#f0ae58", "#bd8238"},
    {"object", "#2468b4", "#6aa9ef"},       {"gripper", "#c71fa5", "#ff70d6"},
    {"base", "#1e9550", "#4fce85"},         {"bad", "#d3302f", "#ff6b66"},
    {"before", "#a3acb6", "#69747f"},       {"after", "#2468b4", "#6aa9ef"},
    {"offset", "#6f4bb2", "#b096ef"},       {"reaching", "#dbe4ee", "#2c3947"},
    {"manipulation", "#f2cfe6", "#5a2b4e"}, {"retreat", "#dcebdd", "#2b4231"},
};

std::string colourRules(bool dark) {
  std::string css;
  for (const Role& role : kRoles) {
    const std::string colour = dark ? role.dark : role.light;
    css += std::string(".gp .f-") + role.name + "{fill:" + colour + "}";
    css += std::string(".gp .s-") + role.name + "{stroke:" + colour + "}\n";
  }
  const std::string ink = dark ? kRoles[0].dark : kRoles[0].light;
  const std::string muted = dark ? kRoles[1].dark : kRoles[1].light;
  css += ".gp text{fill:" + ink + "}.gp text.muted{fill:" + muted + "}\n";
  return css;
}

}  // namespace

std::string escapeXml(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = characterLength(text, i);
    const char c = text[i];
    if (length == 0 || (length == 1 && static_cast<unsigned char>(c) < 0x20 && c != '\n') ||
        c == 0x7F) {
      out += kReplacement;
    } else if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (c == '\'') {
      out += "&#39;";
    } else {
      out += text.substr(i, length);
    }
    i += length == 0 ? 1 : length;
  }
  return out;
}

std::string fixedNumber(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  const std::string text = toChars(value, decimals);
  const bool zero = text.find_first_not_of("-0.") == std::string::npos;
  return zero && text[0] == '-' ? text.substr(1) : text;
}

std::string shortNumber(double value, int decimals) {
  std::string text = fixedNumber(value, decimals);
  if (text.find('.') == std::string::npos) return text;
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string roughNumber(double value) {
  const double size = std::abs(value);
  if (!std::isfinite(value)) return "-";
  if (size >= 1e9 || (size > 0 && size < 1e-3)) {
    const int power = int(std::floor(std::log10(size)));
    return shortNumber(value / std::pow(10.0, power)) + "e" + std::to_string(power);
  }
  if (size >= 100) {
    return (value < 0 ? "-" : "") + groupedNumber(static_cast<std::size_t>(std::llround(size)));
  }
  return shortNumber(value, size >= 10 ? 1 : size >= 1 ? 2 : size >= 0.1 ? 3 : 4);
}

std::string groupedNumber(std::size_t value) {
  std::string text = std::to_string(value);
  for (int i = int(text.size()) - 3; i > 0; i -= 3) text.insert(std::size_t(i), ",");
  return text;
}

void PathData::append(char command, Point p) {
  text_ += command;
  text_ += shortNumber(p.x);
  text_ += ' ';
  text_ += shortNumber(p.y);
}

void PathData::moveTo(Point p) {
  broken_ = !finite(p);
  if (!broken_) append('M', p);
}

void PathData::lineTo(Point p) {
  if (broken_ || !finite(p)) {
    moveTo(p);
  } else {
    append('L', p);
  }
}

void PathData::curveTo(Point control, Point end) {
  if (broken_ || !finite(control) || !finite(end)) {
    moveTo(end);
    return;
  }
  append('Q', control);
  append(' ', end);
}

void PathData::close() {
  if (!broken_) text_ += 'Z';
  broken_ = true;
}

void PathData::dot(Point p) {
  moveTo(p);
  if (!broken_) text_ += "h0";
}

void PathData::cross(Point p, double half) {
  if (!finite(p)) return;
  moveTo({p.x - half, p.y - half});
  lineTo({p.x + half, p.y + half});
  moveTo({p.x - half, p.y + half});
  lineTo({p.x + half, p.y - half});
}

void PathData::polyline(const std::vector<Point>& points, bool closed) {
  broken_ = true;
  for (const Point& p : points) lineTo(p);
  if (closed) close();
}

void PathData::box(Point corner, double width, double height) {
  polyline({corner,
            {corner.x + width, corner.y},
            {corner.x + width, corner.y + height},
            {corner.x, corner.y + height}},
           true);
}

void Svg::open(const char* element) {
  body_ += '<';
  body_ += element;
}

void Svg::attribute(const char* name, double value) { attribute(name, shortNumber(value)); }

void Svg::attribute(const char* name, std::string_view value) {
  body_ += ' ';
  body_ += name;
  body_ += "=\"";
  body_ += escapeXml(value);
  body_ += '"';
}

void Svg::line(Point a, Point b, std::string_view classes) {
  PathData data;
  data.moveTo(a);
  data.lineTo(b);
  path(data, classes);
}

void Svg::path(const PathData& data, std::string_view classes) {
  if (data.empty()) return;
  open("path");
  attribute("class", classes);
  attribute("d", data.text());
  body_ += "/>\n";
}

void Svg::circle(Point center, double radius, std::string_view classes) {
  if (!finite(center) || !std::isfinite(radius)) return;
  open("circle");
  attribute("class", classes);
  attribute("cx", center.x);
  attribute("cy", center.y);
  attribute("r", radius);
  body_ += "/>\n";
}

void Svg::rect(Point corner, double width, double height, std::string_view classes,
               double corner_radius) {
  if (!finite(corner) || !finite({width, height}) || width < 0 || height < 0) return;
  open("rect");
  attribute("class", classes);
  attribute("x", corner.x);
  attribute("y", corner.y);
  attribute("width", width);
  attribute("height", height);
  if (corner_radius > 0) attribute("rx", corner_radius);
  body_ += "/>\n";
}

void Svg::text(Point at, std::string_view text, std::string_view classes, Anchor anchor,
               bool turned) {
  if (!finite(at)) return;
  open("text");
  attribute("class", classes);
  attribute("x", at.x);
  attribute("y", at.y);
  if (anchor != Anchor::kStart) {
    attribute("text-anchor", anchor == Anchor::kMiddle ? "middle" : "end");
  }
  if (turned) {
    attribute("transform", "rotate(-90 " + shortNumber(at.x) + " " + shortNumber(at.y) + ")");
  }
  body_ += '>' + escapeXml(text) + "</text>\n";
}

// A nested picture cuts what is outside of it, without a name that could clash
// with another picture on the same page.
void Svg::beginClip(Point corner, double width, double height) {
  open("svg");
  attribute("x", corner.x);
  attribute("y", corner.y);
  attribute("width", width);
  attribute("height", height);
  attribute("viewBox", shortNumber(corner.x) + " " + shortNumber(corner.y) + " " +
                           shortNumber(width) + " " + shortNumber(height));
  body_ += ">\n";
}

void Svg::endClip() { body_ += "</svg>\n"; }

std::string Svg::head(const std::string& title, bool alone) const {
  std::string out = "<svg class=\"gp\"";
  if (alone) out += " xmlns=\"http://www.w3.org/2000/svg\"";
  const std::string size = shortNumber(width_) + "\" height=\"" + shortNumber(height_);
  out += " width=\"" + size + "\" viewBox=\"0 0 " + shortNumber(width_) + " " +
         shortNumber(height_) + "\" role=\"img\" aria-label=\"" + escapeXml(title) + "\">\n";
  return out;
}

std::string Svg::standalone(const std::string& title) const {
  return head(title, true) + "<title>" + escapeXml(title) + "</title>\n<style>\n" + pictureStyle() +
         "</style>\n<rect class=\"f-paper\" width=\"100%\" height=\"100%\"/>\n" + body_ +
         "</svg>\n";
}

std::string Svg::inlined(const std::string& title) const {
  return head(title, false) + body_ + "</svg>\n";
}

const std::string& pictureStyle() {
  // Plain colours instead of variables: programs that turn pictures into PDF
  // know the former only.
  static const std::string style =
      ".gp text{font:12px system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',"
      "Arial,sans-serif}\n"
      ".gp text.small{font-size:10.5px}.gp text.title{font-size:13px;font-weight:600}\n"
      ".gp path,.gp circle{fill:none}.gp path{stroke-linecap:round;stroke-linejoin:round}\n"
      ".gp .w1{stroke-width:1}.gp .w2{stroke-width:2}.gp .w3{stroke-width:3}"
      ".gp .w5{stroke-width:5}.gp .w6{stroke-width:6.5}\n"
      ".gp .soft{opacity:.55}.gp .faint{opacity:.28}.gp .dash{stroke-dasharray:5 4}\n"
      ".gp .crisp{shape-rendering:crispEdges}\n" +
      colourRules(false) + "@media screen and (prefers-color-scheme:dark){\n" + colourRules(true) +
      "}\n";
  return style;
}

}  // namespace graft::report
