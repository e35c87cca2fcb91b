#pragma once

#include <string>
#include <vector>

namespace twin::report {

/// Text under a label; its lines stay separate.
struct Paragraph {
  std::string label;
  std::vector<std::string> lines;
};

/// Formats paragraphs for a terminal: label on the left, lines beside it, wrapped at 100 columns.
[[nodiscard]] std::string ToText(const std::vector<Paragraph>& paragraphs);

}  // namespace twin::report
