#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace twin::report {

/// Makes an HTML page, or a part of a page, from a template and its data. All pages that panda-twin
/// writes are made here; each is self-contained.
///
/// Templates are the Mustache files in src/report/templates, compiled into the program.
/// `{{> name}}` includes the template `name`. `{{name}}` inserts a string escaped, `{{{name}}}`
/// unescaped. Numbers have four significant digits; one that is not finite becomes "none". A
/// section `{{#name}}` is omitted if its value is missing, null, false, or an empty string or list.
///
/// Threads: any. The same template and data give the same bytes.
/// @param name  the template's path without ".html": "experiment/report".
/// @param data  a JSON object. @pre the template exists; no key of the data names a template.
[[nodiscard]] std::string RenderPage(std::string_view name, const nlohmann::json& data);

/// Data for the template "made", which shows them as `facts`: names and texts.
[[nodiscard]] nlohmann::json FactsOf(const std::vector<std::pair<std::string, std::string>>& facts);

/// Escapes a text for HTML; control characters except line feeds become spaces.
[[nodiscard]] std::string Escape(std::string_view text);

/// Converts an SVG document to an element of a page: drops the document's prologue and makes its
/// ids unique. @param svg  from DrawPlot(). @param name  letters, digits and '_'; unique within the
/// page.
[[nodiscard]] std::string InlineSvg(std::string_view svg, std::string_view name);

/// Bytes in Base64, for a picture's data URL: "data:image/png;base64,...".
[[nodiscard]] std::string Base64(std::string_view bytes);

}  // namespace twin::report
