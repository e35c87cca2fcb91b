#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace twin::report {

/// `text` as HTML shows it; control characters become spaces.
[[nodiscard]] std::string Escape(std::string_view text);

/// A picture as a part of a page: without what makes it a file of its own, and with names that no
/// other picture of the page has. @param svg  as DrawChart gives it. @param name  letters, digits
/// and '_', another one for every picture.
[[nodiscard]] std::string InlineSvg(std::string_view svg, std::string_view name);

/// Bytes as letters, for the address of a picture within a page: "data:image/png;base64,...".
[[nodiscard]] std::string Base64(std::string_view bytes);

/// How a page was made: a heading and a table of names and texts.
[[nodiscard]] std::string FactsTable(const std::vector<std::pair<std::string, std::string>>& facts);

/// One HTML file that needs no other and no network, in the style of all our reports.
/// @param title  plain text. @param body  HTML; the first of it should be the heading.
[[nodiscard]] std::string HtmlPage(std::string_view title, std::string_view body);

}  // namespace twin::report
