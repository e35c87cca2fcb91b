#pragma once

#include <string>
#include <vector>

namespace twin::report {

/// Something told under a label; its lines are kept apart.
struct Paragraph {
  std::string label;
  std::vector<std::string> lines;
};

/// For a terminal: the label left, its lines beside it, wrapped at 100 columns.
[[nodiscard]] std::string ToText(const std::vector<Paragraph>& paragraphs);

}  // namespace twin::report
