// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/page.hpp"

namespace graft::report {

namespace {

constexpr const char* kPageStyle = R"(
:root{color-scheme:light dark;--ink:#1f2328;--muted:#5f6871;--rule:#d9dde1;--paper:#fff}
@media screen and (prefers-color-scheme:dark){
:root{--ink:#e4e7ea;--muted:#98a2ac;--rule:#343b43;--paper:#15181c}}
html{background:var(--paper);color:var(--ink)}
body{font:16px/1.55 system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,sans-serif;
max-width:1000px;margin:0 auto;padding:2.5rem 1.25rem 4rem}
h1{font-size:1.9rem;line-height:1.2;margin:0 0 .3rem;overflow-wrap:anywhere}
h2{font-size:1.25rem;margin:2.8rem 0 .6rem;padding-top:.9rem;border-top:1px solid var(--rule)}
p{max-width:46rem;margin:.6rem 0}
.quiet,figcaption,dt{color:var(--muted)}
.warning{border-left:3px solid #d3302f;padding-left:.9rem}
dl.facts{display:flex;flex-wrap:wrap;gap:.6rem 2.2rem;margin:1.3rem 0}
dl.facts div{min-width:5rem}
dt{font-size:.82rem}dd{margin:0;font-size:1.2rem;font-variant-numeric:tabular-nums}
table{border-collapse:collapse;margin:1rem 0;font-size:.93rem;font-variant-numeric:tabular-nums}
th,td{padding:.32rem .9rem .32rem 0;text-align:right;vertical-align:top}
th:first-child,td:first-child{text-align:left}
th{font-weight:600;border-bottom:1px solid var(--ink)}
td{border-bottom:1px solid var(--rule)}
ul{max-width:46rem;padding-left:1.2rem}
ul.two{columns:2;column-gap:1rem;max-width:none;font-size:.82rem}
td+td{white-space:nowrap}
ul.plain{font-size:.93rem;overflow-wrap:anywhere}
figure{margin:1.4rem 0}
figure svg{display:block;width:100%;height:auto}
figcaption{font-size:.9rem;max-width:46rem;margin-top:.5rem}
figcaption b{color:var(--ink)}
.side{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(400px,100%),1fr));gap:1.2rem}
.side figure{margin:0}
.side svg{max-width:480px}
.scroll{overflow-x:auto}
@media screen{.scroll svg{min-width:640px}}
@media print{body{max-width:none;padding:0;font-size:11pt}
h2{break-after:avoid}figure,table,tr{break-inside:avoid}
.side{grid-template-columns:1fr 1fr}}
)";

}  // namespace

void Page::heading(const std::string& text) { body_ += "<h2>" + escapeXml(text) + "</h2>\n"; }

void Page::paragraph(const std::string& text, const char* classes) {
  body_ += classes != nullptr ? std::string("<p class=\"") + classes + "\">" : std::string("<p>");
  body_ += escapeXml(text) + "</p>\n";
}

void Page::facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  body_ += "<dl class=\"facts\">\n";
  for (const auto& [name, value] : facts) {
    body_ += "<div><dt>" + escapeXml(name) + "</dt><dd>" + escapeXml(value) + "</dd></div>\n";
  }
  body_ += "</dl>\n";
}

void Page::list(const std::vector<std::string>& items, const char* classes) {
  body_ +=
      classes != nullptr ? std::string("<ul class=\"") + classes + "\">\n" : std::string("<ul>\n");
  for (const std::string& item : items) body_ += "<li>" + escapeXml(item) + "</li>\n";
  body_ += "</ul>\n";
}

void Page::table(const std::vector<std::string>& head,
                 const std::vector<std::vector<std::string>>& rows) {
  body_ += "<div class=\"scroll\"><table>\n<thead><tr>";
  for (const std::string& cell : head) body_ += "<th>" + escapeXml(cell) + "</th>";
  body_ += "</tr></thead>\n<tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    body_ += "<tr>";
    for (const std::string& cell : row) body_ += "<td>" + escapeXml(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void Page::figure(const Picture& picture) {
  body_ += "<figure>\n<div class=\"scroll\">" + picture.svg.inlined(picture.title) +
           "</div>\n<figcaption><b>" + escapeXml(picture.title) + ".</b> " +
           escapeXml(picture.caption) + "</figcaption>\n</figure>\n";
}

void Page::figures(const std::vector<Picture>& pictures, const std::string& caption) {
  body_ += "<figure>\n<div class=\"side\">\n";
  for (const Picture& picture : pictures) {
    body_ += "<figure>" + picture.svg.inlined(picture.title) + "<figcaption>" +
             escapeXml(picture.caption) + "</figcaption></figure>\n";
  }
  body_ += "</div>\n<figcaption>" + escapeXml(caption) + "</figcaption>\n</figure>\n";
}

std::string Page::text() const {
  const std::string title = escapeXml(title_);
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>" +
         title + "</title>\n<style>" + kPageStyle + pictureStyle() +
         "</style>\n</head>\n<body>\n<h1>" + title + "</h1>\n" + body_ + "</body>\n</html>\n";
}

}  // namespace graft::report
