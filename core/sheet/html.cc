#include "core/sheet/html.h"

#include "absl/strings/escaping.h"
#include "core/base/sha256.h"
#include "core/base/status.h"
#include "core/plot/svg.h"

namespace axiscal::sheet {
namespace {

using plot::Escape;

constexpr char kStyle[] =
    "@page{size:A4;margin:12mm 15mm}"
    "*{box-sizing:border-box}"
    "body{font:9pt/1.25 'DejaVu Sans',sans-serif;color:#000;background:#fff;max-width:180mm;margin:0 auto;"
    "padding:4mm 0}"
    "h1{font-size:14pt;margin:0}"
    "h2{font-size:10pt;margin:2.2mm 0 .8mm;border-bottom:.3mm solid #000}"
    ".sub{margin:.5mm 0 2mm}"
    "dl{display:grid;grid-template-columns:1fr 1fr;gap:.3mm 6mm;margin:0}"
    "dl div{display:flex;gap:2mm}dt{color:#333;min-width:28mm}dd{margin:0;font-weight:bold;overflow-wrap:anywhere}"
    "table{border-collapse:collapse;width:100%}"
    "th,td{text-align:left;padding:.2mm 2mm .2mm 0;vertical-align:top;font-weight:normal;overflow-wrap:anywhere;"
    "unicode-bidi:isolate}"
    "thead th{border-bottom:.2mm solid #666;color:#333}"
    ".n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}"
    "p{margin:.4mm 0;overflow-wrap:anywhere;unicode-bidi:isolate}"
    ".sign{display:flex;gap:10mm;margin-top:12mm}.sign p{flex:1;border-top:.3mm solid #000;padding-top:.8mm}"
    "footer{margin-top:2mm;font-size:7.5pt;color:#333}"
    ".dense{font-size:7.5pt}"
    ".denser{font-size:5.5pt;line-height:1.12}.denser td,.denser th{padding-top:0;padding-bottom:0}"
    ".denser h2{font-size:6.5pt;margin:1mm 0 .3mm}.denser p{margin:0}.denser footer{font-size:5.5pt;margin-top:1mm}"
    ".denser .sign{margin-top:9mm}"
    "@media print{body{padding:0}}";

// Lines that fit on a page in the usual letters, and in smaller ones.
constexpr size_t kMostUsual = 42, kMostDense = 62;

// Lines that the sections take: a long text takes several.
size_t LinesOf(const Sheet& sheet) {
  constexpr size_t kLettersOfALine = 130;
  size_t count = 0;
  for (const Section& section : sheet.sections) {
    count += section.rows.size();
    for (const std::string& line : section.lines) count += 1 + line.size() / kLettersOfALine;
  }
  return count;
}

std::string Cells(const Section& section, const std::vector<std::string>& cells, bool is_head) {
  std::string html = "<tr>";
  for (size_t i = 0; i < cells.size(); ++i) {
    const char* const tag = is_head || i == 0 ? "th" : "td";
    absl::StrAppend(&html, "<", tag, is_head ? " scope=\"col\"" : (i == 0 ? " scope=\"row\"" : ""),
                    section.columns[i] == 'n' ? " class=\"n\"" : "", ">", Escape(cells[i]), "</", tag, ">");
  }
  return html + "</tr>\n";
}

std::string ToHtml(const Section& section) {
  std::string html = "<h2>" + Escape(section.title) + "</h2>\n";
  if (!section.head.empty()) {
    absl::StrAppend(&html, "<table><thead>", Cells(section, section.head, true), "</thead><tbody>\n");
    for (const std::vector<std::string>& row : section.rows) html += Cells(section, row, false);
    html += "</tbody></table>\n";
  }
  for (const std::string& line : section.lines) absl::StrAppend(&html, "<p>", Escape(line), "</p>\n");
  return html;
}

}  // namespace

std::string ToHtml(const Sheet& sheet) {
  const size_t count = LinesOf(sheet);
  const std::string title = Escape(sheet.title), subtitle = Escape(sheet.subtitle);
  std::string html = absl::StrCat(
      "<!DOCTYPE html>\n<html lang=\"", sheet.language == Language::kGerman ? "de" : "en",
      "\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
      "<title>",
      title, " · ", subtitle, "</title><style>", kStyle, "</style></head>\n<body",
      count > kMostDense   ? " class=\"denser\""
      : count > kMostUsual ? " class=\"dense\""
                           : "",
      "><main>\n<h1>", title, "</h1>\n<p class=\"sub\">", subtitle, "</p>\n<dl>");
  for (const Fact& fact : sheet.facts)
    absl::StrAppend(&html, "<div><dt>", Escape(fact.name), "</dt><dd>", Escape(fact.value), "</dd></div>\n");
  html += "</dl>\n";
  for (const Section& section : sheet.sections) html += ToHtml(section);
  html += "<div class=\"sign\">";
  for (const std::string& who : sheet.signatures) absl::StrAppend(&html, "<p>", Escape(who), "</p>");
  absl::StrAppend(&html, "</div>\n</main>\n<footer>", Escape(sheet.footer), "</footer>\n</body></html>\n");
  return html;
}

std::string StyleHash() {
  return absl::StrCat("'sha256-", absl::Base64Escape(absl::HexStringToBytes(base::Sha256Hex(kStyle))), "'");
}

}  // namespace axiscal::sheet
