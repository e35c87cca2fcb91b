#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace twin::report {

/// Makes an HTML page, or a part of one, from a template and its data. All pages that panda-twin
/// writes are made here; a page needs no other file and no network.
///
/// Templates are Mustache files in src/report/templates and part of the program. `{{> name}}` takes
/// in the template `name`. Strings are escaped, `{{{name}}}` is put in as it is. Numbers are shown
/// with four significant digits, what is not finite as "none". A section `{{#name}}` is left out
/// when its value is missing, null, false, an empty string or an empty list.
///
/// Threads: any thread. The same template and data give the same bytes.
/// @param name  its path there without ".html": "experiment/report".
/// @param data  an object. @pre there is such a template; no datum has the name of one.
[[nodiscard]] std::string RenderPage(std::string_view name, const nlohmann::json& data);

/// How a page was made, for the template "made", which calls it `facts`: names and texts.
[[nodiscard]] nlohmann::json FactsOf(const std::vector<std::pair<std::string, std::string>>& facts);

/// `text` as HTML shows it; control characters but line feeds become spaces.
[[nodiscard]] std::string Escape(std::string_view text);

/// A picture as a part of a page: without what makes it a file of its own, and with names that no
/// other picture of the page has. @param svg  as DrawPlot gives it. @param name  letters, digits
/// and '_', another one for every picture.
[[nodiscard]] std::string InlineSvg(std::string_view svg, std::string_view name);

/// Bytes as letters, for the address of a picture within a page: "data:image/png;base64,...".
[[nodiscard]] std::string Base64(std::string_view bytes);

}  // namespace twin::report
