#include "twin/report/html.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

namespace twin::report {
namespace {

constexpr std::string_view kStyle = R"(
body{font:15px/1.45 'DejaVu Sans',Verdana,sans-serif;color:#222;max-width:1060px;margin:2em auto;padding:0 1em}
h1{font-size:1.35em;margin:0 0 .2em}
h2{font-size:1.1em;margin:2em 0 .5em}
h3{font-size:1em;margin:1.5em 0 .3em}
.run{color:#666;margin:0 0 1.5em}
dl{display:grid;grid-template-columns:9em 1fr;gap:.5em 1em;margin:0}
dt{color:#7a2a90;font-weight:bold}
dd{margin:0}
dd p{margin:0 0 .3em;overflow-wrap:anywhere}
svg{width:100%;height:auto}
table{border-collapse:collapse;font-size:.85em;font-variant-numeric:tabular-nums}
th,td{padding:.15em .6em;text-align:right;border-bottom:1px solid #ddd}
th{text-align:left;vertical-align:bottom;font-weight:normal;color:#555}
td:first-child,td.word{text-align:left}
tr.held{background:#fbe3e5}
td.met{color:#1b6e4f;text-align:left}
p.met{color:#1b6e4f;font-weight:bold}
td.missed,td.failed,p.failed{color:#c0272d;font-weight:bold;text-align:left}
td.reported{color:#777;text-align:left}
figure{margin:0}
pre{font-size:.8em;overflow-x:auto}
.wide{overflow-x:auto}
summary{cursor:pointer}
img,video{max-width:100%}
figure.pair{margin:0 0 1em}
figure.pair img{width:49.5%}
figure.pair img+img{margin-left:1%}
)";

}  // namespace

std::string Escape(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&': html += "&amp;"; break;
      case '<': html += "&lt;"; break;
      case '>': html += "&gt;"; break;
      case '"': html += "&quot;"; break;
      default: html += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
    }
  }
  return html;
}

std::string InlineSvg(std::string_view svg, std::string_view name) {
  // Where gnuplot names something, and where it refers to it.
  constexpr std::array<std::string_view, 4> kNames{" id='", " id=\"", "href='#", "url(#"};
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string_view::npos) return {};
  std::string text(svg.substr(begin));
  // Which browsers show over the picture; gnuplot's tell nothing.
  for (std::size_t at = text.find("<title>"); at != std::string::npos; at = text.find("<title>")) {
    constexpr std::string_view kEnd = "</title>";
    const std::size_t end = text.find(kEnd, at);
    text.erase(at, end == std::string::npos ? end : end + kEnd.size() - at);
  }
  for (const std::string_view before : kNames) {
    for (std::size_t at = text.find(before); at != std::string::npos; at = text.find(before, at)) {
      at += before.size();
      text.insert(at, fmt::format("{}-", name));
    }
  }
  return text;
}

std::string Base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      three = three << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0U);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      text += i + j <= bytes.size() ? kDigits[three >> (18 - 6 * j) & 0x3F] : '=';
    }
  }
  return text;
}

std::string FactsTable(const std::vector<std::pair<std::string, std::string>>& facts) {
  std::string html = "<h2>How this was made</h2>\n<table>\n";
  for (const auto& [name, text] : facts) {
    html +=
        fmt::format("<tr><td>{}</td><td class=\"word\">{}</td></tr>\n", Escape(name), Escape(text));
  }
  return html + "</table>\n";
}

std::string HtmlPage(std::string_view title, std::string_view body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{}</title>\n"
      "<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      Escape(title), kStyle, body);
}

}  // namespace twin::report
