#include "report/paragraphs.h"

#include <algorithm>

#include <fmt/format.h>

namespace twin::report {
namespace {

constexpr std::size_t kColumns = 100;
constexpr std::size_t kIndent = 15;

/// Width of a text on a terminal, characters: bytes except UTF-8's continuation bytes.
std::size_t Width(std::string_view text) {
  std::size_t width = 0;
  for (const char c : text) width += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U ? 1 : 0;
  return width;
}

/// Adds a line, wrapped between words.
void AddWrapped(std::string& text, std::string_view line) {
  std::size_t column = kIndent;
  bool first = true;
  while (!line.empty()) {
    const std::string_view word = line.substr(0, line.find(' '));
    line.remove_prefix(std::min(line.size(), word.size() + 1));
    if (!first && column + 1 + Width(word) > kColumns) {
      text += '\n' + std::string(kIndent, ' ');
      column = kIndent;
    } else if (!first) {
      text += ' ';
      ++column;
    }
    text += word;
    column += Width(word);
    first = false;
  }
  text += '\n';
}

}  // namespace

std::string ToText(const std::vector<Paragraph>& paragraphs) {
  std::string text;
  for (const Paragraph& paragraph : paragraphs) {
    std::string label = paragraph.label;
    for (const std::string& line : paragraph.lines) {
      text += fmt::format("  {:<{}}", label, kIndent - 2);
      AddWrapped(text, line);
      label.clear();
    }
  }
  return text;
}

}  // namespace twin::report
